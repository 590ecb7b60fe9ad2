"""Topics of the motor: the largest axial force of its skewed conductors over a turn."""

import numpy as np

from vibecalc.accuracy.topic import Topic
from vibecalc.accuracy.yardsticks.cycle_peaks import peak_topic
from vibecalc.accuracy.yardsticks.cycle_signals import Signal
from vibecalc.excitation.axial_force import axial_force
from vibecalc.pipeline.scene import Scene


def topics(scene: Scene) -> list[Topic]:
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
