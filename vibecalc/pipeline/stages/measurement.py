"""Adapter: readings on a rigid plate to its motion, to levels anywhere, and to what is unsure."""

import numpy as np

from vibecalc.machine.measurement import (
    build_harmonics,
    position_rows,
    reference_row,
    references,
)
from vibecalc.measurement.level import level_of
from vibecalc.measurement.rigid_plate import PARTS
from vibecalc.numerics.rounding import WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.measured_candidates import emit_candidates, warn_of
from vibecalc.pipeline.stages.measured_motion import Found, solve_all
from vibecalc.pipeline.stages.measured_phase import phase_between
from vibecalc.pipeline.stages.measured_plate import emit_plate
from vibecalc.pipeline.stages.measured_readings import emit_readings

#: relative error of bounds that linear programs may have found
_OF_BOUNDS = 1e-5
_ROWS = {"translation": 0, "roll": 1, "pitch": 2}


def run(scene: Scene) -> None:
    """Solve every harmonic by itself, then emit what follows from the motions."""
    table = scene.case.measurement
    if table is None:
        raise ValueError("the case has no [measurement]")
    reference = reference_row(table)
    found = solve_all(build_harmonics(table), reference)
    for one in found:
        warn_of(scene, one, table)
    orders = {"order": np.array(table.orders)}
    _emit_motion(scene, found, reference, orders)
    _emit_positions(scene, found, orders)
    _emit_fit(scene, found, orders)
    emit_readings(scene, found)
    emit_candidates(scene, found, reference)
    emit_plate(scene, found, orders)
    frequency = table.base_frequency or scene.case.machine.speed
    if frequency is not None:
        scene.emit("measurement/frequency", orders["order"] * frequency, 0.0, orders)
    _cite(scene, found)


def _emit_motion(
    scene: Scene, found: list[Found], reference: np.ndarray, axes: dict[str, np.ndarray]
) -> None:
    table = scene.case.measurement
    assert table is not None
    own = references(table)
    for name, place in _ROWS.items():
        row = np.eye(3)[place]
        scale = own.linear if name == "translation" else own.angular
        values, errors = _stacked([one.signal(row) for one in found])
        scene.emit(f"measurement/{name}", values, errors, axes)
        scene.emit(f"measurement/{name}_level", *level_of(values, errors, scale), axes)
        phases = _stacked([phase_between(one, row, reference) for one in found])
        scene.emit(f"measurement/phase/{name}", *phases, axes)
        doubts = np.array([float(one.level_deviation(row[None])[0]) for one in found])
        _emit_doubt(scene, f"{name}_level", doubts, found, axes)
        doubts = np.array([one.phase_deviation(row, reference) for one in found])
        _emit_doubt(scene, f"{name}_phase", doubts, found, axes)
        if name != "translation":
            phases = _stacked([phase_between(one, row, np.eye(3)[0]) for one in found])
            scene.emit(f"measurement/phase/{name}_to_translation", *phases, axes)


def _emit_doubt(
    scene: Scene, name: str, values: np.ndarray, found: list[Found], axes: dict[str, np.ndarray]
) -> None:
    """Emit uncertainties, the last axis over the harmonics; an infinite one is as it is."""
    finite = np.where(np.isfinite(values), values, 0.0)
    share = np.array([one.spread.doubt + (one.reach is not None) * _OF_BOUNDS for one in found])
    scene.emit(f"measurement/uncertainty/{name}", values, finite * share, axes)


def _emit_positions(scene: Scene, found: list[Found], orders: dict[str, np.ndarray]) -> None:
    table = scene.case.measurement
    assert table is not None
    if not table.positions:
        return
    own = references(table).linear
    rows = position_rows(table)
    names = np.array([position.name for position in table.positions], dtype=object)
    axes = {"position": names, **orders}
    for part, kept in PARTS.items():
        values, errors = _stacked([one.signal(rows * np.array(kept)) for one in found])
        scene.emit(f"measurement/level/{part}", *level_of(values, errors, own), axes)
        if part == "standard":
            scene.emit("measurement/acceleration", values, errors, axes)
            total = np.linalg.norm(values, axis=-1)
            doubt = np.linalg.norm(errors, axis=-1)
            scene.emit("measurement/level/all_orders", *level_of(total, doubt, own), axes)
    deviations = np.stack([one.level_deviation(rows) for one in found], axis=-1)
    _emit_doubt(scene, "level", deviations, found, axes)
    bounds = np.stack([one.level_bound(rows) for one in found], axis=-1)
    _emit_doubt(scene, "level_bound", bounds, found, axes)


def _emit_fit(scene: Scene, found: list[Found], axes: dict[str, np.ndarray]) -> None:
    motions = np.array([max(len(one.candidates), 1) for one in found])
    scene.emit("measurement/fit/motions", motions, 0.0, axes)
    decided = np.array([int(one.decided) for one in found])
    scene.emit("measurement/fit/decided", decided, 0.0, axes)
    misfit = np.array([one.misfit for one in found])
    error = np.array([one.misfit_error for one in found])
    scene.emit("measurement/fit/misfit", misfit, error, axes, terms=1.0)


def _stacked(each: list[WithError]) -> WithError:
    """Results of the harmonics, one beside the other along the last axis."""
    return WithError(
        np.stack([np.asarray(one.value) for one in each], axis=-1),
        np.stack([np.asarray(one.error) for one in each], axis=-1),
    )


def _cite(scene: Scene, found: list[Found]) -> None:
    scene.cite(
        "rigid plate in small motion",
        "levels at any point from translation, roll and pitch",
        "Herold, Roll vibration of reciprocating machines, 1977, eqs. 1 to 43",
    )
    if any(one.candidates for one in found):
        scene.cite(
            "second moments of phasors from levels",
            "all motions that levels allow",
            "a line through the cone of semidefinite matrices, docs/theory_measurement.md; with "
            "three points and two differences the permutations of Herold (1977), eqs. 32 and 33",
        )
    if any(one.harmonic.is_complex for one in found):
        scene.cite(
            "weighted linear least squares",
            "motion from complex amplitudes",
            "Lawson and Hanson, Solving Least Squares Problems, 1974",
        )
    scene.cite(
        "propagation of uncertainty, first order",
        "standard uncertainties of levels and phases",
        "JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1",
    )
