"""Adapter: pressure, valves, work and torque of the cylinders of a pump."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import gas_harmonics, phasor
from vibecalc.excitation.model import firing_angle, liquid_of, pump_card
from vibecalc.excitation.pressure_cycle import cylinder_pressure, pump_turn
from vibecalc.excitation.results import OfPump
from vibecalc.excitation.stage import USUAL_ORDERS
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.schema import Machine

#: degrees of the pressure curve
STEPS = 360


def run_pump(scene: Scene) -> None:
    """Emit what one cylinder does over a turn, and the torque of all of them."""
    machine, options = scene.case.machine, scene.case.excitation
    liquid, geometry = liquid_of(machine), crank_geometry(machine.crank_train)
    turn = pump_turn(liquid, geometry)
    scene.cite(
        "plunger pump with a constant bulk modulus and ideal valves",
        "pressure over a turn",
        "docs/contributing.md, the closed form of the indicator diagram",
    )
    named = None if options is None else options.working
    cylinders = machine.crank_train.cylinders
    works = np.array([named is None or cylinder.name in named for cylinder in cylinders])
    rate = rounded(works.sum() * machine.speed / (2.0 * np.pi), 7)
    order = np.arange(1, ((None if options is None else options.orders) or USUAL_ORDERS) + 1)
    torque, mean_torque = _torque(machine, works, order)
    angle = np.linspace(0.0, 2.0 * np.pi, STEPS + 1)

    def pressure() -> Bounded:
        off = np.full(angle.shape, 2.0 * np.max(pump_card(machine).error))
        return Bounded(cylinder_pressure(liquid, geometry, angle), off)

    found = OfPump(
        suction_opens=turn.suction_opens - turn.top,
        discharge_opens=turn.discharge_opens - turn.bottom,
        swept_volume=turn.swept,
        volumetric_efficiency=turn.drawn / turn.swept,
        work=turn.work,
        flow=rate * turn.drawn,
        power=rate * turn.work,
        torque=torque,
        mean_torque=mean_torque,
        pressure=pressure,
    )
    scene.emit_all(found, {"order": order, "crank_angle": angle})


def _torque(machine: Machine, works: np.ndarray, order: np.ndarray) -> tuple[Bounded, Bounded]:
    """By order, each cylinder turned to its own place; the mean by the same panels."""
    one, mean = gas_harmonics(pump_card(machine), crank_geometry(machine.crank_train), order)
    turned = rounded(phasor(order, firing_angle(machine))[:, works], 12)
    return one * turned.sum(), mean * works.sum()
