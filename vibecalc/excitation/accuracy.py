"""Questions of the excitation: largest force and couple over a turn, motor force, pump torque."""

import numpy as np

from vibecalc.core.accuracy.kinds import TURN, harmonics, peak_over_cycle
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS, Forcing
from vibecalc.excitation.axial_force import axial_force
from vibecalc.excitation.cylinder_torque import gas_harmonics
from vibecalc.excitation.inertia_forces import at_speed, couples_of, forces_of
from vibecalc.excitation.model import liquid_of
from vibecalc.excitation.pressure_cycle import cylinder_pressure, pump_card, pump_turn
from vibecalc.excitation.results import OfPump
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.crank_train import crank_geometry

HIGHEST = 12
_ANGLE = "crank angle [rad]"


def excitation_topics(scene: Scene) -> list[Topic]:
    """The peak of the largest component of force and of couple, each where there is one."""
    forcing: Forcing = scene.handed_on["forcing"]
    driven = at_speed(forcing.per_speed_squared, scene.case.machine.speed)[: forcing.retained]
    orders, found = forcing.order[: forcing.retained], []
    for name, (value, error) in {"force": forces_of(driven), "couple": couples_of(driven)}.items():
        rows = np.where(np.abs(value) > error, value, 0.0).T
        size = cycle_peak(rows, orders).value
        which = int(np.argmax(size))
        if size[which] > 0.0:
            words = f"largest {name} along {DIRECTIONS[which]}, orders to {len(orders)}"
            ask = Ask(f"{name} peak", words, f"excitation/{name}_peak")
            found.append(peak_over_cycle(ask, rows[which : which + 1], orders, _ANGLE))
    return found


def motor_topics(scene: Scene) -> list[Topic]:
    """The peak of the motor's axial force, its mean left out; none where the torque is constant."""
    motor = scene.case.machine.motor
    if motor is None:
        return []
    order, found = axial_force(motor)
    if not np.any(found.axial_force.value):
        return []
    ask = Ask("axial force peak", "largest axial force", "excitation/motor/peak")
    return [peak_over_cycle(ask, found.axial_force.value[None, :], order, _ANGLE)]


def pump_topics(scene: Scene) -> list[Topic]:
    """The first orders of the torque of a pump's liquid in one cylinder."""
    liquid, geometry = liquid_of(scene.case.machine), crank_geometry(scene.case.machine.crank_train)
    order = np.arange(1, HIGHEST + 1)

    def panels(_: float) -> Answer:
        card = pump_card(liquid, geometry)
        return Answer(gas_harmonics(card, geometry, order)[0].value, 25.0 * len(card.coefficient))

    def torque(angle: FloatArray) -> FloatArray:
        gauge = cylinder_pressure(liquid, geometry, angle) - liquid.outside_pressure
        radius, length, _, offset = geometry
        speed = piston_path(angle, radius, length, offset).velocity
        return np.asarray(-gauge * geometry.piston_area * speed)

    ends = [float(one.value) for one in pump_turn(liquid, geometry)[:4]]
    ask = Ask("torque of the liquid", f"orders 1 to {HIGHEST} of the torque of one cylinder",
              f"{OfPump.ROOT}/torque", 4.0,
              "panels serve any order and tell their error")  # fmt: skip
    solver = Solver("card and panels", panels)
    return [harmonics(ask, [solver], torque, order, np.array([*ends, ends[0] + TURN]))]
