"""Which order and mode make a maximum of a shaft line's curve: the one that resonates there."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.critical import critical
from vibecalc.pipeline.stages.torsion.curves import ROWS, solved
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.synthesis import synthesis

#: relative distances at which a maximum is looked at from both sides
SCALES = np.array([0.0025, 0.005, 0.01, 0.02, 0.04])
#: relative distance up to which a maximum belongs to a critical of a mode, without its damping,
#: and what each unit of damping ratio adds
NEAR, WIDER = 0.03, 2.0


class Meeting(NamedTuple):
    """At each maximum (r,): half range of the referred twist, order and mode (from 1); 0: none."""

    twist: FloatArray
    order: FloatArray
    mode: IntArray


def meeting(setup: Setup, speed: FloatArray, section: IntArray, end: BoolArray) -> Meeting:
    """What resonates in sections (r,) at the speeds (r,) of their maxima; nothing at an `end` (r,).

    The curve itself says how wide a maximum is: the least distance at which half of what it stands
    out at any is there. The order is the one whose own amplitude stands out most at this distance;
    the largest of all may be on a flank. The mode is the one of most torque among those that the
    order meets near by.
    """
    if not len(speed):
        return Meeting(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int64))
    order = setup.drive.order
    sides = np.concatenate([[1.0], 1.0 - SCALES, 1.0 + SCALES])
    unique, place = np.unique(speed, return_inverse=True)
    size, half, twist, masked = _looked_at(setup, unique[:, None] * sides, place, section)
    low, high = slice(1, 1 + len(SCALES)), slice(1 + len(SCALES), None)
    out = half[:, :1] - 0.5 * (half[:, low] + half[:, high])
    wide = np.argmax(out >= 0.5 * out.max(axis=1, keepdims=True), axis=1)
    own = np.arange(len(speed))
    gain = size[:, 0] - 0.5 * (size[:, low] + size[:, high])[own, wide]
    gain = np.where(masked, np.inf, np.where(end[:, None], 0.0, gain))
    best = np.argmax(gain, axis=1)
    mode = _modes(setup, speed, section, best)
    found = (gain[own, best] > 0.0) & (mode > 0)
    return Meeting(twist, np.where(found, order[best], 0.0), np.where(found, mode, 0))


def _looked_at(
    setup: Setup, speeds: FloatArray, place: IntArray, section: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Amplitudes (r, k, m) and half ranges (r, k) of torques, of twists (r,), masked (r, m).

    Speeds (u, k), those of maximum r in row place[r]; the first of a row is its middle.
    """
    model, drive = setup.model, setup.drive
    rows, each = speeds.shape
    torque = np.empty((len(place), each, len(drive.order)), dtype=np.complex128)
    twist = np.empty((len(place), len(drive.order)), dtype=np.complex128)
    masked = np.empty((len(place), len(drive.order)), dtype=bool)
    step = max(1, ROWS // each)
    for start in range(0, rows, step):
        at = solved(model, drive, speeds[start : start + step].ravel())
        shape = (-1, each, *at.torque.shape[1:])
        held = np.flatnonzero((place >= start) & (place < start + step))
        row, of = place[held] - start, section[held]
        # an order without bound beside a maximum stands out from nothing
        clear = np.where(at.masked[..., None], 0.0, at.torque).reshape(shape)
        torque[held] = clear[row[:, None], np.arange(each), :, of[:, None]]
        twist[held] = at.twist.reshape(shape)[row, 0, :, of]
        masked[held] = at.masked.reshape(shape[:3])[row, 0]
    half = synthesis(drive.order, torque).half_range
    return np.abs(torque), half, synthesis(drive.order, twist).half_range, masked


def _modes(setup: Setup, speed: FloatArray, section: IntArray, order: IntArray) -> IntArray:
    """Number (r,), from 1, of the mode that an order (place) drives most there; 0: none is near."""
    modes, drive, line = setup.natural(), setup.drive, setup.model.line
    met = critical(setup)[0][:, order]
    ratio = np.abs(modes.damping_ratio)[:, None]
    finite = np.isfinite(met) & (met > 0.0)
    share = np.where(finite, met, 1.0) / speed
    near = finite & (np.abs(share - 1.0) <= NEAR + WIDER * ratio)
    own = np.arange(len(speed))
    torque = drive.torque(speed)[own, order]
    drives = np.abs(modes.shape[:, drive.freedom] @ torque.T)
    twist = np.abs(modes.shape[:, line.first[section]] - modes.shape[:, line.second[section]])
    away = np.hypot(share**2 - 1.0, 2.0 * ratio * share) + 1e-12
    inertia = np.where(modes.inertia > 0.0, modes.inertia, np.inf)[:, None]
    height = np.where(near, drives * twist / (inertia * away), -1.0)
    best = np.argmax(height, axis=0)
    return np.where(height[best, own] >= 0.0, best + 1, 0)
