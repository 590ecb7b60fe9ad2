"""Adapter: natural frequencies of a shaft line two ways, shapes, Holzer tables, damping."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.plan_torsion import has_loops, has_poles
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion_holzer import emit_holzer
from vibecalc.pipeline.stages.torsion_setup import Setup
from vibecalc.response.torsion.damped_equivalent import equivalent_modes
from vibecalc.response.torsion.damped_modes import damped_modes
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes import Modes
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
    ratio = shaft.station_ratio
    doubt = float(np.max(modes.shape_error, initial=0.0))
    biggest = float(np.max(np.abs(ratio)))
    scene.emit(f"{ROOT}/modes/natural_frequency", frequency, modes.frequency_error, axes)
    scene.emit(f"{ROOT}/modes/frequency_error", modes.frequency_error, 0.0, axes)
    scene.emit(f"{ROOT}/modes/shape", shape[:, shaft.freedom] * ratio, doubt * biggest, axes)
    if ring:
        own = shape[:, ring] * shaft.freedom_ratio[ring]
        scene.emit(f"{ROOT}/modes/ring_shape", own, doubt * biggest, axes)
    inertia_error = 2.0 * doubt * float(line.inertia.sum()) + 8.0 * EPSILON * modes.modal_inertia
    scene.emit(f"{ROOT}/modes/modal_inertia", modes.modal_inertia, inertia_error, axes)
    share, share_error = _strain(line, modes)
    scene.emit(f"{ROOT}/modes/strain_energy_share", share, share_error, axes)
    ratios, ratio_error = damping_ratios(setup)
    scene.emit(f"{ROOT}/modes/energy_damping_ratio", ratios, ratio_error, axes)
    if not has_loops(scene.case) and scene.wants(TRANSFER):
        other = riccati_frequencies(line)
        error = modes.frequency_error + 4.0 * EPSILON * other
        scene.emit(TRANSFER, other, error, axes)
    emit_holzer(scene, setup, line)
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


def damping_ratios(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """By work and energy of undamped shapes (m,), 0 for rigid modes, with absolute errors."""
    modes, modal, line = setup.modes, setup.model.modal, setup.model.at(setup.speed)
    w, moving = modes.frequency, modes.frequency > 0.0
    if modal is not None:
        work = w * modal.dashpot + modal.loss
    else:
        twist = _twist(line, modes)
        of_element = w[:, None] * line.damping + line.stiffness * line.loss_factor
        work = np.sum(of_element * twist**2, axis=1)
        work = work + w * (modes.shape**2 @ line.absolute_damping)
    safe = np.where(moving, w, 1.0)
    ratio = np.where(moving, work / (2.0 * modes.modal_inertia * safe**2), 0.0)
    own = 8.0 * EPSILON + 4.0 * modes.shape_error * np.sqrt(
        len(w) * line.inertia.sum() / modes.modal_inertia
    )
    return ratio, ratio * own


def emit_damped(scene: Scene, setup: Setup) -> None:
    """Poles of the line with its dashpots; loss factors as dashpots of each mode's frequency."""
    if not has_poles(scene.case) or not scene.wants(f"{ROOT}/damped/frequency"):
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
    doubt = np.where(found.frequency > 0.0, 2.0 * found.pole_error / size, 0.0) + EPSILON
    scene.emit(f"{ROOT}/damped/damping_ratio", found.damping_ratio, doubt, axes)


def _twist(line: Line, modes: Modes) -> FloatArray:
    return np.asarray(modes.shape[:, line.first] - modes.shape[:, line.second])


def _strain(line: Line, modes: Modes) -> tuple[FloatArray, FloatArray]:
    """Share (m, e) of each element in the strain energy; 0 in a rigid mode."""
    energy = line.stiffness * _twist(line, modes) ** 2
    total = energy.sum(axis=1) + modes.shape**2 @ line.ground_stiffness
    moving = (modes.frequency > 0.0) & (total > 0.0)
    share = np.where(moving[:, None], energy / np.where(moving, total, 1.0)[:, None], 0.0)
    # dE / E: twice the error of a twist over it, for the stiffest element
    root = np.sqrt(line.stiffness.max(initial=0.0) / np.where(moving, total, np.inf))
    return share, 8.0 * modes.shape_error * root + 8.0 * EPSILON
