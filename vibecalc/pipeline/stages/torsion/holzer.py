"""Adapter: Holzer tables of a shaft line at its natural frequencies, branch by branch."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.plan_torsion import has_holzer
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.holzer_doubt import Angles, measured
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.holzer import holzer_rows, holzer_table
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes_doubt import ShapeDoubt

PLACES = tuple(
    f"{ROOT}/modes/holzer_{name}" for name in ("angle", "inertia_torque", "torque", "residual")
)
#: a first row that moves less than this of the largest angle is no measure for the others
_STILL = 1e-6
#: times the largest difference of two ways to the torques of a mode
MANY = 4.0


def emit_holzer(scene: Scene, setup: Setup, line: Line, doubt: ShapeDoubt) -> None:
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
    angle_error = modes.shape_error[:, None] / np.abs(unit) * np.hypot(1.0, angle)
    ground = line.ground_stiffness[rows.freedom]
    inertia_w2 = modes.frequency[:, None] ** 2 * line.inertia[rows.freedom]
    own = inertia_w2 * angle
    own_error = inertia_w2 * angle_error + 8.0 * EPSILON * np.abs(own)
    total, total_error = own - ground * angle, own_error + ground * angle_error
    for row, below in enumerate(rows.below[:-1]):
        total[:, below] += total[:, row]
        # without a common sign
        total_error[:, below] = np.hypot(total_error[:, below], total_error[:, row])
    # where the torques of the shafts agree with those of the inertias they are better than that
    twist = angle[:, :-1] - angle[:, rows.below[:-1]]
    apart = np.abs(total[:, :-1] - rows.stiffness * twist).max(axis=1, keepdims=True, initial=0.0)
    common = modes.shape_error[:, None] / np.abs(unit)  # of the first row
    seen = MANY * apart + (8.0 * EPSILON + common) * np.abs(total)
    total_error = np.where(np.any(ground), total_error, np.minimum(total_error, seen))
    if doubt.moved.shape[-1]:
        table = Angles(line, rows, unit, still, angle, inertia_w2)
        moved = zip((angle_error, own_error, total_error), measured(table, doubt), strict=True)
        angle_error, own_error, total_error = (np.minimum(*both) for both in moved)
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
