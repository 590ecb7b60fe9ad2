"""Stability of the loop broken at the controller: poles to the right, and margins."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.roll.control.loop import Loop, feedthrough

# ----------------------------------------------------------------------------
# Where the open loop has gain one, and how far its phase then is from -180 degrees.
# ----------------------------------------------------------------------------

_TURN = 2.0 * math.pi


class Crossings(NamedTuple):
    """Up to two frequencies (..., 2) with |L| = 1, ascending in neither; see `present`.

    `frequency` (rad/s, positive; 1.0 where absent) and its absolute `frequency_error`;
    `critical` in [0, 2 pi): the lag w T of a delay T that would bring L to -1, delay not counted;
    `slack` in [0, 2 pi): lag that is still allowed next to the loop's own delay; `phase_error`
    belongs to both. `outward`: +1 where roots cross to the right as the delay grows, else -1,
    0 where they only touch the axis.
    """

    present: np.ndarray
    frequency: np.ndarray
    frequency_error: np.ndarray
    critical: np.ndarray
    slack: np.ndarray
    phase_error: np.ndarray
    outward: np.ndarray


def crossings(loop: Loop) -> Crossings:
    """Positive roots x = w^2 of |P(i w)|^2 - |Q(i w)|^2, a quadratic that no delay changes."""
    wide = Loop(*(a[..., None] for a in loop))
    p2, p1, p0, q1, q0, delay = wide
    a = p2 * p2
    b = p1 * p1 - 2.0 * p0 * p2 - q1 * q1
    c = p0 * p0 - q0 * q0
    size_b = p1 * p1 + 2.0 * np.abs(p0 * p2) + q1 * q1
    size_c = p0 * p0 + q0 * q0
    unsure = 16.0 * UNIT_ROUNDOFF

    square = b * b - 4.0 * a * c
    uncertainty = unsure * (size_b * size_b + 4.0 * a * size_c)
    square = np.where(np.abs(square) <= uncertainty, 0.0, square)
    side = -0.5 * (b + np.where(b < 0.0, -1.0, 1.0) * np.sqrt(np.maximum(square, 0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.concatenate(np.broadcast_arrays(side / a, c / side), axis=-1)
    present = (square >= 0.0) & np.isfinite(x) & (x > 0.0)
    x = np.where(present, x, 1.0)
    w = np.sqrt(x)

    slope = 2.0 * a * x + b
    residual = unsure * ((a * x + size_b) * x + size_c)
    with np.errstate(divide="ignore", invalid="ignore"):
        x_error = np.minimum(
            np.where(slope == 0.0, np.inf, residual / np.abs(slope)),
            np.where(a == 0.0, np.inf, 2.0 * np.sqrt(residual / a)),
        )
    x_error = np.where(present, np.minimum(x_error, x), 0.0)
    w_error = x_error / w + UNIT_ROUNDOFF * w

    angle = np.arctan2(q1 * w, q0) - np.arctan2(p1 * w, p0 - p2 * x)
    critical = np.mod(math.pi + angle, _TURN)
    slack = np.mod(math.pi + angle - w * delay, _TURN)
    turning = np.abs(phase_slope(wide, w))
    phase_error = turning * w_error + 8.0 * UNIT_ROUNDOFF * (_TURN + w * delay)
    outward = np.where(present, np.sign(np.where(square == 0.0, 0.0, slope)), 0.0)
    return Crossings(present, w, w_error, critical, slack, phase_error, outward)


def phase_slope(loop: Loop, w: np.ndarray) -> np.ndarray:
    """Slope by frequency (s) of the phase of the open loop at w (rad/s), which broadcasts."""
    p2, p1, p0, q1, q0, delay = loop
    x = w * w
    with np.errstate(divide="ignore", invalid="ignore"):
        above = np.where(q0 * q1 == 0.0, 0.0, q1 * q0 / (q0 * q0 + q1 * q1 * x))
    below = p1 * (p0 + p2 * x) / (np.square(p0 - p2 * x) + p1 * p1 * x)
    slope: np.ndarray = above - below - delay
    return slope


# ----------------------------------------------------------------------------
# How many poles stand to the right, counted and not searched for, and what follows from it.
# ----------------------------------------------------------------------------

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
    """Which of `STATUS` holds, as whole numbers. Uncertainty counts against the loop.

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


# ----------------------------------------------------------------------------
# How much the controller's gain may grow or fall before a root reaches the imaginary axis.
# ----------------------------------------------------------------------------

_STEPS = 45


class GainMargin(NamedTuple):
    """Factors on the open-loop gain, with absolute errors; each of the loop's shape (...).

    `upper` > 1: the least growth that reaches the limit, infinite if none does, met at
    `upper_frequency` (rad/s; infinite: at the high-frequency end, or nowhere when `upper` is
    infinite). `lower` < 1: the largest fall that does, zero if none does (`lower_frequency` 0).
    """

    upper: np.ndarray
    upper_error: np.ndarray
    upper_frequency: np.ndarray
    lower: np.ndarray
    lower_error: np.ndarray
    lower_frequency: np.ndarray


def gain_margin(loop: Loop, cross: Crossings | None = None) -> GainMargin:
    """Gain margins of the loop broken at the controller; meant for loops that are stable.

    Candidates are all frequencies where L is real and negative. Between zero, the stationary
    points of phase and of |L|, and the gain crossovers, both run one way, so that the crossing
    with |L| nearest to one is the one next to an end of each stretch, and is bracketed there.
    """
    cross = crossings(loop) if cross is None else cross
    size, w, error = _candidates(loop, cross)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = 1.0 / size
        uncertainty = factor * (error / size + 4.0 * UNIT_ROUNDOFF)
    grows = np.isfinite(factor) & (factor > 1.0)
    falls = (factor < 1.0) & (factor > 0.0)
    upper = _pick(np.where(grows, factor, np.inf), uncertainty, w, np.argmin)
    lower = _pick(np.where(falls, factor, 0.0), uncertainty, w, np.argmax)
    return GainMargin(
        upper[0], np.where(np.isfinite(upper[0]), upper[1], 0.0),
        np.where(np.isfinite(upper[0]), upper[2], np.inf),
        lower[0], np.where(lower[0] > 0.0, lower[1], 0.0), np.where(lower[0] > 0.0, lower[2], 0.0),
    )  # fmt: skip


def _pick(
    factor: np.ndarray, uncertainty: np.ndarray, w: np.ndarray, choose: Callable[..., np.ndarray]
) -> list[np.ndarray]:
    best = choose(factor, axis=-1)[..., None]
    return [np.take_along_axis(a, best, axis=-1)[..., 0] for a in (factor, uncertainty, w)]


def _candidates(loop: Loop, cross: Crossings) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """|L| where L is real and negative, its frequency and its error; |L| = 0 for none. (..., m)"""
    at_zero = np.where(loop.q0 * loop.p0 < 0.0, np.abs(loop.q0 / loop.p0), 0.0)
    level = feedthrough(loop)
    # with a delay the phase passes -180 degrees again and again, however high the frequency
    end = np.where((loop.delay > 0.0) | (level < 0.0), np.abs(level), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(loop.q1 * loop.p1 < 0.0, -loop.p1 / loop.q1, 0.0)
        square = (loop.p0 + factor * loop.q0) / loop.p2
        met = (loop.delay == 0.0) & (factor > 0.0) & (square > 0.0) & np.isfinite(square)
        plain = np.where(met, 1.0 / factor, 0.0)
    here = np.sqrt(np.where(met, square, 1.0))
    sizes = [at_zero, end, plain]
    rates = [np.zeros_like(here), np.full_like(here, np.inf), here]
    closed = np.stack(sizes, axis=-1)
    places = np.stack(rates, axis=-1)
    error = 8.0 * UNIT_ROUNDOFF * closed
    late = loop.delay > 0.0
    if not np.any(late):
        return closed, places, error

    pick = Loop(*(a[late] for a in loop))
    size, w, uncertainty = _bracketed(pick, Crossings(*(a[late] for a in cross)))
    count = size.shape[-1]
    shape = (*late.shape, count)
    all_size, all_w, all_uncertainty = np.zeros(shape), np.ones(shape), np.zeros(shape)
    all_size[late], all_w[late], all_uncertainty[late] = size, w, uncertainty
    return (
        np.concatenate([closed, all_size], axis=-1),
        np.concatenate([places, all_w], axis=-1),
        np.concatenate([error, all_uncertainty], axis=-1),
    )


def _bracketed(loop: Loop, cross: Crossings) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for loops (m,) with a delay, one candidate on each stretch of frequency."""
    bounds = _bounds(loop, cross)
    left, right = bounds[:, :-1], bounds[:, 1:]
    at_left, at_right = _phase(loop, left), _phase(loop, right)
    # start from the end whose |L| is nearer to one
    size_left, size_right = _size(loop, left), _size(loop, right)
    with np.errstate(divide="ignore"):
        from_left = np.abs(np.log(size_left)) <= np.abs(np.log(size_right))
    begin = np.where(from_left, at_left, at_right)
    stop = np.where(from_left, at_right, at_left)
    sense = np.where(stop > begin, 1.0, -1.0)
    # first odd multiple of pi met on the way from begin to stop
    wanted = sense * (2.0 * np.ceil((sense * begin / math.pi - 1.0) / 2.0) + 1.0) * math.pi
    met = (sense * (stop - wanted) >= 0.0) & (right > left)

    wide = Loop(*(a[:, None] for a in loop))
    near, far = np.where(from_left, left, right), np.where(from_left, right, left)
    w = 0.5 * (near + far)
    for step in range(_STEPS):
        off = _phase(loop, w) - wanted
        near, far = np.where(sense * off < 0.0, w, near), np.where(sense * off < 0.0, far, w)
        middle = 0.5 * (near + far)
        if step % 3 == 2:  # Newton alone would creep where the phase hardly turns
            w = middle
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = w - off / phase_slope(wide, w)
        inside = (ahead >= np.minimum(near, far)) & (ahead <= np.maximum(near, far))
        w = np.where(inside, ahead, middle)
    rounding = 8.0 * UNIT_ROUNDOFF * (_TURN + w * wide.delay)
    with np.errstate(divide="ignore"):
        slip = (np.abs(_phase(loop, w) - wanted) + rounding) / np.abs(phase_slope(wide, w))
    # where the phase hardly turns, the stretch itself bounds the uncertainty
    w_error = np.minimum(2.0 * slip, right - left) + UNIT_ROUNDOFF * w
    size = np.where(met, _size(loop, w), 0.0)
    return size, w, np.abs(_size_slope(loop, w)) * size * w_error + 8.0 * UNIT_ROUNDOFF * size


def _bounds(loop: Loop, cross: Crossings) -> np.ndarray:
    """Ends of the stretches (m, k), ascending; the last lies beyond the first crossing there."""
    p2, p1, p0, q1, q0, delay = loop
    # d phase / d w times its two denominators, a cubic in x = w^2
    a2, a1, a0 = p2 * p2, p1 * p1 - 2.0 * p0 * p2, p0 * p0
    b1, b0 = q1 * q1, q0 * q0
    turn = np.stack([
        -delay * a2 * b1,
        q0 * q1 * a2 - p1 * p2 * b1 - delay * (a1 * b1 + a2 * b0),
        q0 * q1 * a1 - p1 * (p0 * b1 + p2 * b0) - delay * (a0 * b1 + a1 * b0),
        q0 * q1 * a0 - p1 * p0 * b0 - delay * a0 * b0,
    ], axis=-1)  # fmt: skip
    zero = np.zeros_like(a2)
    crest = np.stack([zero, -b1 * a2, -2.0 * a2 * b0, b1 * a0 - b0 * a1], axis=-1)
    x = np.concatenate([_real_roots(turn), _real_roots(crest)], axis=-1)
    inner = np.concatenate([np.sqrt(x), np.where(cross.present, cross.frequency, 0.0)], axis=-1)
    inner.sort(axis=-1)
    # the phases of P and Q together turn by no more than 3 pi
    last = inner[:, -1:] + 5.0 * math.pi / delay[:, None]
    return np.concatenate([zero[:, None], inner, last], axis=-1)


def _real_roots(cubic: np.ndarray) -> np.ndarray:
    """Positive real parts of the roots (m, 3) of cubics (m, 4), zero for the others.

    A bound between stretches may stand anywhere, so real parts of complex roots do no harm.
    """
    found = np.zeros((len(cubic), 3))
    missing = np.argmax(cubic != 0.0, axis=-1)
    for degree in (3, 2, 1):
        rows = np.flatnonzero((missing == 3 - degree) & (cubic[:, 3 - degree] != 0.0))
        if len(rows):
            poly = cubic[rows, 3 - degree :]
            companion = np.zeros((len(rows), degree, degree))
            companion[:, 0, :] = -poly[:, 1:] / poly[:, :1]
            companion[:, np.arange(1, degree), np.arange(degree - 1)] = 1.0
            roots = np.linalg.eigvals(companion).real
            found[rows, :degree] = np.maximum(roots, 0.0)
    return found


def _phase(loop: Loop, w: np.ndarray) -> np.ndarray:
    """Continuous phase (rad) of L: that of P wound from zero, that of Q within a half turn."""
    p2, p1, p0, q1, q0, delay = (a[:, None] for a in loop)
    phase: np.ndarray = np.arctan2(q1 * w, q0) - np.arctan2(p1 * w, p0 - p2 * w * w) - w * delay
    return phase


def _size(loop: Loop, w: np.ndarray) -> np.ndarray:
    p2, p1, p0, q1, q0, _ = (a[:, None] for a in loop)
    size: np.ndarray = np.hypot(q1 * w, q0) / np.hypot(p1 * w, p0 - p2 * w * w)
    return size


def _size_slope(loop: Loop, w: np.ndarray) -> np.ndarray:
    """Slope of log |L| by w, in s."""
    p2, p1, p0, q1, q0, _ = (a[:, None] for a in loop)
    x = w * w
    with np.errstate(divide="ignore", invalid="ignore"):
        above = np.where(q1 == 0.0, 0.0, q1 * q1 * w / (q1 * q1 * x + q0 * q0))
    below = w * (p1 * p1 - 2.0 * p0 * p2 + 2.0 * p2 * p2 * x)
    slope: np.ndarray = above - below / (np.square(p0 - p2 * x) + p1 * p1 * x)
    return slope


# ----------------------------------------------------------------------------
# Stability margins of the loop broken at the controller, in gain, phase and time.
# ----------------------------------------------------------------------------


class Margins(NamedTuple):
    """Margins of the loops (...), with absolute errors inside each pair.

    `status`: index into `vibecalc.roll.control.margins.STATUS`; `stable`: it is 0 or 1.
    `gain` (1, > 1): factor by which the gain may grow; `gain_lower` (1, < 1): down to which it
    may fall, 0 for any; `gain_frequency`, `gain_lower_frequency` where (rad/s).
    `phase` (rad): lag or lead, the smaller, that reaches the limit, met at `phase_frequency`.
    `delay` (s): further delay that reaches the limit, met at `delay_frequency`. Both are zero
    where any delay does, because the gain at high frequency, `feedthrough`, is one or more.
    `bandwidth` (rad/s): highest frequency at which the loop still has gain one; the actuator
    has to work up to there. Zero if the gain is below one everywhere.
    Infinite: no such limit exists (frequency infinite too), for the bandwidth: no end of it.
    A loop that is not stable has no margins: gain and gain_lower are 1, phase and delay 0.
    """

    status: np.ndarray
    stable: np.ndarray
    gain: Bounded
    gain_frequency: np.ndarray
    gain_lower: Bounded
    gain_lower_frequency: np.ndarray
    phase: Bounded
    phase_frequency: np.ndarray
    delay: Bounded
    delay_frequency: np.ndarray
    feedthrough: np.ndarray
    bandwidth: Bounded


def margins(loop: Loop) -> Margins:
    """All margins of every loop, in closed form but for the phase crossovers of a delayed loop."""
    cross = crossings(loop)
    verdict = status(loop, cross)
    stable = verdict <= 1
    level = feedthrough(loop)
    gain = gain_margin(loop, cross)
    phase, phase_at = _phase_margin(cross)
    late, late_at = _delay_margin(cross)

    # the gain stays above one however high the frequency, and there any delay turns the phase
    never = (loop.p2 == 0.0) & (np.abs(level) >= 1.0)
    phase = Bounded(np.where(never, 0.0, phase.value), np.where(never, 0.0, phase.error))
    late = Bounded(np.where(never, 0.0, late.value), np.where(never, 0.0, late.error))
    late_at = np.where(never, np.inf, late_at)

    nothing = np.where(cross.present, cross.frequency, 0.0)
    highest = np.argmax(nothing, axis=-1)[..., None]
    width = np.take_along_axis(nothing, highest, axis=-1)[..., 0]
    width_error = np.take_along_axis(cross.frequency_error, highest, axis=-1)[..., 0]
    bandwidth = Bounded(
        np.where(never, np.inf, width), np.where(never | (width == 0.0), 0.0, width_error)
    )
    return Margins(
        verdict, stable,
        _only(stable, gain.upper, gain.upper_error, 1.0),
        np.where(stable, gain.upper_frequency, np.inf),
        _only(stable, gain.lower, gain.lower_error, 1.0),
        np.where(stable, gain.lower_frequency, 0.0),
        _only(stable, phase.value, phase.error, 0.0), np.where(stable & ~never, phase_at, np.inf),
        _only(stable, late.value, late.error, 0.0), np.where(stable, late_at, np.inf),
        level, bandwidth,
    )  # fmt: skip


def _only(stable: np.ndarray, value: np.ndarray, error: np.ndarray, other: float) -> Bounded:
    return Bounded(np.where(stable, value, other), np.where(stable, error, 0.0))


def _phase_margin(cross: Crossings) -> tuple[Bounded, np.ndarray]:
    lag = np.where(cross.present, np.minimum(cross.slack, _TURN - cross.slack), np.inf)
    return _least(lag, cross.phase_error, cross)


def _delay_margin(cross: Crossings) -> tuple[Bounded, np.ndarray]:
    time = np.where(cross.present, cross.slack / cross.frequency, np.inf)
    error = cross.phase_error + cross.slack * cross.frequency_error / cross.frequency
    return _least(time, error / cross.frequency + 2.0 * UNIT_ROUNDOFF * cross.slack, cross)


def _least(value: np.ndarray, error: np.ndarray, cross: Crossings) -> tuple[Bounded, np.ndarray]:
    which = np.argmin(value, axis=-1)[..., None]
    least, uncertainty, at = (
        np.take_along_axis(a, which, axis=-1)[..., 0] for a in (value, error, cross.frequency)
    )
    some = np.isfinite(least)
    return Bounded(least, np.where(some, uncertainty, 0.0)), np.where(some, at, np.inf)
