"""A line whose inertias change with the crank angle: equations, and steady motion of all orders."""

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure, in_rpm
from vibecalc.numerics.rounding import EPSILON, SINGULAR, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import Line, damping_matrix, free_parts, network_matrix, stiffness_matrix

# ----------------------------------------------------------------------------
# A shaft line whose inertias change with the crank angle: its data and what they are at an angle.
#
# The pistons of a cylinder add m (ds/dtheta)^2 to the inertia of their throw, rods likewise. With
# theta_i = w t + phi_i the Lagrangian 1/2 sum J_i(theta_i) theta_i'^2 - V gives exactly
#
#     J_i(theta_i) phi_i'' + 1/2 J_i'(theta_i) (w + phi_i')^2 + (C phi' + K phi)_i = T_i,
#
# a dash at J being the derivative by theta.
#
# Source: Pasricha and Carnegie (1976), Effects of variable inertia on the damped torsional
# vibrations of diesel engine systems, Journal of Sound and Vibration 46.
# ----------------------------------------------------------------------------

_SAMPLES = 16


class VariableLine(NamedTuple):
    """A line, its inertias' variation, who takes up the mean torque, and the length of a cycle.

    `line.inertia` (n,) is the mean over a turn. `variation` (n, H) complex in kg m^2 holds the
    orders 1 .. H: J_i(theta) = J_i + Re sum_h variation_ih exp(i h theta). `load` (n,) is the share
    of every freedom in the mean torque taken up by what is driven, which is whatever keeps the
    speed; it counts on pieces without ground stiffness only. `turns` is 2 for a four-stroke cycle
    (orders k / 2) and 1 for a two-stroke one.
    """

    line: Line
    variation: ComplexArray
    load: FloatArray
    turns: int


class LineInertia(NamedTuple):
    """Inertias and their first two derivatives by the angle, (..., n) in kg m^2."""

    value: FloatArray
    slope: FloatArray
    curvature: FloatArray


def variable_line(
    line: Line, variation: ArrayLike, *, turns: int = 2, load: ArrayLike | None = None
) -> VariableLine:
    """A line with variation (n, H); without `load` each freedom takes a share like its inertia.

    Raises
    ------
    NumericalFailure
        An inertia does not stay positive over the turn though it varies.
    """
    change = np.asarray(variation, dtype=np.complex128)
    share = line.inertia if load is None else np.asarray(load, dtype=np.float64)
    system = VariableLine(line, change, np.asarray(share, dtype=np.float64), turns)
    highest = max(change.shape[-1], 1)
    angle = np.arange(_SAMPLES * highest) * (2.0 * np.pi / (_SAMPLES * highest))
    least = inertia_at(system, angle[:, None]).value.min(axis=0)
    wrong = (least <= 0.0) & change.any(axis=-1)
    if wrong.any():
        station = int(np.argmax(wrong))
        raise NumericalFailure(
            f"variable inertia: freedom {station + 1} falls to {least[station]:.4g} kg m^2 over "
            f"the turn, with a mean of {line.inertia[station]:.4g} kg m^2; a mean holds half of "
            "the reciprocating parts' inertia at least"
        )
    return system


def inertia_variation(inertia_torque: ArrayLike) -> ComplexArray:
    """Variation (..., H) in kg m^2 from the inertia torque's harmonics of the orders 1 .. H.

    At constant speed the torque is -1/2 w^2 dJ/dtheta, whence J_h = 2 i T_h / h with T_h complex,
    0-to-peak, in N m per (rad/s)^2: sums over the cylinders of a station, rods included, pass on.
    """
    torque = np.asarray(inertia_torque, dtype=np.complex128)
    return np.asarray(2.0j * torque / np.arange(1, torque.shape[-1] + 1))


def inertia_at(system: VariableLine, angle: FloatArray) -> LineInertia:
    """Inertias at the crank angles (..., n) of the freedoms, rad."""
    highest = system.variation.shape[-1]
    order = np.arange(1, highest + 1)
    turned = np.exp(1j * np.asarray(angle)[..., None] * order) * system.variation
    value = system.line.inertia + turned.real.sum(axis=-1)
    slope = -(order * turned.imag).sum(axis=-1)
    curvature = -(order**2 * turned.real).sum(axis=-1)
    return LineInertia(value, slope, curvature)


def turning_parts(line: Line) -> FloatArray:
    """`free_parts` (r, n) of the springs: each may turn as a whole."""
    return free_parts(line, line.stiffness != 0.0)


# ----------------------------------------------------------------------------
# The exact motion of a line with variable inertias: its terms, its linearisation, its energy.
#
# Linearised about a motion phi(t), small deviations d obey
#
#     (J d')' + C d' + (K + S) d = 0,   S = J' phi'' + 1/2 J'' (w + phi')^2 - dT/dtheta,
#
# with J at theta = w t + phi; about uniform turning (phi = 0) S is 1/2 w^2 J'' - dT/dtheta, and
# what is missing there, T - 1/2 w^2 J', is gas and inertia torque as usual.
# ----------------------------------------------------------------------------


class EquationTerms(NamedTuple):
    """At crank angles (S,): what multiplies d'', d' and d, and the torque left over, each (S, n).

    `gap` is T - J phi'' - 1/2 J' (w + phi')^2, without the terms of shafts and dampers.
    """

    inertia: FloatArray
    inertia_rate: FloatArray
    stiffness: FloatArray
    gap: FloatArray


def terms(
    system: VariableLine,
    speed: float,
    crank_angle: FloatArray,
    angle: ComplexArray,
    torque: ComplexArray,
) -> EquationTerms:
    """Terms about the motion `angle` (N + 1, n) at w t = crank_angle (S,).

    `torque` (T, n) holds the gas torque's orders k / turns of w t, 0-to-peak (order 0 its real
    part).
    """
    crank = np.asarray(crank_angle)[:, None]
    phase = np.exp(1j * crank * (np.arange(len(angle)) / system.turns))
    turn = (1j * speed / system.turns * np.arange(len(angle)))[:, None]
    twist, rate, faster = ((phase @ part).real for part in (angle, turn * angle, turn**2 * angle))
    place, turning = crank + twist, speed + rate
    inertia = inertia_at(system, place)
    order = np.arange(len(torque))[:, None] / system.turns
    turned = np.exp(1j * np.broadcast_to(crank, place.shape)[:, None, :] * order) * torque
    gap = turned.real.sum(axis=1) - inertia.value * faster - 0.5 * inertia.slope * turning**2
    stiffness = inertia.slope * faster + 0.5 * inertia.curvature * turning**2
    return EquationTerms(inertia.value, inertia.slope * turning, stiffness, gap)


def acceleration(
    system: VariableLine,
    speed: float,
    crank_angle: float,
    angle: FloatArray,
    rate: FloatArray,
    torque: FloatArray,
) -> FloatArray:
    """phi'' (..., n) of the exact equations for phi and phi' (..., n) and torques (..., n), N m.

    Shafts act through their stiffness and damping; loss factors have no form in time.
    """
    inertia = inertia_at(system, crank_angle + angle)
    shafts = angle @ stiffness_matrix(system.line) + rate @ damping_matrix(system.line)
    return np.asarray((torque - shafts - 0.5 * inertia.slope * (speed + rate) ** 2) / inertia.value)


# ----------------------------------------------------------------------------
# Harmonic balance of small deviations with periodic coefficients: all orders in one system.
#
# With d = sum_p d_p exp(i p w t) over orders p = k / turns of both signs, row p of the system is
#
#     (K_p + i p w C) d_p + sum_q [-(q w)^2 a_{p-q} + i q w b_{p-q} + s_{p-q}] d_q = gap_p,
#
# a, b and s the harmonics of inertia, its rate and the stiffness (variable_inertia_motion). About
# uniform turning the bracket is -w^2 (p^2 + q^2) / 2 J_{p-q}, symmetric in the two orders. A piece
# without ground stiffness has its mean angle at zero (that sets the origin of the time) and a
# steady torque of the load as the unknown instead.
# ----------------------------------------------------------------------------

_PATTERNS = (2.0, 3.0, 5.0, 7.0)
_SAFETY = 4.0


class Blocks(NamedTuple):
    """Steps k (P,) of both signs, matrix (P, n, P, n), right side (P, n), border (n, r) twice.

    `size` (P, n, n) is how large the terms are that the diagonal blocks were formed of.
    """

    step: IntArray
    matrix: ComplexArray
    gap: ComplexArray
    load: FloatArray
    origin: FloatArray
    size: FloatArray


class HarmonicSolution(NamedTuple):
    """Inner d (Q, m); round-off and truncation (Q, m), absolute; orders just beyond (P - Q, m)."""

    value: ComplexArray
    rounding: FloatArray
    truncation: FloatArray
    beyond: ComplexArray


def two_sided(samples: FloatArray, highest: int) -> ComplexArray:
    """Harmonics (2 highest + 1, n), -highest first, of samples (S, n) over one cycle."""
    spectrum = np.fft.fft(samples, axis=0) / len(samples)
    return np.asarray(spectrum[np.arange(-highest, highest + 1)])


def two_sided_angle(angle: ComplexArray, highest: int) -> ComplexArray:
    """The same from one-sided 0-to-peak harmonics (N + 1, n)."""
    both = np.zeros((2 * highest + 1, angle.shape[1]), dtype=np.complex128)
    count = len(angle)
    both[highest : highest + count] = 0.5 * angle
    both[highest - count + 1 : highest + 1][::-1] += 0.5 * angle.conj()
    return both


def shaft_matrices(system: VariableLine, speed: float, step: IntArray) -> ComplexArray:
    """K (1 + i loss factor sign p) + i p w C (P, n, n) at the orders p = step / turns."""
    line = system.line
    loss = line.stiffness * (1.0 + 1j * np.sign(step)[:, None] * line.loss_factor)
    elastic = network_matrix(line, loss, line.ground_stiffness.astype(np.complex128))
    frequency = (1j * speed / system.turns) * step[:, None, None]
    return np.asarray(elastic + frequency * damping_matrix(line))


def station_values(
    system: VariableLine, speed: float, parts: EquationTerms, step: IntArray
) -> ComplexArray:
    """The bracket (P, P, n) of the rows and columns `step`, from samples over the cycle."""
    span = int(step[-1] - step[0])
    inertia, rate, stiffness = (two_sided(part, span) for part in parts[:3])
    apart = step[:, None] - step + span
    turn = (1j * speed / system.turns * step)[:, None]
    return np.asarray(turn**2 * inertia[apart] + turn * rate[apart] + stiffness[apart])


def blocks(
    system: VariableLine, speed: float, parts: EquationTerms, angle: ComplexArray, step: IntArray
) -> Blocks:
    """The system of the steps (P,), rising and of both signs.

    Steps left out must not be coupled with those taken.
    """
    highest = max(int(np.abs(step).max()), len(angle) - 1)
    shafts = shaft_matrices(system, speed, step)
    about = two_sided_angle(angle, highest)[step + highest]
    gap = two_sided(parts.gap, highest)[step + highest] - (shafts @ about[..., None])[..., 0]
    place, index = np.arange(len(step)), np.arange(angle.shape[1])
    matrix = np.zeros((len(step), len(index), len(step), len(index)), dtype=np.complex128)
    matrix[:, index, :, index] = np.moveaxis(station_values(system, speed, parts, step), -1, 0)
    matrix[place, :, place, :] += shafts
    free = turning_parts(system.line)[: len(index) if np.any(step == 0) else 0]
    load, origin = (free * part for part in (system.load, system.line.inertia))
    large = np.abs(shafts)
    inertial = (speed / system.turns * step)[:, None] ** 2 * np.abs(parts.inertia).max(axis=0)
    large[:, index, index] += inertial
    return Blocks(step, matrix, gap, load.T, origin.T, large)


def solve(system_blocks: Blocks, highest: int, size: FloatArray) -> HarmonicSolution | None:
    """Orders to `highest` (steps), what rounding does to them, and what the orders beyond do.

    Orders beyond are driven by those inside and act back on them once: three times that is the
    estimate of the truncation. `size` (Q, m) says how large the terms of the right side are.
    None if the matrix is singular to working precision.
    """
    from scipy.linalg import lu_factor, lu_solve

    inside = np.abs(system_blocks.step) <= highest
    matrix, count = _bordered(system_blocks, inside)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        factors = lu_factor(matrix, check_finite=False)
    if not np.all(np.diagonal(factors[0])):
        return None

    def answer(right: ComplexArray) -> ComplexArray:
        padded = np.zeros((len(matrix), right.shape[1]), dtype=np.complex128)
        padded[:count] = right
        first = lu_solve(factors, padded, check_finite=False)
        return np.asarray(first + lu_solve(factors, padded - matrix @ first, check_finite=False))

    shape = (int(inside.sum()), system_blocks.gap.shape[1])
    whole = answer(system_blocks.gap[inside].reshape(-1, 1))[:, 0]
    value = whole[:count]
    of_terms = (system_blocks.size[inside] @ np.abs(value).reshape(*shape, 1))[..., 0]
    term = np.abs(matrix) @ np.abs(whole)
    term[:count] += (size + of_terms).ravel()
    index = np.arange(1, count + 1)[:, None]
    signs = np.where(np.sin(index * np.sqrt(_PATTERNS)) > 0.0, 1.0, -1.0)
    spread = answer((EPSILON * signs * term[:count, None]).astype(np.complex128))[:count]
    rounding = _SAFETY * np.sqrt((np.abs(spread) ** 2).sum(axis=1))
    truncation, beyond = np.zeros(count), system_blocks.gap[:0]
    if not np.all(inside):
        inner, outer = system_blocks.matrix[inside], system_blocks.matrix[~inside]
        driven = system_blocks.gap[~inside].ravel()
        driven = driven - outer[:, :, inside].reshape(-1, count) @ value
        outer_block = outer[:, :, ~inside].reshape(len(driven), -1)
        beyond = np.asarray(np.linalg.solve(outer_block, driven), dtype=np.complex128)
        back = inner[:, :, ~inside].reshape(count, -1) @ beyond
        truncation = 3.0 * np.abs(answer(back[:, None])[:count, 0])
    return HarmonicSolution(
        value.reshape(shape), rounding.reshape(shape), truncation.reshape(shape),
        beyond.reshape(-1, shape[1]),
    )  # fmt: skip


def _bordered(system_blocks: Blocks, inside: np.ndarray) -> tuple[ComplexArray, int]:
    """Inner matrix with the load's torque and the origin of the time at order 0."""
    inner = system_blocks.matrix[inside][:, :, inside]
    n = inner.shape[1]
    count, parts = inner.shape[0] * n, system_blocks.load.shape[1]
    matrix = np.zeros((count + parts, count + parts), dtype=np.complex128)
    matrix[:count, :count] = inner.reshape(count, count)
    if parts:
        start = int(np.flatnonzero(system_blocks.step[inside] == 0)[0]) * n
        load, origin = bordering(system_blocks.load, system_blocks.origin, matrix)
        matrix[start : start + n, count:], matrix[count:, start : start + n] = -load, origin.T
    return matrix, count


def bordering(
    load: FloatArray, origin: FloatArray, matrix: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Both (n, r), of the size of a matrix that they border."""
    scale = np.abs(matrix).max()
    return scale * load / np.abs(load).max(axis=0), scale * origin / np.abs(origin).max(axis=0)


# ----------------------------------------------------------------------------
# Steady motion of a line with variable inertias: all orders at once, linear or exact.
#
# Linear: small vibration about uniform turning, orders coupled by the inertias. Exact: Newton's
# method on the whole Lagrangian system; its first step from rest is the linear response.
# ----------------------------------------------------------------------------

MOST_ITERATIONS = 25
_NEGLIGIBLE = 1e-15
_STANDS = 1e-12
#: relative truncation that is refused: more orders mend it, so the error may speak up to there
_COARSE = 1e-2


class SteadyTwist(NamedTuple):
    """Twist against uniform turning, 0-to-peak, phase from w t = 0, by speed, order and freedom.

    `order` (N + 1,); `angle` and `error` (S, N + 1, n) in rad; `beyond` (S,) is the largest twist
    at an order above the highest that those inside drive.
    """

    order: FloatArray
    angle: ComplexArray
    error: FloatArray
    beyond: FloatArray


def steady_response(
    system: VariableLine,
    speed: ArrayLike,
    torque: ArrayLike,
    highest_order: float,
    *,
    exact: bool = False,
) -> SteadyTwist:
    """Steady motion at the speeds (S,), with the inertia torque that the variation makes.

    Parameters
    ----------
    speed : (S,), rad/s
    torque : complex (T, n) or (S, T, n), N m
        Gas torque at each freedom, orders k / turns from k = 0, 0-to-peak, cylinders' phases
        applied. No inertia torque: it comes from the variation. Means are balanced by the load.
    highest_order
        Orders kept; a multiple of 1 / turns.
    exact
        Solve the nonlinear equations, else those linear in the twist.

    Returns
    -------
    SteadyTwist
        The error counts round-off (sampled), three times what the orders beyond give back, and the
        last step of Newton's method. Linearisation is not counted.

    Raises
    ------
    NumericalFailure
        Singular (an undamped critical or a limit of stability), too few orders, or Newton's method
        fails. Stability is not examined here: see variable_inertia_stability.
    """
    speeds = np.atleast_1d(np.asarray(speed, dtype=np.float64))
    forces = np.asarray(torque, dtype=np.complex128)
    forces = np.broadcast_to(forces, (len(speeds), *forces.shape[-2:]))
    highest = round(highest_order * system.turns)
    rows = [
        _one_speed(system, float(w), force, highest, exact)
        for w, force in zip(speeds, forces, strict=True)
    ]
    angle, error, beyond = (np.array(part) for part in zip(*rows, strict=True))
    return SteadyTwist(np.arange(highest + 1) / system.turns, angle, error, beyond)


def _one_speed(
    system: VariableLine,
    speed: float,
    torque: ComplexArray,
    highest: int,
    exact: bool,
) -> tuple[ComplexArray, FloatArray, float]:
    n = torque.shape[-1]
    reach = _reach(system)
    bound = highest + max(reach, len(torque) - 1 - highest, 0)
    samples = 1 << int(4 * bound + 2 * reach + 2 * len(torque) + 8).bit_length()
    turn = 2.0 * np.pi * system.turns
    crank_angle = np.linspace(0.0, turn, samples, endpoint=False)
    angle = np.zeros((highest + 1, n), dtype=np.complex128)
    size = np.zeros((2 * highest + 1, n))
    apart = system.turns if not exact else 1
    move = np.inf
    for count in range(MOST_ITERATIONS):
        parts = terms(system, speed, crank_angle, angle, torque)
        if count == 0:
            size += np.abs(parts.gap).max(axis=0)
        solution = _step(system, speed, parts, angle, (highest, bound, apart), size)
        step = _one_sided(solution.value)
        largest = float(np.abs(angle + step).max())
        last, move = move, float(np.abs(step).max())
        # small steps that no longer shrink are round-off
        ended = move <= _STANDS * largest or (move > 0.25 * last and move <= 1e-9 * largest)
        angle = angle + step
        if not exact or (ended and count):
            break
    else:
        raise NumericalFailure(
            f"variable inertia at {in_rpm(speed)}: Newton's method has not settled after "
            f"{MOST_ITERATIONS} steps (the last {move:.2g} rad); it is large or does not exist"
        )
    error = _trusted(solution, largest, speed, system, move if exact else 0.0)
    return angle, error, float(np.abs(solution.beyond).max(initial=0.0) * 2.0)


def _step(
    system: VariableLine,
    speed: float,
    parts: EquationTerms,
    angle: ComplexArray,
    reach: tuple[int, int, int],
    size: FloatArray,
) -> HarmonicSolution:
    """Newton's step; `reach` is the highest step, that of the orders beyond, and how far apart
    coupled steps are at least: whole and half orders have nothing to do with each other at first.
    """
    highest, bound, apart = reach
    step = np.arange(-bound, bound + 1)
    inside = np.arange(-highest, highest + 1)
    value = np.zeros((len(inside), angle.shape[1]), dtype=np.complex128)
    rounding, truncation, beyond = np.zeros(value.shape), np.zeros(value.shape), []
    for remainder in range(apart):
        steps_here = step[step % apart == remainder]
        place = inside % apart == remainder
        if not place.any():
            continue
        solution = solve(blocks(system, speed, parts, angle, steps_here), highest, size[place])
        if solution is None:
            raise _singular(speed, system)
        value[place], rounding[place], truncation[place] = solution[:3]
        beyond.append(solution.beyond)
    return HarmonicSolution(value, rounding, truncation, np.concatenate(beyond))


def _reach(system: VariableLine) -> int:
    """Steps over which orders are coupled directly."""
    large = np.abs(system.variation) > _NEGLIGIBLE * system.line.inertia[:, None]
    used = np.flatnonzero(large.any(axis=0))
    return system.turns * (int(used[-1]) + 1) if len(used) else 0


def _one_sided(value: np.ndarray) -> ComplexArray:
    middle = len(value) // 2
    found = value[middle:] + value[middle::-1].conj()
    found[0] = 0.5 * found[0].real
    return np.asarray(found)


def _trusted(
    solution: HarmonicSolution,
    largest: float,
    speed: float,
    system: VariableLine,
    move: float,
) -> FloatArray:
    """Absolute error (N + 1, n), or the failure that it amounts to."""
    middle = len(solution.value) // 2
    rounding, truncation = (
        part[middle:] + part[middle::-1] for part in (solution.rounding, solution.truncation)
    )
    if not np.isfinite(rounding).all() or rounding.max() > SINGULAR * largest:
        raise _singular(speed, system)
    if truncation.max() > _COARSE * largest:
        raise NumericalFailure(
            f"variable inertia at {in_rpm(speed)}: the orders above {middle / system.turns:g} "
            f"change the twist by up to {truncation.max():.2g} of {largest:.2g} rad; take more"
        )
    return np.asarray(rounding + truncation + move)


def _singular(speed: float, system: VariableLine) -> NumericalFailure:
    return NumericalFailure(
        f"variable inertia at {in_rpm(speed)}: no single steady motion; the speed is an undamped "
        f"critical or a limit of stability of the line of {len(system.line.inertia)} freedoms"
    )


# ----------------------------------------------------------------------------
# Which orders feed which: what a variable inertia adds to the twist of each section, by source.
#
# Order q of the twist makes, through the inertias' order p - q (and p + q), the torque
#
#     w^2 / 2 (p^2 + q^2) (J_{p-q} d_q + J_{p+q} conj d_q)
#
# of order p. Where p w is near a natural frequency the line answers: a secondary resonance, at an
# order that may have no torque of its own.
# ----------------------------------------------------------------------------


def feed(system: VariableLine, speed: float, angle: ComplexArray) -> ComplexArray:
    """Twist (N + 1, N + 1, e) by receiving order, feeding order and element, rad, 0-to-peak.

    At one speed, from the linear response `angle` (N + 1, n). Summed over the feeding orders it is
    exactly its twist less that at constant inertia. Of the mean line a round-off is that of its
    condition at each order: `with_errors` tells it.

    Raises
    ------
    NumericalFailure
        An order meets an undamped natural frequency of the mean line.
    """
    line, count, n = system.line, len(angle), angle.shape[1]
    drive, step = _coupling(system, speed, angle), np.arange(count)
    dynamic = shaft_matrices(system, speed, step)
    index = np.arange(n)
    dynamic[:, index, index] -= (speed * step / system.turns)[:, None] ** 2 * line.inertia
    twist = np.empty((count, count, len(line.first)), dtype=np.complex128)
    for p, matrix in enumerate(dynamic):
        if p == 0:
            free = turning_parts(line)
            load, origin = ((free * part).T for part in (system.load, line.inertia))
            load, origin = bordering(load, origin, matrix)
            matrix = np.block([[matrix, -load], [origin.T, np.zeros((len(free), len(free)))]])
        if not EPSILON * float(np.linalg.cond(matrix)) < SINGULAR:
            raise NumericalFailure(
                f"variable inertia at {in_rpm(speed)}: order {p / system.turns:g} meets an "
                "undamped natural frequency of the line"
            )
        moved = np.linalg.inv(matrix)[:n, :n]
        twist[p] = drive[p] @ (moved[line.first] - moved[line.second]).T
    return twist


def _coupling(system: VariableLine, speed: float, angle: ComplexArray) -> ComplexArray:
    """Torques (P, Q, n) at orders p from orders q."""
    count, n = angle.shape
    half = np.zeros((2 * count, n), dtype=np.complex128)
    steps = system.turns * np.arange(1, system.variation.shape[1] + 1)
    within = steps < 2 * count
    half[steps[within]] = 0.5 * system.variation.T[within]
    both = np.concatenate([half[:0:-1].conj(), half])
    step = np.arange(count)
    middle = 2 * count - 1
    sum_, apart = (both[middle + step[:, None] + s * step] for s in (1, -1))
    torque = apart * angle + sum_ * angle.conj()
    # a mean is one harmonic of the two-sided series, every other order two
    torque[0] = 0.5 * torque[0].real
    squares = step[:, None] ** 2 + step**2
    return np.asarray(0.5 * (speed / system.turns) ** 2 * squares[..., None] * torque)
