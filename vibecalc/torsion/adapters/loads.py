"""Torques that limits are for: those of the sections of a line, then those of its gears."""

from typing import Any

import numpy as np

from vibecalc.numerics.bounded import Bounded, where
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.adapters.critical import UndampedResonances
from vibecalc.torsion.adapters.curves import (
    ROWS,
    OrderSolution,
    actual_per_referred,
    curve_errors,
    curve_uncertainty,
    gear_shares,
    gear_torques,
    sweep,
)
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.line import complex_stiffness
from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# Adapter: loads of a line, the torques of its e sections and after them those of its g gears.
#
# Rigid gears are no sections: what they carry follows from the rest of their side. Gears are left
# out, and cost nothing, where no limit is for one.
# ----------------------------------------------------------------------------


def limits_gears(setup: Setup) -> bool:
    """Whether some limit is for gears."""
    return any(one.gears or one.alternating_share for one in setup.torsion.limits)


def load_ratios(shaft: ShaftLineModel) -> FloatArray:
    """Referred over own torque (e + g,), magnitudes."""
    gears = 1.0 / actual_per_referred(shaft) if shaft.gears else np.zeros(0)
    return np.asarray(np.abs(np.concatenate([shaft.section_ratio, gears])))


def loads_of(shaft: ShaftLineModel, drive: Drive, model: Model, state: OrderSolution) -> Any:
    """Referred torques (s, m, e + g) of all orders at some speeds."""
    return np.concatenate([state.torque, gear_torques(shaft, drive, model, state)], axis=-1)


def own_loads(setup: Setup, torque: Bounded) -> Bounded:
    """Own half ranges (e + g,) at the operating speed from those of the sections (e,)."""
    if not limits_gears(setup):
        return torque
    at = np.array([setup.speed])
    curves = sweep(setup.model, setup.drive, at, setup.shaft, angles=False)
    off = curve_uncertainty(setup, at, np.zeros(0)).gear
    clear = ~curves.masked[0]
    own = Bounded(np.where(clear, curves.gear[0], 0.0), off)
    gears = where(clear, own * np.abs(actual_per_referred(setup.shaft)), np.inf)
    return Bounded(
        np.concatenate([torque.value, gears.value]),
        np.concatenate([np.broadcast_to(one.error, one.shape) for one in (torque, gears)]),
    )


def load_uncertainty(setup: Setup, speed: FloatArray, place: IntArray) -> FloatArray:
    """Errors (r,) of half ranges of referred torques, each of one load at its own speed.

    0 where unbounded.
    """
    at, row = np.unique(speed, return_inverse=True)
    parts = [np.zeros((0, int(np.max(place, initial=-1)) + 1))]
    for start in range(0, len(at), ROWS):
        found = curve_errors(setup, at[start : start + ROWS])
        both = np.concatenate([found.torque, found.gear], axis=1)
        parts.append(both[:, : parts[0].shape[1]])
    return np.asarray(np.concatenate(parts)[row, place])


# ----------------------------------------------------------------------------
# What a mode of the line does to its gears.
# ----------------------------------------------------------------------------


#: part of a mode's largest torque below which a gear counts as unloaded
UNLOADED = 1e-9


def loads_of_modes(
    setup: Setup, shape: ComplexArray, frequency: FloatArray, stiffness: ComplexArray
) -> FloatArray:
    """Magnitudes of the torques (m, g) of gears in shapes (m, n) at frequencies (m,) in rad/s.

    `stiffness` (m, e), complex, of the sections there.
    """
    shaft, line = setup.shaft, setup.model.line
    of_sections, of_stations = gear_shares(shaft)
    torque = stiffness * (shape[:, line.first] - shape[:, line.second])
    inertia, damping, held = shaft.station_values
    w = frequency[:, None]
    need = (held - w**2 * inertia + 1j * w * damping) * shape[:, shaft.freedom]
    return np.asarray(np.abs(torque @ of_sections - need @ of_stations))


def endless_loads(setup: Setup, undamped: UndampedResonances) -> FloatArray:
    """Lowest speeds (e + g,) at which nothing bounds a load, NaN for none."""
    gears = np.full(len(setup.shaft.gears), np.nan)
    if len(gears) and len(undamped.speed):
        which = undamped.mode - 1
        natural = setup.natural()
        frequency = undamped.speed * undamped.order
        stiff = complex_stiffness(setup.model.at(undamped.speed, frequency), frequency)
        carried = loads_of_modes(setup, natural.shape[which], frequency, stiff)
        line = setup.model.line
        shape = natural.shape[which]
        sections = np.abs(stiff * (shape[:, line.first] - shape[:, line.second]))
        most = np.maximum(sections.max(axis=1), carried.max(axis=1))
        loaded = carried > UNLOADED * most[:, None]
        for speed, one in zip(undamped.speed[::-1], loaded[::-1], strict=True):
            gears[one] = speed
    return np.concatenate([undamped.endless, gears])
