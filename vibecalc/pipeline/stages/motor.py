"""Adapter: torque harmonics of the motor to the axial force of its skewed conductors."""

from vibecalc.excitation.axial_force import axial_force
from vibecalc.pipeline.scene import Scene


def run(scene: Scene) -> None:
    """Emit the axial force by order, its mean, bound, peak and effective value."""
    motor = scene.case.machine.motor
    if motor is None:
        raise ValueError("the case has no motor")
    force = axial_force(
        motor.torque.order,
        motor.torque.cosine,
        motor.torque.sine,
        rotor_diameter=motor.rotor_diameter,
        skew_angle=motor.skew_angle,
    )
    scene.emit(
        "excitation/motor/axial_force", force.harmonics, force.error, {"order": force.orders}
    )
    for name, (value, error) in (
        ("mean_force", force.mean),
        ("sum_of_amplitudes", force.sum_of_amplitudes),
        ("peak", force.peak),
        ("rms", force.rms),
    ):
        scene.emit(f"excitation/motor/{name}", value, error)
    scene.cite(
        "normal force on skewed conductors",
        "axial force of the motor",
        "Ong (2000), equations 6.1 to 6.6, with the tangent of the skew angle",
    )
