"""Largest values of a shaft line at any speed of a range, narrow resonances included."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters.critical import FREEDOMS, UndampedResonances
from vibecalc.torsion.adapters.curves import ROWS, solved, speeds_at_once
from vibecalc.torsion.adapters.loads import loads_of, loads_of_modes
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.critical_speeds import (
    NarrowResonances,
    Value,
    by_machine,
    machine_and_speed,
    narrow_resonance_speeds,
)
from vibecalc.torsion.line import Line, complex_stiffness
from vibecalc.torsion.model import ShaftLineModel
from vibecalc.torsion.poles import LinePoles, all_poles, all_poles_by_order, poles_at_orders
from vibecalc.torsion.rough_range import near_the_largest

# ----------------------------------------------------------------------------
# Largest values of a shaft line at any speed of a range, found between the speeds of the sweep.
# ----------------------------------------------------------------------------


def torque_value(
    model: Model, drive: Drive, section: IntArray, shaft: ShaftLineModel | None = None
) -> Value:
    """Half range of the referred torque of sections (r,), or loads of `shaft`, at speeds (r, k).

    Of many machines sections count on from one machine to the next.
    """
    machine, own = model.own(section)

    def value(speed: FloatArray) -> FloatArray:
        # sections that are highest at one resonance are examined from the same places
        pairs = by_machine(np.broadcast_to(machine[:, None], speed.shape), speed)
        flat, place = np.unique(pairs, return_inverse=True)
        place, repeated = place.ravel(), np.repeat(own, speed.shape[1])
        torque = np.empty((len(place), len(drive.order)), dtype=np.complex128)
        size = speeds_at_once(model, drive)
        for start in range(0, len(flat), size):
            of, at = machine_and_speed(flat[start : start + size])
            held = np.flatnonzero((place >= start) & (place < start + size))
            state = solved(model.of(of), drive, at)
            every = state.torque if shaft is None else loads_of(shaft, drive, model, state)
            torque[held] = every[place[held] - start, :, repeated[held]]
        half = synthesis(drive.cycles, torque).half_range
        return np.asarray(half.reshape(speed.shape))

    return value


# ----------------------------------------------------------------------------
# Speeds between those of a sweep at which a resonance too narrow for its steps may stand.
# ----------------------------------------------------------------------------

#: relative distance up to which two speeds are one
SAME = 1e-13


class DenseSweep(NamedTuple):
    """The speeds of a sweep with those of narrow resonances (r,), referred half ranges (r, e).

    With columns for gears behind those of sections where some limit is for gears. `machine` (r,) is
    whose they are, of many those of one after the other.
    """

    speed: FloatArray
    torque: FloatArray
    machine: IntArray


def with_narrow_resonances(
    setup: Setup,
    speed: FloatArray,
    torque: FloatArray,
    undamped: UndampedResonances,
    levels: tuple[FloatArray, ...] = (),
    alone: bool = False,
) -> DenseSweep:
    """Put in what the sweep (s,), with torques (s, e), may have stepped over.

    That is: where a damped pole meets an order, is narrower than the steps, and may reach, on what
    the curve is next to it, the largest torque of some section or one of the `levels`, each (e,)
    or (s, e). Gears, too, if `torque` has columns for them. Of p machines torques are (p, s, e).
    `alone`: of what is put in only the largest torques count, as in `near_the_largest`.
    """
    torque = torque.reshape(-1, len(speed), torque.shape[-1])
    each = np.broadcast_to(np.arange(len(torque))[:, None], torque.shape[:2])
    every = np.broadcast_to(speed, each.shape)
    dense = DenseSweep(every.ravel(), torque.reshape(-1, torque.shape[-1]), each.ravel())
    if len(speed) < 2:
        return dense
    gears = torque.shape[-1] > len(setup.model.line.first)
    narrow = _narrow_resonances(setup, speed[0], speed[-1], gears)
    extra = narrow_resonance_speeds(speed, torque, narrow, levels)
    at = extra.imag[:, None]
    endless = np.any((at >= undamped.low) & (at <= undamped.high), axis=1)
    inside = (extra.imag > speed[0]) & (extra.imag < speed[-1]) & ~endless
    return added(setup, dense, extra[inside], alone)


def added(setup: Setup, dense: DenseSweep, extra: ComplexArray, alone: bool = False) -> DenseSweep:
    """With more speeds (r,) `by_machine`, in any order, but those at which nothing damps an order.

    What is a speed of the sweep but for rounding, as the corner of a limit may be, is left out.
    """
    known = by_machine(dense.machine, dense.speed)
    extra = np.unique(extra[~np.isin(extra, known)], return_index=True)[0]
    if not len(extra):
        return dense
    place = np.clip(np.searchsorted(known, extra), 1, len(known) - 1)
    beside = known[np.stack([place - 1, place])]
    extra = extra[np.all(np.abs(beside - extra) > SAME * extra.imag, axis=0)]
    extra = extra[np.abs(np.diff(extra, prepend=-1.0)) > SAME * extra.imag]
    machine, speed = machine_and_speed(extra)
    parts = [np.zeros((0, dense.torque.shape[1]))]
    gears, cycles = dense.torque.shape[1] > len(setup.model.line.first), setup.drive.cycles
    first = np.searchsorted(dense.machine, np.arange(dense.machine[-1] + 1))
    best = np.maximum.reduceat(dense.torque, first, axis=0).ravel()
    for start in range(0, len(extra), ROWS):
        part = slice(start, start + ROWS)
        at = solved(setup.model.of(machine[part]), setup.drive, speed[part])
        torque = loads_of(setup.shaft, setup.drive, setup.model, at) if gears else at.torque
        torque = np.moveaxis(torque, 1, -1)
        if alone:
            section = machine[part, None] * torque.shape[1] + np.arange(torque.shape[1])
            rows = torque.reshape(-1, torque.shape[-1])
            half = near_the_largest(cycles, rows, section.ravel(), best).reshape(section.shape)
        else:
            half = synthesis(cycles, torque).half_range
        parts.append(np.where(np.any(at.masked, axis=1)[:, None], np.nan, half))
    values = np.concatenate(parts)
    clear = np.all(np.isfinite(values), axis=1)
    rising = np.argsort(np.concatenate([known, extra[clear]]), kind="stable")
    more = DenseSweep(speed[clear], values[clear], machine[clear])
    return DenseSweep(*(np.concatenate(pair)[rising] for pair in zip(dense, more, strict=True)))


#: parts of a range of speeds, each with the dampings of its middle
PARTS = 12


def _poles(setup: Setup, first: float, last: float) -> LinePoles:
    """Poles of the line with positive frequency, each at every order; from `first` to `last`."""
    order, model, line = setup.drive.order, setup.model, setup.model.line
    if model.modal is not None or line.inertia.shape[-1] > FREEDOMS:
        modes = setup.natural()
        some = np.flatnonzero(modes.frequency > 0.0)
        poles = (modes.pole[some], modes.shape[some], modes.scale[some])
        none = np.zeros_like(some)
        return poles_at_orders(LinePoles(*poles, none, none), len(order))
    if model.couplings is not None:
        from vibecalc.torsion.adapters.coupling_criticals import poles_by_order

        return poles_by_order(setup, first, last)
    found = _poles_of(line, model, order)
    if model.over_speed is None:
        return found
    # a width is that of the dampings at the speed where the pole meets the order
    met = found.pole.imag / order[found.order]
    part = np.clip(PARTS * (met - first) / (last - first), 0, PARTS - 1).astype(int)
    for number in np.unique(part).tolist():
        middle = first + (number + 0.5) * (last - first) / PARTS
        there = _poles_of(model.over_speed.on(line, middle), model, order)
        rows = np.flatnonzero(part == number)
        apart = np.abs(there.pole.imag - found.pole.imag[rows, None])
        apart[there.order != found.order[rows, None]] = np.inf
        nearest = np.argmin(apart, axis=1)
        for values, others in zip(found[:3], there[:3], strict=True):
            values[rows] = others[nearest]
    return found


def _poles_of(line: Line, model: Model, order: FloatArray) -> LinePoles:
    """Those of a line with the dampings of one speed."""
    if not np.any(model.speed_stiffness):
        return poles_at_orders(all_poles(line), len(order))
    # with pendulums the line is another one at every order
    return all_poles_by_order(line, model.speed_stiffness, order)


def _narrow_resonances(setup: Setup, first: float, last: float, gears: bool) -> NarrowResonances:
    """Resonances whose width touches a range of speeds, without those that nothing damps.

    Heights of sections, and of `gears` behind them.
    """
    line, drive = setup.model.line, setup.drive
    poles = _poles(setup, first, last)
    order = drive.order[poles.order]
    speed, width = poles.pole.imag / order, np.abs(poles.pole.real) / order
    inside = (speed + 3.0 * width > first) & (speed - 3.0 * width < last) & (width > 0.0)
    inside &= np.isfinite(poles.scale) & (poles.scale != 0.0)
    inside &= drive.orders.fixed[poles.order] == 0.0
    used = np.flatnonzero(inside)
    height = np.empty((len(used), len(line.first) + gears * len(setup.shaft.gears)))
    for start in range(0, len(used), 8 * ROWS):
        part = used[start : start + 8 * ROWS]
        at = np.clip(speed[part], first, last)
        shape = poles.shape[part]
        torque = drive.load(at)[np.arange(len(part)), poles.order[part]]
        drives = np.abs(np.sum(shape[:, drive.freedom] * torque, axis=1))
        amplitude = drives / np.abs(poles.scale[part] * poles.pole[part].real)
        twist = np.abs(shape[:, line.first] - shape[:, line.second])
        w = at * order[part]
        model = setup.model.of(poles.machine[part])
        stiff = complex_stiffness(model.at(at[:, None], w[:, None]), w[:, None])[:, 0]
        loads = [np.abs(stiff) * twist]
        if gears:
            loads.append(loads_of_modes(setup, shape, w, stiff))
        carried = np.concatenate(loads, axis=1)
        height[start : start + 8 * ROWS] = carried * amplitude[:, None]
    # no digits below this: a narrower one is masked
    width = np.maximum(width[used], 1e-11 * speed[used])
    return NarrowResonances(speed[used], width, height, poles.machine[used])
