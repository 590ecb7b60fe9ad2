"""Adapter: natural frequencies of a shaft line two ways, shapes, Holzer tables, damping."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.plan_torsion import has_loops, has_poles
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.holzer import emit_holzer
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.damped_equivalent import equivalent_modes
from vibecalc.response.torsion.damped_modes import damped_modes
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes import Modes
from vibecalc.response.torsion.modes_doubt import ShapeDoubt, angle_doubt, doubt_of, shape_doubt
from vibecalc.response.torsion.modes_riccati import riccati_frequencies

TRANSFER = f"{ROOT}/modes/transfer_matrix_frequency"


def emit_modes(scene: Scene, setup: Setup) -> None:
    """Undamped modes at the operating speed."""
    modes, shaft, line = setup.modes, setup.shaft, setup.model.at(setup.speed)
    frequency, shape = modes.frequency, modes.shape
    numbers = np.arange(1, len(frequency) + 1)
    axes = {
        "mode": numbers,
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
    }
    ring = [one.ring for one in shaft.dampers]
    doubt = shape_doubt(line, modes)
    off = angle_doubt(doubt)
    scene.emit(f"{ROOT}/modes/natural_frequency", frequency, modes.frequency_error, axes)
    scene.emit(f"{ROOT}/modes/frequency_error", modes.frequency_error, 0.0, axes)
    for name, freedom, turned in (
        ("shape", shaft.freedom, shaft.station_ratio),
        ("ring_shape", np.array(ring, dtype=np.int64), shaft.freedom_ratio[ring]),
    ):
        if len(freedom):
            value = shape[:, freedom] * turned
            error = off[:, freedom] * np.abs(turned) + EPSILON * np.abs(value)
            scene.emit(f"{ROOT}/modes/{name}", value, error, axes)
    inertia_error = _modal_inertia_error(line, modes, doubt)
    scene.emit(f"{ROOT}/modes/modal_inertia", modes.modal_inertia, inertia_error, axes)
    share, share_error = _strain(line, modes, doubt)
    scene.emit(f"{ROOT}/modes/strain_energy_share", share, share_error, axes)
    ratios = damping_ratios(setup)
    ratio_error = _ratio_error(setup, ratios, doubt, inertia_error)
    scene.emit(f"{ROOT}/modes/energy_damping_ratio", ratios, ratio_error, axes)
    if not has_loops(scene.case) and scene.wants(TRANSFER):
        other = riccati_frequencies(line)
        error = modes.frequency_error + 4.0 * EPSILON * other
        scene.emit(TRANSFER, other, error, axes)
    emit_holzer(scene, setup, line, doubt)
    scene.cite(
        "qd algorithm and twisted factorisation of the shaft line; mode counts for branches",
        "natural frequencies and shapes to all digits",
        "Parlett, The Symmetric Eigenvalue Problem, 1998; Fernando and Parlett, Numer. Math. 67, "
        "1994",
    )
    scene.cite(
        "Riccati transfer matrix with mode count and bisection",
        "natural frequencies a second way",
        "Horner and Pilkey, J. Mech. Design 100, 1978; Wittrick and Williams, QJMAM 24, 1971",
    )


def damping_ratios(setup: Setup) -> FloatArray:
    """By work and energy of undamped shapes (m,), 0 for rigid modes."""
    modes, modal, line = setup.modes, setup.model.modal, setup.model.at(setup.speed)
    w, moving = modes.frequency, modes.frequency > 0.0
    if modal is not None:
        work = w * modal.dashpot + modal.loss
    else:
        work = np.sum(_dissipating(line, modes) * _twist(line, modes) ** 2, axis=1)
        work = work + w * (modes.shape**2 @ line.absolute_damping)
    safe = np.where(moving, w, 1.0)
    return np.where(moving, work / (2.0 * modes.modal_inertia * safe**2), 0.0)


def _ratio_error(
    setup: Setup, ratio: FloatArray, doubt: ShapeDoubt, inertia_error: FloatArray
) -> FloatArray:
    modes, modal, line = setup.modes, setup.model.modal, setup.model.at(setup.speed)
    if modal is not None:
        return 8.0 * EPSILON * ratio
    w, moving = modes.frequency, modes.frequency > 0.0
    safe = np.where(moving, w, 1.0)
    # what moves the angles moves all parts of the work at once
    weight = 2.0 * (_dissipating(line, modes) * _twist(line, modes)) @ _ends(line)
    weight = weight + 2.0 * w[:, None] * modes.shape * line.absolute_damping
    work = doubt_of(doubt, weight[:, None, :])[:, 0]
    off = work / (2.0 * modes.modal_inertia * safe**2)
    rounding = 8.0 * EPSILON + modes.frequency_error / safe + inertia_error / modes.modal_inertia
    return np.where(moving, off + np.abs(ratio) * rounding, 0.0)


def _modal_inertia_error(line: Line, modes: Modes, doubt: ShapeDoubt) -> FloatArray:
    moved = doubt_of(doubt, 2.0 * (modes.shape * line.inertia)[:, None, :])[:, 0]
    return np.asarray(moved + 8.0 * EPSILON * modes.modal_inertia)


def emit_damped(scene: Scene, setup: Setup) -> None:
    """Poles of the line with its dashpots; loss factors as dashpots of each mode's frequency."""
    wanted = scene.wants(f"{ROOT}/damped/frequency", f"{ROOT}/damped/damping_ratio")
    if not has_poles(scene.case) or not wanted:
        return
    line = setup.model.at(setup.speed)
    try:
        if np.any(line.loss_factor):
            found = equivalent_modes(line, setup.modes)
        else:
            found = damped_modes(line)
    except NumericalFailure as failure:
        scene.warn(f"no damped natural frequencies: {failure}")
        return
    axes = {"damped_mode": np.arange(1, len(found.frequency) + 1)}
    scene.emit(f"{ROOT}/damped/frequency", found.frequency, found.pole_error, axes)
    size = np.where(found.frequency > 0.0, found.frequency, 1.0)
    # an error of a pole turns it by that over its size at most
    doubt = np.where(found.frequency > 0.0, found.pole_error / size, 0.0)
    doubt = doubt + 4.0 * EPSILON * np.abs(found.damping_ratio)
    scene.emit(f"{ROOT}/damped/damping_ratio", found.damping_ratio, doubt, axes)


def _twist(line: Line, modes: Modes) -> FloatArray:
    return np.asarray(modes.shape[:, line.first] - modes.shape[:, line.second])


def _ends(line: Line) -> FloatArray:
    """Weights (e, n) of the angles in the twists."""
    ends, every = np.zeros((len(line.first), len(line.inertia))), np.arange(len(line.first))
    np.add.at(ends, (every, line.first), 1.0)
    np.add.at(ends, (every, line.second), -1.0)
    return ends


def _dissipating(line: Line, modes: Modes) -> FloatArray:
    """w^2 times what each element takes (m, e) of a twist of 1."""
    return np.asarray(modes.frequency[:, None] * line.damping + line.stiffness * line.loss_factor)


def _strain(line: Line, modes: Modes, doubt: ShapeDoubt) -> tuple[FloatArray, FloatArray]:
    """Share (m, e) of each element in the strain energy, 0 in a rigid mode, and its error."""
    ends, twist = _ends(line), _twist(line, modes)
    energy = line.stiffness * twist**2
    total = energy.sum(axis=1) + modes.shape**2 @ line.ground_stiffness
    moving = (modes.frequency > 0.0) & (total > 0.0)
    safe = np.where(moving, total, 1.0)
    share = np.where(moving[:, None], energy / safe[:, None], 0.0)
    # d share = (d energy - share d total) / total
    own = 2.0 * (line.stiffness * twist)[..., None] * ends
    whole = own.sum(axis=1) + 2.0 * modes.shape * line.ground_stiffness
    weight = (own - share[..., None] * whole[:, None, :]) / safe[:, None, None]
    off = doubt_of(doubt, weight) + 8.0 * EPSILON * share
    return share, np.where(moving[:, None], off, 0.0)
