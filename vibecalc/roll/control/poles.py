"""Poles of the closed loop, with a delay and without, and how they move as its gain grows."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.roll.control.gains import LoopLoad
from vibecalc.roll.control.loop import Controller, Loop, ReducedModel, loop_of, speed_feedback_for
from vibecalc.roll.control.margins import poles_right, rounding_of, shifted

# ----------------------------------------------------------------------------
# Where to begin the search for the poles of a loop with a delay.
# ----------------------------------------------------------------------------


def first_guesses(loop: Loop, order: int, branches: int) -> np.ndarray:
    """Approximate roots (m,) in 1/s of P(s) + Q(s) exp(-s delay), the delay positive.

    Near the origin those without the delay and those with its diagonal Pade approximant, of
    `order`; far away those of the leading terms alone, by branches of Lambert's W function, or
    the chain of a loop without a lag. One loop, all coefficients scalars. Only starts: some lead
    nowhere.
    """
    plain = np.roots([loop.p2, loop.p1 + loop.q1, loop.p0 + loop.q0])
    return np.concatenate([plain, _by_pade(loop, order), _by_leading_terms(loop, branches)])


def _by_pade(loop: Loop, order: int) -> np.ndarray:
    top = math.factorial(2 * order)
    weight = np.array([
        math.factorial(2 * order - k) * math.factorial(order)
        / (top * math.factorial(k) * math.factorial(order - k))
        for k in range(order, -1, -1)
    ])  # fmt: skip
    sign = np.array([(-1.0) ** k for k in range(order, -1, -1)])
    time = float(loop.delay)
    direct = np.array([loop.p2 / time**2, loop.p1 / time, loop.p0])
    back = np.array([loop.q1 / time, loop.q0])
    poly = np.polyadd(np.polymul(direct, weight), np.polymul(back, weight * sign))
    found: np.ndarray = np.roots(np.trim_zeros(poly, "f")) / time
    return found


def _by_leading_terms(loop: Loop, branches: int) -> np.ndarray:
    from scipy.special import lambertw

    time = float(loop.delay)
    number = np.arange(-branches, branches + 1)
    if loop.p2 == 0.0 and loop.q1 != 0.0:
        level = complex(-loop.q1 / loop.p1)
        chain: np.ndarray = (np.log(level) + 2j * math.pi * number) / time
        return chain
    if loop.p2 > 0.0 and loop.q1 != 0.0:
        roots: np.ndarray = lambertw(-loop.q1 * time / loop.p2, number) / time
        return roots
    if loop.q0 == 0.0:
        return np.zeros(0, dtype=complex)
    if loop.p2 == 0.0:
        single: np.ndarray = lambertw(-loop.q0 * time / loop.p1, number) / time
        return single
    root = np.sqrt(complex(-loop.q0 / loop.p2)) * time / 2.0
    both = [2.0 * lambertw(sign * root, number) / time for sign in (1.0, -1.0)]
    return np.concatenate(both)


# ----------------------------------------------------------------------------
# Poles of the closed loop: two of a plain one, the rightmost of the many that a delay makes.
# ----------------------------------------------------------------------------

#: orders of the delay's rational stand-in, tried in turn until no pole is missing
_STAND_INS = (8, 12, 16, 22, 30)
_SAME = 1e-7


class LoopPoles(NamedTuple):
    """Poles (..., count) in 1/s, rightmost first, pairs with the positive imaginary part first.

    `complete`: every pole to the right of the last is there, by an exact count. False only for
    a delay without a lag, whose poles come as an endless chain along a vertical line; then those
    with the smallest imaginary part are given next to all to the right of that line.
    """

    value: np.ndarray
    error: np.ndarray
    complete: np.ndarray


def poles(loop: Loop, count: int = 6) -> LoopPoles:
    """Closed-loop poles; lag and delay must be the same for all loops.

    Without a delay there are two (lag > 0) or one, whatever `count` says, and infinity stands for
    one that has left (k_S cancels the rotor's inertia). Raises NumericalFailure where the search
    and the count cannot be made to agree.
    """
    if not np.any(loop.delay > 0.0):
        return _plain(loop)
    shape = loop.p0.shape
    value = np.empty((*shape, count), dtype=complex)
    complete = np.empty(shape, dtype=bool)
    for place in np.ndindex(shape):
        one = Loop(*(a[place] for a in loop))
        value[place], complete[place] = _late(one, count)
    return LoopPoles(value, _error(loop, value), complete)


def _plain(loop: Loop) -> LoopPoles:
    linear, constant = loop.p1 + loop.q1, loop.p0 + loop.q0
    with np.errstate(divide="ignore", invalid="ignore"):
        if not np.any(loop.p2 > 0.0):
            value = np.where(linear == 0.0, np.inf, -constant / linear)[..., None] + 0j
        else:
            square = linear * linear - 4.0 * loop.p2 * constant
            root = np.sqrt(np.abs(square))
            side = -0.5 * (linear + np.where(linear < 0.0, -1.0, 1.0) * root)
            real = np.stack([side / loop.p2, np.where(side == 0.0, 0.0, constant / side)], axis=-1)
            pair = np.stack([-linear + 1j * root, -linear - 1j * root], axis=-1)
            swings = (square < 0.0)[..., None]
            value = np.where(swings, 0.5 * pair / loop.p2[..., None], real)
    value = _ordered(value)
    error = np.where(np.isfinite(value), _error(loop, np.where(np.isfinite(value), value, 0)), 0)
    return LoopPoles(value, error, np.ones(loop.p0.shape, dtype=bool))


def _ordered(value: np.ndarray) -> np.ndarray:
    rank = np.lexsort((-value.imag, -value.real), axis=-1)
    ordered: np.ndarray = np.take_along_axis(value, rank, axis=-1)
    return ordered


def _terms(loop: Loop, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The characteristic function and its first two derivatives at s (..., m)."""
    p2, p1, p0, q1, q0, delay = (np.asarray(a)[..., None] for a in loop)
    fade = np.exp(-s * delay)
    back = q1 * s + q0
    value = (p2 * s + p1) * s + p0 + back * fade
    slope = 2.0 * p2 * s + p1 + (q1 - delay * back) * fade
    bend = 2.0 * p2 + delay * (delay * back - 2.0 * q1) * fade
    return value, slope, bend


def _error(loop: Loop, s: np.ndarray) -> np.ndarray:
    """First order in the residual, or second order where two poles nearly meet."""
    value, slope, bend = _terms(loop, s)
    uncertainty = np.abs(value) + rounding_of(loop, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        single = np.where(slope == 0.0, np.inf, 2.0 * uncertainty / np.abs(slope))
        double = np.where(bend == 0.0, np.inf, 2.0 * np.sqrt(2.0 * uncertainty / np.abs(bend)))
    error: np.ndarray = np.minimum(single, double) + 2.0**-52 * np.abs(s)
    return error


def _late(loop: Loop, count: int) -> tuple[np.ndarray, bool]:
    chain = -np.inf
    if loop.p2 == 0.0 and loop.q1 != 0.0:
        chain = float(np.log(np.abs(loop.q1) / loop.p1) / loop.delay)
    for trial, order in enumerate(_STAND_INS):
        roots = _polished(loop, first_guesses(loop, order, (2 * count + 4) << trial))
        inside = roots[roots.real > chain + 1e-9 * (1.0 + abs(chain))]
        chosen = roots if chain == -np.inf else inside
        edge = _edge(chosen, count, chain)
        if edge is not None and poles_right(shifted(loop, edge)) == np.sum(chosen.real > edge):
            if chain == -np.inf or len(chosen) >= count:
                return chosen[:count], True
            remainder = roots[roots.real <= edge]
            remainder = remainder[np.argsort(np.abs(remainder.imag), kind="stable")]
            together = np.concatenate([chosen, remainder[: count - len(chosen)]])
            if len(together) == count:
                return together, False
    raise NumericalFailure(
        f"poles of a loop with a delay of {float(loop.delay):.6g} s: the roots found do not agree "
        f"with their number. Give the actuator a lag, or ask for fewer poles"
    )


def _edge(roots: np.ndarray, count: int, chain: float) -> float | None:
    """A line left of the poles wanted and clear of all, to count what lies to its right."""
    if len(roots) <= count:
        if chain == -np.inf:
            return None
        last = float(roots[-1].real) if len(roots) else chain + 1.0 + abs(chain)
        return 0.5 * (last + chain)
    gaps = roots[count - 1 : -1].real - roots[count:].real
    wide = np.flatnonzero(gaps > 1e-6 * (1.0 + np.abs(roots[count:].real)))
    if not len(wide):
        return None
    first = count - 1 + int(wide[0])
    return float(0.5 * (roots[first].real + roots[first + 1].real))


def _polished(loop: Loop, start: np.ndarray) -> np.ndarray:
    """Newton from every start at once; what has converged, once each, rightmost first."""
    s = start.astype(complex)
    with np.errstate(all="ignore"):
        for _ in range(60):
            value, slope, _ = _terms(loop, s)
            step = value / slope
            limit = 1.0 / loop.delay + 0.2 * np.abs(s)
            step *= np.minimum(1.0, limit / np.maximum(np.abs(step), 1e-300))
            s = s - np.where(np.isfinite(step), step, 0.0)
        value, slope, _ = _terms(loop, s)
        good = np.isfinite(value) & (np.abs(value) <= 100.0 * rounding_of(loop, s))
    s = s[good]
    s = np.where(np.abs(s.imag) <= 1e-9 * np.abs(s), s.real + 0j, s.real + 1j * np.abs(s.imag))
    distinct: list[complex] = []
    for root in s:
        if all(abs(root - other) > _SAME * abs(root) for other in distinct):
            distinct.append(complex(root))
    both = distinct + [root.conjugate() for root in distinct if root.imag > 0.0]
    return _ordered(np.array(both, dtype=complex))


# ----------------------------------------------------------------------------
# Root locus: how the poles move as the controller's gain grows.
# ----------------------------------------------------------------------------


class Locus(NamedTuple):
    """`gain` (g,) ascending as given; `pole` (g, branches) complex in 1/s with absolute errors.

    A column follows one pole from gain to gain as far as the steps allow; a picture may draw it
    as a line.
    """

    gain: np.ndarray
    pole: np.ndarray
    pole_error: np.ndarray


def root_locus(
    model: ReducedModel, controller: Controller, gains: ArrayLike, load: LoopLoad | None = None,
    target: float = 0.0, count: int = 6,
) -> Locus:  # fmt: skip
    """Poles for each of `gains` (g,); with a `load` the speed feedback keeps `target` (rad/s).

    `controller` gives the feedbacks, lag and delay (scalars); its gain is ignored. Each row holds
    two poles (one without lag), or `count` of the rightmost with a delay.
    """
    from scipy.optimize import linear_sum_assignment

    gain = np.asarray(gains, dtype=float)
    moved = controller._replace(gain=gain)
    if load is not None:
        feedback = speed_feedback_for(model, gain, load.reference, load.mean, target)
        moved = moved._replace(speed_feedback=feedback.value)
    located = poles(loop_of(model, moved), count)
    pole, error = located.value.copy(), located.error.copy()
    for row in range(1, len(gain)):
        away = np.abs(pole[row - 1][:, None] - pole[row][None, :])
        away = np.where(np.isfinite(away), away, 1e300)
        _, order = linear_sum_assignment(away)
        pole[row], error[row] = pole[row][order], error[row][order]
    return Locus(gain, pole, error)
