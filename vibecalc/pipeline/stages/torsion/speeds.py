"""Adapter: a shaft line over a range of crank speeds, with its dampers and without."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.torsion_tables import LineSpeeds
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.bare import emit_bare
from vibecalc.pipeline.stages.torsion.campbell import emit_campbell
from vibecalc.pipeline.stages.torsion.curves import Curves, sweep
from vibecalc.pipeline.stages.torsion.doubt import (
    OwnDoubt,
    curve_doubt,
    own_doubt,
    shifted_twist,
    telling_speeds,
)
from vibecalc.pipeline.stages.torsion.gears import by_freedom, station_means
from vibecalc.pipeline.stages.torsion.hammer import emit_gears
from vibecalc.pipeline.stages.torsion.healthy import emit_healthy_range
from vibecalc.pipeline.stages.torsion.limits import emit_limits, limit_corners, limit_levels
from vibecalc.pipeline.stages.torsion.maxima import (
    MOST,
    REFINED,
    Maxima,
    largest,
    summits,
    torque_value,
)
from vibecalc.pipeline.stages.torsion.meeting import Meeting, meeting
from vibecalc.pipeline.stages.torsion.needles import (
    Dense,
    added,
    highest_maxima,
    with_needles,
)
from vibecalc.pipeline.stages.torsion.separation import emit_separation
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.pipeline.stages.torsion.stage import setup_of
from vibecalc.pipeline.stages.torsion.undamped import Undamped, undamped_speeds
from vibecalc.response.torsion.steady import steady_shares

SPEEDS = f"{ROOT}/speeds"
SUMMIT = tuple(
    f"{ROOT}/summit/{name}"
    for name in ("speed", "torque_half_range", "section", "mode", "half_order")
)
#: what has to be looked at once more where the largest values are
THERE = tuple(f"{ROOT}/largest/{name}" for name in ("twist_half_range", "mode", "half_order"))


class Range(NamedTuple):
    """Curves of the line at the speeds (s,), with errors, and its endless resonances."""

    speed: FloatArray
    curves: Curves
    twist_error: FloatArray
    torque_error: FloatArray
    angle_error: FloatArray
    gear_error: FloatArray
    undamped: Undamped
    largest: Maxima
    largest_error: OwnDoubt
    dense: Dense


def run(scene: Scene) -> None:
    """Emit curves, largest values, summits, limits, the line without dampers or misfire."""
    setup = setup_of(scene)
    options = setup.torsion.speeds
    assert options is not None
    speed = chosen(options)
    curves = sweep(setup.model, setup.drive, speed, setup.shaft)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    make = lambda section: torque_value(setup.model, setup.drive, section)  # noqa: E731
    dense = _dense(scene, setup, speed, curves.torque, undamped)
    top = largest(make, dense.torque, dense.speed, undamped.speed, undamped.endless)
    doubt = curve_doubt(setup, speed, telling_speeds(speed, curves.torque, undamped.speed))
    own = own_doubt(setup, top.speed, top.section)
    found = Range(speed, curves, *doubt, undamped, top, own, dense)
    _curves(scene, setup, found)
    emit_campbell(scene, setup, speed)
    _mean(scene, setup, found)
    _masked(scene, undamped)
    _largest(scene, setup, found)
    if scene.wants(*SUMMIT):
        high = [
            summits(make, dense.torque, dense.speed, section, undamped.speed)
            for section in _most_loaded(setup, top.value)
        ]
        joined = Maxima(*(np.concatenate(part) for part in zip(*high, strict=True)))
        _summits(scene, setup, found, joined)
    emit_separation(scene, setup, "range", speed[0], speed[-1])
    if len(top.section) > REFINED:
        scene.warn(
            f"largest values between the speeds of the sweep are looked for in the {REFINED} most "
            "loaded sections only; the others have the largest of the sweep"
        )
    if setup.torsion.limits:
        emit_limits(scene, setup, speed, dense, undamped)
    if setup.shaft.dampers:
        emit_bare(scene, setup, speed, top.value, own.torque)
    if setup.torsion.misfire:
        emit_healthy_range(scene, setup, speed)


def _dense(
    scene: Scene, setup: Setup, speed: FloatArray, torque: FloatArray, undamped: Undamped
) -> Dense:
    """The sweep (s,) of torques (s, e) with what it may have stepped over."""
    levels = limit_levels(setup, speed, torque) if setup.torsion.limits else ()
    if scene.wants(*SUMMIT):
        told = np.full(torque.shape[1], np.inf)
        for section in _most_loaded(setup, torque.max(axis=0)):
            told[section] = highest_maxima(torque[:, section], MOST)
        levels = (*levels, told)
    dense = with_needles(setup, speed, torque, undamped, levels)
    if setup.torsion.limits:
        dense = added(setup, dense, limit_corners(setup, speed))
    return dense


def chosen(options: LineSpeeds) -> FloatArray:
    """Speeds of a range, both ends included."""
    make = np.geomspace if options.spacing == "logarithmic" else np.linspace
    found = make(options.start, options.stop, options.points)
    found[[0, -1]] = options.start, options.stop
    return np.asarray(found)


def _curves(scene: Scene, setup: Setup, found: Range) -> None:
    shaft, curves = setup.shaft, found.curves
    axes = {
        "speed": found.speed,
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
    }
    ratio, own = np.abs(shaft.section_ratio), np.abs(shaft.station_ratio)
    angle = curves.angle[:, shaft.freedom] * own
    off = found.angle_error[shaft.freedom] * own
    scene.emit(f"{SPEEDS}/angle_half_range", angle.T, off, axes)
    twist, off = curves.twist * ratio, found.twist_error * ratio
    scene.emit(f"{SPEEDS}/twist_half_range", twist.T, off, axes)
    scene.emit(f"{SPEEDS}/twist_peak", (curves.travel * ratio).T, off, axes)
    torque, off = curves.torque / ratio, found.torque_error / ratio
    scene.emit(f"{SPEEDS}/torque_half_range", torque.T, off, axes)
    stressed = np.flatnonzero(shaft.section_modulus)
    if len(stressed):
        modulus = shaft.section_modulus[stressed]
        named = {**axes, "section": tuple(shaft.section_names[e] for e in stressed)}
        stress = torque[:, stressed] / modulus
        error = off[stressed] / modulus
        scene.emit(f"{SPEEDS}/stress_half_range", stress.T, error, named)
    if shaft.dampers:
        rings = [one.element for one in shaft.dampers]
        heat = curves.heat[:, rings]
        scene.emit(f"{SPEEDS}/heat", heat.T, _heat_doubt(found, rings), axes)
        travel = (curves.travel * ratio)[:, rings].T
        scene.emit(f"{SPEEDS}/travel", travel, (found.twist_error * ratio)[rings], axes)


def _heat_doubt(found: Range, rings: list[int]) -> FloatArray:
    """Errors of the powers: twice that of the twist, relatively, at the largest."""
    twist, heat = found.curves.twist[:, rings], found.curves.heat[:, rings]
    finite = np.isfinite(twist).all(axis=1)
    top = np.max(twist[finite], axis=0, initial=0.0)
    relative = 2.0 * found.twist_error[rings] / np.where(top > 0.0, top, 1.0)
    return np.asarray(np.max(heat[finite], axis=0, initial=0.0) * (relative + 16.0 * EPSILON))


def _mean(scene: Scene, setup: Setup, found: Range) -> None:
    """Mean torques, with them the largest magnitude in the sections, and gears."""
    shaft, speed, curves, top = setup.shaft, found.speed, found.curves, found.largest
    total = setup.drive.mean_torque(speed).sum(axis=1)
    total_error = setup.drive.mean_torque_error(speed).sum(axis=1) + EPSILON * np.abs(total)
    scene.emit(f"{SPEEDS}/mean_torque", total, total_error, {"speed": speed})
    shares = steady_shares(setup.model.at(setup.speed))
    mean, mean_error = station_means(shaft, setup.drive, speed, setup.speed)
    sections = by_freedom(shaft, mean) @ shares.T
    clear = ~curves.masked[:, None]
    high = np.where(clear, curves.highest, 0.0) + sections
    low = np.where(clear, curves.lowest, 0.0) + sections
    peak = np.where(clear, np.maximum(np.abs(high), np.abs(low)), np.inf)
    ratio = np.abs(shaft.section_ratio)
    steady = np.max(np.abs(shares), axis=1, initial=0.0) * np.max(mean_error)
    axes = {"speed": speed, "section": shaft.section_names}
    error = (found.torque_error + steady) / ratio
    scene.emit(f"{SPEEDS}/torque_peak", (peak / ratio).T, error, axes)
    if not shaft.gears:
        return
    near = top.speed[np.isfinite(top.value)]
    every = np.unique(np.concatenate([found.dense.speed, near, found.undamped.speed]))
    emit_gears(scene, setup, speed, curves, shares, found.gear_error, every)


def _masked(scene: Scene, undamped: Undamped) -> None:
    axes = {"masked": np.arange(1, len(undamped.speed) + 1)}
    scene.emit(f"{ROOT}/masked/from", undamped.low, undamped.error, axes)
    scene.emit(f"{ROOT}/masked/to", undamped.high, undamped.error, axes)
    scene.emit(f"{ROOT}/masked/mode", undamped.mode, 0.0, axes)
    scene.emit(f"{ROOT}/masked/half_order", undamped.order, 0.0, axes)
    if len(undamped.speed):
        scene.warn(
            f"nothing damps what is excited at {len(undamped.speed)} speeds of the range "
            "(masked): the curves have no upper end there"
        )


def _largest(scene: Scene, setup: Setup, found: Range) -> None:
    shaft, top = setup.shaft, found.largest
    ratio = np.abs(shaft.section_ratio)
    axes = {"section": shaft.section_names}
    value, error = top.value / ratio, found.largest_error.torque / ratio
    scene.emit(f"{ROOT}/largest/torque_half_range", value, error, axes)
    scene.emit(f"{ROOT}/largest/speed", top.speed, top.speed_error, axes)
    if scene.wants(*THERE):
        seen = _meeting(setup, found, top)
        twist = np.where(np.isfinite(top.value), seen.twist, np.inf) * ratio
        moved = shifted_twist(setup, top.speed, top.speed_error)
        scene.emit(THERE[0], twist, (found.largest_error.twist + moved) * ratio, axes)
        scene.emit(THERE[1], seen.mode, 0.0, axes)
        scene.emit(THERE[2], seen.order, 0.0, axes)
    stressed = np.flatnonzero(shaft.section_modulus)
    if len(stressed):
        modulus = shaft.section_modulus[stressed]
        axes = {"section": tuple(shaft.section_names[e] for e in stressed)}
        stress, off = value[stressed] / modulus, error[stressed] / modulus
        scene.emit(f"{ROOT}/largest/stress_half_range", stress, off, axes)


def _most_loaded(setup: Setup, value: FloatArray) -> list[int]:
    """The section of the largest torque, and that of the largest stress if it is another.

    Of referred torques (e,), those without end left out.
    """
    torque = np.where(np.isfinite(value), value, 0.0) / np.abs(setup.shaft.section_ratio)
    modulus = setup.shaft.section_modulus
    chosen = [int(np.argmax(torque))]
    stress = np.where(modulus > 0.0, torque / np.where(modulus > 0.0, modulus, 1.0), 0.0)
    if np.any(stress > 0.0):
        chosen.append(int(np.argmax(stress)))
    return list(dict.fromkeys(chosen))


def _summits(scene: Scene, setup: Setup, found: Range, high: Maxima) -> None:
    seen = _meeting(setup, found, high)
    axes = {"summit": np.arange(1, len(high.speed) + 1)}
    own = np.abs(setup.shaft.section_ratio[high.section])
    error = own_doubt(setup, high.speed, high.section).torque / own
    scene.emit(f"{ROOT}/summit/speed", high.speed, high.speed_error, axes)
    scene.emit(f"{ROOT}/summit/torque_half_range", high.value / own, error, axes)
    scene.emit(f"{ROOT}/summit/section", high.section + 1, 0.0, axes)
    scene.emit(f"{ROOT}/summit/mode", seen.mode, 0.0, axes)
    scene.emit(f"{ROOT}/summit/half_order", seen.order, 0.0, axes)


def _meeting(setup: Setup, found: Range, high: Maxima) -> Meeting:
    end = (high.speed <= found.speed[0]) | (high.speed >= found.speed[-1])
    return meeting(setup, high.speed, high.section, end)
