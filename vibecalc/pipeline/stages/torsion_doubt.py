"""Error of the curves of a shaft line against speed, taken where they are largest and between."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.stages.torsion_curves import solved, stiffness_of
from vibecalc.pipeline.stages.torsion_gears import gear_doubts, gear_torques
from vibecalc.pipeline.stages.torsion_maxima import Maxima
from vibecalc.pipeline.stages.torsion_needles import Dense
from vibecalc.pipeline.stages.torsion_setup import Setup
from vibecalc.pipeline.stages.torsion_steady import data_doubt

#: speeds at equal steps, beside those of the largest values
SAMPLES = 16


class CurveDoubt(NamedTuple):
    """Absolute errors, referred: twist (e,), torque (e,), angle (n,), torque of gears (g,)."""

    twist: FloatArray
    torque: FloatArray
    angle: FloatArray
    gear: FloatArray


def telling_speeds(dense: Dense, top: Maxima, undamped: FloatArray) -> FloatArray:
    """Speeds (r,) at which the errors of curves are largest: their maxima, and about no end.

    Of a section without end that is where what is finite is largest, and of each of the speeds
    `undamped` (u,) the nearest on both sides.
    """
    finite = np.isfinite(top.value)
    speed, curve = dense
    known = np.where(np.isfinite(curve), curve, -1.0)[:, ~finite]
    known = known[:, np.any(known > 0.0, axis=0)]
    clear = np.all(np.isfinite(curve), axis=1)
    parts = [top.speed[finite], speed[np.argmax(known, axis=0)]]
    beside = speed[clear]
    if len(undamped) and len(beside):
        place = np.searchsorted(beside, undamped)[:, None] + np.array([-1, 0])
        parts.append(beside[np.clip(place, 0, len(beside) - 1)].ravel())
    return np.unique(np.concatenate(parts))


def curve_doubt(setup: Setup, speed: FloatArray, largest: FloatArray) -> CurveDoubt:
    """Largest errors of sums over orders at some of the speeds (s,) and at those of maxima (r,)."""
    some = speed[np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)]
    at = np.unique(np.concatenate([some, largest]))
    found = solved(setup.model, setup.drive, at, estimate=True)
    angle, twist = data_doubt(setup, at)
    error = np.where(found.masked, 0.0, found.error)[..., None]
    line = setup.model.at(at[:, None])
    twist = twist + 2.0 * error + 4.0 * EPSILON * np.abs(found.twist)
    torque = np.abs(stiffness_of(line, found.frequency)) * twist
    torque = torque + 4.0 * EPSILON * np.abs(found.torque)
    angle = angle + error
    sums = [(twist, found.twist), (torque, found.torque), (angle, found.angle)]
    if len(line.first) == len(setup.shaft.section_names):  # else the line without dampers
        known = setup.drive.torque_error(at)
        of_line = (setup.shaft, setup.drive, found.frequency)
        gear = gear_torques(*of_line, found.angle, found.torque, found.load)
        sums.append((gear_doubts(*of_line, angle, torque, known), gear))
    else:
        sums.append((torque[..., :0], found.torque[..., :0]))
    clear = ~np.any(found.masked, axis=1)
    return CurveDoubt(*(_worst(part[clear], value[clear]) for part, value in sums))


def _worst(error: FloatArray, value: np.ndarray) -> FloatArray:
    """Of each column: sum over orders, with the rounding of that sum, at the worst speed."""
    total = error.sum(axis=1) + 8.0 * EPSILON * np.abs(value).sum(axis=1)
    return np.asarray(np.max(total, axis=0, initial=0.0))
