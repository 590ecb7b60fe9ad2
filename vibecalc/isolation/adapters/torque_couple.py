"""Torque of all cylinders of an engine at its speed, and the couple that it is for the body."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_moments, share_of_rotor
from vibecalc.excitation.cylinder_torque import (
    cylinder_gas,
    cylinder_torque,
    inertia_harmonics,
    phasor,
)
from vibecalc.excitation.gas_tables import card_of_force, card_weights
from vibecalc.excitation.model import (
    build_firing,
    firing_angle,
    force_curves,
    gas_cards,
    has_cards,
    misfire_cards,
)
from vibecalc.excitation.stage import USUAL_ORDERS
from vibecalc.isolation.torque_reaction import couple_on_body, line_transfer
from vibecalc.numerics.bounded import Bounded, rounded, stack
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.parts.firing import TURN, cycle_angle, is_separate, shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.schema import Machine

#: orders (m,) and crank speeds (...) to the couple on the body (..., m, c) for a unit torque
Passing = Callable[[np.ndarray, np.ndarray | float], Bounded]


class Couples(NamedTuple):
    """Couples (m,) on the body about the crankshaft at the orders (m,), twice as many as
    `retained`.

    `total` is of gas and inertia; `added` is what the shaking of the crank train lacks of it;
    `mean` a number.
    """

    order: np.ndarray
    retained: int
    total: Bounded
    added: Bounded
    mean: Bounded


class TorqueLaw(NamedTuple):
    """Torque of the cylinders on the crankshaft against its speed, at the orders (m,).

    `gas` (k, c, m) and `mean` (k,) at the `speeds` (k,) of the gas cards, linear between them; one
    for all speeds has none. `inertia` (c, m) per speed squared. `share` of the torque turns what is
    fixed to the crank and, the other way round, the body.
    """

    order: np.ndarray
    retained: int
    speeds: np.ndarray
    gas: Bounded
    mean: Bounded
    inertia: Bounded
    share: float

    def gas_at(self, speed: np.ndarray | float) -> Bounded:
        """Gas torque (..., c, m) at speeds (...)."""
        return _mixed(self.gas, self._weights(speed))

    def mean_at(self, speed: float) -> Bounded:
        """Mean torque of all cylinders."""
        return _mixed(self.mean, self._weights(speed))

    def _weights(self, speed: np.ndarray | float) -> np.ndarray:
        return card_weights(self.speeds if len(self.speeds) else [0.0], speed)


def couples_of(scene: Scene, shaking_orders: int) -> Couples:
    """Couples with all orders up to `shaking_orders`, or more, in steps of the engine's cycle."""
    law, speed = torque_law(scene, shaking_orders), scene.case.machine.speed
    gas, torque = law.gas_at(speed), total_torque(law, speed)
    mean = mean_couple(scene, law, speed)
    if not shakes_with_torque(scene.case):
        transfer = line_passing(scene)(law.order, speed)
        total = couple_on_body(torque, transfer)
        return Couples(law.order, law.retained, total, total, mean)
    total = couple_on_body(torque, share=law.share)
    added = couple_on_body(gas, share=law.share)
    return Couples(law.order, law.retained, total, added, mean)


def mean_couple(scene: Scene, law: "TorqueLaw", speed: float) -> Bounded:
    """What is constant of the couple: minus the mean torque, if that leaves the body."""
    if not is_separate(scene.case):
        return Bounded(np.zeros(()), np.zeros(()))
    return -law.mean_at(speed)


def torque_law(scene: Scene, shaking_orders: int) -> TorqueLaw:
    """The torque of the cylinders at any speed, with twice the orders that are kept.

    Evenly spaced cylinders leave every c-th order only, of which at least two are beyond.
    """
    case = scene.case
    step = TURN / cycle_angle(case.machine)
    used = int(np.ceil(_highest(scene, shaking_orders) / step))
    beyond = max(used, 2 * len(scene.parts.crank_train.names))
    order = step * np.arange(1, used + beyond + 1)
    rotor, share = case.machine.rotor, 1.0
    if rotor is not None:
        rod, train = case.machine.crank_train.rod, scene.parts.crank_train
        moments, motion = rod_moments(train, rod), scene.handed_on["motion"]
        share = float(share_of_rotor(train, motion, rotor.inertia, moments))
    return TorqueLaw(order, used, *_torques(scene, order), share)


def total_torque(law: TorqueLaw, speed: np.ndarray | float) -> Bounded:
    """Torque (..., c, m) of gas and inertia at speeds (...)."""
    return law.gas_at(speed) + law.inertia * np.square(speed)[..., None, None]


def _mixed(cards: Bounded, weights: np.ndarray) -> Bounded:
    """Values (k, ...) of cards in the shares `weights` (..., k)."""
    value = np.tensordot(weights, cards.value, axes=(-1, 0))
    size = cards.error + 2.0 * EPSILON * np.abs(cards.value)
    return Bounded(value, np.tensordot(weights, size, axes=(-1, 0)))


def _highest(scene: Scene, shaking_orders: int) -> float:
    case = scene.case
    torsion = None if case.response is None else case.response.torsion
    orders = None if torsion is None else torsion.orders
    said = 0.0
    if orders is not None:
        step = orders.step or TURN / cycle_angle(case.machine)
        said = orders.highest or (orders.count or 0) * step
    given_orders = None if case.excitation is None else case.excitation.orders
    return max(said, shaking_orders, USUAL_ORDERS if given_orders is None and not said else 0)


def _torques(scene: Scene, order: np.ndarray) -> tuple[np.ndarray, Bounded, Bounded, Bounded]:
    """Speeds of the cards, gas torque and its mean at each, inertia torque, as in `TorqueLaw`."""
    case, train = scene.case, scene.parts.crank_train
    firing = build_firing(case)
    options = case.excitation
    working = None if options is None else options.working
    runs = np.array([working is None or name in working for name in firing.names])
    geometry = crank_geometry(case.machine.crank_train)
    scale = runs * firing.pressure_scale
    speeds, gas, mean = _gas(scene, len(order), scale, ~firing.fires)
    # the shaking of the masses counts from crank phase zero
    turned = rounded(phasor(order, firing_angle(case.machine)).T, 12)
    moments = rod_moments(train, case.machine.crank_train.rod)
    inertia = train.reciprocating_mass[:, None] * inertia_harmonics(geometry, 1.0, 0.0, order)
    if moments is not None:
        inertia = inertia + moments[:, None] * inertia_harmonics(geometry, 0.0, 1.0, order)
    return speeds, gas * turned, mean.sum(), inertia * turned


def _gas(
    scene: Scene, count: int, scale: np.ndarray, misfiring: np.ndarray
) -> tuple[np.ndarray, Bounded, Bounded]:
    """Gas torque of every cylinder and its mean at the speeds of the cards.

    One that misfires has none, or that of a motored one.
    """
    case = scene.case
    if not has_cards(case.machine):
        return np.empty(0), *_gas_of_forces(case.machine, count, scale)
    speeds, cards = gas_cards(case.machine)
    motored, geometry = None, crank_geometry(case.machine.crank_train)
    dead = misfire_cards(case, cards)
    if dead:
        motored = cylinder_torque(dead, geometry, reciprocating_mass=0.0, harmonics=count)
    healthy = cylinder_torque(cards, geometry, reciprocating_mass=0.0, harmonics=count)
    return speeds, *cylinder_gas(healthy, scale, misfiring=misfiring, motored=motored)


def _gas_of_forces(machine: "Machine", count: int, scale: np.ndarray) -> tuple[Bounded, Bounded]:
    """The same of cylinders that have curves of their own over a turn, one set for all speeds."""
    geometry = crank_geometry(machine.crank_train)._replace(bore=2.0 / np.sqrt(np.pi))  # of 1 m^2
    none = rounded(np.zeros((1, count), dtype=complex), 0), rounded(np.zeros(1), 0)
    rows = []
    for row, curve in enumerate(force_curves(machine)):
        if curve is None or not scale[row]:
            rows.append(none)
            continue
        card = card_of_force(curve)
        found = cylinder_torque([card], geometry, reciprocating_mass=0.0, harmonics=count)
        rows.append((found.gas, found.mean))
    gas, mean = zip(*rows, strict=True)
    return stack(gas, axis=1), stack(mean, axis=1)


def line_passing(scene: Scene) -> Passing:
    """Couple on the body (..., m, c) for a unit torque of each cylinder, by the shaft line.

    A function of the orders (m,) and of the crank speeds (...).
    """
    from vibecalc.torsion.model import build_shaft_line, spin_inertia

    built = build_shaft_line(scene.case)
    spin = spin_inertia(scene.case, built)
    cylinders = built.cylinder_freedom
    ratio = built.station_ratio[built.cylinder_station]

    def passing(order: np.ndarray, speed: np.ndarray | float) -> Bounded:
        crank = np.asarray(speed, dtype=float)[..., None]
        found = line_transfer(built.at(crank), spin, order * crank)
        value, error = found.value[..., cylinders], found.error[..., cylinders]
        return Bounded(value * ratio, error * np.abs(ratio))

    return passing
