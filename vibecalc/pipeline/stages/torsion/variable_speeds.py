"""Adapter, continued: variable inertia over a range of speeds, and where vibration grows."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion_studies import VARIABLE
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.critical import critical_speeds
from vibecalc.response.torsion.variable_inertia_regions import Wedges, unstable_ranges, wedges
from vibecalc.response.torsion.variable_inertia_steady import constant_response, steady_response

#: even steps of the range; criticals that are added, the lowest orders first; wedges that are told
_EVEN, _CRITICALS, _WEDGES = 31, 20, 8
#: a wedge whose growth is below this share of what damping takes away is not looked into
_FEARED, _MOST_RANGES = 0.3, 4


def emit_speeds(scene: Scene, setup: Setup, highest: float) -> None:
    """Half ranges, changes, wedges and unstable ranges over the speeds of the case."""
    speeds = _speeds(setup)
    _emit_half_ranges(scene, setup, highest, speeds)
    found = _emit_wedges(scene, setup)
    if not np.any(setup.model.line.loss_factor):
        _emit_unstable(scene, setup, found)


def _speeds(setup: Setup) -> FloatArray:
    """Even steps, and the criticals of the lowest orders among them."""
    asked = setup.torsion.speeds
    assert asked is not None
    even = np.linspace(asked.start, asked.stop, min(asked.points, _EVEN))
    met = critical_speeds(setup.natural().frequency, setup.drive.order, asked.start, asked.stop)
    lowest = np.argsort(met.order, kind="stable")[:_CRITICALS]
    return np.unique(np.concatenate([even, met.speed[lowest]]))


def _emit_half_ranges(scene: Scene, setup: Setup, highest: float, speeds: FloatArray) -> None:
    from vibecalc.pipeline.stages.torsion.variable import (
        gas_torque,
        half_ranges,
        relative_change,
        system_of,
    )

    count = len(setup.shaft.section_names)
    half, change = np.full((2, count, len(speeds)), np.inf)
    half_error, change_error = np.zeros((2, count, len(speeds)))
    left = 0
    for k, speed in enumerate(speeds):
        system, torque = system_of(setup, float(speed)), gas_torque(setup, float(speed))
        try:
            plain = constant_response(system, speed, torque, highest)
            full = steady_response(system, speed, torque, highest)
        except NumericalFailure:
            left += 1
            continue
        one, one_error = half_ranges(system, float(speed), plain)
        other, other_error = half_ranges(system, float(speed), full)
        half[:, k], half_error[:, k] = other, other_error
        change[:, k], change_error[:, k] = relative_change(one, one_error, other, other_error)
    if left:
        scene.warn(
            f"variable inertia: {left} of {len(speeds)} speeds have no motion to tell (an undamped "
            "critical, or a border of stability); they stand as unbounded"
        )
    ratio = np.abs(setup.shaft.section_ratio)[:, None]
    axes = {"section": setup.shaft.section_names, "variable_speed": speeds}
    scene.emit(f"{VARIABLE}speeds/torque_half_range", half / ratio, half_error / ratio, axes)
    scene.emit(f"{VARIABLE}speeds/change", change, change_error, axes)
    told = np.where(np.isfinite(change), np.abs(change), -1.0)
    best, row = np.argmax(told, axis=1), np.arange(count)
    if np.any(told[row, best] < 0.0):
        raise NumericalFailure("variable inertia: no speed of the range has a steady motion")
    axes = {"section": setup.shaft.section_names}
    scene.emit(f"{VARIABLE}largest_change", change[row, best], change_error[row, best], axes)
    scene.emit(f"{VARIABLE}largest_change_speed", speeds[best], 0.0, axes)


def _emit_wedges(scene: Scene, setup: Setup) -> Wedges:
    """The widest sum resonances whose centre lies in the range."""
    from vibecalc.pipeline.stages.torsion.variable import system_of

    asked, modes = setup.torsion.speeds, setup.modes
    assert asked is not None
    system = system_of(setup, setup.speed)
    found = wedges(system, modes.frequency, modes.shape, modes.modal_inertia)
    inside = (found.speed >= asked.start) & (found.speed <= asked.stop) & (found.half_width > 0.0)
    kept = np.flatnonzero(inside)[:_WEDGES]
    first = Wedges(**{name: part[kept] for name, part in found._asdict().items()})
    axes = {"wedge": np.arange(1, len(kept) + 1)}
    for name, value, error in (
        ("speed", first.speed, first.error), ("half_width", first.half_width, first.error),
        ("order", first.order.astype(float), 0.0), ("first_mode", first.first + 1.0, 0.0),
        ("second_mode", first.second + 1.0, 0.0),
        ("growth", first.growth, first.error * first.order),
        ("damping_ratio", first.damping_ratio, first.damping_ratio * first.error
         / np.maximum(first.half_width, np.finfo(float).tiny)),
    ):  # fmt: skip
        scene.emit(f"{VARIABLE}wedge/{name}", value, error, axes)
    return first


def _emit_unstable(scene: Scene, setup: Setup, found: Wedges) -> None:
    """Ranges, about the widest wedges, in which the line as it is damped has growing vibration."""
    from vibecalc.pipeline.stages.torsion.variable import basis_of, system_of

    asked = setup.torsion.speeds
    assert asked is not None
    system = system_of(setup, setup.speed)
    if np.any(setup.model.speed_stiffness):
        scene.warn("unstable ranges are those of pendulums as they are at the operating speed")
    decay = _decay(setup)
    held = np.sqrt(decay[found.first] * decay[found.second])
    feared = np.flatnonzero(found.growth > _FEARED * held)[:_MOST_RANGES]
    centre, width = found.speed[feared], found.half_width[feared] + found.error[feared]
    looked = (centre[:, None] + width[:, None] * np.array([-4.0, -1.5, 0.0, 1.5, 4.0])).ravel()
    looked = np.clip(looked, asked.start, asked.stop)
    ranges = (
        unstable_ranges(system, np.unique(looked), basis=basis_of(setup, system))
        if looked.size
        else []
    )
    axes = {"unstable": np.arange(1, len(ranges) + 1)}
    error = np.array([one.error for one in ranges])
    scene.emit(f"{VARIABLE}unstable/from", np.array([one.low for one in ranges]), error, axes)
    scene.emit(f"{VARIABLE}unstable/to", np.array([one.high for one in ranges]), error, axes)
    growth = np.array([one.growth for one in ranges])
    scene.emit(f"{VARIABLE}unstable/growth", growth, 1e-9 * np.abs(growth), axes)


def _decay(setup: Setup) -> FloatArray:
    """Rate of decay of each mode (m,) in 1/s from the work of its undamped shape."""
    line, modes = setup.model.line, setup.modes
    twist = modes.shape[:, line.first] - modes.shape[:, line.second]
    work = twist**2 @ line.damping + modes.shape**2 @ line.absolute_damping
    return np.asarray(0.5 * work / modes.modal_inertia)
