"""What sections, dampers and gears of a shaft line show, at one speed or at each of many."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, maximum, where
from vibecalc.numerics.rounding import IntArray
from vibecalc.torsion.adapters.curves import (
    Curves,
    CurveUncertainty,
    MeanTorques,
    actual_per_referred,
    of_finite,
)
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# Actual values of referred ones, the speeds in front: where nothing damps an order, there is no
# upper end.
# ----------------------------------------------------------------------------


#: readings of dampers and gears over speeds -> where they stand at the operating speed
AT_SPEED = {
    "heat": "damper/heat",
    "travel": "damper/travel",
    "gear_mean_torque": "gear/mean_torque",
    "gear_torque": "gear/alternating_torque",
    "gear_minimum_torque": "gear/minimum_torque",
}


def emit_half_ranges(
    scene: Scene,
    place: str,
    shaft: ShaftLineModel,
    section: IntArray,
    torque: Bounded,
    twist: Bounded,
    axes: Mapping[str, Any],
) -> Bounded:
    """Torques, twists and stresses of some sections (k,) from referred ones (..., k).

    Over speeds they are (s, k), without `axes` of such maybe of many machines. Gives the actual
    torques.
    """
    ratio, modulus = np.abs(shaft.section_ratio[section]), shaft.section_modulus[section]

    def put(name: str, value: Bounded, chosen: Any = slice(None)) -> Bounded:
        names = tuple(shaft.section_names[e] for e in section[chosen])
        along = value.T if axes else value
        scene.emit(f"{place}/{name}", along, axes={**axes, "section": names})
        return value

    put("twist_half_range", of_finite(twist, lambda one: one * ratio))
    actual = of_finite(torque, lambda one: one / ratio)
    stressed = np.flatnonzero(modulus)
    if len(stressed):
        stress = of_finite(actual[..., stressed], lambda one: one / modulus[stressed])
        put("stress_half_range", stress, stressed)
    return put("torque_half_range", actual)


def names_of(shaft: ShaftLineModel) -> dict[str, Any]:
    """Entries of the axes of readings."""
    return {
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
        "gear": tuple(one.name for one in shaft.gears),
    }


def readings(
    setup: Setup, curves: Curves, uncertainty: CurveUncertainty, mean: MeanTorques
) -> dict[str, Bounded]:
    """What stations, sections, dampers and gears show (..., k), actual, by name; bounded.

    Half ranges of all orders, and peaks with the mean in them.
    """
    shaft, clear = setup.shaft, ~curves.masked[..., None]
    rings, ratio = [one.element for one in shaft.dampers], np.abs(shaft.section_ratio)

    def known(value: Any, error: Any) -> Bounded:
        return Bounded(np.where(clear, value, 0.0), error)

    angle = known(curves.angle, uncertainty.angle)[..., shaft.freedom]
    travel = known(curves.travel, uncertainty.twist) * ratio
    high, low = (known(one, uncertainty.torque) for one in (curves.highest, curves.lowest))
    found = {
        "angle_half_range": angle * np.abs(shaft.station_ratio),
        "twist_peak": travel,
        "torque_peak": peak_of(mean.section, high, low) / ratio,
    }
    if rings:
        found["travel"] = travel[..., rings]
        found["heat"] = known(curves.heat, uncertainty.heat)[..., rings]
    if shaft.gears:
        scale = np.abs(actual_per_referred(shaft))
        found["gear_torque"] = known(curves.gear, uncertainty.gear) * scale
    found = {name: where(clear, value, np.inf) for name, value in found.items()}
    if shaft.gears:
        least = least_gear_torque(shaft, curves, mean.gear, uncertainty.gear)
        found["gear_minimum_torque"] = where(clear, least, -np.inf)
        found["gear_mean_torque"] = mean.gear * actual_per_referred(shaft)
    return found


def emit_curves(
    scene: Scene,
    place: str,
    setup: Setup,
    curves: Curves,
    uncertainty: CurveUncertainty,
    mean: MeanTorques,
    axes: Mapping[str, Any],
) -> tuple[Bounded, dict[str, Bounded]]:
    """Readings at one speed, or with an axis of speeds.

    Gives actual half ranges of torques, and the readings.
    """
    shaft, named = setup.shaft, {**axes, **names_of(setup.shaft)}
    found = readings(setup, curves, uncertainty, mean)
    for name, value in found.items():
        path = name if axes else AT_SPEED.get(name, name)
        scene.emit(f"{place}/{path}", value.T, axes=named)
    if shaft.gears:
        least, alternating = found["gear_minimum_torque"], found["gear_torque"]
        hammers = least.value < -least.error
        path = "gear_hammers" if axes else "gear/hammers"
        scene.emit(f"{place}/{path}", hammers.astype(np.int64).T, 0.0, named)
        unsure = (np.abs(least.value) <= least.error) & (alternating.value > 0.0)
        for gear in np.flatnonzero(unsure) if unsure.ndim == 1 else ():
            name = shaft.gears[gear].name
            scene.warn(f"gear {name!r}: its least torque is zero to within the error")
    torque, twist = (
        Bounded(getattr(curves, name), getattr(uncertainty, name)) for name in ("torque", "twist")
    )
    every = np.arange(len(shaft.section_names))
    return emit_half_ranges(scene, place, shaft, every, torque, twist, axes), found


# ----------------------------------------------------------------------------
# What a mean and the extremes of what alternates about it make, all actual or all referred.
# ----------------------------------------------------------------------------


def peak_of(mean: Bounded, high: Bounded, low: Bounded) -> Bounded:
    """The largest magnitude."""
    return maximum(abs(mean + high), abs(mean + low))


def least_of(mean: Bounded, high: Bounded, low: Bounded) -> Bounded:
    """The least in the sense of the mean.

    A mean that is zero to within its error has no sense: the lower of both counts.
    """
    up, down = maximum(high, low), maximum(-high, -low)
    unloaded = np.abs(mean.value) <= mean.error
    against = where(unloaded, maximum(up, down), where(mean.value < 0.0, up, down))
    return abs(mean) - against


def least_gear_torque(shaft: ShaftLineModel, curves: Curves, mean: Bounded, error: Any) -> Bounded:
    """Least torques (..., g) over the cycle in the sense of the referred `mean` (..., g).

    `error` is that of the alternating part. Without it where that is endless.
    """
    scale, clear = actual_per_referred(shaft), ~curves.masked[..., None]
    high, low = (
        Bounded(np.where(clear, one, 0.0), error) * scale
        for one in (curves.gear_highest, curves.gear_lowest)
    )
    return least_of(mean * scale, high, low)
