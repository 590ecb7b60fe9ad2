"""Adapter: impact force beside the piston's inertia force and the motor's axial force, by order."""

import numpy as np

from vibecalc.excitation.axial_force import axial_force
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.machine.joints import Joints
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.response.impact.ensemble import Statistic
from vibecalc.response.impact.spectra import dominance


def emit_dominance(
    scene: Scene, joints: Joints, impact: Statistic, axes: dict[str, np.ndarray]
) -> None:
    """Emit both forces and who leads; `impact` (C, N) has the orders of `axes`."""
    orders = axes["order"]
    shaking = _shaking(scene, joints, int(orders[-1]))
    scene.emit("response/impact/shaking", shaking.value, shaking.error, axes)
    motor = np.zeros(len(orders))
    if scene.case.machine.motor is not None and scene.case.excitation is not None:
        force = _motor(scene, orders)
        scene.emit("response/impact/motor", force.value, force.error, axes)
        motor = force.value
    found = dominance(impact, shaking.value, motor)
    # whole numbers, which a spectrum moves by whole orders
    for name, value, spread in (
        ("leader", found.leader, found.leader_spread),
        ("leads_from", found.leads_from, found.leads_from_spread),
    ):
        scene.emit(f"response/impact/{name}", value, 0.0, axes, float(np.max(spread)))


def _shaking(scene: Scene, joints: Joints, highest: int) -> WithError:
    """Inertia force (N,), N, of all that moves with the piston, magnitudes of orders 1 to N."""
    train, speed = scene.parts.crank_train, scene.case.machine.speed
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    motion = harmonics_with_error(ratio, highest, offset, derivative=2)
    scale = joints.reciprocating_mass * train.crank_radius * speed**2
    size = scale * np.abs(motion.values[1:])
    # R / L is itself rounded: d ln C_n / d ln(R / L) is about n / sqrt(1 - (R / L)^2)
    steepness = np.arange(1, highest + 1) / np.sqrt(1.0 - ratio**2)
    return WithError(size, scale * motion.error[1:] + EPSILON * (8.0 + steepness) * size)


def _motor(scene: Scene, orders: np.ndarray) -> WithError:
    """Axial force (N,) of the motor, N, magnitudes at these orders."""
    motor = scene.case.machine.motor
    if motor is None:
        raise ValueError("the case has no motor")
    torque = motor.torque
    force = axial_force(
        torque.order,
        torque.cosine,
        torque.sine,
        rotor_diameter=motor.rotor_diameter,
        skew_angle=motor.skew_angle,
    )
    value, error = np.zeros(len(orders)), np.zeros(len(orders))
    here = np.isin(force.orders, orders)
    at = force.orders[here] - orders[0]
    value[at], error[at] = np.abs(force.harmonics[here]), force.error[here]
    return WithError(value, error)
