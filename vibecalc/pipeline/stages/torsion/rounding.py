"""Rounding of a solved shaft line, measured: what another solve would correct."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.stages.torsion.curves import Solved, stiffness_of
from vibecalc.pipeline.stages.torsion.gears import modal_braking
from vibecalc.pipeline.stages.torsion.setup import Setup

#: times the correction, which is itself as large as the error but no bound on it
CORRECTIONS = 4.0


def rounding_doubt(setup: Setup, speed: FloatArray, found: Solved) -> tuple[FloatArray, FloatArray]:
    """What rounding may move angles (s, m, n) and twists (s, m, e) by; 0 where masked.

    The torques that the equations of motion lack, with the angles found, are put on the line once
    more. Their own rounding is of the size of that of the first solve, and so is the answer. No
    more is told than the bound of the solver, `found.error` (s, m), which one number for all
    angles makes far too large for the twists of a line that turns as a whole.
    """
    line = setup.model.at(speed[:, None])
    a, b = line.first, line.second
    bound = np.where(found.masked, 0.0, found.error)[..., None]
    size = np.abs(found.angle)
    least = EPSILON * (size[..., a] + size[..., b])
    moved = np.where(found.masked[..., None], 0.0, _correction(setup, speed, found))
    angle = CORRECTIONS * np.max(np.abs(moved), axis=-1, keepdims=True) + EPSILON * size
    twist = CORRECTIONS * np.abs(moved[..., a] - moved[..., b]) + least
    return np.minimum(angle, bound), np.minimum(twist, 2.0 * bound + least)


def _correction(setup: Setup, speed: FloatArray, found: Solved) -> ComplexArray:
    """Angles (s, m, n) for what is left of the torques."""
    line, w = setup.model.at(speed[:, None]), found.frequency[..., None]
    own = line.ground_stiffness - w**2 * line.inertia + 1j * w * line.absolute_damping
    left = -own * found.angle
    if setup.model.modal is not None:
        left -= line.inertia * modal_braking(setup.model, found.frequency, found.angle)
    torque = stiffness_of(line, found.frequency) * found.twist
    for e, (first, second) in enumerate(zip(line.first, line.second, strict=True)):
        left[..., first] -= torque[..., e]
        left[..., second] += torque[..., e]
    for place, freedom in enumerate(setup.drive.freedom):
        left[..., freedom] += found.load[..., place]
    every = np.arange(len(line.inertia))
    return setup.model.solve(speed, setup.drive.order, left, every, estimate=False).angle
