"""Adapter: a shaft line whose cylinders all fire, beside its misfire."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.beside import State, emit_operating, emit_range
from vibecalc.pipeline.stages.torsion.bounds import bounds
from vibecalc.pipeline.stages.torsion.curves import solved, stiffness_of
from vibecalc.pipeline.stages.torsion.doubt import twist_doubt
from vibecalc.pipeline.stages.torsion.drive import build_drive
from vibecalc.pipeline.stages.torsion.limit_table import operating_uses
from vibecalc.pipeline.stages.torsion.limits import stress_doubt, uses_of
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.synthesis import synthesis

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
        uses, doubts = operating_uses(setup, torque), operating_uses(setup, error)
        value = np.array([np.max(one, initial=0.0) for one in uses])
        off = np.array([np.max(one, initial=0.0) for one in doubts])
        doubt = off + 64.0 * EPSILON * _known(value)
        axes = {"limit": np.arange(1, len(value) + 1)}
        scene.emit(f"{HEALTHY}/limit/operating_use", value, doubt, axes)
    if setup.shaft.dampers:
        _dampers(scene, healthy)


def emit_healthy_range(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Curves and largest values over speeds (s,), largest use of limits."""
    healthy = healthy_setup(scene, setup)
    found = emit_range(scene, _state(healthy), speed, limited=bool(setup.torsion.limits))
    if not setup.torsion.limits:
        return
    value, doubt = [], []
    for bound in bounds(setup):
        uses = uses_of(healthy, bound, found.dense, found.undamped)
        worst = int(np.argmax(uses.top.value))
        value.append(float(uses.top.value[worst]))
        allowed = float(bound.continuous(uses.top.speed)[worst, worst])
        doubt.append(float(stress_doubt(healthy, bound, uses.top)[worst]) / allowed)
    axes = {"limit": np.arange(1, len(value) + 1)}
    off = np.array(doubt) + 64.0 * EPSILON * _known(np.array(value))
    scene.emit(f"{HEALTHY}/limit/largest_use", np.array(value), off, axes)


def _dampers(scene: Scene, setup: Setup) -> None:
    """Heat of the dampers and the largest travel of their rings, at the operating speed."""
    shaft, at = setup.shaft, np.array([setup.speed])
    rings = [one.element for one in shaft.dampers]
    found = solved(setup.model, setup.drive, at)
    masked = bool(found.masked.any())
    twist = found.twist[0][:, rings]
    line, w = setup.model.at(setup.speed), found.frequency[0]
    power = 0.5 * w[:, None] * stiffness_of(line, w).imag[:, rings]
    heat = np.sum(power * np.abs(twist) ** 2, axis=0)
    error = twist_doubt(setup, at)[0][:, rings]
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
