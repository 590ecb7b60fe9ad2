"""Critical speeds of a shaft line: every order against every mode."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.line import stiffness_matrix
from vibecalc.response.torsion.modes import natural_modes


def emit_critical(scene: Scene, setup: Setup) -> None:
    """Speeds (mode, order) in rad/s; 0 for a rigid mode, infinite where none is."""
    path = f"{ROOT}/critical/speed"
    if not scene.wants(path):
        return
    speed, error = critical(setup)
    axes = {"mode": np.arange(1, len(speed) + 1), "half_order": setup.drive.order}
    scene.emit(path, speed, error, axes)


def critical(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """Critical speeds (m, q) and their absolute errors, 0 for those without end."""
    modes, order = setup.modes, setup.drive.order
    speed = modes.frequency[:, None] / order
    error = modes.frequency_error[:, None] / order + EPSILON * speed
    if not np.any(setup.model.speed_stiffness):
        return speed, error
    for place, one in enumerate(order.tolist()):
        speed[:, place], error[:, place] = _met(setup, one)
    return speed, error


def _met(setup: Setup, order: float) -> tuple[FloatArray, FloatArray]:
    """Speeds (m,) at which the modes, which rise with the speed, meet an order; or infinity.

    There K + w^2 S - q^2 w^2 J is singular. The frequency of a mode over the speed falls as the
    speed rises, so each mode is met once at most.
    """
    line, modes = setup.model.line, setup.modes
    grown = line._replace(stiffness=setup.model.speed_stiffness)
    added = stiffness_matrix(grown._replace(ground_stiffness=np.zeros_like(line.inertia)))
    inertia = order**2 * np.diag(line.inertia) - added
    stiffness = stiffness_matrix(line)
    square = np.linalg.eigvals(np.linalg.solve(inertia, stiffness))
    doubt = 64.0 * EPSILON * len(square) * float(np.max(np.abs(square)))
    real = np.abs(square.imag) <= 1e-6 * np.abs(square)
    kept = np.sort(square.real[real & (square.real > doubt)])
    speed = np.where(modes.frequency > 0.0, np.inf, 0.0)
    error = np.zeros(len(speed))
    for met in np.sqrt(kept).tolist():
        there = natural_modes(setup.model.at(met))
        mode = int(np.argmin(np.abs(there.frequency - order * met)))
        # one step of Newton's method on w(speed) - order speed; its slope is negative
        own, shape = there.frequency[mode], there.shape[mode]
        rise = met * float(shape @ added @ shape) / (there.modal_inertia[mode] * own)
        left = own - order * met
        speed[mode] = met + left / (order - rise)
        rounding = there.frequency_error[mode] + 4.0 * EPSILON * own
        # the step leaves the square of what it mends
        error[mode] = rounding / (order - rise) + left**2 / (own * (order - rise))
    return speed, error
