"""Adapter: Holzer tables of a shaft line at its natural frequencies, branch by branch."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.plan_torsion import has_holzer
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion_setup import Setup
from vibecalc.response.torsion.holzer import holzer_rows, holzer_table
from vibecalc.response.torsion.line import Line

PLACES = tuple(
    f"{ROOT}/modes/holzer_{name}" for name in ("angle", "inertia_torque", "torque", "residual")
)
#: a first row that moves less than this of the largest angle is no measure for the others
_STILL = 1e-6


def emit_holzer(scene: Scene, setup: Setup, line: Line) -> None:
    """Angles and torques of each mode from its shape, what the recurrence leaves at the end.

    The recurrence loses digits in a row where a mode fades, the shapes keep them.
    """
    if not has_holzer(scene.case) or not scene.wants(*PLACES):
        return
    modes, rows = setup.modes, holzer_rows(line)
    axes = {
        "mode": np.arange(1, len(modes.frequency) + 1),
        "freedom": tuple(setup.shaft.freedom_names[place] for place in rows.freedom),
    }
    shape = modes.shape[:, rows.freedom]
    first = shape[:, :1]
    size = np.abs(shape).max(axis=1, keepdims=True, initial=0.0)
    still = np.abs(first) <= np.maximum(_STILL * size, 4.0 * modes.shape_error[:, None])
    unit = np.where(still, 1.0, first)
    angle = shape / unit
    angle_error = modes.shape_error[:, None] / np.abs(unit) * (1.0 + np.abs(angle))
    ground = line.ground_stiffness[rows.freedom]
    inertia_w2 = modes.frequency[:, None] ** 2 * line.inertia[rows.freedom]
    own = inertia_w2 * angle
    own_error = inertia_w2 * angle_error + 8.0 * EPSILON * np.abs(own)
    total, total_error = own - ground * angle, own_error + ground * angle_error
    for row, below in enumerate(rows.below[:-1]):
        total[:, below] += total[:, row]
        total_error[:, below] += total_error[:, row]
    try:
        left = holzer_table(line, modes.frequency).residual
    except NumericalFailure:  # a branch that swings alone: what the shapes leave
        left = total[:, -1]
    scene.emit(PLACES[0], angle, angle_error, axes)
    scene.emit(PLACES[1], own, own_error, axes)
    scene.emit(PLACES[2], total, total_error, axes)
    # at a natural frequency nothing is left
    scene.emit(PLACES[3], left, np.abs(left) + total_error[:, -1], axes)
    scene.cite(
        "Holzer's table at the natural frequencies",
        "angles and torques of each mode as they are printed",
        "Holzer, Die Berechnung der Drehschwingungen, 1921",
    )
