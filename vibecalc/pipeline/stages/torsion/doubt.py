"""Error of the curves of a shaft line against speed, taken where they are largest and between."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.curves import ROWS, solved, stiffness_of
from vibecalc.pipeline.stages.torsion.data_doubt import data_doubt
from vibecalc.pipeline.stages.torsion.gears import gear_doubts, gear_torques
from vibecalc.pipeline.stages.torsion.rounding import rounding_doubt
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.synthesis import synthesis

#: speeds at equal steps, beside those of the largest values
SAMPLES = 16


class CurveDoubt(NamedTuple):
    """Absolute errors, referred: twist (e,), torque (e,), angle (n,), torque of gears (g,)."""

    twist: FloatArray
    torque: FloatArray
    angle: FloatArray
    gear: FloatArray


class OwnDoubt(NamedTuple):
    """Absolute errors (r,), referred, of twist and torque, each of one section at one speed."""

    twist: FloatArray
    torque: FloatArray


def telling_speeds(speed: FloatArray, curve: FloatArray, undamped: FloatArray) -> FloatArray:
    """Speeds (r,), of those (s,) of a curve (s, e), at which its errors are largest.

    Those of the largest finite values, and of each of the speeds `undamped` (u,), at which the line
    has no bound, the nearest on both sides.
    """
    clear = np.all(np.isfinite(curve), axis=1)
    beside = speed[clear]
    if not len(beside):
        return beside
    parts = [beside[np.argmax(curve[clear], axis=0)]]
    if len(undamped):
        place = np.searchsorted(beside, undamped)[:, None] + np.array([-1, 0])
        parts.append(beside[np.clip(place, 0, len(beside) - 1)].ravel())
    return np.unique(np.concatenate(parts))


def curve_doubt(setup: Setup, speed: FloatArray, telling: FloatArray) -> CurveDoubt:
    """Largest errors of sums over orders at some of the speeds (s,) and at those that tell (r,)."""
    some = speed[np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)]
    found = _errors(setup, np.unique(np.concatenate([some, telling])))
    return CurveDoubt(*(np.max(part, axis=0, initial=0.0) for part in found))


def own_doubt(setup: Setup, speed: FloatArray, section: IntArray) -> OwnDoubt:
    """Errors of half ranges of sections (r,), each at its own speed (r,); 0 where unbounded."""
    at, place = np.unique(speed, return_inverse=True)
    parts = [_errors(setup, at[k : k + ROWS])[:2] for k in range(0, len(at), ROWS)]
    if not parts:
        return OwnDoubt(np.zeros(0), np.zeros(0))
    return OwnDoubt(*(np.concatenate(part)[place, section] for part in zip(*parts, strict=True)))


def twist_doubt(setup: Setup, at: FloatArray) -> FloatArray:
    """Errors (s, m, e) of the twists of each order at speeds (s,)."""
    found = solved(setup.model, setup.drive, at, estimate=True)
    return data_doubt(setup, at)[1] + rounding_doubt(setup, at, found)[1]


def _errors(setup: Setup, at: FloatArray) -> CurveDoubt:
    """Errors of sums over orders at speeds (s,), each with s in front; 0 where unbounded."""
    found = solved(setup.model, setup.drive, at, estimate=True)
    angle, twist = data_doubt(setup, at)
    own_angle, own_twist = rounding_doubt(setup, at, found)
    angle = angle + own_angle
    twist = twist + own_twist
    line = setup.model.at(at[:, None])
    torque = np.abs(stiffness_of(line, found.frequency)) * twist
    torque = torque + 4.0 * EPSILON * np.abs(found.torque)
    sums = [(twist, found.twist), (torque, found.torque), (angle, found.angle)]
    if len(line.first) == len(setup.shaft.section_names):  # else the line without dampers
        known = setup.drive.torque_error(at)
        of_line = (setup.shaft, setup.drive, setup.model, found.frequency)
        gear = gear_torques(*of_line, found.angle, found.torque, found.load)
        sums.append((gear_doubts(*of_line, angle, torque, known), gear))
    else:
        sums.append((torque[..., :0], found.torque[..., :0]))
    clear = ~np.any(found.masked, axis=1)[:, None]
    return CurveDoubt(*(np.where(clear, _summed(*one), 0.0) for one in sums))


def _summed(error: FloatArray, value: np.ndarray) -> FloatArray:
    """Over the orders (s, m, ...), without a common sign, with the rounding of that sum."""
    whole = np.sqrt(np.sum(np.square(error), axis=1))
    return np.asarray(whole + 8.0 * EPSILON * np.abs(value).sum(axis=1))


def shifted_twist(setup: Setup, speed: FloatArray, error: FloatArray) -> FloatArray:
    """What errors (e,) of the speeds of each section (e,) move the half ranges of its twist by.

    The torque of a section is flat where it is largest; its twist need not be.
    """
    section = np.arange(len(speed))
    half = []
    for at in (speed, speed + error):
        own = [solved(setup.model, setup.drive, at[k : k + ROWS]) for k in section[::ROWS]]
        twist = np.concatenate([one.twist for one in own])[section, :, section]
        clear = ~np.concatenate([np.any(one.masked, axis=1) for one in own])
        half.append(np.where(clear, synthesis(setup.drive.order, twist).half_range, 0.0))
    return np.asarray(np.abs(half[1] - half[0]))
