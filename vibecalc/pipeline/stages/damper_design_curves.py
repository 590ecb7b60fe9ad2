"""Adapter, continued: map, rings and curves of a damper design."""

import numpy as np

from vibecalc.case.damper_tables import DamperDesign
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.chart import chart
from vibecalc.optimisation.damper.chart_doubt import chart_error
from vibecalc.optimisation.damper.design import Design, design
from vibecalc.optimisation.damper.gain import relative_error
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.pipeline.entries.damper_design import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.damper_design_problem import Asked
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.forced import forced_masked
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.sections import section_torque
from vibecalc.response.torsion.synthesis import synthesis

#: points of the map each way, speeds of each, how far it reaches around the optimum at least
_MAP, _MAP_SPEEDS, _AROUND = 31, 121, 12.0
_ROWS = 64
#: share by which values of the damper are moved to see what the curve makes of their errors
_MOVED = 1e-6


def emit_chart(scene: Scene, options: DamperDesign, asked: Asked, found: Design) -> None:
    """Worst section, heat and travel over stiffness and damping around optimum and table value."""
    paths = [f"{ROOT}chart/{name}" for name in (options.objective, "heat", "travel")]
    if not {"stiffness", "damping"} <= set(options.find) or not scene.wants(*paths):
        return
    spans = []
    for place in (1, 2):
        own = [found.damper[place]] + ([asked.table[place]] if asked.table is not None else [])
        low, high = asked.limits.bounds[place]
        seen = [value for value in own if value > 0.0]
        low = max(low, min(seen) / _AROUND)
        high = min(high, max(seen) * _AROUND)
        spans.append((min(low, min(seen)), max(high, max(seen))))
    inertia = found.damper.inertia
    limits = asked.limits._replace(inertia=(inertia, inertia), stiffness=spans[0], damping=spans[1])
    drawn = chart(asked.problem, limits, _MAP, _MAP_SPEEDS)
    square = asked.ratio**2
    axes = {
        "chart_stiffness": drawn.stiffness / square,
        "chart_damping": drawn.damping / square,
    }
    # read on a grid of speeds: the true summits lie elsewhere
    doubt = chart_error(asked.problem, drawn)
    scene.emit(f"{ROOT}chart/{options.objective}", drawn.worst[0], doubt[0], axes)
    scene.emit(f"{ROOT}chart/heat", drawn.heat[0], doubt[1], axes)
    ratio = abs(asked.ratio)
    scene.emit(f"{ROOT}chart/travel", drawn.travel[0] * ratio, doubt[2] * ratio, axes)


def emit_rings(scene: Scene, options: DamperDesign, asked: Asked, found: Design) -> None:
    """The best damper of other rings, where the case asks for them."""
    if not options.rings:
        return
    paths = [f"{ROOT}ring/{name}" for name in (options.objective, "stiffness", "damping")]
    if not scene.wants(*paths):
        return
    rows = []
    bounds = options.bounds
    for inertia in (value * asked.ratio**2 for value in sorted(options.rings)):
        share = inertia / found.damper.inertia
        limits = asked.limits._replace(inertia=(inertia, inertia))
        # what suits a ring grows with it
        if bounds is None or bounds.stiffness is None:
            limits = limits._replace(stiffness=_scaled(limits.stiffness, share))
        if bounds is None or bounds.damping is None:
            limits = limits._replace(damping=_scaled(limits.damping, share))
        try:
            one = design(asked.problem, limits)
        except NumericalFailure as failure:
            own = inertia / asked.ratio**2
            scene.warn(f"no best damper told for a ring of {own:.6g} kg m^2: {failure}")
            continue
        rows.append((
            inertia, one.damper.stiffness, one.damper.damping, one.worst,
            one.damper_error[1], one.damper_error[2], one.worst_error,
        ))  # fmt: skip
    if not rows:
        raise NumericalFailure("none of the rings of the case has a best damper")
    table, square = np.array(rows).T, asked.ratio**2
    axes = {"ring_inertia": table[0] / square}
    scene.emit(f"{ROOT}ring/stiffness", table[1] / square, table[4] / square, axes)
    scene.emit(f"{ROOT}ring/damping", table[2] / square, table[5] / square, axes)
    scene.emit(f"{ROOT}ring/{options.objective}", table[3], table[6], axes)


def _scaled(bounds: tuple[float, float], share: float) -> tuple[float, float]:
    """Bounds times a share; a value that is held stays."""
    low, high = bounds
    return (share * low, share * high) if low < high else bounds


def emit_curves(
    scene: Scene, setup: Setup, options: DamperDesign, asked: Asked, found: Design
) -> None:
    """Largest section at each speed without ring, with the table value and with the optimum."""
    if not scene.wants(f"{ROOT}curve/{options.objective}"):
        return
    given = options.speeds or setup.torsion.speeds
    assert given is not None
    make = np.geomspace if given.spacing == "logarithmic" else np.linspace
    speeds = np.asarray(make(given.start, given.stop, given.points))
    dampers: dict[str, Damper | None] = {"none": None}
    if asked.table is not None:
        dampers["table value"] = asked.table
    dampers["optimum"] = found.damper
    rows, errors = [], []
    for damper in dampers.values():
        value, error = largest_section(setup, asked, damper, speeds)
        rows.append(value)
        errors.append(error)
    errors[-1] = errors[-1] + _of_tuning(setup, asked, found, speeds, rows[-1])
    axes = {"damper_curve": tuple(dampers), "speed": speeds}
    scene.emit(f"{ROOT}curve/{options.objective}", np.array(rows), np.array(errors), axes)


def _of_tuning(
    setup: Setup, asked: Asked, found: Design, speeds: FloatArray, value: FloatArray
) -> FloatArray:
    """What the errors of the damper found do to its curve (s,): each value moved a little."""
    share, error = relative_error(found), np.zeros(len(speeds))
    for place in np.flatnonzero(share):
        factor = np.ones(3)
        factor[place] += _MOVED
        damper = Damper(*(float(one) for one in factor * np.array(found.damper)))
        moved, _ = largest_section(setup, asked, damper, speeds)
        known = np.isfinite(moved) & np.isfinite(value)
        slope = np.abs(np.where(known, moved, 0.0) - np.where(known, value, 0.0)) / _MOVED
        error = error + share[place] * slope
    return error


def with_ring(line: Line, station: int, damper: Damper) -> Line:
    """The line with a ring as its last freedom and its damper as its last element."""
    n = line.inertia.size
    return Line(
        np.append(line.inertia, damper.inertia), np.append(line.absolute_damping, 0.0),
        np.append(line.ground_stiffness, 0.0), np.append(line.first, station),
        np.append(line.second, n), np.append(line.stiffness, damper.stiffness),
        np.append(line.damping, damper.damping), np.append(line.loss_factor, 0.0),
    )  # fmt: skip


def largest_section(
    setup: Setup, asked: Asked, damper: Damper | None, speeds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest weighted half range (s,) at speeds (s,), infinite where nothing damps; its error."""
    problem, drive = asked.problem, setup.drive
    line = problem.line if damper is None else with_ring(problem.line, problem.station, damper)
    counts = np.flatnonzero(problem.weight > 0.0)
    number = {int(old): new for new, old in enumerate(_freedoms(setup, asked))}
    stations = [number[int(place)] for place in drive.freedom]
    value, error = np.empty(len(speeds)), np.zeros(len(speeds))
    for start in range(0, len(speeds), _ROWS):
        part = slice(start, start + _ROWS)
        frequency = speeds[part, None] * drive.order
        solved = forced_masked(line, frequency, drive.torque(speeds[part]), stations=stations)
        doubt = np.where(solved.masked, 0.0, solved.error)
        seen = section_torque(line, frequency, solved.angle, doubt)
        wave, wave_error = seen.total, seen.error
        if problem.quantity == "twist":
            wave = seen.twist
            wave_error = np.broadcast_to(2.0 * doubt[..., None], wave.shape)
        whole = synthesis(
            drive.order,
            np.moveaxis(wave[..., counts], 1, -1),
            np.moveaxis(wave_error[..., counts], 1, -1),
        )
        weight = problem.weight[counts]
        masked = np.any(solved.masked, axis=-1)
        value[part] = np.where(masked, np.inf, np.max(weight * whole.half_range, axis=-1))
        # of orders the squares add: each is a solution of its own
        own = np.sqrt(np.sum(np.square(wave_error[..., counts]), axis=1))
        bound = np.minimum(whole.error, own + 8.0 * EPSILON * whole.half_range)
        error[part] = np.where(masked, 0.0, np.max(weight * bound, axis=-1))
    return value, error


def _freedoms(setup: Setup, asked: Asked) -> np.ndarray:
    """Freedoms of the case's line that the line without ring has, in its order."""
    every = np.arange(setup.model.line.inertia.size)
    if asked.problem.line.inertia.size == every.size:
        return every
    rings = {one.ring for one in setup.shaft.dampers if one.element not in asked.element}
    return np.array([place for place in every if place not in rings])
