"""Adapter: the damper that makes the worst section of a shaft line best, and what proves it."""

import math

import numpy as np

from vibecalc.case.damper_tables import DamperDesign
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.damper.design import Design, design
from vibecalc.optimisation.damper.gain import (
    Performance,
    mistuning,
    performance,
    performance_of,
)
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.pipeline.entries.damper_design import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.damper_design_curves import emit_chart, emit_curves, emit_rings
from vibecalc.pipeline.stages.damper_design_problem import Asked, build_problem
from vibecalc.pipeline.stages.torsion.setup import build_setup

_SECTION, _HEAT, _TRAVEL = 0.0, 1.0, 2.0


def run(scene: Scene) -> None:
    """Emit everything for [damper_design]."""
    options = scene.case.damper_design
    if options is None:
        raise ValueError("the case has no [damper_design]")
    setup = build_setup(scene.case)
    asked = build_problem(setup, options)
    low, high = asked.problem.speed
    if not low <= setup.speed <= high:
        scene.warn(
            f"the damper is tuned over {low:.6g} to {high:.6g} rad/s; the operating speed of "
            f"{setup.speed:.6g} rad/s lies outside"
        )
    found = design(asked.problem, asked.limits)
    _emit_damper(scene, asked, found)
    seen = performance_of(asked.problem, found)
    _emit_seen(scene, "", options, asked, seen, (found.worst, found.worst_error))
    _emit_proof(scene, asked, found)
    if options.compare is not None:
        _emit_table(scene, options, asked, found)
    if scene.wants(f"{ROOT}sensitivity"):
        off = mistuning(asked.problem, found, options.tolerance)
        axes = {"stiffness_factor": off.stiffness, "damping_factor": off.damping}
        scene.emit(f"{ROOT}sensitivity", off.rise, off.rise_error, axes)
    emit_chart(scene, options, asked, found)
    emit_rings(scene, options, asked, found)
    emit_curves(scene, setup, options, asked, found)
    scene.cite(
        "minimax over spring and dashpot by summits of all sections and speeds, Newton's method "
        "on the conditions that hold the tuning",
        "damper design",
        "Madsen (1975), Journal of the Institute of Mathematics and its Applications 16; "
        "docs/theory_torsion_studies.md",
    )


def _emit_damper(scene: Scene, asked: Asked, found: Design) -> None:
    """Own values: referred ones over the square of the speed ratio of its shaft."""
    square = asked.ratio**2
    names = ("inertia", "stiffness", "damping")
    values = [value / square for value in found.damper]
    errors = [float(error) / square for error in found.damper_error]
    for name, value, error in zip(names, values, errors, strict=True):
        scene.emit(f"{ROOT}{name}", value, error + 4.0 * EPSILON * value)
    inertia, stiffness, damping = values
    relative = [e / v if v > 0.0 else 0.0 for e, v in zip(errors, values, strict=True)]
    own = math.sqrt(stiffness / inertia)
    doubt = 0.5 * (relative[0] + relative[1]) + 4.0 * EPSILON
    scene.emit(f"{ROOT}own_frequency", own, own * doubt)
    ratio = damping / (2.0 * math.sqrt(stiffness * inertia)) if stiffness > 0.0 else math.inf
    error = ratio * (doubt + relative[2]) if stiffness > 0.0 else 0.0
    scene.emit(f"{ROOT}own_damping", ratio, error)


def _emit_seen(
    scene: Scene, stem: str, options: DamperDesign, asked: Asked, seen: Performance,
    worst: tuple[float, float],
) -> None:  # fmt: skip
    path = f"{ROOT}{stem}"
    scene.emit(f"{path}worst_{options.objective}", worst[0], worst[1])
    scene.emit(f"{path}worst_section", seen.section + 1, 0.0)
    place = seen.speed_error
    scene.emit(f"{path}worst_speed", seen.speed, place[0])
    scene.emit(f"{path}heat", seen.heat, seen.heat_error)
    scene.emit(f"{path}heat_speed", seen.heat_speed, place[1])
    ratio = abs(asked.ratio)
    scene.emit(f"{path}travel", ratio * seen.travel, ratio * seen.travel_error)
    scene.emit(f"{path}travel_speed", seen.travel_speed, place[2])


def _emit_proof(scene: Scene, asked: Asked, found: Design) -> None:
    """The summits that hold the tuning, from low to high speed, the pull of bounds, the ends."""
    order = np.argsort(found.speed, kind="stable")
    row, count = found.reading[order], len(asked.problem.weight)
    kind = np.where(row < count, _SECTION, np.where(row == count, _HEAT, _TRAVEL))
    section = np.where(row < count, row + 1, 0)
    whole = np.array([found.worst, asked.limits.heat, asked.limits.travel])
    level = found.value[order] / whole[kind.astype(int)]
    axes = {"active": np.arange(1, len(row) + 1)}
    scene.emit(f"{ROOT}active/kind", kind, 0.0, axes)
    scene.emit(f"{ROOT}active/section", section, 0.0, axes)
    speed = found.speed[order]
    scene.emit(f"{ROOT}active/speed", speed, found.speed_error[order], axes)
    slack = found.worst_error / found.worst + 2.0 * EPSILON
    scene.emit(f"{ROOT}active/level", level, slack, axes)
    doubt_of_weight = found.weight_error[order] + 2.0 * EPSILON * np.abs(found.weight[order])
    scene.emit(f"{ROOT}active/weight", found.weight[order], doubt_of_weight, axes)
    names = {"design_value": ("inertia", "stiffness", "damping")}
    scene.emit(f"{ROOT}pull", found.bound_weight, found.bound_error, names)
    # zero at an optimum: all of it is error
    scene.emit(f"{ROOT}certificate", found.residual, found.residual, terms=1.0)
    scene.emit(f"{ROOT}curvature", found.curvature, found.curvature_error)
    axes = {"basin": np.arange(1, len(found.basin) + 1)}
    square = asked.ratio**2
    # ends of descents: how far the optimum of each basin is from there
    doubt = found.basin_error / square + 4.0 * EPSILON * found.basin / square
    scene.emit(f"{ROOT}basin/stiffness", found.basin[:, 1] / square, doubt[:, 1], axes)
    scene.emit(f"{ROOT}basin/damping", found.basin[:, 2] / square, doubt[:, 2], axes)
    rise = (found.basin_worst_error + found.worst_error) / found.worst + 2.0 * EPSILON
    scene.emit(f"{ROOT}basin/worst", found.basin_worst / found.worst, rise, axes)


def _emit_table(scene: Scene, options: DamperDesign, asked: Asked, found: Design) -> None:
    assert asked.table is not None
    seen = performance(asked.problem, asked.table)
    _emit_seen(scene, "table/", options, asked, seen, (seen.worst, seen.worst_error))
    gain = seen.worst / found.worst
    error = gain * (seen.worst_error / seen.worst + found.worst_error / found.worst)
    scene.emit(f"{ROOT}table/gain", gain, error)
    limits = asked.limits
    for value, limit, words in (
        (seen.heat, limits.heat, "heat in its dashpot"),
        (seen.travel, limits.travel, "travel of its ring"),
    ):
        if value > limit:
            scene.warn(f"the table value of the damper does not keep the limit on the {words}")


def referred(damper: Damper, ratio: float) -> Damper:
    """A damper on a shaft with this speed ratio, seen from the crankshaft."""
    if ratio == 0.0:
        raise NumericalFailure("a shaft that does not turn carries no damper")
    return Damper(*(value * ratio**2 for value in damper))
