"""Rows of the pitch model as functions of crank speed, with their slopes."""

import numpy as np

from vibecalc.isolation.pitch import Pitch, pitch_dynamic_stiffness
from vibecalc.isolation.readout import Readout
from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet, Motion, read
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError


def pitch_rows(
    pitch: Pitch,
    readout: Readout,
    orders: np.ndarray,
    couple: WithError,
    left_out: np.ndarray | bool = False,
) -> HarmonicsAt:
    """Rows of the pitch model under couples (orders,) per squared crank speed, N m s^2.

    `left_out` (orders,) as in `angle_harmonics`.
    """
    order = np.asarray(orders, dtype=float)
    per_square = couple.value

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        column = speed[:, None]
        rate = column * order
        system = pitch_dynamic_stiffness(pitch, rate)
        flexibility = np.where(left_out, 0.0, 1.0 / np.where(left_out, 1.0, system.value))
        angle = column * column * per_square * flexibility
        error = slope = slope_error = curvature = EMPTY
        if slopes:
            turn = order * (1j * pitch.damping - 2.0 * pitch.inertia * rate)
            load_slope = 2.0 * column * per_square
            slope = flexibility * (load_slope - turn * angle)
            bent = 2.0 * per_square + 2.0 * pitch.inertia * order * order * angle
            curvature = flexibility * (bent - 2.0 * turn * slope)
        if errors:
            size, gain = np.abs(angle), np.abs(flexibility)
            load_error = column * column * couple.error
            error = gain * (size * system.error + load_error) + 16.0 * UNIT_ROUNDOFF * size
        if slopes and errors:
            doubt = np.abs(turn) * error + np.abs(slope) * system.error
            doubt = doubt + 2.0 * column * couple.error
            terms = np.abs(load_slope) + np.abs(turn) * size
            slope_error = gain * (doubt + (pitch.rounding + 16.0 * UNIT_ROUNDOFF) * terms)
        motion = Motion(angle, error, slope, slope_error, curvature)
        each = Motion(*(EMPTY if part is EMPTY else part[..., None] for part in motion))
        return read(readout, order, rate, each)

    return harmonics_at
