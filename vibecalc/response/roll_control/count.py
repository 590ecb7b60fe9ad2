"""How many poles stand to the right, counted and not searched for, and what follows from it."""

import math

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.roll_control.crossings import Crossings, crossings
from vibecalc.response.roll_control.model import Loop, feedthrough

#: what `status` numbers mean; only the first two are stable
STATUS = (
    "stable",
    "stable only without any delay",
    "on the limit of stability",
    "unstable",
    "unstable with the least lag of the actuator",
)

#: phase (rad) or relative gain from the limit, below which nothing is called stable
_LIMIT = 1e-9


def poles_right(loop: Loop, cross: Crossings | None = None) -> np.ndarray:
    """Number of roots with positive real part, exact, as a float: infinite for a neutral loop
    whose high-frequency gain reaches one.

    Without the delay the signs of a quadratic tell; as the delay grows roots cross the axis only
    at the frequencies with |L| = 1, always the same way, once a turn of w T. Source: K. Walton
    and J. E. Marshall, Direct method for TDS stability analysis, IEE Proc. D 134 (1987) 101.
    """
    cross = crossings(loop) if cross is None else cross
    linear, constant = loop.p1 + loop.q1, loop.p0 + loop.q0
    pair = np.where(linear < 0.0, 2.0, 0.0)
    second = np.where(constant < 0.0, 1.0, pair)
    first = np.where(linear * constant < 0.0, 1.0, 0.0)
    count = np.where(loop.p2 > 0.0, second, first)

    turned = cross.frequency * loop.delay[..., None] - cross.critical
    passed = np.where(turned > 0.0, np.floor(turned / (2.0 * math.pi)) + 1.0, 0.0)
    count = count + 2.0 * np.sum(passed * cross.outward, axis=-1)
    neutral = (loop.delay > 0.0) & (loop.p2 == 0.0) & (np.abs(loop.q1) >= np.abs(loop.p1))
    return np.where(neutral, np.inf, count)


def status(loop: Loop, cross: Crossings | None = None) -> np.ndarray:
    """Which of `STATUS` holds, as whole numbers. Doubt counts against the loop.

    "On the limit": within 1e-9 (rad, or of the gain), or nearer than rounding can tell.
    """
    cross = crossings(loop) if cross is None else cross
    right = poles_right(loop, cross)
    level = feedthrough(loop)
    late = loop.delay > 0.0

    found = np.where(right > 0.0, 3, 0)
    outrun = (loop.p2 == 0.0) & ~late & (loop.p1 + loop.q1 < 0.0)
    found = np.where(outrun & (right == 0.0), 4, found)
    found = np.where(_on_limit(loop, cross), 2, found)
    bare = (loop.p2 == 0.0) & ~late & (np.abs(level) >= 1.0 - _LIMIT)
    return np.where(bare & (found == 0), 1, found)


def _on_limit(loop: Loop, cross: Crossings) -> np.ndarray:
    linear, constant = loop.p1 + loop.q1, loop.p0 + loop.q0
    near = np.abs(constant) <= _LIMIT * (np.abs(loop.p0) + np.abs(loop.q0))
    near |= np.abs(linear) <= _LIMIT * (np.abs(loop.p1) + np.abs(loop.q1))
    tolerance = np.maximum(_LIMIT, cross.phase_error)
    for lag in (cross.slack, cross.critical):
        away = np.minimum(lag, 2.0 * math.pi - lag)
        near |= np.any(cross.present & (away <= tolerance), axis=-1)
    edge = np.abs(np.abs(loop.q1) - np.abs(loop.p1)) <= _LIMIT * np.abs(loop.p1)
    limit: np.ndarray = near | ((loop.delay > 0.0) & (loop.p2 == 0.0) & edge)
    return limit


def shifted(loop: Loop, by: np.ndarray | float) -> Loop:
    """The loop seen from `by` (1/s): its roots are the old ones minus `by`."""
    fade = np.exp(-by * loop.delay)
    return Loop(
        p2=loop.p2,
        p1=loop.p1 + 2.0 * loop.p2 * by,
        p0=loop.p0 + (loop.p1 + loop.p2 * by) * by,
        q1=loop.q1 * fade,
        q0=(loop.q0 + loop.q1 * by) * fade,
        delay=loop.delay,
    )


def rounding_of(loop: Loop, s: np.ndarray) -> np.ndarray:
    """Bound of the rounding in P(s) + Q(s) exp(-s delay) at s (..., m), for error estimates."""
    p2, p1, p0, q1, q0, delay = (np.abs(a[..., None]) for a in loop)
    r = np.abs(s)
    direct = (p2 * r + p1) * r + p0
    back = (q1 * r + q0) * np.exp(-s.real * delay) * (1.0 + r * delay)
    bound: np.ndarray = 12.0 * UNIT_ROUNDOFF * (direct + back)
    return bound
