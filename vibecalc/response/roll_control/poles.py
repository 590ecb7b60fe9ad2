"""Poles of the closed loop: two of a plain one, the rightmost of the many that a delay makes."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.response.roll_control.count import poles_right, rounding_of, shifted
from vibecalc.response.roll_control.delay_starts import first_guesses
from vibecalc.response.roll_control.model import Loop

#: orders of the delay's rational stand-in, tried in turn until no pole is missing
_STAND_INS = (8, 12, 16, 22, 30)
_SAME = 1e-7


class Poles(NamedTuple):
    """Poles (..., count) in 1/s, rightmost first, pairs with the positive imaginary part first.

    `complete`: every pole to the right of the last is there, by an exact count. False only for
    a delay without a lag, whose poles come as an endless chain along a vertical line; then those
    with the smallest imaginary part are given beside all to the right of that line.
    """

    value: np.ndarray
    error: np.ndarray
    complete: np.ndarray


def poles(loop: Loop, count: int = 6) -> Poles:
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
    return Poles(value, _error(loop, value), complete)


def _plain(loop: Loop) -> Poles:
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
    return Poles(value, error, np.ones(loop.p0.shape, dtype=bool))


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
    doubt = np.abs(value) + rounding_of(loop, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        single = np.where(slope == 0.0, np.inf, 2.0 * doubt / np.abs(slope))
        double = np.where(bend == 0.0, np.inf, 2.0 * np.sqrt(2.0 * doubt / np.abs(bend)))
    error: np.ndarray = np.minimum(single, double) + 2.0**-52 * np.abs(s)
    return error


def _late(loop: Loop, count: int) -> tuple[np.ndarray, bool]:
    chain = -np.inf
    if loop.p2 == 0.0 and loop.q1 != 0.0:
        chain = float(np.log(np.abs(loop.q1) / loop.p1) / loop.delay)
    for trial, order in enumerate(_STAND_INS):
        found = _polished(loop, first_guesses(loop, order, (2 * count + 4) << trial))
        inside = found[found.real > chain + 1e-9 * (1.0 + abs(chain))]
        chosen = found if chain == -np.inf else inside
        edge = _edge(chosen, count, chain)
        if edge is not None and poles_right(shifted(loop, edge)) == np.sum(chosen.real > edge):
            if chain == -np.inf or len(chosen) >= count:
                return chosen[:count], True
            rest = found[found.real <= edge]
            rest = rest[np.argsort(np.abs(rest.imag), kind="stable")]
            together = np.concatenate([chosen, rest[: count - len(chosen)]])
            if len(together) == count:
                return together, False
    raise NumericalFailure(
        f"poles of a loop with a delay of {float(loop.delay):.6g} s: the roots found do not agree "
        f"with their number. Give the actuator a lag, or ask for fewer poles"
    )


def _edge(found: np.ndarray, count: int, chain: float) -> float | None:
    """A line left of the poles wanted and clear of all, to count what lies to its right."""
    if len(found) <= count:
        if chain == -np.inf:
            return None
        last = float(found[-1].real) if len(found) else chain + 1.0 + abs(chain)
        return 0.5 * (last + chain)
    gaps = found[count - 1 : -1].real - found[count:].real
    wide = np.flatnonzero(gaps > 1e-6 * (1.0 + np.abs(found[count:].real)))
    if not len(wide):
        return None
    first = count - 1 + int(wide[0])
    return float(0.5 * (found[first].real + found[first + 1].real))


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
    kept: list[complex] = []
    for root in s:
        if all(abs(root - other) > _SAME * abs(root) for other in kept):
            kept.append(complex(root))
    both = kept + [root.conjugate() for root in kept if root.imag > 0.0]
    return _ordered(np.array(both, dtype=complex))
