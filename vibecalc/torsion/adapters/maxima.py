"""Largest values of a shaft line at any speed of a range, narrow resonances included."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.adapters.critical import Undamped
from vibecalc.torsion.adapters.curves import ROWS, solved, speeds_at_once, stiffness_of
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.critical_speeds import CORNER, Value, highest, refined
from vibecalc.torsion.line import damping_matrix, network_matrix, stiffness_matrix
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# Largest values of a shaft line at any speed of a range, found between the speeds of the sweep.
# ----------------------------------------------------------------------------

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
        size = speeds_at_once(model, drive)
        for start in range(0, len(flat), size):
            found = solved(model, drive, flat[start : start + size])
            held = np.flatnonzero((place >= start) & (place < start + size))
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


# ----------------------------------------------------------------------------
# Speeds between those of a sweep at which a resonance too narrow for its steps may stand.
# ----------------------------------------------------------------------------

#: steps of the sweep that half a resonance is wide when its points show it
SHOWN = 1.5
#: places about a resonance, in half its width
PLACES = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
#: what orders near by may add to the height of a resonance
MARGIN = 2.0
#: freedoms up to which the poles of the damped line are looked for; else modes without coupling
FREEDOMS = 200
#: part of a curve below which a resonance on it is nothing
FAINT = 1e-9


class Dense(NamedTuple):
    """The speeds of a sweep with those of narrow resonances (r,), referred half ranges (r, e)."""

    speed: FloatArray
    torque: FloatArray


class _Needles(NamedTuple):
    """Resonances (r,): speed, half of the width at half the power, torques (r, e) of that alone."""

    speed: FloatArray
    width: FloatArray
    height: FloatArray


class _Poles(NamedTuple):
    """Poles (r,) with vectors (r, n), place of the order; `scale`: x^T (2 s M + C) x."""

    pole: ComplexArray
    shape: ComplexArray
    scale: ComplexArray
    order: IntArray


def with_needles(
    setup: Setup,
    speed: FloatArray,
    torque: FloatArray,
    undamped: Undamped,
    levels: tuple[FloatArray, ...] = (),
) -> Dense:
    """Put in what the sweep (s,), with torques (s, e), may have stepped over.

    That is: where a damped pole meets an order, is narrower than the steps, and may reach, on what
    the curve is beside it, the largest torque of some section or one of the `levels`, each (e,)
    or (s, e).
    """
    if len(speed) < 2:
        return Dense(speed, torque)
    found = _needles(setup, speed[0], speed[-1])
    step = np.diff(speed)
    place = np.clip(np.searchsorted(speed, found.speed) - 1, 0, len(step) - 1)
    beside = np.maximum(torque[:-1], torque[1:])
    reach = np.zeros_like(beside)
    np.add.at(reach, place, found.height)
    reach = beside + MARGIN * reach
    best = np.max(torque, axis=0, initial=0.0, where=np.isfinite(torque))
    near = np.any(reach >= best, axis=1)
    for level in levels:
        least = np.minimum(level[:-1], level[1:]) if level.ndim > 1 else level
        near |= np.any(reach >= least, axis=1)
    counts = np.any(MARGIN * found.height >= FAINT * beside[place], axis=1)
    chosen = near[place] & (found.width < SHOWN * step[place]) & counts
    if not np.any(chosen):
        return Dense(speed, torque)
    extra = found.speed[chosen, None] + found.width[chosen, None] * PLACES
    extra = np.setdiff1d(extra, speed)
    endless = (extra[:, None] >= undamped.low) & (extra[:, None] <= undamped.high)
    extra = extra[(extra > speed[0]) & (extra < speed[-1]) & ~np.any(endless, axis=1)]
    return added(setup, Dense(speed, torque), extra)


def added(setup: Setup, dense: Dense, extra: FloatArray) -> Dense:
    """With more speeds (r,), in any order, but those at which nothing damps an order."""
    extra = np.setdiff1d(extra, dense.speed)
    parts = [np.zeros((0, dense.torque.shape[1]))]
    for start in range(0, len(extra), ROWS):
        at = solved(setup.model, setup.drive, extra[start : start + ROWS])
        half = synthesis(setup.drive.order, np.moveaxis(at.torque, 1, -1)).half_range
        parts.append(np.where(np.any(at.masked, axis=1)[:, None], np.nan, half))
    values = np.concatenate(parts)
    clear = np.all(np.isfinite(values), axis=1)
    every = np.concatenate([dense.speed, extra[clear]])
    rise = np.argsort(every, kind="stable")
    return Dense(every[rise], np.concatenate([dense.torque, values[clear]])[rise])


def highest_maxima(curve: FloatArray, count: int) -> float:
    """Height (of a curve (s,)) of that many of its maxima; 0 where it has fewer."""
    inside = curve[1:-1]
    high = inside[(inside > curve[:-2]) & (inside >= curve[2:]) & np.isfinite(inside)]
    return float(np.sort(high)[-count]) if len(high) >= count else 0.0


def _needles(setup: Setup, first: float, last: float) -> _Needles:
    """Resonances whose width touches a range of speeds, without those that nothing damps."""
    line, drive = setup.model.line, setup.drive
    poles = _poles(setup)
    order = drive.order[poles.order]
    speed, width = poles.pole.imag / order, np.abs(poles.pole.real) / order
    inside = (speed + 3.0 * width > first) & (speed - 3.0 * width < last) & (width > 0.0)
    inside &= np.isfinite(poles.scale) & (poles.scale != 0.0)
    kept = np.flatnonzero(inside)
    height = np.empty((len(kept), len(line.first)))
    for start in range(0, len(kept), 8 * ROWS):
        part = kept[start : start + 8 * ROWS]
        at = np.clip(speed[part], first, last)
        shape = poles.shape[part]
        torque = drive.torque(at)[np.arange(len(part)), poles.order[part]]
        drives = np.abs(np.sum(shape[:, drive.freedom] * torque, axis=1))
        amplitude = drives / np.abs(poles.scale[part] * poles.pole[part].real)
        twist = np.abs(shape[:, line.first] - shape[:, line.second])
        stiff = np.abs(stiffness_of(setup.model.at(at), at * order[part]))
        height[start : start + 8 * ROWS] = stiff * twist * amplitude[:, None]
    # no digits below this: a narrower one is masked
    width = np.maximum(width[kept], 1e-11 * speed[kept])
    return _Needles(speed[kept], width, height)


def _poles(setup: Setup) -> _Poles:
    """Poles of the line with positive frequency, each at every order."""
    orders, model = setup.drive.order, setup.model
    if model.modal is not None or len(model.line.inertia) > FREEDOMS:
        modes = setup.natural()
        some = np.flatnonzero(modes.frequency > 0.0)
        return _at_orders(modes.pole[some], modes.shape[some], modes.scale[some], len(orders))
    if not np.any(model.speed_stiffness):
        return _at_orders(*_pole_set(setup, None), len(orders))
    # with pendulums the line is another one at every order
    sets = [_pole_set(setup, one) for one in orders.tolist()]
    counts = [len(one[0]) for one in sets]
    pole, shape, scale = (np.concatenate(part) for part in zip(*sets, strict=True))
    scale = np.asarray(scale, dtype=np.complex128)
    return _Poles(pole, shape, scale, np.repeat(np.arange(len(orders)), counts))


def _at_orders(pole: ComplexArray, shape: ComplexArray, scale: ComplexArray, count: int) -> _Poles:
    each = np.tile(np.arange(len(pole)), count)
    order = np.repeat(np.arange(count), len(pole))
    return _Poles(pole[each], shape[each], scale[each], order)


def _pole_set(setup: Setup, order: float | None) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Poles (r,), vectors (r, n), x^T (2 s M + C) x, where s = i order speed is on a pendulum."""
    model, line = setup.model, setup.model.line
    count = len(line.inertia)
    mass = np.diag(line.inertia)
    if order is not None:
        nothing = np.zeros_like(line.inertia)
        mass = mass - network_matrix(line, model.speed_stiffness, nothing) / order**2
    stiffness, damping = stiffness_matrix(line), damping_matrix(line)
    if np.any(line.loss_factor):
        loss = network_matrix(line, line.stiffness * line.loss_factor, np.zeros(count))
        stiffness = stiffness + 1j * loss
    # in units of the stiffest mode, or the digits of the soft ones are lost
    unit = max(float(np.max(setup.modes.frequency, initial=0.0)), 1.0)
    try:
        moved = np.linalg.solve(mass, np.hstack([-stiffness / unit**2, -damping / unit]))
    except np.linalg.LinAlgError:
        none = np.zeros(0, dtype=np.complex128)
        return none, np.zeros((0, count), dtype=np.complex128), none
    whole = np.vstack([np.eye(count, 2 * count, count), moved])
    pole, vector = np.linalg.eig(whole)
    pole = pole * unit
    up = pole.imag > 1e-9 * unit
    pole, shape = pole[up], vector[:count, up].T
    a, b, c = (np.sum((shape @ part) * shape, axis=1) for part in (mass, damping, stiffness))
    # one step of Newton with the quotient of the vector: errors of the vector count squared
    slope = 2.0 * pole * a + b
    with np.errstate(divide="ignore", invalid="ignore"):
        better = pole - (pole * (pole * a + b) + c) / slope
    pole = np.where(np.abs(better - pole) <= 1e-6 * np.abs(pole), better, pole)
    return pole, shape, 2.0 * pole * a + b
