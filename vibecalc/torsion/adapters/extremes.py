"""The largest, or least, of any reading of a shaft line at any speed of a range."""

from collections.abc import Mapping, Sequence

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, bounded
from vibecalc.numerics.rounding import FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters.critical import UndampedResonances
from vibecalc.torsion.adapters.curves import (
    actual_per_referred,
    curve_errors_of,
    mean_torques,
    solved,
    sweep,
)
from vibecalc.torsion.adapters.readings import least_of, names_of, peak_of, readings
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.adapters.signals import Signal, blocks, tops, with_narrow
from vibecalc.torsion.critical_speeds import Value, by_machine
from vibecalc.torsion.results import FOLLOWED, ROOT
from vibecalc.torsion.section_loads import heat

# ----------------------------------------------------------------------------
# One search for all readings: samples of the sweep and about narrow resonances, each maximum that
# may be the highest refined.
# ----------------------------------------------------------------------------

#: what moves without end where a reading of an axis does
_MOVES = {"station": "angle", "section": "twist", "gear": "gear", "damper": "twist"}


def emit_extremes(
    scene: Scene,
    setup: Setup,
    speed: FloatArray,
    dense: FloatArray,
    known: Mapping[str, Bounded],
    undamped: UndampedResonances,
) -> None:
    """Extremes of the readings between speeds (s,) and where they are, searched from `dense` on.

    `known` are the readings at those speeds.
    """
    place, names = f"{ROOT}/largest", names_of(setup.shaft)
    asked = [
        name
        for name, axis in FOLLOWED.items()
        if names[axis] and scene.wants(f"{place}/{name}", f"{place}/{name}_speed")
    ]
    if not asked:
        return
    kind = np.repeat(asked, [len(names[FOLLOWED[name]]) for name in asked])
    every = np.arange(len(kind))
    seen = np.concatenate([known[name].value.T for name in asked])
    low = kind == "gear_minimum_torque"
    # the least of what may be negative is the largest of what a constant leaves
    most = 2.0 * np.max(np.abs(np.where(np.isfinite(seen), seen, 0.0)), axis=1)
    shift, sense = np.where(low, most, 0.0), np.where(low, -1.0, 1.0)

    def make(row: IntArray) -> Value:
        def value(at: FloatArray) -> FloatArray:
            found = _picked(setup, asked, kind[row], _column(kind)[row], at)
            return shift[row, None] + sense[row, None] * found

        return value

    grid = distinct(np.concatenate([dense, with_narrow(setup, speed, setup.drive.order)]))
    extra = grid[~np.isin(grid, speed)]
    more = make(every)(np.broadcast_to(extra, (len(kind), len(extra))))
    both = np.concatenate([shift[:, None] + sense[:, None] * seen, more], axis=1)
    at = np.concatenate([speed, extra])
    rising = np.argsort(at, kind="stable")
    at, curve = at[rising], both[:, rising]
    clear = np.all(np.isfinite(curve), axis=0)
    endless = np.concatenate([_endless(setup, FOLLOWED[name], undamped) for name in asked])
    top = tops(make, curve[:, clear].T, at[clear], undamped.speed, endless)
    finite = np.isfinite(top.value)
    at, back = np.unique(np.where(finite, top.speed, at[clear][0]), return_inverse=True)
    off = readings(
        setup,
        sweep(setup.model, setup.drive, at, setup.shaft),
        curve_errors_of(setup, by_machine(0, at)),
        mean_torques(setup, at),
    )
    errors = np.concatenate([np.broadcast_to(off[n].error, off[n].shape).T for n in asked])
    errors = np.where(finite, errors[every, back], 0.0)
    value = Bounded(sense * (top.value - shift), top.value_error + errors)
    where = Bounded(top.speed, top.speed_error)
    for name in asked:
        rows = kind == name
        scene.emit(f"{place}/{name}", value[rows], axes=names)
        scene.emit(f"{place}/{name}_speed", where[rows], axes=names)


def _column(kind: np.ndarray) -> IntArray:
    """Places of rows among those of one kind, which stand together."""
    first = np.concatenate([[True], kind[1:] != kind[:-1]])
    every = np.arange(len(kind))
    return every - np.maximum.accumulate(np.where(first, every, 0))


#: of which signal a reading is
_SIGNALS = {
    "angle_half_range": "angle",
    "twist_peak": "twist",
    "torque_peak": "torque",
    "travel": "twist",
    "gear_torque": "gear",
    "gear_minimum_torque": "gear",
}


def _picked(
    setup: Setup, names: Sequence[str], kind: np.ndarray, column: IntArray, speed: FloatArray
) -> FloatArray:
    """Readings (r, k), each of one kind and place at speeds (r, k) of its own; endless if undamped.

    Sums over the cycle are formed of these alone.
    """
    shaft, drive, model = setup.shaft, setup.drive, setup.model
    rings = np.array([one.element for one in shaft.dampers], dtype=int)
    flat, back = np.unique(speed, return_inverse=True)
    back, found = back.reshape(speed.shape), np.empty(speed.shape)
    for part in blocks(model, drive, len(flat)):
        state = solved(model, drive, flat[part])
        carried = {"torque_peak", "gear_minimum_torque"} & {*names}
        mean = mean_torques(setup, flat[part]) if carried else None
        here = (back >= part.start) & (back < part.stop)
        for name in names:
            row, place = np.nonzero(here & (kind == name)[:, None])
            at, own = back[row, place] - part.start, column[row]
            if name == "heat":
                line = model.at(flat[part, None], state.frequency)
                power = heat(line, state.frequency, bounded(state.twist)).value.sum(axis=-2)
                value = power[at, rings[own]]
            else:
                signal = Signal(_SIGNALS[name], rings if name == "travel" else _every(setup, name))
                total = synthesis(drive.cycles, signal.of(setup, state)[at, :, own])
                ends = bounded(total.highest), bounded(total.lowest)
                if mean is not None and name == "torque_peak":
                    steady = mean.section.value[at, own] / shaft.section_ratio[own]
                    value = peak_of(bounded(steady), *ends).value
                elif mean is not None and name == "gear_minimum_torque":
                    steady = (mean.gear * actual_per_referred(shaft))[at, own]
                    value = least_of(steady, *ends).value
                else:
                    value = total.half_range if "half" in name or "gear" in name else total.peak
            endless = np.any(state.masked, axis=-1)[at]
            low = -np.inf if name == "gear_minimum_torque" else np.inf
            found[row, place] = np.where(endless, low, value)
    return found


def _every(setup: Setup, name: str) -> IntArray:
    return np.arange(len(names_of(setup.shaft)[FOLLOWED[name]]))


def _endless(setup: Setup, axis: str, undamped: UndampedResonances) -> FloatArray:
    """The lowest speeds at which nothing bounds the readings of an axis, NaN for none."""
    rings = np.array([one.element for one in setup.shaft.dampers], dtype=int)
    every = np.arange(len(names_of(setup.shaft)[axis]))
    return Signal(_MOVES[axis], rings if axis == "damper" else every).endless(setup, undamped)
