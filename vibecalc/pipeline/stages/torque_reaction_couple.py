"""Torque of all cylinders of an engine at its speed, and the couple that it is for the body."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.engine_firing import TURN, cycle_angle
from vibecalc.case.engine_mounted import is_separate
from vibecalc.excitation.cylinder_torque import (
    CylinderTorque,
    cylinder_torque,
    inertia_harmonics,
    phasor,
    weighted,
)
from vibecalc.excitation.gas_card import GasCard, card_weights
from vibecalc.excitation.misfire import CylinderGas, cylinder_gas, motored_card
from vibecalc.isolation.torque_reaction import couple_on_body, line_transfer
from vibecalc.machine.engine import build_firing, crank_geometry, cycle_of, firing_angle, gas_cards
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.train_excitation import rod_difference

#: highest order where the case does not say one; a gas torque has many
HIGHEST = 24


class Couples(NamedTuple):
    """Couples (m,) on the body about the crankshaft at the orders (m,), twice as many as `kept`.

    `total` is of gas and inertia; `added` is what the shaking of the crank train lacks of it;
    `mean` a number.
    """

    order: np.ndarray
    kept: int
    total: WithError
    added: WithError
    mean: WithError


def couples_of(scene: Scene, shaking_orders: int) -> Couples:
    """Couples with all orders up to `shaking_orders`, or more, in steps of the engine's cycle."""
    case = scene.case
    step = TURN / cycle_angle(case.machine)
    kept = int(np.ceil(_highest(scene, shaking_orders) / step))
    order = step * np.arange(1, 2 * kept + 1)
    gas, inertia, mean = _torques(scene, order)
    if is_separate(scene.case):
        total = couple_on_body(_sum(gas, inertia))
        return Couples(order, kept, total, couple_on_body(gas), WithError(-mean.value, mean.error))
    transfer = _transfer(scene, order)
    total = couple_on_body(_sum(gas, inertia), transfer)
    return Couples(order, kept, total, total, WithError(np.zeros(()), np.zeros(())))


def _highest(scene: Scene, shaking_orders: int) -> float:
    case = scene.case
    torsion = None if case.response is None else case.response.torsion
    orders = None if torsion is None else torsion.orders
    said = 0.0
    if orders is not None:
        step = orders.step or TURN / cycle_angle(case.machine)
        said = orders.highest or (orders.count or 0) * step
    own = None if case.excitation is None else case.excitation.orders
    return max(said, shaking_orders, HIGHEST if own is None and not said else 0)


def _torques(scene: Scene, order: np.ndarray) -> tuple[WithError, WithError, WithError]:
    """Gas and inertia torque (c, m) of each cylinder on the common crank angle, mean of all."""
    case, train = scene.case, scene.parts.crank_train
    firing = build_firing(case)
    options = case.excitation
    working = None if options is None else options.working
    runs = np.array([working is None or name in working for name in firing.names])
    geometry, speed = crank_geometry(case.machine), case.machine.speed
    gas = _gas(scene, len(order), runs * firing.pressure_scale, ~firing.fires)
    # the shaking of the masses counts from crank phase zero
    turned = phasor(order, firing_angle(case.machine)).T
    rod = case.machine.crank_train.rod
    mass = train.reciprocating_mass[:, None]
    piston = inertia_harmonics(geometry, 1.0, 0.0, order)
    value, error = mass * piston.value, mass * piston.error
    if rod is not None and rod.inertia is not None:
        difference = rod_difference(train, rod)
        moves = (train.reciprocating_mass + train.rotating_mass > 0.0)[:, None]
        turning = inertia_harmonics(geometry, 0.0, 1.0, order)
        value = value + moves * difference.value * turning.value
        error = error + moves * (
            np.abs(difference.value) * turning.error + difference.error * np.abs(turning.value)
        )
    square = speed**2
    doubt = 8.0 * EPSILON
    return (
        WithError(gas.value * turned, gas.error + doubt * np.abs(gas.value)),
        WithError(square * value * turned, square * (error + doubt * np.abs(value))),
        WithError(
            gas.mean.sum(), gas.mean_error.sum() + len(runs) * EPSILON * np.abs(gas.mean).sum()
        ),
    )


def _gas(scene: Scene, count: int, scale: np.ndarray, misfiring: np.ndarray) -> CylinderGas:
    """Gas torque of every cylinder; one that misfires has none, or that of a motored one."""
    case = scene.case
    speeds, cards = gas_cards(case.machine)
    torsion = None if case.response is None else case.response.torsion
    motored = None
    if torsion is not None and torsion.misfire and torsion.misfire_kind == "motored":
        motored = _at_speed(scene, speeds, _motored(scene, cards), count)
    healthy = _at_speed(scene, speeds, cards, count)
    return cylinder_gas(healthy, scale, misfiring=misfiring, motored=motored)


def _at_speed(
    scene: Scene, speeds: np.ndarray, cards: tuple[GasCard, ...], count: int
) -> CylinderTorque:
    machine = scene.case.machine
    found = cylinder_torque(cards, crank_geometry(machine), reciprocating_mass=0.0, harmonics=count)
    return weighted(found, card_weights(speeds if len(speeds) else [0.0], machine.speed))


def _motored(scene: Scene, cards: tuple[GasCard, ...]) -> tuple[GasCard, ...]:
    machine = scene.case.machine
    geometry = crank_geometry(machine)
    if machine.crank_train.gas_cycle is not None:
        from vibecalc.excitation.gas_cycle import motored_cycle

        return (motored_cycle(cycle_of(machine), geometry),)
    return tuple(motored_card(card, geometry) for card in cards)


def _transfer(scene: Scene, order: np.ndarray) -> WithError:
    """Couple on the body (m, c) for a unit torque of each cylinder, by way of the shaft line."""
    from vibecalc.machine.shaft_line import build_shaft_line
    from vibecalc.machine.shaft_line_spin import spin_inertia

    built, speed = build_shaft_line(scene.case), scene.case.machine.speed
    found = line_transfer(built.at(speed), spin_inertia(scene.case, built), order * speed)
    cylinders = built.cylinder_freedom
    ratio = built.station_ratio[built.cylinder_station]
    return WithError(found.value[:, cylinders] * ratio, found.error[:, cylinders] * np.abs(ratio))


def _sum(one: WithError, other: WithError) -> WithError:
    value = one.value + other.value
    return WithError(value, one.error + other.error + EPSILON * np.abs(value))
