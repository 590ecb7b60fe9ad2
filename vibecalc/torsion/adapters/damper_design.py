"""The damper that makes the worst section of a shaft line best, and what proves it."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, concatenate, rounded, sqrt, stack
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds, placed
from vibecalc.torsion.damper_design.design import (
    Design,
    Performance,
    chart_error,
    design,
    mistuning,
    performance,
    performance_of,
    relative_error,
)
from vibecalc.torsion.damper_design.problem import (
    Damper,
    DamperProblem,
    Limits,
    SpeedTorque,
    speed_torque,
)
from vibecalc.torsion.damper_design.settle import chart
from vibecalc.torsion.forced import largest_half_range
from vibecalc.torsion.line import Line, with_ring, without_freedom
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.results import NAMES
from vibecalc.torsion.study_results import DESIGN
from vibecalc.torsion.tables import DamperDesign

# ----------------------------------------------------------------------------
# Adapter, continued: the question of [damper_design] in the terms of the search.
# ----------------------------------------------------------------------------

#: bounds of a search without any: shares of what the lowest and the highest excited mode ask for
_STIFFNESS, _DAMPING = (0.05, 4.0), (0.02, 4.0)
_NAMES = ("inertia", "stiffness", "damping")
#: from and to, by name
Spans = dict[str, tuple[float, float]]


class DesignTask(NamedTuple):
    """`problem` and `limits` are referred; `ratio` is the own speed ratio of the damper's shaft.

    `freedom` (n,) are the places, among those of the case, of the freedoms of the line without the
    ring; `table` is the value to compare with, or None.
    """

    problem: DamperProblem
    limits: Limits
    ratio: float
    freedom: np.ndarray
    table: Damper | None


def build_problem(setup: Setup, options: DamperDesign) -> DesignTask:
    """The line without the ring, its torque, the weights of its sections, bounds and limits."""
    if setup.torsion.damping_model is not None and setup.model.modal is not None:
        raise NumericalFailure(
            "damping ratios by mode hold for the line as it is; a search for a damper needs "
            "dampings of shafts and stations, or a damping_model of kind 'rayleigh'"
        )
    line, shaft = setup.model.line, setup.shaft
    element, freedom = np.arange(line.stiffness.size), np.arange(line.inertia.size)
    replaced = next((one for one in shaft.dampers if one.name == options.on), None)
    given: tuple[float | None, ...] = (None, None, None)
    if replaced is None:
        station = shaft.station_names.index(options.on)
        carrier = int(shaft.freedom[station])
    else:
        station, carrier = replaced.station, replaced.carrier
        given = replaced.inertia, replaced.stiffness, replaced.damping
        line, element, freedom = without_freedom(line, replaced.ring, replaced.element)
    if np.any(setup.model.speed_stiffness[element]):
        raise NumericalFailure(
            "pendulums change with the speed, which the search for another damper does not follow"
        )
    ratio = float(shaft.station_ratio[station])
    task = options.speeds or setup.torsion.speeds
    assert task is not None
    speeds = (task.start, task.stop)
    own = [getattr(options, name) for name in _NAMES]
    known = [other if one is None else one for one, other in zip(own, given, strict=True)]
    limits = _limits(options, known, _spans(line, setup, speeds), ratio)
    problem = DamperProblem(
        line=line,
        station=int(np.flatnonzero(freedom == carrier)[0]),
        order=setup.drive.order,
        cycle=setup.drive.firing.cycle,
        torque=_torque(setup, freedom),
        speed=speeds,
        weight=_weights(setup, options, element),
        quantity="twist" if options.objective == "twist" else "torque",
    )
    table = None
    if options.compare is not None:
        # on the ring that is given, or the one that is replaced
        ring = limits.inertia[0] if known[0] is None else known[0] * ratio**2
        values = (options.compare.stiffness, options.compare.damping)
        table = Damper(ring, *(value * ratio**2 for value in values))
    return DesignTask(problem, limits, ratio, freedom, table)


def _weights(setup: Setup, options: DamperDesign, element: np.ndarray) -> FloatArray:
    """What turns a referred torque or twist of each section into what is made small."""
    shaft = setup.shaft
    names = np.array([shaft.section_names[place] for place in element], dtype=object)
    kinds = np.array([shaft.section_kinds[place] for place in element], dtype=object)
    counts = np.isin(names, options.sections) if options.sections else kinds != "damper"
    weight = np.abs(shaft.section_ratio[element])
    if options.objective != "twist":
        weight = 1.0 / weight
    if options.objective == "stress":
        modulus = shaft.section_modulus[element]
        lacking = counts & (modulus <= 0.0)
        if options.sections and np.any(lacking):
            raise NumericalFailure(
                f"no stress in section {names[lacking][0]!r}: it has neither diameter nor section "
                "modulus"
            )
        counts &= modulus > 0.0
        if not np.any(counts):
            raise NumericalFailure(
                "no section has a diameter or section modulus: no stress to lower"
            )
        weight = weight / np.where(counts, modulus, 1.0)
    return np.asarray(np.where(counts, weight, 0.0))


def _torque(setup: Setup, freedom: np.ndarray) -> SpeedTorque:
    """The torques of the cylinders on the freedoms that are left."""
    drive = setup.drive
    on = placed(drive.freedom, setup.model.line.inertia.size)[:, freedom].astype(complex)
    return speed_torque(drive.gas.value @ on, drive.inertia.value @ on, drive.card_speed)


def _spans(line: Line, setup: Setup, speeds: tuple[float, float]) -> Callable[[float], Spans]:
    """Usual bounds of stiffness and damping of a ring inertia, by the modes that are excited."""
    natural = natural_modes(line).frequency
    natural = natural[natural > 0.0]
    if natural.size == 0:
        raise NumericalFailure("the line has no elastic mode that a damper could calm")
    excited = natural[natural <= float(setup.drive.order[-1]) * speeds[1]]
    low, high = float(natural[0]), float(excited[-1] if excited.size else natural[0])
    return lambda ring: {
        "stiffness": (_STIFFNESS[0] * ring * low**2, _STIFFNESS[1] * ring * high**2),
        "damping": (_DAMPING[0] * ring * low, _DAMPING[1] * ring * high),
    }


def _limits(
    options: DamperDesign, known: list[float | None], usual: Callable[[float], Spans], ratio: float
) -> Limits:
    """Bounds of what is searched, equal ones of what is not; referred."""
    square, spans = ratio**2, Spans()
    for name, value in zip(_NAMES, known, strict=True):
        said = None if options.bounds is None else getattr(options.bounds, name)
        if name not in options.find:
            if value is None and name == "inertia":
                raise NumericalFailure(
                    f"no inertia of the ring on {options.on!r} is known: give one"
                )
            if value is None and name == "damping":
                raise NumericalFailure("the damping is neither looked for nor given")
            said = (value or 0.0, value or 0.0)
        elif said is None and name == "inertia":
            raise NumericalFailure("a ring inertia is looked for between bounds: give them")
        if said is None:
            spans[name] = usual(math.sqrt(math.prod(spans["inertia"])))[name]
        else:
            spans[name] = (said[0] * square, said[1] * square)
    limits = options.limits
    heat = np.inf if limits is None or limits.heat is None else limits.heat
    travel = np.inf if limits is None or limits.travel is None else limits.travel / abs(ratio)
    return Limits(**spans, heat=heat, travel=travel)


# ----------------------------------------------------------------------------
# Adapter: the damper that makes the worst section of a shaft line best, and what proves it.
# ----------------------------------------------------------------------------

_SECTION, _HEAT, _TRAVEL = 0.0, 1.0, 2.0


def run_damper_design(scene: Scene) -> None:
    """Emit everything for [damper_design]."""
    options = scene.case.damper_design
    assert options is not None
    setup = build_setup(scene.case)
    task = build_problem(setup, options)
    low, high = task.problem.speed
    if not low <= setup.speed <= high:
        low, high, at = (30.0 / math.pi * speed for speed in (low, high, setup.speed))
        scene.warn(
            f"the damper is tuned over {low:.4g} to {high:.4g} rpm; the operating speed of "
            f"{at:.4g} rpm lies outside"
        )
    best = design(task.problem, task.limits)
    _emit_damper(scene, task, best)
    achieved = performance_of(task.problem, best)
    _emit_achieved(scene, "", options, task, achieved)
    _emit_proof(scene, task, best)
    if options.compare is not None:
        _emit_table(scene, options, task, best)
    if scene.wants(f"{DESIGN}sensitivity"):
        off = mistuning(task.problem, best, options.tolerance)
        axes = {"stiffness_factor": off.stiffness, "damping_factor": off.damping}
        scene.emit(f"{DESIGN}sensitivity", off.increase, axes=axes)
    emit_chart(scene, options, task, best)
    emit_rings(scene, options, task, best)
    emit_curves(scene, setup, options, task, best)
    scene.cite(
        "minimax over spring and dashpot of the peaks of all sections and speeds, Newton's method "
        "on the optimality conditions",
        "damper design",
        "Madsen (1975), Journal of the Institute of Mathematics and its Applications 16; "
        "docs/theory_torsion_studies.md",
    )


def _emit_damper(scene: Scene, task: DesignTask, best: Design) -> None:
    """Own values: referred ones over the square of the speed ratio of its shaft."""
    values = best.damper / rounded(task.ratio**2, 6.0)
    inertia, stiffness, damping = each = [values[place] for place in range(3)]
    for name, value in zip(_NAMES, each, strict=True):
        scene.emit(f"{DESIGN}{name}", value)
    scene.emit(f"{DESIGN}natural_frequency", sqrt(stiffness / inertia))
    ratio: Bounded | float = math.inf
    if stiffness.value > 0.0:
        ratio = damping / (2.0 * sqrt(stiffness * inertia))
    scene.emit(f"{DESIGN}damping_ratio", ratio)


def _emit_achieved(
    scene: Scene, stem: str, options: DamperDesign, task: DesignTask, achieved: Performance
) -> None:
    path = f"{DESIGN}{stem}"
    worst = f"worst_{options.objective}"
    scene.emit(f"{path}worst_section", achieved.section + 1, 0.0)
    reading = achieved.reading * np.array([1.0, 1.0, abs(task.ratio)])
    names = ((worst, "worst_speed"), ("heat", "heat_speed"), ("travel", "travel_speed"))
    for place, (name, at) in enumerate(names):
        scene.emit(f"{path}{name}", reading[place])
        scene.emit(f"{path}{at}", achieved.speed[place])


def _emit_proof(scene: Scene, task: DesignTask, best: Design) -> None:
    """The peaks that hold the tuning, from low to high speed, the pull of bounds, the ends."""
    order = np.argsort(best.peaks.speed, kind="stable")
    row, count = best.peaks.row[order], len(task.problem.weight)
    kind = np.where(row < count, _SECTION, np.where(row == count, _HEAT, _TRAVEL))
    whole = np.array([best.worst.value, task.limits.heat, task.limits.travel])
    level = best.peaks.value[order] / whole[kind.astype(int)]
    slack = best.worst.error / best.worst.value + 2.0 * EPSILON
    axes = {"active": np.arange(1, len(row) + 1)}
    scene.emit(f"{DESIGN}active/kind", kind, 0.0, axes)
    scene.emit(f"{DESIGN}active/section", np.where(row < count, row + 1, 0), 0.0, axes)
    scene.emit(f"{DESIGN}active/speed", best.speed[order], axes=axes)
    scene.emit(f"{DESIGN}active/level", level, float(slack), axes)
    scene.emit(f"{DESIGN}active/weight", best.weight[order], axes=axes)
    names = {"design_value": NAMES["design_value"]}
    scene.emit(f"{DESIGN}bound_sensitivity", best.bound_weight, axes=names)
    # zero at an optimum: all of it is error
    scene.emit(f"{DESIGN}certificate", best.residual, best.residual, terms=1.0)
    scene.emit(f"{DESIGN}curvature", best.curvature)
    # ends of descents: how far the optimum of each basin is from there
    axes, ends = {"basin": np.arange(1, len(best.basin.value) + 1)}, best.basin
    ends = ends / rounded(task.ratio**2, 6.0)
    scene.emit(f"{DESIGN}basin/stiffness", ends[:, 1], axes=axes)
    scene.emit(f"{DESIGN}basin/damping", ends[:, 2], axes=axes)
    scene.emit(f"{DESIGN}basin/worst", best.basin_worst / best.worst, axes=axes)


def _emit_table(scene: Scene, options: DamperDesign, task: DesignTask, best: Design) -> None:
    assert task.table is not None
    achieved = performance(task.problem, task.table)
    _emit_achieved(scene, "table/", options, task, achieved)
    scene.emit(f"{DESIGN}table/gain", achieved.reading[0] / best.worst)
    _, heat, travel = achieved.reading.value
    limits = task.limits
    for value, limit, words in (
        (heat, limits.heat, "heat in its dashpot"),
        (travel, limits.travel, "travel of its ring"),
    ):
        if value > limit:
            scene.warn(f"the compared damper exceeds the limit on the {words}")


# ----------------------------------------------------------------------------
# Adapter, continued: map, rings and curves of a damper design.
# ----------------------------------------------------------------------------

#: points of the map each way, speeds of each, how far it reaches around the optimum at least
_MAP, _MAP_SPEEDS, _AROUND = 31, 121, 12.0
#: share by which values of the damper are moved to see what the curve makes of their errors
_MOVED = 1e-6


def emit_chart(scene: Scene, options: DamperDesign, task: DesignTask, best: Design) -> None:
    """Worst section, heat and travel over stiffness and damping around optimum and table value."""
    paths = [f"{DESIGN}chart/{name}" for name in (options.objective, "heat", "travel")]
    if not {"stiffness", "damping"} <= set(options.find) or not scene.wants(*paths):
        return
    spans = []
    for place in (1, 2):
        marked = [best.values[place]] + ([task.table[place]] if task.table is not None else [])
        low, high = task.limits.bounds[place]
        positive = [value for value in marked if value > 0.0]
        low = max(low, min(positive) / _AROUND)
        high = min(high, max(positive) * _AROUND)
        spans.append((min(low, min(positive)), max(high, max(positive))))
    inertia = best.values.inertia
    limits = task.limits._replace(inertia=(inertia, inertia), stiffness=spans[0], damping=spans[1])
    drawn = chart(task.problem, limits, _MAP, _MAP_SPEEDS)
    square = task.ratio**2
    axes = {
        "chart_stiffness": drawn.stiffness / square,
        "chart_damping": drawn.damping / square,
    }
    # read on a grid of speeds: the true peaks lie elsewhere
    uncertainty = chart_error(task.problem, drawn)
    scene.emit(f"{DESIGN}chart/{options.objective}", drawn.worst[0], uncertainty[0], axes)
    scene.emit(f"{DESIGN}chart/heat", drawn.heat[0], uncertainty[1], axes)
    ratio = abs(task.ratio)
    scene.emit(f"{DESIGN}chart/travel", drawn.travel[0] * ratio, uncertainty[2] * ratio, axes)


def emit_rings(scene: Scene, options: DamperDesign, task: DesignTask, best: Design) -> None:
    """The best damper of other rings, where the case asks for them."""
    if not options.rings:
        return
    paths = [f"{DESIGN}ring/{name}" for name in (options.objective, "stiffness", "damping")]
    if not scene.wants(*paths):
        return
    rings, rows = [], []
    bounds = options.bounds
    for inertia in (value * task.ratio**2 for value in sorted(options.rings)):
        share = inertia / best.values.inertia
        limits = task.limits._replace(inertia=(inertia, inertia))
        # what suits a ring grows with it
        if bounds is None or bounds.stiffness is None:
            limits = limits._replace(stiffness=_scaled(limits.stiffness, share))
        if bounds is None or bounds.damping is None:
            limits = limits._replace(damping=_scaled(limits.damping, share))
        try:
            one = design(task.problem, limits)
        except NumericalFailure as failure:
            actual = inertia / task.ratio**2
            scene.warn(f"no optimum damper for a ring of {actual:.6g} kg m^2: {failure}")
            continue
        values = one.damper / task.ratio**2
        rings.append(inertia / task.ratio**2)
        rows.append(concatenate([values[1:], one.worst[None]]))
    if not rows:
        raise NumericalFailure("none of the rings of the case has a best damper")
    table, axes = stack(rows), {"ring_inertia": np.array(rings)}
    for place, name in enumerate(("stiffness", "damping", options.objective)):
        scene.emit(f"{DESIGN}ring/{name}", table[place], axes=axes)


def _scaled(bounds: tuple[float, float], share: float) -> tuple[float, float]:
    """Bounds times a share; a value that is held stays."""
    low, high = bounds
    return (share * low, share * high) if low < high else bounds


def emit_curves(
    scene: Scene, setup: Setup, options: DamperDesign, task: DesignTask, best: Design
) -> None:
    """Largest section at each speed without ring, with the table value and with the optimum."""
    if not scene.wants(f"{DESIGN}curve/{options.objective}"):
        return
    given = options.speeds or setup.torsion.speeds
    assert given is not None
    speeds = line_speeds(given)
    dampers: dict[str, Damper | None] = {"none": None}
    if task.table is not None:
        dampers["table value"] = task.table
    dampers["optimum"] = best.values
    rows, errors = [], []
    for damper in dampers.values():
        value, error = largest_section(setup, task, damper, speeds)
        rows.append(value)
        errors.append(error)
    errors[-1] = errors[-1] + _of_tuning(setup, task, best, speeds, rows[-1])
    axes = {"damper_curve": tuple(dampers), "speed": speeds}
    scene.emit(f"{DESIGN}curve/{options.objective}", np.array(rows), np.array(errors), axes)


def _of_tuning(
    setup: Setup, task: DesignTask, best: Design, speeds: FloatArray, value: FloatArray
) -> FloatArray:
    """What the errors of the damper found do to its curve (s,): each value moved a little."""
    share, error = relative_error(best), np.zeros(len(speeds))
    for place in np.flatnonzero(share):
        factor = np.ones(3)
        factor[place] += _MOVED
        damper = Damper(*(float(one) for one in factor * best.damper.value))
        moved, _ = largest_section(setup, task, damper, speeds)
        known = np.isfinite(moved) & np.isfinite(value)
        slope = np.abs(np.where(known, moved, 0.0) - np.where(known, value, 0.0)) / _MOVED
        error = error + share[place] * slope
    return error


def largest_section(
    setup: Setup, task: DesignTask, damper: Damper | None, speeds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest weighted half range (s,) at speeds (s,), infinite where nothing damps; its error."""
    problem, drive = task.problem, setup.drive
    line = problem.line if damper is None else with_ring(problem.line, problem.station, *damper)
    stations = [int(np.flatnonzero(task.freedom == place)[0]) for place in drive.freedom]
    return largest_half_range(
        line, drive.order, drive.load, stations, problem.weight, speeds,
        of_twist=problem.quantity == "twist",
    )  # fmt: skip
