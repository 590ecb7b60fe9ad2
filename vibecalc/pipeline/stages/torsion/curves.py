"""Half ranges of a shaft line against speed, block by block: memory does not grow with speeds.

What is not damped between its ends has a torque that is its stiffness times its twist at every
order, so that one sum over the orders serves both.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.machine.shaft_line import ShaftLine
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.drive import Drive
from vibecalc.pipeline.stages.torsion.gears import gear_torques
from vibecalc.pipeline.stages.torsion.setup import Model
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.synthesis import synthesis

#: speeds of one block
ROWS = 128


class Curves(NamedTuple):
    """Referred values against speed: half ranges, extremes of the torque, heat; (s, ...).

    `twist`, its largest magnitude `travel`, `torque`, `highest`, `lowest` (s, e), `angle` (s, n),
    `gear` with its extremes (s, g), `heat` (s, e) in W without that of absolute damping. `masked`
    (s,): some order is where nothing damps a mode; the values are infinite there.
    """

    twist: FloatArray
    travel: FloatArray
    torque: FloatArray
    highest: FloatArray
    lowest: FloatArray
    angle: FloatArray
    gear: FloatArray
    gear_highest: FloatArray
    gear_lowest: FloatArray
    heat: FloatArray
    masked: BoolArray


class Solved(NamedTuple):
    """All orders (s, m, ...) at some speeds, referred: angles, twists, torques of sections."""

    frequency: FloatArray
    angle: ComplexArray
    twist: ComplexArray
    torque: ComplexArray
    load: ComplexArray
    error: FloatArray
    masked: BoolArray


def solved(model: Model, drive: Drive, speed: FloatArray, estimate: bool = False) -> Solved:
    """Angles and torques at speeds (s,) in rad/s; `error` (s, m) of the angles, if asked for."""
    load = drive.torque(speed)
    found = model.solve(speed, drive.order, load, drive.freedom, estimate)
    line = model.at(speed[:, None])
    w = speed[:, None] * drive.order
    twist = found.angle[..., line.first] - found.angle[..., line.second]
    torque = stiffness_of(line, w) * twist
    return Solved(w, found.angle, twist, torque, load, found.error, found.masked)


def stiffness_of(line: Line, frequency: FloatArray) -> ComplexArray:
    """Complex stiffness (..., e) of the elements at frequencies (...)."""
    lossy = lossy_of(line, frequency)
    value: ComplexArray = np.empty(np.broadcast_shapes(lossy.shape, line.stiffness.shape), complex)
    value.real, value.imag = line.stiffness, lossy
    return value


def lossy_of(line: Line, frequency: FloatArray) -> FloatArray:
    """Imaginary part of `stiffness_of`."""
    loss = line.stiffness * line.loss_factor
    return np.asarray(loss + frequency[..., None] * line.damping)


def is_damped(line: Line) -> IntArray:
    """Elements whose torque is not in phase with their twist at every order."""
    return np.flatnonzero((line.damping != 0.0) | (line.loss_factor != 0.0))


def sweep(
    model: Model, drive: Drive, speed: FloatArray, shaft: ShaftLine | None, angles: bool = True
) -> Curves:
    """The curves at speeds (s,); gears are those of `shaft`, none without it."""
    parts = []
    for start in range(0, len(speed), ROWS):
        parts.append(_block(model, drive, speed[start : start + ROWS], shaft, angles))
    return Curves(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _block(
    model: Model, drive: Drive, speed: FloatArray, shaft: ShaftLine | None, angles: bool
) -> Curves:
    found = solved(model, drive, speed)
    damped = is_damped(model.line)
    signals = [found.twist, found.torque[..., damped]]
    if angles:
        signals.append(found.angle)
    if shaft is not None and shaft.gears:
        signals.append(
            gear_torques(
                shaft, drive, model, found.frequency, found.angle, found.torque, found.load
            )
        )
    ends = np.cumsum([one.shape[-1] for one in signals])[:-1]
    # signals in front and orders last, as they lie in memory
    stacked = np.concatenate([np.moveaxis(one, -1, 0) for one in signals])
    total = synthesis(drive.order, stacked)
    kept = (total.half_range.T, total.highest.T, total.lowest.T)
    # by kind of signal, then half range, highest and lowest
    twist, apart, *others = zip(*(np.split(one, ends, axis=1) for one in kept), strict=True)
    stiffness = np.broadcast_to(model.at(speed).stiffness, twist[0].shape)
    half, highest, lowest = (stiffness * one for one in twist)
    for each, own in zip((half, highest, lowest), apart, strict=True):
        each[:, damped] = own
    none = np.zeros((len(speed), 0))
    gears = others[-1] if len(others) > angles else (none, none, none)
    masked = np.any(found.masked, axis=-1)
    line = model.at(speed[:, None])
    heat = np.zeros((len(speed), len(line.first)))
    if len(damped):
        twisted = found.twist[..., damped]
        factor = found.frequency[..., None] * lossy_of(line, found.frequency)[..., damped]
        square = np.square(twisted.real) + np.square(twisted.imag)
        heat[:, damped] = 0.5 * np.sum(factor * square, axis=1)
    curves = (
        twist[0], np.maximum(np.abs(twist[1]), np.abs(twist[2])), half, highest, lowest,
        others[0][0] if angles else none,
        *gears,
        heat,
    )  # fmt: skip
    blank = [np.where(masked[:, None], np.inf, one) for one in curves]
    return Curves._make([*blank, masked])
