"""The highest summit of a function of the crank angle over a turn, smooth or not."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray

_FULL = 2.0 * np.pi
#: coarse looks of a turn, rounds of closer ones at most, summits followed
_COARSE, _ROUNDS, _SUMMITS = 720, 60, 4
#: of an interval, how far beside a parabola's top looks are; more left of it is slow progress, less
#: the sign of a smooth summit
_CLOSE, _SLOW, _SMOOTH = 0.025, 0.3, 0.1
#: values that differ by so many roundings are alike
_FLAT = 16.0
#: a summit rises at most by so many times what the last look added
_RISES = 16.0


def summit(
    values_at: Callable[[FloatArray], FloatArray],
    known: tuple[FloatArray, FloatArray] | None = None,
) -> tuple[float, float]:
    """Largest value of a function of the crank angle over a turn, and what looking leaves open.

    `values_at` takes ascending angles (k,) in [0, 2 pi). `known` are ascending angles (k,) within a
    turn that resolve the function, with its values there; without, a coarse look comes first. Then
    each of the highest summits is closed in between two angles: by a parabola, and where that does
    not help, as beside a jump or a kink, by even steps. Beside a jump, as of friction at a dead
    centre, or with summits of nearly one height, the coarse look may take the wrong one, so that
    several are followed until they cannot be the highest. The error is the gain of the last look.
    """
    if known is None:
        angles = np.linspace(0.0, _FULL, _COARSE, endpoint=False)
        known = angles, values_at(angles)
    at, values = _brackets(*known)
    best, gain = float(np.max(values)), np.inf
    even = np.zeros(len(at), dtype=bool)
    for _ in range(_ROUNDS):
        near = _looks(at, values, even)
        turned = np.mod(near, _FULL)
        turned = np.where(turned < _FULL, turned, 0.0)
        order = np.argsort(turned, axis=None, kind="stable")
        found = np.empty(near.size)
        found[order] = values_at(turned.ravel()[order])
        width, top = at[:, 2] - at[:, 0], values[:, 1]
        at, values = _closer(at, values, near, found.reshape(near.shape))
        shrunk = (at[:, 2] - at[:, 0]) / np.maximum(width, np.finfo(float).tiny)
        even = ~even & (shrunk > _SLOW)
        gain, best = float(np.max(values)) - best, max(best, float(np.max(values)))
        # a smooth summit, which a parabola closes in at once, that is far below cannot win
        smooth = shrunk < _SMOOTH
        may = ~smooth | (values[:, 1] + _RISES * (values[:, 1] - top) >= best)
        at, values, even = at[may], values[may], even[may]
        # a look that gains nothing proves nothing while the values beside it are lower
        flat = values[:, 1] - values.min(axis=1) <= _FLAT * EPSILON * abs(best)
        flat &= at[:, 2] - at[:, 0] < _FULL * EPSILON**0.5
        if np.all(flat | (at[:, 2] - at[:, 0] <= _FLAT * EPSILON * _FULL)):
            break
    return best, abs(gain)


def _brackets(angles: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The highest few of the samples that are no lower than their neighbours, with these.

    Angles and values (summits, 3); angles may lie a little outside the turn.
    """
    before, after = np.roll(values, 1), np.roll(values, -1)
    tops = np.flatnonzero((values >= before) & (values >= after))
    tops = tops[np.argsort(-values[tops], kind="stable")][:_SUMMITS]
    place = tops[:, None] + np.array([-1, 0, 1])
    turns, place = np.divmod(place, len(values))
    return angles[place] + _FULL * turns, values[place]


def _looks(at: FloatArray, values: FloatArray, even: BoolArray) -> FloatArray:
    """Angles (summits, 3) to look at next: close about the parabola's top, or in even steps."""
    left, right = at[:, 1] - at[:, 0], at[:, 2] - at[:, 1]
    tiny = np.finfo(float).tiny
    up = (values[:, 1] - values[:, 0]) / np.maximum(left, tiny)
    down = (values[:, 2] - values[:, 1]) / np.maximum(right, tiny)
    bend = up - down
    curved = (bend > 0.0) & (left > 0.0) & (right > 0.0) & ~even
    slope = (up * right + down * left) / np.maximum(left + right, tiny)
    top = at[:, 1] + np.where(curved, 0.5 * slope * (left + right), 0.0) / np.where(
        curved, bend, 1.0
    )
    width = at[:, 2] - at[:, 0]
    about = np.clip(top[:, None] + _CLOSE * width[:, None] * np.array([-1.0, 0.0, 1.0]),
                    at[:, :1], at[:, 2:])  # fmt: skip
    steps = at[:, :1] + width[:, None] * np.array([0.25, 0.5, 0.75])
    return np.asarray(np.where(curved[:, None], about, steps))


def _closer(
    at: FloatArray, values: FloatArray, near: FloatArray, found: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The highest of the old and new angles of each summit between its neighbours."""
    angles, heights = np.concatenate([at, near], axis=1), np.concatenate([values, found], axis=1)
    order = np.argsort(angles, axis=1, kind="stable")
    angles = np.take_along_axis(angles, order, axis=1)
    heights = np.take_along_axis(heights, order, axis=1)
    place = np.argmax(heights, axis=1)[:, None] + np.array([-1, 0, 1])
    place = np.clip(place, 0, angles.shape[1] - 1)
    return np.take_along_axis(angles, place, axis=1), np.take_along_axis(heights, place, axis=1)
