"""Rows of a rigid body on its mounts as functions of crank speed, with their slopes."""

from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.isolation.readout import Readout
from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet, Motion, read
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.direct import Undriven, dynamics, response
from vibecalc.response.matrices import Matrices


class Couple(NamedTuple):
    """A couple (speeds, orders) in N m with its error; slope and curvature are by crank speed."""

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


class CoupleAt(Protocol):
    """A couple at crank speeds (speeds,), as much of it as is asked for."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Couple: ...


def body_rows(
    matrices: Matrices,
    readout: Readout,
    orders: np.ndarray,
    force: WithError,
    undriven: Undriven | None = None,
    couple_at: CoupleAt | None = None,
    about: np.ndarray | None = None,
) -> HarmonicsAt:
    """Rows of a rigid body under forces (orders, 6) per squared crank speed, N s^2 and N m s^2.

    `couple_at` is added, a couple about the unit vector `about` (6,), as a function of the speed.
    """
    order = np.asarray(orders, dtype=float)
    axis = np.zeros(force.value.shape[-1]) if about is None else about

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        system = dynamics(matrices, rate, undriven)
        column = speed[:, None, None]
        load = column * column * force.value
        added = None if couple_at is None else couple_at(speed, slopes, errors)
        if added is not None:
            load = load + added.value[..., None] * axis
        error = slope = slope_error = curvature = EMPTY
        if errors:
            load_error = column * column * force.error + 4.0 * UNIT_ROUNDOFF * np.abs(load)
            if added is not None:
                load_error = load_error + added.error[..., None] * np.abs(axis)
            value, error = response(system, load, load_error)
        else:
            value = _apply(system.inverse, load)
        if slopes:
            turn = order[:, None, None] * (
                1j * matrices.damping - 2.0 * rate[..., None, None] * matrices.mass
            )
            load_slope = 2.0 * column * force.value
            load_bend = 2.0 * force.value
            if added is not None:
                load_slope = load_slope + added.slope[..., None] * axis
                load_bend = load_bend + added.curvature[..., None] * axis
            slope = _apply(system.inverse, load_slope - _apply(turn, value))
            bent = load_bend + 2.0 * np.square(order)[:, None] * (value @ matrices.mass.T)
            curvature = _apply(system.inverse, bent - 2.0 * _apply(turn, slope))
        if slopes and errors:
            doubt = _apply(np.abs(turn), error + 32.0 * UNIT_ROUNDOFF * np.abs(value))
            doubt = doubt + _apply(system.error, np.abs(slope)) + 2.0 * column * force.error
            doubt = doubt + 16.0 * UNIT_ROUNDOFF * np.abs(load_slope)
            if added is not None:
                doubt = doubt + added.slope_error[..., None] * np.abs(axis)
            slope_error = _apply(np.abs(system.inverse), doubt)
            slope_error = slope_error + 16.0 * UNIT_ROUNDOFF * np.abs(slope)
        motion = Motion(value, error, slope, slope_error, curvature)
        return read(readout, order, rate, motion)

    return harmonics_at


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
