"""A shaft line over a range of crank speeds: sections, dampers, gears."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, distinct
from vibecalc.torsion.adapters.critical import (
    MeetingOrder,
    UndampedResonances,
    emit_separation,
    meeting,
    undamped_speeds,
)
from vibecalc.torsion.adapters.curves import (
    Curves,
    SectionUncertainty,
    actual_per_referred,
    by_freedom,
    curve_uncertainty,
    section_uncertainty,
    shifted_twist,
    station_means,
    steady_gears,
    steady_uncertainties,
    sweep,
)
from vibecalc.torsion.adapters.limits import emit_limits, limit_corners, limit_levels
from vibecalc.torsion.adapters.maxima import DenseSweep, added, torque_value, with_narrow_resonances
from vibecalc.torsion.adapters.modes import emit_campbell
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.adapters.variants import emit_bare, emit_healthy_range
from vibecalc.torsion.critical_speeds import (
    MOST,
    REFINED,
    Maxima,
    barred_ranges,
    highest_maxima,
    largest,
    peaks,
    telling_speeds,
)
from vibecalc.torsion.model import ShaftLineModel
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.section_loads import steady_shares
from vibecalc.torsion.tables import LineSpeeds

# ----------------------------------------------------------------------------
# Adapter: a shaft line over a range of crank speeds, with its dampers and without.
# ----------------------------------------------------------------------------

SPEEDS = f"{ROOT}/speeds"
PEAK = tuple(
    f"{ROOT}/peak/{name}"
    for name in ("speed", "torque_half_range", "section", "mode", "half_order")
)
#: what has to be examined once more where the largest values are
THERE = tuple(f"{ROOT}/largest/{name}" for name in ("twist_half_range", "mode", "half_order"))


class SpeedCurves(NamedTuple):
    """Curves of the line at the speeds (s,), with errors, and its endless resonances."""

    speed: FloatArray
    curves: Curves
    twist_error: FloatArray
    torque_error: FloatArray
    angle_error: FloatArray
    gear_error: FloatArray
    undamped: UndampedResonances
    largest: Maxima
    largest_error: SectionUncertainty
    dense: DenseSweep


def run_torsion_speeds(scene: Scene) -> None:
    """Emit curves, largest values, peaks, limits, the line without dampers or misfire."""
    setup = setup_of(scene)
    options = setup.torsion.speeds
    assert options is not None
    speed = chosen(options)
    curves = sweep(setup.model, setup.drive, speed, setup.shaft)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    make = lambda section: torque_value(setup.model, setup.drive, section)  # noqa: E731
    dense = _dense(scene, setup, speed, curves.torque, undamped)
    top = largest(make, dense.torque, dense.speed, undamped.speed, undamped.endless)
    uncertainty = curve_uncertainty(
        setup, speed, telling_speeds(speed, curves.torque, undamped.speed)
    )
    largest_error = section_uncertainty(setup, top.speed, top.section)
    swept = SpeedCurves(speed, curves, *uncertainty, undamped, top, largest_error, dense)
    _curves(scene, setup, swept)
    emit_campbell(scene, setup, speed)
    _mean(scene, setup, swept)
    _masked(scene, undamped)
    _largest(scene, setup, swept)
    if scene.wants(*PEAK):
        high = [
            peaks(make, dense.torque, dense.speed, section, undamped.speed)
            for section in _most_loaded(setup, top.value)
        ]
        joined = Maxima(*(np.concatenate(part) for part in zip(*high, strict=True)))
        _peaks(scene, setup, swept, joined)
    emit_separation(scene, setup, "range", speed[0], speed[-1])
    if len(top.section) > REFINED:
        scene.warn(
            f"largest values between the speeds of the sweep are looked for in the {REFINED} most "
            "loaded sections only; the others have the largest of the sweep"
        )
    if setup.torsion.limits:
        emit_limits(scene, setup, speed, dense, undamped)
    if setup.shaft.dampers:
        emit_bare(scene, setup, speed, top.value, largest_error.torque)
    if setup.torsion.misfire:
        emit_healthy_range(scene, setup, speed)


def _dense(
    scene: Scene, setup: Setup, speed: FloatArray, torque: FloatArray, undamped: UndampedResonances
) -> DenseSweep:
    """The sweep (s,) of torques (s, e) with what it may have stepped over."""
    levels = limit_levels(setup, speed, torque) if setup.torsion.limits else ()
    if scene.wants(*PEAK):
        reported = np.full(torque.shape[1], np.inf)
        for section in _most_loaded(setup, torque.max(axis=0)):
            reported[section] = highest_maxima(torque[:, section], MOST)
        levels = (*levels, reported)
    dense = with_narrow_resonances(setup, speed, torque, undamped, levels)
    if setup.torsion.limits:
        dense = added(setup, dense, limit_corners(setup, speed))
    return dense


def chosen(options: LineSpeeds) -> FloatArray:
    """Speeds of a range, both ends included."""
    make = np.geomspace if options.spacing == "logarithmic" else np.linspace
    found = make(options.start, options.stop, options.points)
    found[[0, -1]] = options.start, options.stop
    return np.asarray(found)


def _curves(scene: Scene, setup: Setup, swept: SpeedCurves) -> None:
    shaft, curves = setup.shaft, swept.curves
    axes = {
        "speed": swept.speed,
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
    }
    ratio, station_ratio = np.abs(shaft.section_ratio), np.abs(shaft.station_ratio)
    angle = curves.angle[:, shaft.freedom] * station_ratio
    off = swept.angle_error[shaft.freedom] * station_ratio
    scene.emit(f"{SPEEDS}/angle_half_range", angle.T, off, axes)
    twist, off = curves.twist * ratio, swept.twist_error * ratio
    scene.emit(f"{SPEEDS}/twist_half_range", twist.T, off, axes)
    scene.emit(f"{SPEEDS}/twist_peak", (curves.travel * ratio).T, off, axes)
    torque, off = curves.torque / ratio, swept.torque_error / ratio
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
        scene.emit(f"{SPEEDS}/heat", heat.T, _heat_uncertainty(swept, rings), axes)
        travel = (curves.travel * ratio)[:, rings].T
        scene.emit(f"{SPEEDS}/travel", travel, (swept.twist_error * ratio)[rings], axes)


def _heat_uncertainty(swept: SpeedCurves, rings: list[int]) -> FloatArray:
    """Errors of the powers: twice that of the twist, relatively, at the largest."""
    twist, heat = swept.curves.twist[:, rings], swept.curves.heat[:, rings]
    finite = np.isfinite(twist).all(axis=1)
    top = np.max(twist[finite], axis=0, initial=0.0)
    relative = 2.0 * swept.twist_error[rings] / np.where(top > 0.0, top, 1.0)
    return np.asarray(np.max(heat[finite], axis=0, initial=0.0) * (relative + 16.0 * EPSILON))


def _mean(scene: Scene, setup: Setup, swept: SpeedCurves) -> None:
    """Mean torques, with them the largest magnitude in the sections, and gears."""
    shaft, speed, curves, top = setup.shaft, swept.speed, swept.curves, swept.largest
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
    error = (swept.torque_error + steady) / ratio
    scene.emit(f"{SPEEDS}/torque_peak", (peak / ratio).T, error, axes)
    if not shaft.gears:
        return
    near = top.speed[np.isfinite(top.value)]
    every = distinct(np.concatenate([swept.dense.speed, near, swept.undamped.speed]))
    emit_gears(scene, setup, speed, curves, shares, swept.gear_error, every)


def _masked(scene: Scene, undamped: UndampedResonances) -> None:
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


def _largest(scene: Scene, setup: Setup, swept: SpeedCurves) -> None:
    shaft, top = setup.shaft, swept.largest
    ratio = np.abs(shaft.section_ratio)
    axes = {"section": shaft.section_names}
    value, error = top.value / ratio, swept.largest_error.torque / ratio
    scene.emit(f"{ROOT}/largest/torque_half_range", value, error, axes)
    scene.emit(f"{ROOT}/largest/speed", top.speed, top.speed_error, axes)
    if scene.wants(*THERE):
        met = _meeting(setup, swept, top)
        twist = np.where(np.isfinite(top.value), met.twist, np.inf) * ratio
        moved = shifted_twist(setup, top.speed, top.speed_error)
        scene.emit(THERE[0], twist, (swept.largest_error.twist + moved) * ratio, axes)
        scene.emit(THERE[1], met.mode, 0.0, axes)
        scene.emit(THERE[2], met.order, 0.0, axes)
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


def _peaks(scene: Scene, setup: Setup, swept: SpeedCurves, high: Maxima) -> None:
    met = _meeting(setup, swept, high)
    axes = {"peak": np.arange(1, len(high.speed) + 1)}
    section_ratio = np.abs(setup.shaft.section_ratio[high.section])
    error = section_uncertainty(setup, high.speed, high.section).torque / section_ratio
    scene.emit(f"{ROOT}/peak/speed", high.speed, high.speed_error, axes)
    scene.emit(f"{ROOT}/peak/torque_half_range", high.value / section_ratio, error, axes)
    scene.emit(f"{ROOT}/peak/section", high.section + 1, 0.0, axes)
    scene.emit(f"{ROOT}/peak/mode", met.mode, 0.0, axes)
    scene.emit(f"{ROOT}/peak/half_order", met.order, 0.0, axes)


def _meeting(setup: Setup, swept: SpeedCurves, high: Maxima) -> MeetingOrder:
    end = (high.speed <= swept.speed[0]) | (high.speed >= swept.speed[-1])
    return meeting(setup, high.speed, high.section, end)


# ----------------------------------------------------------------------------
# Adapter: torque of the gears of a shaft line against speed, and where their teeth hammer.
# ----------------------------------------------------------------------------

HAMMERING = tuple(f"{ROOT}/hammering/{name}" for name in ("from", "to", "gear"))


def emit_gears(
    scene: Scene,
    setup: Setup,
    speed: FloatArray,
    curves: Curves,
    shares: FloatArray,
    error: FloatArray,
    every: FloatArray,
) -> None:
    """Mean and alternating torques, the least over a cycle, ranges in which it changes its sign.

    `curves` at speeds (s,), with errors (g,) of referred torques of gears; `shares` say what the
    sections carry of the mean torques. Ranges are searched between the speeds `every` (r,).
    """
    shaft = setup.shaft
    size = np.abs(actual_per_referred(shaft))
    axes = {"speed": speed, "gear": tuple(one.name for one in shaft.gears)}
    through, uncertainty = _gear_means(setup, speed, shares)
    off = size * error + uncertainty
    scene.emit(f"{SPEEDS}/gear_mean_torque", through.T, uncertainty, axes)
    scene.emit(f"{SPEEDS}/gear_torque", (curves.gear * size).T, size * error, axes)
    least = _least(shaft, curves, through, uncertainty)
    scene.emit(f"{SPEEDS}/gear_minimum_torque", least.T, off, axes)
    hammers = least < -off
    scene.emit(f"{SPEEDS}/gear_hammers", hammers.astype(np.int64).T, 0.0, axes)
    if not scene.wants(*HAMMERING):
        return
    ends = [_ranges(setup, every, shares, gear, float(off[gear])) for gear in range(len(size))]
    rows = [(*one, number) for number, ranges_of in enumerate(ends, start=1) for one in ranges_of]
    low, high, uncertainties, number = (np.array([row[k] for row in rows]) for k in range(4))
    axes = {"hammering": np.arange(1, len(rows) + 1)}
    scene.emit(HAMMERING[0], low, uncertainties, axes)
    scene.emit(HAMMERING[1], high, uncertainties, axes)
    scene.emit(HAMMERING[2], number.astype(np.int64), 0.0, axes)


def _gear_means(
    setup: Setup, speed: FloatArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean torques (s, g) on the first wheels, and the largest error (g,) of each."""
    shaft, scale = setup.shaft, actual_per_referred(setup.shaft)
    mean, _ = station_means(shaft, setup.drive, speed, setup.speed)
    through = steady_gears(shaft, by_freedom(shaft, mean) @ shares.T, mean) * scale
    error = steady_uncertainties(shaft, setup.drive, speed, mean, shares) * np.abs(scale)
    return through, np.max(error, axis=0)


def _least(
    shaft: ShaftLineModel, curves: Curves, through: FloatArray, uncertainty: FloatArray
) -> FloatArray:
    """Least torque (s, g) in the sense of the mean; minus infinity where nothing damps the line.

    A mean that is zero to within its error `uncertainty` (g,) has no sense: the lower one of both
    counts.
    """
    scale = actual_per_referred(shaft)
    size, turned = np.abs(scale), (scale < 0.0) != (through < 0.0)
    ends = curves.gear_highest, -curves.gear_lowest
    down = (
        np.where(np.abs(through) <= uncertainty, np.maximum(*ends), np.where(turned, *ends)) * size
    )
    bounded: BoolArray = ~curves.masked[:, None]
    return np.where(bounded, np.abs(through) - np.where(bounded, down, 0.0), -np.inf)


def _ranges(
    setup: Setup, speed: FloatArray, shares: FloatArray, gear: int, off: float
) -> list[tuple[float, float, float]]:
    """Ends of the ranges in which a gear hammers, in rad/s, and the error of both."""

    def reversed_by(at: FloatArray) -> FloatArray:
        curves = sweep(setup.model, setup.drive, at, setup.shaft, angles=False)
        through, uncertainty = _gear_means(setup, at, shares)
        return -off - _least(setup.shaft, curves, through, uncertainty)[:, gear]

    barred = barred_ranges(reversed_by, speed)
    rows = []
    for start, end in zip(barred.start.tolist(), barred.end.tolist(), strict=True):
        at = np.array([start, end])
        step = 1e-7 * at
        nearby = reversed_by(np.concatenate([at - step, at + step]))
        with np.errstate(invalid="ignore"):  # next to a speed without bound
            slope = np.abs(nearby[2:] - nearby[:2]) / (2.0 * step)
        # an end of the speeds that were asked for, or of the sense of the mean, is exact
        crosses = np.isfinite(slope) & (slope > 0.0) & (np.abs(reversed_by(at)) < slope * step)
        moved = np.where(crosses, 4.0 * off / np.where(crosses, slope, 1.0), 0.0)
        rows.append((start, end, float(np.max(moved + 8.0 * EPSILON * at))))
    return rows
