"""How much the controller's gain may grow or fall before a root reaches the imaginary axis."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.roll_control.crossings import Crossings, crossings, phase_slope
from vibecalc.response.roll_control.model import Loop, feedthrough

_TURN = 2.0 * math.pi
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
        doubt = factor * (error / size + 4.0 * UNIT_ROUNDOFF)
    grows = np.isfinite(factor) & (factor > 1.0)
    falls = (factor < 1.0) & (factor > 0.0)
    upper = _pick(np.where(grows, factor, np.inf), doubt, w, np.argmin)
    lower = _pick(np.where(falls, factor, 0.0), doubt, w, np.argmax)
    return GainMargin(
        upper[0], np.where(np.isfinite(upper[0]), upper[1], 0.0),
        np.where(np.isfinite(upper[0]), upper[2], np.inf),
        lower[0], np.where(lower[0] > 0.0, lower[1], 0.0), np.where(lower[0] > 0.0, lower[2], 0.0),
    )  # fmt: skip


def _pick(
    factor: np.ndarray, doubt: np.ndarray, w: np.ndarray, choose: Callable[..., np.ndarray]
) -> list[np.ndarray]:
    best = choose(factor, axis=-1)[..., None]
    return [np.take_along_axis(a, best, axis=-1)[..., 0] for a in (factor, doubt, w)]


def _candidates(loop: Loop, cross: Crossings) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """|L| where L is real and negative, its frequency and its error; |L| = 0 for none. (..., m)"""
    at_rest = np.where(loop.q0 * loop.p0 < 0.0, np.abs(loop.q0 / loop.p0), 0.0)
    level = feedthrough(loop)
    # with a delay the phase passes -180 degrees again and again, however high the frequency
    end = np.where((loop.delay > 0.0) | (level < 0.0), np.abs(level), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(loop.q1 * loop.p1 < 0.0, -loop.p1 / loop.q1, 0.0)
        square = (loop.p0 + factor * loop.q0) / loop.p2
        met = (loop.delay == 0.0) & (factor > 0.0) & (square > 0.0) & np.isfinite(square)
        plain = np.where(met, 1.0 / factor, 0.0)
    here = np.sqrt(np.where(met, square, 1.0))
    sizes = [at_rest, end, plain]
    rates = [np.zeros_like(here), np.full_like(here, np.inf), here]
    closed = np.stack(sizes, axis=-1)
    places = np.stack(rates, axis=-1)
    error = 8.0 * UNIT_ROUNDOFF * closed
    late = loop.delay > 0.0
    if not np.any(late):
        return closed, places, error

    pick = Loop(*(a[late] for a in loop))
    size, w, doubt = _bracketed(pick, Crossings(*(a[late] for a in cross)))
    count = size.shape[-1]
    shape = (*late.shape, count)
    all_size, all_w, all_doubt = np.zeros(shape), np.ones(shape), np.zeros(shape)
    all_size[late], all_w[late], all_doubt[late] = size, w, doubt
    return (
        np.concatenate([closed, all_size], axis=-1),
        np.concatenate([places, all_w], axis=-1),
        np.concatenate([error, all_doubt], axis=-1),
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
    # where the phase hardly turns, the stretch itself bounds the doubt
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
