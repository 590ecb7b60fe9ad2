"""Adapter: a line in another state beside its own: curves, largest values, at operating speed."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.curves import solved, sweep
from vibecalc.pipeline.stages.torsion.doubt import (
    CurveDoubt,
    OwnDoubt,
    curve_doubt,
    own_doubt,
    shifted_twist,
    telling_speeds,
)
from vibecalc.pipeline.stages.torsion.limits import limit_corners, limit_levels
from vibecalc.pipeline.stages.torsion.maxima import Maxima, largest, torque_value
from vibecalc.pipeline.stages.torsion.needles import Dense, added, with_needles
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.pipeline.stages.torsion.undamped import Undamped, undamped_speeds
from vibecalc.response.torsion.synthesis import synthesis


class State(NamedTuple):
    """Where results of a state go, its setup, and the places (k,) of its elements in the line."""

    place: str
    setup: Setup
    section: IntArray


class Beside(NamedTuple):
    """Referred half ranges at speeds (s, k), the largest torques (k,), twists there (k,)."""

    twist: FloatArray
    torque: FloatArray
    undamped: Undamped
    top: Maxima
    dense: Dense
    twist_there: FloatArray
    doubt: CurveDoubt
    own: OwnDoubt


def emit_operating(scene: Scene, state: State) -> tuple[FloatArray, FloatArray]:
    """Half ranges at the operating speed; own torques (k,) and their errors.

    Infinite where an order meets a mode that nothing damps.
    """
    setup = state.setup
    at = np.array([setup.speed])
    curves = sweep(setup.model, setup.drive, at, None, angles=False)
    doubt = curve_doubt(setup, at, np.zeros(0))
    return _emit(scene, state, "", curves.torque[0], curves.twist[0], doubt, {})


def emit_range(scene: Scene, state: State, speed: FloatArray, limited: bool = False) -> Beside:
    """Curves over speeds (s,) and the largest values of each section.

    `limited`: what the line has limits for is looked at as closely as its largest values.
    """
    found = _over(state.setup, speed, limited)
    _emit(scene, state, "speeds/", found.torque, found.twist, found.doubt, {"speed": speed})
    _emit(scene, state, "largest/", found.top.value, found.twist_there, found.own, {})
    axes = {"section": _names(state, state.section)}
    scene.emit(f"{state.place}/largest/speed", found.top.speed, found.top.speed_error, axes)
    return found


def _over(setup: Setup, speed: FloatArray, limited: bool) -> Beside:
    model, drive = setup.model, setup.drive
    curves = sweep(model, drive, speed, None, angles=False)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    make = lambda section: torque_value(model, drive, section)  # noqa: E731
    levels = limit_levels(setup, speed, curves.torque) if limited else ()
    dense = with_needles(setup, speed, curves.torque, undamped, levels)
    if limited:
        dense = added(setup, dense, limit_corners(setup, speed))
    top = largest(make, dense.torque, dense.speed, undamped.speed, undamped.endless)
    doubt = curve_doubt(setup, speed, telling_speeds(speed, curves.torque, undamped.speed))
    own_error = own_doubt(setup, top.speed, top.section)
    moved = shifted_twist(setup, top.speed, top.speed_error)
    own_error = own_error._replace(twist=own_error.twist + moved)
    there = solved(model, drive, top.speed)
    own = there.twist[np.arange(len(top.section)), :, top.section]
    half = synthesis(drive.order, own).half_range
    twist = np.where(np.isfinite(top.value), half, np.inf)
    return Beside(curves.twist, curves.torque, undamped, top, dense, twist, doubt, own_error)


def _emit(
    scene: Scene,
    state: State,
    kind: str,
    torque: FloatArray,
    twist: FloatArray,
    doubt: CurveDoubt | OwnDoubt,
    axes: dict[str, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Own torques, twists and stresses of referred ones (..., k)."""
    shaft, place = state.setup.shaft, f"{state.place}/{kind}"
    ratio = np.abs(shaft.section_ratio[state.section])
    named = {**axes, "section": _names(state, state.section)}
    own, error = torque / ratio, doubt.torque / ratio
    scene.emit(f"{place}torque_half_range", own.T, error, named)
    scene.emit(f"{place}twist_half_range", (twist * ratio).T, doubt.twist * ratio, named)
    modulus = shaft.section_modulus[state.section]
    some = np.flatnonzero(modulus)
    if len(some):
        named = {**axes, "section": _names(state, state.section[some])}
        stress = own[..., some] / modulus[some]
        off = error[some] / modulus[some] * (1.0 + 4.0 * EPSILON)
        top = np.max(stress, initial=0.0, where=np.isfinite(stress))
        scene.emit(f"{place}stress_half_range", stress.T, off + 4.0 * EPSILON * top, named)
    return own, error


def _names(state: State, places: IntArray) -> tuple[str, ...]:
    return tuple(state.setup.shaft.section_names[e] for e in places)
