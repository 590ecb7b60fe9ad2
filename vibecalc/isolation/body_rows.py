"""Rows of a rigid body on its mounts as functions of crank speed, with their slopes."""

import numpy as np

from vibecalc.isolation.readout import Readout
from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet, Motion, read
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.direct import Undriven, dynamics, response
from vibecalc.response.matrices import Matrices


def body_rows(
    matrices: Matrices,
    readout: Readout,
    orders: np.ndarray,
    force: WithError,
    undriven: Undriven | None = None,
) -> HarmonicsAt:
    """Rows of a rigid body under forces (orders, 6) per squared crank speed, N s^2 and N m s^2."""
    order = np.asarray(orders, dtype=float)

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        system = dynamics(matrices, rate, undriven)
        column = speed[:, None, None]
        load = column * column * force.value
        error = slope = slope_error = curvature = EMPTY
        if errors:
            load_error = column * column * force.error + 4.0 * UNIT_ROUNDOFF * np.abs(load)
            value, error = response(system, load, load_error)
        else:
            value = _apply(system.inverse, load)
        if slopes:
            turn = order[:, None, None] * (
                1j * matrices.damping - 2.0 * rate[..., None, None] * matrices.mass
            )
            load_slope = 2.0 * column * force.value
            slope = _apply(system.inverse, load_slope - _apply(turn, value))
            bent = 2.0 * force.value + 2.0 * np.square(order)[:, None] * (value @ matrices.mass.T)
            curvature = _apply(system.inverse, bent - 2.0 * _apply(turn, slope))
        if slopes and errors:
            doubt = _apply(np.abs(turn), error + 32.0 * UNIT_ROUNDOFF * np.abs(value))
            doubt = doubt + _apply(system.error, np.abs(slope)) + 2.0 * column * force.error
            doubt = doubt + 16.0 * UNIT_ROUNDOFF * np.abs(load_slope)
            slope_error = _apply(np.abs(system.inverse), doubt)
            slope_error = slope_error + 16.0 * UNIT_ROUNDOFF * np.abs(slope)
        motion = Motion(value, error, slope, slope_error, curvature)
        return read(readout, order, rate, motion)

    return harmonics_at


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
