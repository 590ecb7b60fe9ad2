"""Where a line with variable inertias is unstable: to the first order and exactly.

Order h of the inertias, modes j and k: near h w = W_j + W_k both grow together. With the modal
part of the order, mu = 1/2 |sum_i s_ji s_ki V_ih| / sqrt(M_j M_k), slowly varying amplitudes give

    growth = mu (W_j^2 + W_k^2) / (4 sqrt(W_j W_k)),   |h w - W_j - W_k| < 2 growth,

and stability at every speed once the rates of decay satisfy d_j d_k > growth^2. For one freedom
(j = k) this is the first wedge of Mathieu's equation.

Source: Nayfeh and Mook (1979), Nonlinear oscillations, chapter 5 (sum resonances).
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.variable_inertia import VariableLine
from vibecalc.response.torsion.variable_inertia_stability import stability

#: a line's motion at a speed (N + 1, n) and its error, as from `steady_response(..., exact=True)`
Motion: TypeAlias = Callable[[VariableLine, float], tuple[ComplexArray, FloatArray]]

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


class Range(NamedTuple):
    """Speeds between which vibration grows, rad/s, with errors, and the fastest growth seen."""

    low: float
    high: float
    error: float
    worst_speed: float
    growth: float


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
    system: VariableLine,
    speed: ArrayLike,
    *,
    basis: FloatArray | None = None,
    motion: Motion | None = None,
) -> list[Range]:
    """Ranges about uniform turning, or `motion`, with borders by bisection between speeds (S,).

    The speeds must be as close as the ranges looked for; add the centres of `wedges`. The line's
    damping counts. A range that reaches an end of the speeds ends there, with the error 0.
    """
    speeds = np.unique(np.asarray(speed, dtype=np.float64))
    growth = {float(w): _growth(system, float(w), basis, motion) for w in speeds}
    found: list[Range] = []
    inside = np.array([growth[float(w)] > 0.0 for w in speeds])
    starts = np.flatnonzero(inside & ~np.append(False, inside[:-1]))
    ends = np.flatnonzero(inside & ~np.append(inside[1:], False))
    for start, end in zip(starts, ends, strict=True):
        low, high, error = float(speeds[start]), float(speeds[end]), 0.0
        if start > 0:
            low, error = _border(system, low, float(speeds[start - 1]), basis, motion)
        if end + 1 < len(speeds):
            high, other = _border(system, high, float(speeds[end + 1]), basis, motion)
            error = max(error, other)
        worst = max(speeds[start : end + 1], key=lambda w: growth[float(w)])
        found.append(Range(low, high, error, float(worst), growth[float(worst)]))
    return found


def _growth(
    system: VariableLine, speed: float, basis: FloatArray | None, motion: Motion | None
) -> float:
    """Growth in 1/s, zero where it is none or cannot be told from round-off."""
    angle, error = (None, None) if motion is None else motion(system, speed)
    found = stability(system, speed, angle=angle, angle_error=error, basis=basis)
    return found.growth if found.unstable else 0.0


def _border(
    system: VariableLine,
    inside: float,
    outside: float,
    basis: FloatArray | None,
    motion: Motion | None,
) -> tuple[float, float]:
    for _ in range(_BISECTIONS):
        middle = 0.5 * (inside + outside)
        if _growth(system, middle, basis, motion) > 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside), abs(outside - inside)
