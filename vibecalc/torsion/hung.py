"""A line on one freedom of which rings hang: its response from that of the line without them."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, complex_stiffness

# ----------------------------------------------------------------------------
# A change of rank one: rings on springs and dashpots at one freedom of a line.
#
# With the angle a of the freedom under all torques, and h under a torque of one there, both without
# the rings, rings of the dynamic stiffness D leave it the angle x = a / (1 + D h). They pull at the
# line with D x, so that any torque T in it becomes T - D x H, H being that of a torque of one. What
# the line has without the rings is solved once for any rings.
# ----------------------------------------------------------------------------

#: roundings of the quotient and the products
ROUNDINGS = 16.0


class BareLine(NamedTuple):
    """A line without its rings at frequencies (s, m), under its own torques and under one.

    `torque` and `unit_torque` (e, s, m) of its elements, `angle` and `unit_angle` (s, m) of the
    freedom that the rings hang on, complex; `error` and `unit_error` (s, m) bound all angles,
    `reach` (s, m) is the largest angle under the torque of one. `masked` (s, m): there is none.
    """

    torque: ComplexArray
    unit_torque: ComplexArray
    angle: ComplexArray
    unit_angle: ComplexArray
    error: FloatArray
    unit_error: FloatArray
    reach: FloatArray
    masked: BoolArray

    def cut(self, part: slice) -> "BareLine":
        """Some of the speeds."""
        by_element = {name: getattr(self, name)[:, part] for name in ("torque", "unit_torque")}
        others = {name: getattr(self, name)[part] for name in self._fields[2:]}
        return BareLine(**by_element, **others)


class Hung(NamedTuple):
    """What the rings pull the line with, and the angle of their freedom, (..., s, m) each.

    `error` (..., s, m) bounds all angles.
    """

    pull: ComplexArray
    angle: ComplexArray
    error: FloatArray


def bare_line(
    line: Line, frequency: FloatArray, load: ComplexArray, stations: IntArray, freedom: int
) -> BareLine:
    """Of torques (s, m, k) on some stations of a line without its rings; w (s, m) in rad/s."""
    own = forced_masked(line, frequency, load, stations=stations.tolist())
    one = forced_masked(line, frequency, np.ones((1, 1, 1), complex), stations=[freedom])
    stiffness = np.moveaxis(complex_stiffness(line, frequency), -1, 0)

    def torque(angle: ComplexArray) -> ComplexArray:
        twist = np.moveaxis(angle[..., line.first] - angle[..., line.second], -1, 0)
        return np.ascontiguousarray(stiffness * twist)

    masked = own.masked | one.masked
    return BareLine(
        torque(own.angle),
        torque(one.angle),
        np.ascontiguousarray(own.angle[..., freedom]),
        np.ascontiguousarray(one.angle[..., freedom]),
        np.where(masked, 0.0, own.error),
        np.where(masked, 0.0, one.error),
        np.max(np.abs(one.angle), axis=-1),
        masked,
    )


def ring_stiffness(
    line: Line, element: int, frequency: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Of the ring behind an element at (..., s, m): its dynamic stiffness, and twist per angle."""
    square = -np.square(frequency) * line.inertia[..., line.second[element]]
    stiffness = line.stiffness[..., element]
    lossy = frequency * line.damping[..., element] + stiffness * line.loss_factor[..., element]
    shape = np.broadcast_shapes(square.shape, np.shape(stiffness), lossy.shape)
    spring: ComplexArray = np.empty(shape, dtype=complex)
    spring.real, spring.imag = stiffness, lossy
    twist = square / (spring + square)
    return spring * twist, twist


def hung(bare: BareLine, stiffness: ComplexArray) -> Hung:
    """With rings of a dynamic stiffness (..., s, m) on the freedom, many machines in front.

    Errors are infinite where masked.
    """
    whole = 1.0 / (1.0 + stiffness * bare.unit_angle)
    angle = bare.angle * whole
    pull = stiffness * angle
    # what is wrong in both angles without rings moves the pull, and that all of the line
    size = np.abs(pull)
    wrong = bare.error + size * bare.unit_error
    wrong *= 1.0 + np.abs(stiffness * whole) * bare.reach
    wrong += ROUNDINGS * EPSILON * (np.abs(bare.angle) + size * bare.reach)
    wrong[..., bare.masked] = np.inf
    return Hung(pull, angle, wrong)


def torque_under(bare: BareLine, pull: ComplexArray, out: ComplexArray) -> None:
    """Torques (e, ..., s, m) of the bare line's elements under a pull (..., s, m), into `out`."""
    between = tuple(range(1, pull.ndim - 1))
    np.multiply(np.expand_dims(bare.unit_torque, between), pull, out=out)
    np.subtract(np.expand_dims(bare.torque, between), out, out=out)
