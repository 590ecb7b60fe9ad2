"""Adapter: pressure, valves, work and torque of the cylinders of a pump."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import gas_harmonics, phasor
from vibecalc.excitation.model import crank_geometry, firing_angle, liquid_of, pump_card
from vibecalc.excitation.pressure_cycle import cylinder_pressure, pump_turn
from vibecalc.excitation.results import PUMP_ROOT
from vibecalc.excitation.stage import USUAL_ORDERS
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON

#: degrees of the pressure curve
STEPS = 360


def run_pump(scene: Scene) -> None:
    """Emit what one cylinder does over a turn, and the torque of all of them."""
    machine, options = scene.case.machine, scene.case.excitation
    liquid, geometry = liquid_of(machine), crank_geometry(machine)
    turn = pump_turn(liquid, geometry)
    scene.cite(
        "plunger pump with a constant bulk modulus and ideal valves",
        "pressure over a turn",
        "docs/new_machine.md, the closed form of the indicator diagram",
    )
    opens = (("suction_opens", turn.suction_opens, turn.top),)
    for name, at, since in (*opens, ("discharge_opens", turn.discharge_opens, turn.bottom)):
        angle = at.value - since.value
        scene.emit(f"{PUMP_ROOT}/{name}", angle, at.error + since.error + EPSILON * abs(angle))
    scene.emit(f"{PUMP_ROOT}/swept_volume", *turn.swept)
    efficiency = _ratio(turn.drawn, turn.swept)
    scene.emit(f"{PUMP_ROOT}/volumetric_efficiency", *efficiency)
    named = None if options is None else options.working
    cylinders = machine.crank_train.cylinders
    works = np.array([named is None or cylinder.name in named for cylinder in cylinders])
    count, rate = float(works.sum()), machine.speed / (2.0 * np.pi)
    scene.emit(f"{PUMP_ROOT}/work", *turn.work)
    for name, one in (("flow", turn.drawn), ("power", turn.work)):
        total = count * rate * one.value
        scene.emit(f"{PUMP_ROOT}/{name}", total, count * rate * one.error + 4.0 * EPSILON * total)
    _torque(scene, works, firing_angle(machine))
    angle = np.linspace(0.0, 2.0 * np.pi, STEPS + 1)
    if scene.wants(f"{PUMP_ROOT}/pressure"):
        scene.emit(
            f"{PUMP_ROOT}/pressure",
            cylinder_pressure(liquid, geometry, angle),
            2.0 * float(np.max(pump_card(machine).error)),
            {"crank_angle": angle},
        )


def _torque(scene: Scene, works: np.ndarray, angle: np.ndarray) -> None:
    """By order, each cylinder turned to its own place; the mean by the same panels."""
    orders = None if scene.case.excitation is None else scene.case.excitation.orders
    order = np.arange(1, (orders or USUAL_ORDERS) + 1)
    card, geometry = pump_card(scene.case.machine), crank_geometry(scene.case.machine)
    one, mean = gas_harmonics(card, geometry, order)
    turned = phasor(order, angle)[:, works]
    count = turned.shape[1]
    size = np.abs(one.value)
    scene.emit(
        f"{PUMP_ROOT}/torque",
        one.value * turned.sum(axis=1),
        count * (one.error + (6.0 + count) * EPSILON * size),
        {"order": order},
    )
    scene.emit(f"{PUMP_ROOT}/mean_torque", count * mean.value, count * mean.error)


def _ratio(one: Bounded, other: Bounded) -> Bounded:
    value = one.value / other.value
    uncertainty = one.error + value * other.error
    return Bounded(value, uncertainty / other.value + EPSILON * value)
