"""Largest values of a shaft line at any speed of a range, found between the speeds of the sweep."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.curves import ROWS, solved
from vibecalc.pipeline.stages.torsion.drive import Drive
from vibecalc.pipeline.stages.torsion.setup import Model
from vibecalc.pipeline.stages.torsion.twin_summits import CORNER, Value, highest
from vibecalc.response.torsion.resonances import refined
from vibecalc.response.torsion.synthesis import synthesis

#: maxima of the most loaded section that are told
MOST = 12

#: sections whose largest value is looked for between the speeds of the sweep, most loaded first
REFINED = 32

#: part of the largest value among the speeds that a maximum there has at least, and its value when
#: looked at closer, to be refined as well; how many of a section
RIVAL, EQUAL, FEW = 0.7, 0.97, 4
#: places between a side and the middle where a maximum is looked at
PARTS = np.array([0.0, 0.25, 0.5, 0.75])

#: parts of the first and last step at which a curve that is highest at an end is looked at
INWARDS = np.array([0.0, 1e-6, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0])


class Maxima(NamedTuple):
    """By section (r,): speed in rad/s with its error, and value; infinite where undamped."""

    section: IntArray
    speed: FloatArray
    speed_error: FloatArray
    value: FloatArray


def torque_value(model: Model, drive: Drive, section: IntArray) -> Value:
    """Half range of the referred torque of sections (r,) at speeds (r, k)."""

    def value(speed: FloatArray) -> FloatArray:
        # sections that are highest at one resonance are looked at from the same places
        flat, place = np.unique(speed, return_inverse=True)
        place, own = place.ravel(), np.repeat(section, speed.shape[1])
        torque = np.empty((len(place), len(drive.order)), dtype=np.complex128)
        for start in range(0, len(flat), ROWS):
            found = solved(model, drive, flat[start : start + ROWS])
            held = np.flatnonzero((place >= start) & (place < start + ROWS))
            torque[held] = found.torque[place[held] - start, :, own[held]]
        half = synthesis(drive.order, torque).half_range
        return np.asarray(half.reshape(speed.shape))

    return value


def maxima(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    place: IntArray,
    undamped: FloatArray,
) -> Maxima:
    """Refine the values of `curve` (s, e) at (place, section) of the speeds (s,).

    What is no maximum, as at an end of the range, stays; so does what stands beside one of the
    speeds `undamped` (u,), towards which a curve grows without end.
    """
    values = curve[place, section]
    at, error = speed[place].copy(), np.zeros(len(place))
    inner = (place > 0) & (place < len(speed) - 1) & np.isfinite(values) & (values > 0.0)
    sides = np.clip(place[:, None] + np.array([-1, 1]), 0, len(speed) - 1)
    inner &= np.all(np.isfinite(curve[sides, section[:, None]]), axis=1)
    inner &= np.all(curve[sides, section[:, None]] <= values[:, None], axis=1)
    # where a limit begins to say something, a use drops to nothing
    inner &= np.all(curve[sides, section[:, None]] > 0.0, axis=1)
    between = (undamped >= speed[sides[:, :1]]) & (undamped <= speed[sides[:, 1:]])
    inner &= ~np.any(between, axis=1)
    if np.any(inner):
        own = make(section[inner])
        low, high = speed[place[inner] - 1], speed[place[inner] + 1]
        at[inner], error[inner] = highest(make, section[inner], low, at[inner], high)
        there, seen = own(at[inner][:, None])[:, 0], values[inner]
        # beside a corner the slope says nothing: what was seen stays
        corner = there < seen * (1.0 - CORNER)
        known = speed[place[inner]]
        error[inner] = np.where(corner, np.abs(at[inner] - known), error[inner])
        at[inner] = np.where(corner, known, at[inner])
        values[inner] = np.maximum(there, seen)
    return Maxima(section, at, error, values)


def largest(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    undamped: FloatArray,
    endless: FloatArray,
) -> Maxima:
    """The largest of each section's curve (s, e), (e,); past `REFINED` of them that of the sweep.

    Every maximum among the speeds that may be the highest is refined. `endless` (e,) is the speed
    in the range at which a section's curve has no end, NaN for none.
    """
    place = np.argmax(curve, axis=0)
    value = curve[place, np.arange(curve.shape[1])]
    at, doubt = speed[place].copy(), np.zeros(len(place))
    section = np.sort(np.argsort(-value, kind="stable")[:REFINED])
    rivals, owner = _rivals(make, curve, speed, section, value)
    near = maxima(
        make,
        curve,
        speed,
        np.concatenate([section, owner]),
        np.concatenate([place[section], rivals]),
        undamped,
    )
    ends = _beside_ends(make, curve, speed, section, value, undamped)
    near = Maxima(*(np.concatenate(part) for part in zip(near, ends, strict=True)))
    # what comes first is kept where two are alike
    for k in np.lexsort((np.arange(len(near.value)), -near.value))[::-1].tolist():
        own = near.section[k]
        if near.value[k] >= value[own]:
            at[own], doubt[own], value[own] = near.speed[k], near.speed_error[k], near.value[k]
    found = Maxima(np.arange(len(place)), at, doubt, value)
    no_end = ~np.isnan(endless)
    at, value = np.where(no_end, endless, found.speed), np.where(no_end, np.inf, found.value)
    return Maxima(found.section, at, np.where(no_end, 1e-10 * at, found.speed_error), value)


def _rivals(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    best: FloatArray,
) -> tuple[IntArray, IntArray]:
    """Places and sections (r,) of maxima but the highest that may be the highest between speeds."""
    own = curve[:, section]
    inside = own[1:-1]
    high = (inside > own[:-2]) & (inside >= own[2:]) & np.isfinite(own[:-2] + own[2:])
    high &= (inside >= RIVAL * best[section]) & (inside < best[section]) & (inside > 0.0)
    place, column = np.nonzero(high)
    place, owner = place + 1, section[column]
    if not len(place):
        return place, owner
    seen = narrowed(make(owner), speed[place - 1], speed[place], speed[place + 1])
    # of each section no more than the first few
    rise = np.lexsort((-seen, owner))
    rank = np.arange(len(rise)) - np.searchsorted(owner[rise], owner[rise])
    kept = rise[(seen[rise] >= EQUAL * best[owner[rise]]) & (rank < FEW)]
    return place[kept], owner[kept]


def _beside_ends(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    best: FloatArray,
    undamped: FloatArray,
) -> Maxima:
    """Maxima (r,) inside the first and the last step, where a curve falls towards its high end."""
    parts = []
    for end, beside in ((0, 1), (-1, -2)) if len(speed) > 1 else ():
        top, inner = curve[end, section], curve[beside, section]
        high = np.isfinite(top) & (top > 0.0) & (top >= RIVAL * best[section])
        own = section[high & np.isfinite(inner) & (inner > 0.0) & (inner < top)]
        low, far = sorted((speed[end], speed[beside]))
        if np.any((undamped >= low) & (undamped <= far)):
            continue
        where = speed[end] + (speed[beside] - speed[end]) * np.tile(INWARDS[:2], (len(own), 1))
        if not len(own):
            continue
        seen = make(own)(where)
        own = own[seen[:, 1] > seen[:, 0]]
        if not len(own):
            continue
        where = speed[end] + (speed[beside] - speed[end]) * np.tile(INWARDS, (len(own), 1))
        row, made = np.arange(len(own)), make(own)
        place = np.clip(np.argmax(made(where), axis=1), 1, len(INWARDS) - 2)
        sides = np.sort(np.stack([where[row, place - 1], where[row, place + 1]]), axis=0)
        at, error = refined(made, sides[0], where[row, place], sides[1])
        at = np.clip(at, *sides)
        parts.append(Maxima(own, at, error, made(at[:, None])[:, 0]))
    if not parts:
        return Maxima(np.zeros(0, dtype=np.int64), *np.zeros((3, 0)))
    return Maxima(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def narrowed(value: Value, low: FloatArray, at: FloatArray, high: FloatArray) -> FloatArray:
    """Heights (r,) of maxima between `low` and `high`, to about a hundredth from below."""
    best, row = np.zeros(len(at)), np.arange(len(at))
    for _ in range(2):
        # both sides of the middle are divided alike, for a side may be far away
        where = np.concatenate(
            [low[:, None] + (at - low)[:, None] * PARTS, at[:, None],
             high[:, None] + (at - high)[:, None] * PARTS[::-1]], axis=1,
        )  # fmt: skip
        found = value(where)
        top = np.clip(np.argmax(found, axis=1), 1, where.shape[1] - 2)
        best = np.maximum(best, found.max(axis=1))
        low, at, high = where[row, top - 1], where[row, top], where[row, top + 1]
    return best


def summits(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: int,
    undamped: FloatArray,
) -> Maxima:
    """The highest maxima of one section inside the range, by rising speed, without endless ones."""
    own = curve[:, section]
    inside = own[1:-1]
    place = np.flatnonzero((inside > own[:-2]) & (inside >= own[2:])) + 1
    near = (undamped >= speed[place - 1, None]) & (undamped <= speed[place + 1, None])
    place = place[~np.any(near, axis=1)]
    place = np.sort(place[np.argsort(-own[place], kind="stable")][:MOST])
    return maxima(make, curve, speed, np.full(len(place), section), place, undamped)
