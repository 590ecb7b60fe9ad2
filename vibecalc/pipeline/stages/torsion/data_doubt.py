"""What the errors of the torques do to a shaft line, and to sums over its orders."""

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.synthesis import Synthesis, synthesis


def data_doubt(setup: Setup, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What the errors of the torques may move angles (s, m, n) and twists (s, m, e) by.

    The cylinders have them in common, as they have a card, each turned to its own firing; what is
    each one's own has no common sign.
    """
    drive, model = setup.drive, setup.model
    error = drive.torque_error(speed)
    one_by_one = error * np.eye(error.shape[-1])[:, None, None, :]
    moved = model.solve(
        speed, drive.order, one_by_one.astype(np.complex128), drive.freedom, estimate=False
    ).angle
    torque = drive.torque(speed)
    size = np.abs(torque)
    turn = np.moveaxis(torque / np.where(size > 0.0, size, 1.0), -1, 0)[..., None]
    line = model.line
    twist = moved[..., line.first] - moved[..., line.second]
    angle, between = (
        np.abs((turn * one).sum(axis=0)) + np.sqrt(np.sum(np.square(np.abs(one)), axis=0))
        for one in (moved, twist)
    )
    return angle, between


def summed(order: FloatArray, amplitude: ComplexArray, error: FloatArray) -> Synthesis:
    """All orders over the cycle; the errors (..., m) of the orders have no common sign."""
    found = synthesis(order, amplitude)
    return found._replace(error=found.error + np.sqrt(np.sum(np.square(error), axis=-1)))
