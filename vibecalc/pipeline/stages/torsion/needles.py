"""Speeds between those of a sweep at which a resonance too narrow for its steps may stand."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.curves import ROWS, solved, stiffness_of
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.pipeline.stages.torsion.undamped import Undamped
from vibecalc.response.torsion.line import damping_matrix, network_matrix, stiffness_matrix
from vibecalc.response.torsion.synthesis import synthesis

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
