"""Accuracy of the excitation: largest force and couple over a turn, motor force, pump torque."""

import numpy as np

from vibecalc.core.accuracy.other_integrators import (
    Signal,
    harmonics_of_samples,
    peak_topic,
    transform_work,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS, Forcing
from vibecalc.excitation.axial_force import axial_force
from vibecalc.excitation.cylinder_torque import gas_harmonics
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.excitation.model import crank_geometry, liquid_of
from vibecalc.excitation.pressure_cycle import Liquid, cylinder_pressure, pump_card, pump_turn
from vibecalc.excitation.results import PUMP_ROOT
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# Topics of the excitation: the largest force and couple on the body over a turn.
# ----------------------------------------------------------------------------


def excitation_force_topics(scene: Scene) -> list[Topic]:
    """The peak of the largest component of force and of couple, each where there is one."""
    forcing: Forcing = scene.handed_on["forcing"]
    driven = at_speed(forcing.per_speed_squared, scene.case.machine.speed)
    orders = forcing.orders[: forcing.retained]
    found = []
    for name, unit, value, error in (
        ("force", "N", driven.force, driven.force_error),
        ("couple", "N*m", driven.couple, driven.couple_error),
    ):
        rows, uncertainty = value[: forcing.retained].T, error[: forcing.retained].T
        rows = np.where(np.abs(rows) > uncertainty, rows, 0.0)
        size = cycle_peak(rows, orders).value
        which = int(np.argmax(size))
        if not size[which] > 0.0:
            continue  # balanced: nothing has a peak
        found.append(
            peak_topic(
                "excitation",
                f"{name} peak",
                f"largest {name} on the body along {DIRECTIONS[which]} over a turn, "
                f"orders to {forcing.retained}",
                f"excitation/{name}_peak",
                unit,
                Signal(rows[which : which + 1], orders),
            )
        )
    return found


# ----------------------------------------------------------------------------
# Topics of the motor: the largest axial force of its skewed conductors over a turn.
# ----------------------------------------------------------------------------


def motor_force_topics(scene: Scene) -> list[Topic]:
    """The peak of the axial force; none where the torque is constant."""
    motor = scene.case.machine.motor
    if motor is None:
        return []
    force = axial_force(
        motor.torque.order,
        motor.torque.cosine,
        motor.torque.sine,
        rotor_diameter=motor.rotor_diameter,
        skew_angle=motor.skew_angle,
    )
    if not np.any(force.harmonics != 0.0):
        return []
    return [
        peak_topic(
            "motor",
            "axial force peak",
            "largest axial force over a turn, its mean left out as in the case's result",
            "excitation/motor/peak",
            "N",
            Signal(force.harmonics[None, :], force.orders),
        )
    ]


# ----------------------------------------------------------------------------
# Topics of a pump: harmonics of the torque of its liquid.
# ----------------------------------------------------------------------------

HIGHEST = 12
SAMPLES = (64.0, 256.0, 1024.0, 4096.0, 16384.0)
NODES = (8.0, 12.0, 16.0, 24.0, 32.0)


def pump_torque_topics(scene: Scene) -> list[Topic]:
    """The first twelve orders of one cylinder."""
    liquid, geometry = liquid_of(scene.case.machine), crank_geometry(scene.case.machine)
    order = np.arange(1, HIGHEST + 1)

    def panels(_: float) -> Answer:
        card = pump_card(liquid, geometry)
        points = len(card.coefficient) * 25.0
        return Answer(gas_harmonics(card, geometry, order)[0].value, points * (HIGHEST + 1))

    def sampled(count: float) -> Answer:
        angle: FloatArray = np.arange(int(count), dtype=np.float64) * (2.0 * np.pi / count)
        found = harmonics_of_samples(_torque(liquid, geometry, angle), HIGHEST)
        return Answer(found[1:], count + transform_work(int(count)))

    def between_valves(count: float) -> Answer:
        angle, weight = _nodes(liquid, geometry, int(count))
        torque = weight * _torque(liquid, geometry, angle)
        value = np.exp(-1j * np.multiply.outer(order, angle)) @ torque / np.pi
        return Answer(value, float(len(angle) * (HIGHEST + 1)))

    def reference() -> Reference:
        ours = gas_harmonics(pump_card(liquid, geometry), geometry, order)[0].value
        other = between_valves(64.0).values
        apart = float(np.max(np.abs(ours - other)) / np.max(np.abs(ours)))
        return Reference(
            other, max(apart, 1e-15),
            "Gauss's rule of 64 points between the events of a turn, held against the panels of a "
            "fitted card",
        )  # fmt: skip

    return [
        Topic(
            stage="pump",
            name="torque of the liquid",
            words=f"orders 1 to {HIGHEST} of the torque of one cylinder",
            quantity=f"{PUMP_ROOT}/torque",
            unit="N*m",
            work="multiplications",
            reference=reference,
            solvers=(
                Solver(
                    "card and panels", "a fitted card, then panels of Gauss's rule", "",
                    NOTHING_TO_SET, panels, default=1.0,
                ),
                Solver(
                    "Gauss between valves", "one rule from each event of a turn to the next",
                    "points", NODES, between_valves, theory="geometric",
                ),
                Solver(
                    "samples", "Fourier transform of samples at even angles", "samples", SAMPLES,
                    sampled, theory="order 2: the torque has kinks where valves open",
                ),
            ),
            default_extra=4.0,
            default_why="the card is that of an engine's gas, whose panels also tell their error; "
            "one rule between the valves would do for twelve orders, and not for a hundred",
        )
    ]  # fmt: skip


def _torque(liquid: Liquid, geometry: CrankGeometry, angle: FloatArray) -> FloatArray:
    gauge = cylinder_pressure(liquid, geometry, angle) - liquid.outside_pressure
    radius, length, _, offset = geometry
    speed = piston_path(angle, radius, length, offset).velocity
    return np.asarray(-gauge * geometry.piston_area * speed)


def _nodes(liquid: Liquid, geometry: CrankGeometry, count: int) -> tuple[FloatArray, FloatArray]:
    turn = pump_turn(liquid, geometry)
    ends = [float(turn[place].value) for place in range(4)]
    ends.append(ends[0] + 2.0 * np.pi)
    rule = gauss_rule(count)
    start, width = np.array(ends[:-1])[:, None], np.diff(ends)[:, None]
    return (start + width * rule.nodes).ravel(), (width * rule.weights).ravel()
