"""Speeds of a range at which an order meets a mode that nothing damps."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.critical import critical
from vibecalc.pipeline.stages.torsion.setup import Setup

#: part of a mode's largest twist below which a section counts as still
STILL = 1e-11


class Undamped(NamedTuple):
    """By rising speed (u,) in rad/s; `mode` from 1; `low` and `high` enclose what has no digits.

    `endless` (e,) is the lowest of the speeds at which a section twists without end, NaN for none.
    """

    speed: FloatArray
    low: FloatArray
    high: FloatArray
    mode: IntArray
    order: FloatArray
    error: FloatArray
    endless: FloatArray


def undamped_speeds(setup: Setup, first: float, last: float) -> Undamped:
    """Those from `first` to `last` whose order drives the mode, in rad/s."""
    modes, drive, line = setup.natural(), setup.drive, setup.model.line
    natural = np.where(modes.frequency > 0.0, modes.frequency, 1.0)
    # as near as this, and with as little damping, fewer than four digits are left
    exposed = (modes.frequency_error / natural + 4.0 * EPSILON) / SINGULAR
    free = (modes.frequency > 0.0) & (modes.damping_ratio < exposed)
    speed, doubt = critical(setup)
    inside = free[:, None] & (speed >= first) & (speed <= last)
    mode, place = np.nonzero(inside)
    at = speed[mode, place]
    row = np.arange(len(at))
    torque = drive.torque(at)[row, place]
    error = drive.torque_error(at)[row, place]
    shape = modes.shape[mode][:, drive.freedom]
    driven = np.abs(np.sum(shape * torque, axis=1))
    least = np.sum(np.abs(shape) * error, axis=1)
    least = least + (modes.shape_error[mode] + 16.0 * EPSILON) * np.abs(torque).sum(axis=1)
    keep = np.flatnonzero(driven > 2.0 * least)
    keep = keep[np.argsort(at[keep], kind="stable")]
    at, mode, place = at[keep], mode[keep], place[keep]
    width = exposed[mode] * at
    endless = np.full(len(line.first), np.nan)
    for one, which in zip(at[::-1].tolist(), mode[::-1].tolist(), strict=True):
        twist = np.abs(modes.shape[which, line.first] - modes.shape[which, line.second])
        endless[twist > STILL * twist.max(initial=0.0)] = one
    return Undamped(
        speed=at,
        low=at - width,
        high=at + width,
        mode=mode + 1,
        order=drive.order[place],
        error=doubt[mode, place] + 4.0 * EPSILON * at,
        endless=endless,
    )
