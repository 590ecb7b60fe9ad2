"""Stability of a line with variable inertias: multipliers, growth, unstable ranges of speeds."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure, in_rpm
from vibecalc.numerics.gauss import GaussRule, gauss_rule
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.torsion.variable_inertia.motion import VariableLine, terms, turning_parts

# ----------------------------------------------------------------------------
# Stability of a line with variable inertias: multipliers over a cycle and rates of growth.
#
# In the canonical pair d and p = J d' the undamped equations are Hamiltonian, and Gauss collocation
# keeps them so: multipliers of a stable undamped line stay on the unit circle to round-off, and a
# growth that is found is not one of the method.
#
# Source: Yakubovich and Starzhinskii (1975), Linear differential equations with periodic
# coefficients; Hairer, Lubich and Wanner (2006), Geometric numerical integration, section IV.2.
# ----------------------------------------------------------------------------

_POINTS = 8
#: radians of the fastest motion in one panel
_PANEL = 2.5
#: panels are halved until two rules agree so closely (relative), or that often
_CLOSE = 1e-12
_DENSITIES = (1, 2, 4, 8)


class Stability(NamedTuple):
    """Multipliers over one cycle (2 m,) with absolute errors, and the fastest growth of vibration.

    `common` (2 m,) is each motion's share of turning as a whole, 0 to 1: about 1 for drifts of the
    speed, whose multipliers lie about 1. The two of each piece without ground stiffness that have
    the largest shares are its drifts and do not count as vibration. `growth` in
    1/s (negative: everything dies out) has the error `growth_error`; `unstable` says that it is
    positive beyond that.
    """

    multiplier: ComplexArray
    error: FloatArray
    common: FloatArray
    growth: float
    growth_error: float
    unstable: bool


def stability(
    system: VariableLine,
    speed: float,
    *,
    angle: ArrayLike | None = None,
    angle_error: ArrayLike | None = None,
    basis: FloatArray | None = None,
) -> Stability:
    """Multipliers of small deviations about a motion at one speed.

    Parameters
    ----------
    angle : complex (N + 1, n), rad
        The motion, as from `steady_response(..., exact=True)`; None is uniform turning, right to
        the first order of the variation: the second makes drifts of the speed seem to grow.
    angle_error : (N + 1, n), rad
        How far the motion may be off; what so much more at every order changes is counted twice.
    basis : (m, n)
        Shapes that deviations are sought in; None keeps every freedom.

    Raises
    ------
    NumericalFailure
        The line has loss factors, which have no form in time, or freedoms without inertia.
    """
    line = system.line
    if np.any(line.loss_factor):
        raise NumericalFailure("stability: a loss factor has no form in time; give shaft damping")
    if np.any(line.inertia <= 0.0) and basis is None:
        raise NumericalFailure("stability: a freedom has no inertia; join it to its neighbour")
    n, speed = len(line.inertia), float(speed)
    shapes = np.eye(n) if basis is None else np.asarray(basis, dtype=np.float64)
    none = np.zeros((1, n), dtype=np.complex128)
    motion = none if angle is None else np.asarray(angle, dtype=np.complex128)

    def turned(points: int, density: int, motion: ComplexArray) -> tuple[FloatArray, int]:
        rule = gauss_rule(points)
        return _turn(system, speed, motion, shapes, rule, density)

    for density in _DENSITIES:
        turn, panels = turned(_POINTS + 1, density, motion)
        noise = float(np.linalg.norm(turn - turned(_POINTS, density, motion)[0], 2))
        if noise <= _CLOSE * float(np.linalg.norm(turn, 2)):
            break
    if angle_error is not None:
        changed, _ = turned(_POINTS + 1, density, motion + np.asarray(angle_error))
        noise += 2.0 * float(np.linalg.norm(changed - turn, 2))
    return _judged(system, speed, shapes, turn, panels, noise)


def refuse_unstable(stability: Stability, speed: float) -> None:
    """NumericalFailure if small deviations grow: there is no steady motion at this speed."""
    if stability.unstable:
        raise NumericalFailure(
            f"variable inertia at {in_rpm(speed)}: no steady motion; small vibration grows by "
            f"{stability.growth:.4g} 1/s (parametric instability). More damping or another speed"
        )


def _turn(
    system: VariableLine,
    speed: float,
    angle: ComplexArray,
    shapes: FloatArray,
    rule: GaussRule,
    density: int,
) -> tuple[FloatArray, int]:
    """Transfer over one cycle (2 m, 2 m) in scaled d and p, and the number of panels."""
    line, period = system.line, 2.0 * np.pi * system.turns / speed
    mean, stiffness, damping = (
        shapes @ matrix @ shapes.T
        for matrix in (np.diag(line.inertia), stiffness_matrix(line), damping_matrix(line))
    )
    pace = _pace(system, speed, mean, stiffness)
    orders = max(system.variation.shape[1], (len(angle) + 1) / system.turns)
    panels = density * int(np.ceil(period * max(pace, orders * speed / 3.0) / _PANEL))
    edges = np.arange(panels) / panels
    at = (edges[:, None] + rule.nodes / panels).ravel() * (2.0 * np.pi * system.turns)
    samples = terms(system, speed, at, angle, np.zeros((1, len(line.inertia)), dtype=np.complex128))
    pairs = (shapes[:, None] * shapes).reshape(-1, shapes.shape[1])
    size, m = len(at), len(shapes)
    inverse = np.linalg.inv((samples.inertia @ pairs.T).reshape(size, m, m))
    spring = stiffness + (samples.stiffness @ pairs.T).reshape(size, m, m)
    scale = np.sqrt(np.diagonal(mean))
    slope = np.zeros((size, 2 * m, 2 * m))
    slope[:, :m, m:] = scale[:, None] * inverse * scale * pace
    slope[:, m:, :m] = -spring / (scale[:, None] * scale) / pace
    slope[:, m:, m:] = -(damping @ inverse) * scale / scale[:, None]
    split = slope.reshape(panels, len(rule.nodes), 2 * m, 2 * m)
    transfer = _panel_transfers(rule, period / panels, split)
    while len(transfer) > 1:
        odd = transfer[-1:] if len(transfer) % 2 else transfer[:0]
        even = transfer[: len(transfer) // 2 * 2]
        transfer = np.concatenate([even[1::2] @ even[::2], odd])
    return transfer[0], panels


def _pace(system: VariableLine, speed: float, mean: FloatArray, stiffness: FloatArray) -> float:
    """Highest natural frequency of the mean line, or the speed, rad/s."""
    root = np.sqrt(np.diagonal(mean))
    highest = np.linalg.eigvalsh(stiffness / (root[:, None] * root))[-1]
    return float(np.sqrt(max(highest, speed**2)))


def _panel_transfers(rule: GaussRule, width: float, slope: FloatArray) -> FloatArray:
    """Transfers (P, k, k) of y' = slope y over panels, slope (P, s, k, k) at the Gauss points."""
    panels, points, states = slope.shape[:3]
    whole = -width * rule.integration[:, None, :, None] * slope.transpose(0, 2, 1, 3)[:, None]
    # rows: point i and state of the equation; columns: point j and state that slope acts on
    matrix = whole.reshape(panels, points * states, points * states)
    matrix = matrix + np.eye(points * states)
    start = np.tile(np.eye(states), (points, 1))
    stages = np.linalg.solve(matrix, np.broadcast_to(start, (panels, *start.shape)))
    stages = stages.reshape(panels, points, states, states)
    rates = (slope @ stages) * rule.weights[:, None, None]
    return np.asarray(np.eye(states) + width * rates.sum(axis=1))


def _judged(
    system: VariableLine,
    speed: float,
    shapes: FloatArray,
    turn: FloatArray,
    panels: int,
    disturbed: float,
) -> Stability:
    multiplier, right = np.linalg.eig(turn)
    noise = (4.0 * EPSILON * panels + EPSILON * len(turn)) * float(np.linalg.norm(turn, 2))
    noise += disturbed
    try:
        left = np.linalg.inv(right)
        condition = np.linalg.norm(left, axis=1) * np.linalg.norm(right, axis=0)
    except np.linalg.LinAlgError:
        condition = np.full(len(turn), np.inf)
    # two that nearly coincide move by the root of what disturbs them
    root = 2.0 * np.sqrt(noise * max(1.0, float(np.linalg.norm(turn, 2))))
    error = np.minimum(condition * noise, root)
    m = len(shapes)
    line, period = system.line, 2.0 * np.pi * system.turns / speed
    scale = np.sqrt((shapes**2 * line.inertia).sum(axis=1))
    twist = shapes.T @ (right[:m] / scale[:, None])
    common = np.zeros(len(turn))
    total = (line.inertia[:, None] * np.abs(twist) ** 2).sum(axis=0)
    for part in turning_parts(line):
        weight = part * line.inertia
        common += np.abs(weight @ twist) ** 2 / weight.sum() / np.where(total > 0.0, total, 1.0)
    vibrates = np.ones(len(turn), dtype=bool)
    vibrates[np.argsort(-common, kind="stable")[: 2 * len(turning_parts(line))]] = False
    size = np.maximum(np.abs(multiplier), np.finfo(float).tiny)
    rate = np.where(vibrates, np.log(size) / period, -np.inf)
    worst = int(np.argmax(rate))
    uncertainty = float(error[worst] / size[worst] / period)
    order = np.argsort(-size, kind="stable")
    return Stability(
        multiplier[order],
        error[order],
        common[order],
        float(rate[worst]),
        uncertainty,
        bool(rate[worst] > uncertainty),
    )


# ----------------------------------------------------------------------------
# Where a line with variable inertias is unstable: to the first order and exactly.
#
# Order h of the inertias, modes j and k: near h w = W_j + W_k both grow together. With the modal
# part of the order, mu = 1/2 |sum_i s_ji s_ki V_ih| / sqrt(M_j M_k), slowly varying amplitudes give
#
#     growth = mu (W_j^2 + W_k^2) / (4 sqrt(W_j W_k)),   |h w - W_j - W_k| < 2 growth,
#
# and stability at every speed once the rates of decay satisfy d_j d_k > growth^2. For one freedom
# (j = k) this is the first wedge of Mathieu's equation.
#
# Source: Nayfeh and Mook (1979), Nonlinear oscillations, chapter 5 (sum resonances).
# ----------------------------------------------------------------------------

_BISECTIONS = 26


class Wedges(NamedTuple):
    """Sum resonances (r,) by falling width: order of the inertias, modes from 0, speed in rad/s.

    `growth` in 1/s without damping at the centre, `half_width` in rad/s, `damping_ratio` of both
    modes (equal) that removes it. All to the first order: `error` (r,) in rad/s says by how much
    speed and half width may be off where the next order counts, half the square of the largest
    variation, an estimate.
    """

    order: IntArray
    first: IntArray
    second: IntArray
    speed: FloatArray
    growth: FloatArray
    half_width: FloatArray
    damping_ratio: FloatArray
    error: FloatArray


def wedges(
    system: VariableLine, frequency: FloatArray, shape: FloatArray, modal_inertia: FloatArray
) -> Wedges:
    """Sum resonances of all pairs of modes (m,) above zero and all orders of the variation."""
    mode = np.flatnonzero(frequency > 0.0)
    root = shape[mode] / np.sqrt(modal_inertia[mode])[:, None]
    w = frequency[mode]
    share = 0.5 * np.abs(np.einsum("ji,ki,ih->hjk", root, root, system.variation))
    first, second = np.triu_indices(len(mode))
    share = share[:, first, second]
    both = w[first] * w[second]
    growth = share * (w[first] ** 2 + w[second] ** 2) / (4.0 * np.sqrt(both))
    order = np.arange(1, len(share) + 1)[:, None]
    speed = (w[first] + w[second]) / order
    width = 2.0 * growth / order
    ratio = growth / np.sqrt(both)
    largest = np.max(np.abs(system.variation) / system.line.inertia[:, None], initial=0.0)
    falling = np.argsort(-width, axis=None, kind="stable")

    def row(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.broadcast_to(values, width.shape).ravel()[falling])

    return Wedges(
        row(order), row(mode[first]), row(mode[second]), row(speed), row(growth), row(width),
        row(ratio), row(0.5 * speed * largest**2),
    )  # fmt: skip


def unstable_ranges(
    system: VariableLine, speed: ArrayLike, *, basis: FloatArray | None = None
) -> FloatArray:
    """Ranges (r, 4) about uniform turning, with borders by bisection between speeds (S,).

    Each from one speed to another in rad/s, with the error of both, and the fastest growth seen in
    1/s. The speeds must be as close as the ranges searched; add the centres of `wedges`. The line's
    damping counts. A range that reaches an end of the speeds ends there, with the error 0.
    """
    speeds = np.unique(np.asarray(speed, dtype=np.float64)).tolist()

    def growth(speed: float) -> float:
        """In 1/s, zero where it is none or cannot be distinguished from round-off."""
        found = stability(system, speed, basis=basis)
        return found.growth if found.unstable else 0.0

    def border(inside: float, outside: float) -> tuple[float, float]:
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + outside)
            if growth(middle) > 0.0:
                inside = middle
            else:
                outside = middle
        return 0.5 * (inside + outside), abs(outside - inside)

    seen = np.array([growth(one) for one in speeds])
    edges = np.diff(np.concatenate([[False], seen > 0.0, [False]]).astype(int))
    ranges = []
    for start, end in zip(*(np.flatnonzero(edges == side) for side in (1, -1)), strict=True):
        low, off = border(speeds[start], speeds[start - 1]) if start else (speeds[0], 0.0)
        last = speeds[end - 1 : end + 1]
        high, other = border(*last) if len(last) == 2 else (last[0], 0.0)
        ranges.append((low, high, max(off, other), seen[start:end].max()))
    return np.array(ranges).reshape(-1, 4)
