"""What the cylinders do to the stations of a shaft line, ready for any crank speed.

The gas part is linear in the cards, whose weights follow the speed; the inertia part goes with its
square. Both are summed over the cylinders of each station once, with their firing phases.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.excitation.cylinder_torque import (
    CrankGeometry,
    CylinderTorque,
    cylinder_torque,
    inertia_harmonics,
    phasor,
    weighted,
)
from vibecalc.excitation.gas_card import GasCard, card_weights, gas_card
from vibecalc.excitation.misfire import cylinder_gas, motored_card
from vibecalc.machine.crank_train import build_crank_train
from vibecalc.machine.engine import Firing, build_firing, crank_geometry, cycle_of, gas_cards
from vibecalc.machine.shaft_line import ShaftLine
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.pipeline.plan_torsion import asked_orders

if TYPE_CHECKING:
    from vibecalc.case.schema import Case, Machine


class Drive(NamedTuple):
    """Torques on k of the stations at m orders for c cards, referred, complex, 0-to-peak.

    `gas` (c, m, k) in N m and `inertia` (m, k) in N m per (rad/s)^2 with absolute errors, `mean`
    (c, k) of the gas in N m; `station` and `freedom` (k,) say where. `card_speed` (c,) in rad/s,
    empty for one card that holds at every speed. `cylinder` is a healthy one, `reciprocating_mass`
    in kg and `rod_inertia` in kg m^2 what moves in it.
    """

    order: FloatArray
    gas: ComplexArray
    gas_error: FloatArray
    inertia: ComplexArray
    inertia_error: FloatArray
    mean: FloatArray
    mean_error: FloatArray
    station: IntArray
    freedom: IntArray
    card_speed: FloatArray
    cards: tuple[GasCard, ...]
    geometry: CrankGeometry
    firing: Firing
    cylinder: CylinderTorque
    reciprocating_mass: float
    rod_inertia: float

    def weights(self, speed: FloatArray) -> FloatArray:
        """Of the cards at speeds (...), (..., c)."""
        return card_weights(self.card_speed if len(self.card_speed) else np.zeros(1), speed)

    def torque(self, speed: FloatArray) -> ComplexArray:
        """Torques (s, m, k) at speeds (s,) in rad/s."""
        share = self.weights(speed)
        gas = np.tensordot(share, self.gas, 1) if len(self.gas) > 1 else self.gas
        return np.asarray(gas + np.square(speed)[:, None, None] * self.inertia)

    def torque_error(self, speed: FloatArray) -> FloatArray:
        """Absolute error (s, m, k) of those."""
        square = np.square(speed)[:, None, None]
        known = self.gas_error + 4.0 * EPSILON * np.abs(self.gas)
        inertia = self.inertia_error + 4.0 * EPSILON * np.abs(self.inertia)
        return np.asarray(np.tensordot(np.abs(self.weights(speed)), known, 1) + square * inertia)

    def mean_torque(self, speed: FloatArray) -> FloatArray:
        """Mean torques (s, k) at speeds (s,)."""
        return np.asarray(self.weights(speed) @ self.mean)

    def mean_torque_error(self, speed: FloatArray) -> FloatArray:
        """Absolute error (s, k) of those."""
        known = self.mean_error + 4.0 * EPSILON * np.abs(self.mean)
        return np.asarray(np.abs(self.weights(speed)) @ known)

    def healthy(self, speed: float) -> CylinderTorque:
        """One cylinder at one speed: gas (m,), mean ()."""
        return weighted(self.cylinder, self.weights(np.asarray(speed)))


def build_drive(
    case: "Case",
    shaft: ShaftLine,
    *,
    all_fire: bool = False,
    orders: tuple[float, float] | None = None,
) -> Drive:
    """The drive of a validated engine at the orders that [response.torsion] asks for.

    `all_fire` leaves out that cylinders misfire; `orders` are others, the highest and the step.
    """
    machine = case.machine
    firing, geometry = build_firing(case), crank_geometry(machine)
    if all_fire:
        firing = replace(firing, fires=np.ones_like(firing.fires))
    card_speed, cards = gas_cards(machine)
    if not cards:
        ends = np.array([0.0, firing.cycle])
        cards = (gas_card(ends, np.zeros(2), cycle=firing.cycle),)
    highest, step = orders or asked_orders(case)
    base = 2.0 * np.pi / firing.cycle
    harmonics, every = round(highest / base), round(step / base)
    train, rod_inertia = build_crank_train(machine.crank_train), rod_difference(machine)
    masses = train.reciprocating_mass
    mass = float(masses.max())
    one = cylinder_torque(
        cards,
        geometry,
        reciprocating_mass=mass,
        rod_inertia_difference=rod_inertia,
        harmonics=harmonics,
    )
    healthy = _thinned(one, every)
    motored = None
    if _motored(case) and not all_fire:
        without = tuple(motored_cylinder(machine, card, geometry) for card in cards)
        found = cylinder_torque(without, geometry, reciprocating_mass=0.0, harmonics=harmonics)
        motored = _thinned(found, every)
    gas = cylinder_gas(
        healthy, firing.pressure_scale, misfiring=~firing.fires, motored=motored
    )  # (cards, cylinders, orders)
    ratio = shaft.station_ratio[shaft.cylinder_station]
    station, place = np.unique(shaft.cylinder_station, return_inverse=True)
    on = (place[:, None] == np.arange(len(station))) * ratio[:, None]
    size = np.abs(on)
    turned = phasor(healthy.order, firing.angle).T  # (cylinders, orders)
    moved = inertia_harmonics(geometry, 1.0, 0.0, healthy.order)
    rocked = inertia_harmonics(geometry, 0.0, rod_inertia, healthy.order)
    own = masses[:, None] * moved.value + rocked.value
    own_error = masses[:, None] * moved.error + rocked.error + 2.0 * EPSILON * np.abs(own)
    many = (6.0 + len(on)) * EPSILON
    return Drive(
        order=healthy.order,
        gas=np.swapaxes(gas.value * turned, -1, -2) @ on,
        gas_error=np.swapaxes(gas.error + many * np.abs(gas.value), -1, -2) @ size,
        inertia=(own * turned).T @ on,
        inertia_error=(own_error + many * np.abs(own)).T @ size,
        mean=gas.mean @ on,
        mean_error=(gas.mean_error + many * np.abs(gas.mean)) @ size,
        station=station,
        freedom=shaft.freedom[station],
        card_speed=card_speed,
        cards=tuple(cards),
        geometry=geometry,
        firing=firing,
        cylinder=healthy,
        reciprocating_mass=mass,
        rod_inertia=rod_inertia,
    )


def rod_difference(machine: "Machine") -> float:
    """Moment of the rod beyond its two point masses, kg m^2; 0 where the case gives none."""
    rod = machine.crank_train.rod
    if rod is None or rod.inertia is None:
        return 0.0
    from vibecalc.pipeline.stages.train_excitation import rod_difference as beyond

    return float(beyond(build_crank_train(machine.crank_train), rod).value)


def _motored(case: "Case") -> bool:
    torsion = None if case.response is None else case.response.torsion
    return torsion is not None and bool(torsion.misfire) and torsion.misfire_kind == "motored"


def motored_cylinder(machine: "Machine", card: GasCard, geometry: CrankGeometry) -> GasCard:
    """The card of a cylinder without fuel."""
    if machine.crank_train.gas_cycle is None:
        return motored_card(card, geometry)
    from vibecalc.excitation.gas_cycle import motored_cycle

    return motored_cycle(cycle_of(machine), geometry)


def _thinned(torque: CylinderTorque, every: int) -> CylinderTorque:
    """Every so many-th order of a cylinder."""
    keep = slice(every - 1, None, every)
    return torque._replace(
        order=torque.order[keep],
        gas=torque.gas[..., keep],
        gas_error=torque.gas_error[..., keep],
        inertia=torque.inertia[keep],
        inertia_error=torque.inertia_error[keep],
    )
