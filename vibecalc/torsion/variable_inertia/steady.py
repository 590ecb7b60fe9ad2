"""Steady motion of a line with variable inertias: all orders at once, which of them feed which."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, SINGULAR, ComplexArray, FloatArray
from vibecalc.torsion.line import Line
from vibecalc.torsion.variable_inertia.motion import (
    EquationTerms,
    HarmonicSolution,
    VariableLine,
    blocks,
    bordering,
    shaft_matrices,
    solve,
    terms,
    turning_parts,
)

# ----------------------------------------------------------------------------
# Steady motion of a line with variable inertias: all orders at once, linear or exact.
#
# Linear: small vibration about uniform turning, orders coupled by the inertias (and by the slope of
# the gas torque when it follows the throw's own angle). Exact: Newton's method on the whole
# Lagrangian system; its first step from rest is the linear response.
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
    follows: bool = False,
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
    follows
        The gas torque is a function of the throw's own angle, else of w t.
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
        _one_speed(system, float(w), force, highest, follows, exact)
        for w, force in zip(speeds, forces, strict=True)
    ]
    angle, error, beyond = (np.array(part) for part in zip(*rows, strict=True))
    return SteadyTwist(np.arange(highest + 1) / system.turns, angle, error, beyond)


def _one_speed(
    system: VariableLine,
    speed: float,
    torque: ComplexArray,
    highest: int,
    follows: bool,
    exact: bool,
) -> tuple[ComplexArray, FloatArray, float]:
    n = torque.shape[-1]
    reach = _reach(system, torque, follows)
    bound = highest + max(reach, len(torque) - 1 - highest, 0)
    samples = 1 << int(4 * bound + 2 * reach + 2 * len(torque) + 8).bit_length()
    turn = 2.0 * np.pi * system.turns
    crank_angle = np.linspace(0.0, turn, samples, endpoint=False)
    angle = np.zeros((highest + 1, n), dtype=np.complex128)
    size = np.zeros((2 * highest + 1, n))
    apart = system.turns if not (exact or follows) else 1
    move = np.inf
    for count in range(MOST_ITERATIONS):
        parts = terms(system, speed, crank_angle, angle, torque, follows=follows)
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
            f"variable inertia at {speed:.6g} rad/s: Newton's method has not settled after "
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


def _reach(system: VariableLine, torque: ComplexArray, follows: bool) -> int:
    """Steps over which orders are coupled directly."""
    large = np.abs(system.variation) > _NEGLIGIBLE * system.line.inertia[:, None]
    used = np.flatnonzero(large.any(axis=0))
    inertial = system.turns * (int(used[-1]) + 1) if len(used) else 0
    return max(inertial, len(torque) - 1 if follows else 0)


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
            f"variable inertia at {speed:.6g} rad/s: the orders above {middle / system.turns:g} "
            f"change the twist by up to {truncation.max():.2g} of {largest:.2g} rad; take more"
        )
    return np.asarray(rounding + truncation + move)


def _singular(speed: float, system: VariableLine) -> NumericalFailure:
    return NumericalFailure(
        f"variable inertia at {speed:.6g} rad/s: no single steady motion; the speed is an undamped "
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


def section_twist(line: Line, angle: ComplexArray) -> ComplexArray:
    """Twist (..., e) of every element from angles (..., n)."""
    return np.asarray(angle[..., line.first] - angle[..., line.second])


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
                f"variable inertia at {speed:.6g} rad/s: order {p / system.turns:g} meets an "
                "undamped natural frequency of the line"
            )
        twist[p] = drive[p] @ section_twist(line, np.linalg.inv(matrix)[:n, :n].T)
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
