"""Comparison variants of a shaft line: without its dampers, with all cylinders firing."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.adapters.critical import UndampedResonances, undamped_speeds
from vibecalc.torsion.adapters.curves import (
    CurveUncertainty,
    SectionUncertainty,
    curve_uncertainty,
    section_uncertainty,
    shifted_twist,
    solved,
    sweep,
    twist_uncertainty,
)
from vibecalc.torsion.adapters.exceeded import bounds
from vibecalc.torsion.adapters.limits import (
    limit_corners,
    limit_levels,
    operating_uses,
    stress_uncertainty,
    uses_of,
)
from vibecalc.torsion.adapters.maxima import DenseSweep, added, torque_value, with_narrow_resonances
from vibecalc.torsion.adapters.setup import Setup, build_drive, build_model, natural_of
from vibecalc.torsion.critical_speeds import Maxima, largest, telling_speeds
from vibecalc.torsion.line import complex_stiffness
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# Adapter: a line in another state next to its own: curves, largest values, at operating speed.
# ----------------------------------------------------------------------------


class State(NamedTuple):
    """Where results of a state go, its setup, and the places (k,) of its elements in the line."""

    place: str
    setup: Setup
    section: IntArray


class NearbyRange(NamedTuple):
    """Referred half ranges at speeds (s, k), the largest torques (k,), twists there (k,)."""

    twist: FloatArray
    torque: FloatArray
    undamped: UndampedResonances
    top: Maxima
    dense: DenseSweep
    twist_there: FloatArray
    uncertainty: CurveUncertainty
    largest_error: SectionUncertainty


def emit_operating(scene: Scene, state: State) -> tuple[FloatArray, FloatArray]:
    """Half ranges at the operating speed; own torques (k,) and their errors.

    Infinite where an order meets a mode that nothing damps.
    """
    setup = state.setup
    at = np.array([setup.speed])
    curves = sweep(setup.model, setup.drive, at, None, angles=False)
    uncertainty = curve_uncertainty(setup, at, np.zeros(0))
    return _emit(scene, state, "", curves.torque[0], curves.twist[0], uncertainty, {})


def emit_range(scene: Scene, state: State, speed: FloatArray, limited: bool = False) -> NearbyRange:
    """Curves over speeds (s,) and the largest values of each section.

    `limited`: what the line has limits for is examined as closely as its largest values.
    """
    nearby = _over(state.setup, speed, limited)
    _emit(
        scene, state, "speeds/", nearby.torque, nearby.twist, nearby.uncertainty, {"speed": speed}
    )
    _emit(scene, state, "largest/", nearby.top.value, nearby.twist_there, nearby.largest_error, {})
    axes = {"section": _names(state, state.section)}
    scene.emit(f"{state.place}/largest/speed", nearby.top.speed, nearby.top.speed_error, axes)
    return nearby


def _over(setup: Setup, speed: FloatArray, limited: bool) -> NearbyRange:
    model, drive = setup.model, setup.drive
    curves = sweep(model, drive, speed, None, angles=False)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    make = lambda section: torque_value(model, drive, section)  # noqa: E731
    levels = limit_levels(setup, speed, curves.torque) if limited else ()
    dense = with_narrow_resonances(setup, speed, curves.torque, undamped, levels)
    if limited:
        dense = added(setup, dense, limit_corners(setup, speed))
    top = largest(make, dense.torque, dense.speed, undamped.speed, undamped.endless)
    uncertainty = curve_uncertainty(
        setup, speed, telling_speeds(speed, curves.torque, undamped.speed)
    )
    error = section_uncertainty(setup, top.speed, top.section)
    moved = shifted_twist(setup, top.speed, top.speed_error)
    error = error._replace(twist=error.twist + moved)
    there = solved(model, drive, top.speed)
    of_section = there.twist[np.arange(len(top.section)), :, top.section]
    half = synthesis(drive.order, of_section).half_range
    twist = np.where(np.isfinite(top.value), half, np.inf)
    return NearbyRange(curves.twist, curves.torque, undamped, top, dense, twist, uncertainty, error)


def _emit(
    scene: Scene,
    state: State,
    kind: str,
    torque: FloatArray,
    twist: FloatArray,
    uncertainty: CurveUncertainty | SectionUncertainty,
    axes: dict[str, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Own torques, twists and stresses of referred ones (..., k)."""
    shaft, place = state.setup.shaft, f"{state.place}/{kind}"
    ratio = np.abs(shaft.section_ratio[state.section])
    named = {**axes, "section": _names(state, state.section)}
    actual, error = torque / ratio, uncertainty.torque / ratio
    scene.emit(f"{place}torque_half_range", actual.T, error, named)
    scene.emit(f"{place}twist_half_range", (twist * ratio).T, uncertainty.twist * ratio, named)
    modulus = shaft.section_modulus[state.section]
    some = np.flatnonzero(modulus)
    if len(some):
        named = {**axes, "section": _names(state, state.section[some])}
        stress = actual[..., some] / modulus[some]
        off = error[some] / modulus[some] * (1.0 + 4.0 * EPSILON)
        top = np.max(stress, initial=0.0, where=np.isfinite(stress))
        scene.emit(f"{place}stress_half_range", stress.T, off + 4.0 * EPSILON * top, named)
    return actual, error


def _names(state: State, places: IntArray) -> tuple[str, ...]:
    return tuple(state.setup.shaft.section_names[e] for e in places)


# ----------------------------------------------------------------------------
# Adapter: the same shaft line without its dampers, at the same speeds.
# ----------------------------------------------------------------------------

BARE = f"{ROOT}/bare"


def bare_setup(setup: Setup) -> Setup:
    """The line without rings and what holds them; hubs belong to their stations and stay."""
    shaft, line = setup.shaft, setup.shaft.line
    stays = np.array([kind != "damper" for kind in shaft.section_kinds])
    count = len(line.inertia) - len(shaft.dampers)
    bare = line._replace(
        inertia=line.inertia[:count],
        absolute_damping=line.absolute_damping[:count],
        ground_stiffness=line.ground_stiffness[:count],
        first=line.first[stays],
        second=line.second[stays],
        stiffness=line.stiffness[stays],
        damping=line.damping[stays],
        loss_factor=line.loss_factor[stays],
    )
    torsion, speed = setup.torsion, setup.speed
    model, modes = build_model(torsion, bare, shaft.speed_stiffness[stays], speed, count)
    natural = natural_of(torsion, model, modes, speed)
    return setup._replace(model=model, modes=modes, natural=natural)


def emit_bare(
    scene: Scene, setup: Setup, speed: FloatArray, damped: FloatArray, damped_error: FloatArray
) -> None:
    """Curves and largest values without dampers; how much less they are with them.

    `damped` (e,) are the largest referred torques of the whole line, `damped_error` their errors.
    """
    bare, shaft = bare_setup(setup), setup.shaft
    stays = np.flatnonzero([kind != "damper" for kind in shaft.section_kinds])
    state = State(BARE, bare, stays)
    frequency = bare.modes.frequency
    modes = {"bare_mode": np.arange(1, len(frequency) + 1)}
    scene.emit(f"{BARE}/natural_frequency", frequency, bare.modes.frequency_error, modes)
    emit_operating(scene, state)
    nearby = emit_range(scene, state, speed)
    ratio = np.abs(shaft.section_ratio[stays])
    value, error = nearby.top.value / ratio, nearby.largest_error.torque / ratio
    actual, actual_error = damped[stays] / ratio, damped_error[stays] / ratio
    finite = np.isfinite(actual) & np.isfinite(value) & (actual > 0.0)
    safe = np.where(finite, actual, 1.0)
    gain = np.where(finite, np.where(finite, value, 0.0) / safe, np.inf)
    off = np.where(finite, (error + np.where(finite, gain, 0.0) * actual_error) / safe, 0.0)
    axes = {"section": tuple(shaft.section_names[e] for e in stays)}
    scene.emit(f"{ROOT}/reduction", gain, off, axes)


# ----------------------------------------------------------------------------
# Adapter: a shaft line whose cylinders all fire, next to its misfire.
# ----------------------------------------------------------------------------

HEALTHY = f"{ROOT}/healthy"


def healthy_setup(scene: Scene, setup: Setup) -> Setup:
    """The same line with the torques of an engine that fires in all cylinders."""
    return setup._replace(drive=build_drive(scene.case, setup.shaft, all_fire=True))


def emit_healthy(scene: Scene, setup: Setup) -> None:
    """Half ranges at the operating speed, mean torque, dampers, use of limits."""
    healthy = healthy_setup(scene, setup)
    at = np.array([setup.speed])
    torque, error = emit_operating(scene, _state(healthy))
    total = float(healthy.drive.mean_torque(at).sum())
    error_of_mean = float(healthy.drive.mean_torque_error(at).sum()) + EPSILON * abs(total)
    scene.emit(f"{HEALTHY}/mean_torque", total, error_of_mean)
    if setup.torsion.limits:
        uses, uncertainties = operating_uses(setup, torque), operating_uses(setup, error)
        value = np.array([np.max(one, initial=0.0) for one in uses])
        off = np.array([np.max(one, initial=0.0) for one in uncertainties])
        uncertainty = off + 64.0 * EPSILON * _known(value)
        axes = {"limit": np.arange(1, len(value) + 1)}
        scene.emit(f"{HEALTHY}/limit/operating_use", value, uncertainty, axes)
    if setup.shaft.dampers:
        _dampers(scene, healthy)


def emit_healthy_range(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Curves and largest values over speeds (s,), largest use of limits."""
    healthy = healthy_setup(scene, setup)
    found = emit_range(scene, _state(healthy), speed, limited=bool(setup.torsion.limits))
    if not setup.torsion.limits:
        return
    value, uncertainty = [], []
    for bound in bounds(setup):
        uses = uses_of(healthy, bound, found.dense, found.undamped)
        worst = int(np.argmax(uses.top.value))
        value.append(float(uses.top.value[worst]))
        allowed = float(bound.continuous(uses.top.speed)[worst, worst])
        uncertainty.append(float(stress_uncertainty(healthy, bound, uses.top)[worst]) / allowed)
    axes = {"limit": np.arange(1, len(value) + 1)}
    off = np.array(uncertainty) + 64.0 * EPSILON * _known(np.array(value))
    scene.emit(f"{HEALTHY}/limit/largest_use", np.array(value), off, axes)


def _dampers(scene: Scene, setup: Setup) -> None:
    """Heat of the dampers and the largest travel of their rings, at the operating speed."""
    shaft, at = setup.shaft, np.array([setup.speed])
    rings = [one.element for one in shaft.dampers]
    state = solved(setup.model, setup.drive, at)
    masked = bool(state.masked.any())
    twist = state.twist[0][:, rings]
    line, w = setup.model.at(setup.speed), state.frequency[0]
    power = 0.5 * w[:, None] * complex_stiffness(line, w).imag[:, rings]
    heat = np.sum(power * np.abs(twist) ** 2, axis=0)
    error = twist_uncertainty(setup, at)[0][:, rings]
    heat_error = np.sum(power * (2.0 * np.abs(twist) + error) * error, axis=0)
    axes = {"damper": tuple(one.name for one in shaft.dampers)}
    value = np.full(len(rings), np.inf) if masked else heat
    scene.emit(f"{HEALTHY}/damper/heat", value, heat_error + 16.0 * EPSILON * heat, axes)
    ratio = np.abs(shaft.section_ratio[rings])
    travel = synthesis(setup.drive.order, (twist * ratio).T)
    value = np.full(len(rings), np.inf) if masked else travel.peak
    scene.emit(f"{HEALTHY}/damper/travel", value, travel.error + error.sum(axis=0) * ratio, axes)


def _state(setup: Setup) -> State:
    return State(HEALTHY, setup, np.arange(len(setup.shaft.section_names)))


def _known(value: FloatArray) -> FloatArray:
    return np.where(np.isfinite(value), value, 0.0)
