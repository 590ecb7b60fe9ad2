"""Kernel: forces on crank pins, wrist pins, cylinder walls and main bearings at crank angles."""

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import GasCard, card_weights, pressure_at
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# Newton and Euler for piston and rod of a crank that turns steadily.
#
# In the plane of a cylinder, e outwards along its axis and q a quarter of a turn ahead of it in the
# sense of rotation, forces are complex numbers e + i q. The crank stands at the angle t from e; the
# wrist pin at s(t) e + o q, o the offset. The rod is a mass at each of its ends and what its moment
# of inertia has beyond theirs, dJ. With G the gas force towards the crank and m all the mass that
# goes with the piston,
#
#     piston and rod along e:         F   = -G - m s'' w^2
#     moments on the rod about
#     the crank pin:                  W_q = ((o - R sin t) F + dJ w^2 theta'') / p
#
# with p the rod's projection on e, and theta its angle, tan theta = (o - R sin t) / p. F + i W_q is
# what the rod hands on to the crank pin, besides the centrifugal force of its big end; the piston
# presses on the wall with -W_q, and on the wrist pin with W = F + m_rod s'' w^2 + i W_q, m_rod the
# rod's share of m. (Own derivation; cf. Biezeno and Grammel, Technische Dynamik, ch. XI.)
# ----------------------------------------------------------------------------


class Gas(NamedTuple):
    """Gas in c cylinders: cards of groups that share them, with what a group takes of its cards.

    A group has a card for each of the `speeds` (k,) in rad/s, ascending, or one for all, and the
    force (c,) in N at 1 Pa, zero of cylinders that are not in it. `start` (c,) in rad is the crank
    angle at which the cards begin.
    """

    start: FloatArray
    speeds: FloatArray
    groups: tuple[tuple[tuple[GasCard, ...], FloatArray], ...]

    def at(self, angle: FloatArray, speed: FloatArray) -> FloatArray:
        """Force (..., c) in N towards the crank, at crank angles (...) and speeds (...)."""
        shape = np.broadcast_shapes(np.shape(angle), np.shape(speed))
        own, force = angle[..., None] - self.start, np.zeros((*shape, len(self.start)))
        weight = card_weights(self.speeds, speed)
        for cards, share in self.groups:
            filled = np.flatnonzero(share)
            for k, card in enumerate(cards):
                pressure = pressure_at(card, own[..., filled])
                force[..., filled] += weight[..., k, None] * pressure * share[filled]
        return force

    @property
    def kinks(self) -> FloatArray:
        """Crank angles (k,) at which the force has kinks."""
        cards = [
            one for cards, share in self.groups for one in product(cards, self.start[share > 0])
        ]
        return np.concatenate([np.zeros(0), *(card.node + start for card, start in cards)])


class Shaft(NamedTuple):
    """A crankshaft on b bearings: what each takes of the forces of c rods and of m weights.

    `rod_share` (b, c) and `weight_share` (b, m) are without unit; `unbalance` (m,) in kg m turns
    with the crank, `weight_angle` (m,) its angle at crank angle zero; `at_rest` (b,) in N is what
    each bearing bears of constant loads, complex: along the stroke + i ahead of it.
    """

    names: tuple[str, ...]
    rod_share: FloatArray
    unbalance: FloatArray
    weight_angle: FloatArray
    weight_share: FloatArray
    at_rest: ComplexArray


class Loads(NamedTuple):
    """What loads the bearings of one machine: forces at crank angles (...) and speeds (...).

    Angles are in rad, speeds in rad/s, forces in N, complex, along the stroke + i ahead of it; they
    repeat after a `cycle`. Of c cylinders `bank` (c,) is the angle of each from there, `angle` (c,)
    that of its throw from the cylinder at crank angle zero. `reciprocating_mass` (c,) in kg is all
    that goes with a piston, `small_end` (c,) the rod's share of it, `big_end` (c,) the mass of the
    rod at the crank pin; `rod_difference` (c,) in kg m^2 is the rod's moment of inertia less that
    of these two.
    """

    cycle: float
    geometry: CrankGeometry
    bank: FloatArray
    angle: FloatArray
    reciprocating_mass: FloatArray
    small_end: FloatArray
    big_end: FloatArray
    rod_difference: FloatArray
    gas: Gas
    shaft: Shaft

    def rods(self, angle: FloatArray, speed: FloatArray) -> tuple[ComplexArray, ...]:
        """Forces (..., c) along e + i q of each cylinder: of the rod on the crank pin, without and
        with the centrifugal force of its big end, and of the piston on the rod.
        """
        square = np.square(speed)[..., None]
        radius, length, _, offset = self.geometry
        local = angle[..., None] + self.angle
        path = piston_path(local, radius, length, offset)
        aside = offset - radius * np.sin(local)
        turning = -radius * np.cos(local) / path.rod
        bending = (radius * np.sin(local) + aside * turning**2) / path.rod
        inertia = path.acceleration * square
        along = -self.gas.at(angle, speed) - self.reciprocating_mass * inertia
        across = (aside * along + self.rod_difference * bending * square) / path.rod
        on_pin = along + 1j * across
        big_end = self.big_end * radius * square * np.exp(1j * local)
        return on_pin, on_pin + big_end, on_pin + self.small_end * inertia

    def crank_pin(self, angle: FloatArray, speed: FloatArray) -> ComplexArray:
        """Of the rods on the crank pins (..., c), with their big ends."""
        return np.asarray(self.rods(angle, speed)[1] * np.exp(1j * self.bank))

    def crank_pin_of_throw(self, angle: FloatArray, speed: FloatArray) -> ComplexArray:
        """The same outwards along each throw + i ahead of it."""
        turned = np.exp(-1j * (angle[..., None] + self.angle))
        return np.asarray(self.rods(angle, speed)[1] * turned)

    def wrist_pin(self, angle: FloatArray, speed: FloatArray) -> ComplexArray:
        """Of the pistons on the rods (..., c)."""
        return np.asarray(self.rods(angle, speed)[2] * np.exp(1j * self.bank))

    def wall(self, angle: FloatArray, speed: FloatArray) -> ComplexArray:
        """Side thrust (..., c) of the pistons, real, positive ahead."""
        return -self.rods(angle, speed)[0].imag.astype(complex)

    def main(self, angle: FloatArray, speed: FloatArray) -> ComplexArray:
        """Of the shaft on the main bearings (..., b)."""
        shaft, of_rods = self.shaft, self.rods(angle, speed)[0] * np.exp(1j * self.bank)
        turned = angle[..., None] + shaft.weight_angle
        weights = shaft.unbalance * np.square(speed)[..., None] * np.exp(1j * turned)
        return np.asarray(
            of_rods @ shaft.rod_share.T + weights @ shaft.weight_share.T + shaft.at_rest
        )


#: one kind of bearing, as `Loads.main`: forces (..., rows)
Kind = Callable[[Loads, FloatArray, FloatArray], ComplexArray]


def force_with_error(kind: Kind, loads: Loads, angle: Any, speed: FloatArray) -> Bounded:
    """Forces with the errors that the last bits of all data make, and what is uncertain of gas.

    `angle` may be a `Bounded` itself.
    """
    groups = tuple((tuple(map(_uncertain, cards)), share) for cards, share in loads.gas.groups)
    known = loads._replace(gas=loads.gas._replace(groups=groups))
    found: Bounded = with_errors(kind, known, angle, np.asarray(speed, dtype=float))
    return found


def _uncertain(card: GasCard) -> GasCard:
    """A card whose coefficients are as far off as it says of each piece."""
    error = 2.0 * EPSILON * np.abs(card.coefficient)
    error[:, 0] += card.error
    coefficient: Any = Bounded(card.coefficient, error)
    return card._replace(coefficient=coefficient)
