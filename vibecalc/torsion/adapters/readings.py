"""What sections, dampers and gears of a shaft line show, at one speed or at each of many."""

from collections.abc import Mapping
from typing import Any, NamedTuple

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


class Paths(NamedTuple):
    """Where readings of dampers and gears go."""

    heat: str
    travel: str
    gear_mean: str
    gear_alternating: str
    gear_minimum: str
    gear_hammers: str


AT_SPEED = Paths(
    "damper/heat",
    "damper/travel",
    "gear/mean_torque",
    "gear/alternating_torque",
    "gear/minimum_torque",
    "gear/hammers",
)
OVER_SPEEDS = Paths(
    "heat",
    "travel",
    "gear_mean_torque",
    "gear_torque",
    "gear_minimum_torque",
    "gear_hammers",
)


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


def emit_curves(
    scene: Scene,
    place: str,
    paths: Paths,
    setup: Setup,
    curves: Curves,
    uncertainty: CurveUncertainty,
    mean: MeanTorques,
    axes: Mapping[str, Any],
) -> Bounded:
    """Half ranges of all orders, peaks with the mean, dampers and gears; gives actual torques."""
    shaft, clear = setup.shaft, ~curves.masked[..., None]
    every, rings = np.arange(len(shaft.section_names)), [one.element for one in shaft.dampers]
    named = {
        **axes,
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
        "gear": tuple(one.name for one in shaft.gears),
    }

    def put(name: str, value: Bounded, endless: float = np.inf) -> None:
        scene.emit(f"{place}/{name}", where(clear, value, endless).T, axes=named)

    def known(value: Any, error: Any) -> Bounded:
        return Bounded(np.where(clear, value, 0.0), error)

    angle = known(curves.angle, uncertainty.angle)[..., shaft.freedom]
    put("angle_half_range", angle * np.abs(shaft.station_ratio))
    ratio = np.abs(shaft.section_ratio)
    travel = known(curves.travel, uncertainty.twist) * ratio
    put("twist_peak", travel)
    torque, twist = (
        Bounded(curves.torque, uncertainty.torque),
        Bounded(curves.twist, uncertainty.twist),
    )
    actual = emit_half_ranges(scene, place, shaft, every, torque, twist, axes)
    high, low = (known(one, uncertainty.torque) for one in (curves.highest, curves.lowest))
    peak = maximum(abs(mean.section + high), abs(mean.section + low))
    put("torque_peak", peak / ratio)
    if rings:
        put(paths.travel, travel[..., rings])
        put(paths.heat, known(curves.heat, uncertainty.heat)[..., rings])
    if shaft.gears:
        scale = actual_per_referred(shaft)
        least = least_gear_torque(shaft, curves, mean.gear, uncertainty.gear)
        scene.emit(f"{place}/{paths.gear_mean}", (mean.gear * scale).T, axes=named)
        alternating = known(curves.gear, uncertainty.gear) * np.abs(scale)
        put(paths.gear_alternating, alternating)
        put(paths.gear_minimum, least, -np.inf)
        hammers = ~clear | (least.value < -least.error)
        scene.emit(f"{place}/{paths.gear_hammers}", hammers.astype(np.int64).T, 0.0, named)
        unsure = (np.abs(least.value) <= least.error) & (alternating.value > 0.0)
        if unsure.ndim == 1:
            for gear in np.flatnonzero(unsure):
                name = shaft.gears[gear].name
                scene.warn(f"gear {name!r}: its least torque is zero to within the error")
    return actual


def least_gear_torque(shaft: ShaftLineModel, curves: Curves, mean: Bounded, error: Any) -> Bounded:
    """Least torques (..., g) over the cycle in the sense of the referred `mean` (..., g).

    `error` is that of the alternating part. A gear whose mean is zero to within its error rests on
    neither flank: the lower one of both counts. Without the alternating part where that is endless.
    """
    scale, clear = actual_per_referred(shaft), ~curves.masked[..., None]
    through = mean * scale
    ends = [
        Bounded(np.where(clear, one, 0.0), error) * scale
        for one in (curves.gear_highest, curves.gear_lowest)
    ]
    up, down = maximum(*ends), maximum(*(-one for one in ends))
    unloaded = np.abs(through.value) <= through.error
    against = where(unloaded, maximum(up, down), where(through.value < 0.0, up, down))
    return abs(through) - against
