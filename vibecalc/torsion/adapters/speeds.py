"""A shaft line over a range of crank speeds: sections, dampers, gears."""

from functools import partial

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.rounding import EPSILON, FloatArray, distinct
from vibecalc.torsion.adapters.critical import (
    MeetingOrder,
    UndampedResonances,
    emit_separation,
    meeting,
    none_undamped,
    undamped_speeds,
)
from vibecalc.torsion.adapters.curves import (
    actual_per_referred,
    at_largest,
    mean_torques,
    of_finite,
    section_uncertainty,
    sweep,
)
from vibecalc.torsion.adapters.extremes import emit_extremes
from vibecalc.torsion.adapters.largest_alone import HEAT, highest_torques, little_asked
from vibecalc.torsion.adapters.limits import emit_limits, over_range
from vibecalc.torsion.adapters.maxima import torque_value, with_narrow_resonances
from vibecalc.torsion.adapters.modes import emit_campbell
from vibecalc.torsion.adapters.readings import (
    emit_curves,
    emit_half_ranges,
    least_gear_torque,
)
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.adapters.variants import bare_setup, emit_bare, emit_healthy_range
from vibecalc.torsion.critical_speeds import (
    MOST,
    REFINED,
    SLOPE_STEP,
    Maxima,
    barred_ranges,
    highest_maxima,
    largest,
    peaks,
    slopes,
)
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: a shaft line over a range of crank speeds, with its dampers and without.
# ----------------------------------------------------------------------------

SPEEDS = f"{ROOT}/speeds"
PEAK = tuple(
    f"{ROOT}/peak/{name}"
    for name in ("speed", "torque_half_range", "section", "mode", "half_order")
)
SEPARATION = below(f"{ROOT}/separation/range/")
#: what has to be examined once more where the largest values are
THERE = tuple(f"{ROOT}/largest/{name}" for name in ("mode", "half_order"))


def run_torsion_speeds(scene: Scene) -> None:
    """Emit curves, largest values, peaks, limits, the line without dampers or misfire."""
    setup = setup_of(scene)
    options = setup.torsion.speeds
    assert options is not None
    speed = line_speeds(options)
    if little_asked(scene, setup):
        _largest_alone(scene, setup, speed)
        return
    ranged = over_range(
        setup, speed, bool(setup.torsion.limits), setup.shaft, angles=True,
        reported=partial(_reported, setup) if scene.wants(*PEAK) else None,
    )  # fmt: skip
    curves, uncertainty, undamped, dense, top = ranged
    mean, axes = mean_torques(setup, speed), {"speed": speed}
    _, known = emit_curves(scene, SPEEDS, setup, curves, uncertainty, mean, axes)
    if setup.drive.firing.names:
        total = setup.drive.mean_torque(speed).sum()
        scene.emit(f"{SPEEDS}/mean_torque", total, axes=axes)
    if setup.shaft.gears and scene.wants(*HAMMERING):
        near = top.speed[np.isfinite(top.value)]
        every = distinct(np.concatenate([dense.speed, near, undamped.speed]))
        _emit_hammering(scene, setup, every, mean.gear.error, uncertainty.gear)
    emit_campbell(scene, setup, speed)
    if setup.model.over_speed is not None:
        from vibecalc.torsion.adapters.dampings import emit_damping_curves

        emit_damping_curves(scene, setup, speed)
    _masked(scene, undamped)
    torque = _largest(scene, setup, speed, top)
    emit_extremes(scene, setup, speed, dense.speed, known, undamped)
    if scene.wants(*PEAK):
        make = partial(torque_value, setup.model, setup.drive)
        high = [
            peaks(make, ranged.torques, dense.speed, section, undamped.speed)
            for section in _most_loaded(setup, top.value)
        ]
        joined = Maxima(*(np.concatenate(part) for part in zip(*high, strict=True)))
        _peaks(scene, setup, speed, joined)
    emit_separation(scene, setup, "range", speed[0], speed[-1])
    _warn_of_sections(scene, top)
    if setup.torsion.limits:
        emit_limits(scene, setup, speed, dense, undamped)
    if setup.shaft.couplings:
        from vibecalc.torsion.adapters.couplings import emit_coupling_speeds

        emit_coupling_speeds(scene, setup, speed, dense.speed)
    if setup.shaft.dampers:
        emit_bare(scene, setup, speed, torque)
    if setup.torsion.misfire:
        emit_healthy_range(scene, setup, speed)


def _largest_alone(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """The same of a study that asks for largest torques and the heat of dampers at most."""
    bare = bare_setup(setup) if setup.shaft.dampers else None
    found = highest_torques(scene, setup, bare, speed)
    if setup.shaft.dampers:
        names = tuple(one.name for one in setup.shaft.dampers)
        heat = of_finite(found.heat, lambda one: one)
        heat = reshaped(heat, lambda one: np.swapaxes(one, 1, 2))
        heat = heat if setup.model.machines else heat[0]
        scene.emit(HEAT, heat, axes={"speed": speed, "damper": names})
    emit_campbell(scene, setup, speed)
    if scene.wants(*SEPARATION):
        emit_separation(scene, setup, "range", speed[0], speed[-1])
    undamped = none_undamped(setup) or undamped_speeds(setup, speed[0], speed[-1])
    _masked(scene, undamped)
    if scene.wanted is not None and scene.wanted <= {HEAT}:
        return
    dense = with_narrow_resonances(setup, speed, found.torque, undamped, alone=True)
    make = partial(torque_value, setup.model, setup.drive)
    top = largest(make, dense.torque, dense.speed, undamped.speed, undamped.endless, dense.machine)
    _warn_of_sections(scene, top)
    torque = _largest(scene, setup, speed, top)
    if setup.shaft.dampers:
        emit_bare(scene, setup, speed, torque)


def _warn_of_sections(scene: Scene, top: Maxima) -> None:
    if len(top.section) > REFINED:
        scene.warn(
            f"largest values between the speeds of the sweep are looked for in the {REFINED} most "
            "loaded sections only; the others have the largest of the sweep"
        )


def _reported(setup: Setup, torque: FloatArray) -> FloatArray:
    """Levels (e,) of referred torques (s, e) that would be among the maxima that are reported."""
    levels = np.full(torque.shape[1], np.inf)
    sections = torque[:, : len(setup.model.line.first)]
    for section in _most_loaded(setup, sections.max(axis=0)):
        levels[section] = highest_maxima(torque[:, section], MOST)
    return levels


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


def _largest(scene: Scene, setup: Setup, speed: FloatArray, top: Maxima) -> Bounded:
    """Largest values of each section; gives the referred torques."""
    shaft, place = setup.shaft, f"{ROOT}/largest"
    axes, every = {"section": shaft.section_names}, np.arange(len(shaft.section_names))
    found = at_largest(setup, top, speed[-1], scene.wants(f"{place}/twist_half_range"))
    shape = (setup.model.machines, len(every)) if setup.model.machines else (len(every),)
    torque, twist, speeds = (
        reshaped(one, lambda part: part.reshape(shape))
        for one in (*found, Bounded(top.speed, top.speed_error))
    )
    emit_half_ranges(scene, place, shaft, every, torque, twist, {})
    scene.emit(f"{place}/speed", speeds, axes=axes)
    if scene.wants(*THERE):
        met = _meeting(setup, speed, top)
        scene.emit(THERE[0], met.mode, 0.0, axes)
        scene.emit(THERE[1], met.order, 0.0, axes)
    return torque


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


def _peaks(scene: Scene, setup: Setup, speed: FloatArray, high: Maxima) -> None:
    met = _meeting(setup, speed, high)
    axes = {"peak": np.arange(1, len(high.speed) + 1)}
    ratio = np.abs(setup.shaft.section_ratio[high.section])
    rounding = section_uncertainty(setup, high.speed, high.section)[1]
    torque = Bounded(high.value, rounding + high.value_error)
    scene.emit(f"{ROOT}/peak/speed", high.speed, high.speed_error, axes)
    actual = of_finite(torque, lambda one: one / ratio)
    scene.emit(f"{ROOT}/peak/torque_half_range", actual, axes=axes)
    scene.emit(f"{ROOT}/peak/section", high.section + 1, 0.0, axes)
    scene.emit(f"{ROOT}/peak/mode", met.mode, 0.0, axes)
    scene.emit(f"{ROOT}/peak/half_order", met.order, 0.0, axes)


def _meeting(setup: Setup, speed: FloatArray, high: Maxima) -> MeetingOrder:
    end = (high.speed <= speed[0]) | (high.speed >= speed[-1])
    return meeting(setup, high.speed, high.section, end)


# ----------------------------------------------------------------------------
# Adapter: ranges of speeds in which the teeth of a gear hammer.
# ----------------------------------------------------------------------------

HAMMERING = tuple(f"{ROOT}/hammering/{name}" for name in ("from", "to", "gear"))


def _emit_hammering(
    scene: Scene, setup: Setup, every: FloatArray, steady: FloatArray, error: FloatArray
) -> None:
    """Where the torque of a gear changes its sign within the cycle.

    Looked for between the speeds `every` (r,). Errors of referred torques of gears: of the mean
    ones (s, g) and of what alternates (g,).
    """
    off = (np.max(steady, axis=0) + error) * np.abs(actual_per_referred(setup.shaft))
    ends = [_ranges(setup, every, gear, float(one)) for gear, one in enumerate(off)]
    rows = [(*one, number) for number, ranges_of in enumerate(ends, start=1) for one in ranges_of]
    low, high, uncertainties, number = (np.array([row[k] for row in rows]) for k in range(4))
    axes = {"hammering": np.arange(1, len(rows) + 1)}
    scene.emit(HAMMERING[0], low, uncertainties, axes)
    scene.emit(HAMMERING[1], high, uncertainties, axes)
    scene.emit(HAMMERING[2], number.astype(np.int64), 0.0, axes)


def _ranges(
    setup: Setup, speed: FloatArray, gear: int, off: float
) -> list[tuple[float, float, float]]:
    """Ends of the ranges in which a gear hammers, in rad/s, and the error of both."""

    def reversed_by(at: FloatArray) -> FloatArray:
        curves = sweep(setup.model, setup.drive, at, setup.shaft, angles=False)
        least = least_gear_torque(setup.shaft, curves, mean_torques(setup, at).gear, 0.0)
        return np.where(curves.masked, np.inf, -off - least.value[:, gear])

    barred = barred_ranges(reversed_by, speed)
    rows = []
    for start, end in zip(barred.start.tolist(), barred.end.tolist(), strict=True):
        at = np.array([start, end])
        slope = slopes(reversed_by, at, speed[0], speed[-1])
        # an end of the speeds that were asked for, or of the sense of the mean, is exact
        near = np.abs(reversed_by(at)) < slope * SLOPE_STEP * at
        crosses = np.isfinite(slope) & (slope > 0.0) & near
        moved = np.where(crosses, 4.0 * off / np.where(crosses, slope, 1.0), 0.0)
        rows.append((start, end, float(np.max(moved + 8.0 * EPSILON * at))))
    return rows
