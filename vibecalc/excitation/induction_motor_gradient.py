"""How the steady torque of an induction motor follows its parameters."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.induction_motor import (
    Circuit,
    InductionMotor,
    at_slip,
    change_of_torque,
)
from vibecalc.numerics.typing import FloatArray


def parameter_names(cages: int) -> tuple[str, ...]:
    """Names of the columns of `torque_sensitivity`."""
    numbers = [""] if cages == 1 else [f" {cage + 1}" for cage in range(cages)]
    return (
        "stator_resistance",
        "stator_leakage",
        "magnetising_inductance",
        *(f"rotor_resistance{number}" for number in numbers),
        *(f"rotor_leakage{number}" for number in numbers),
    )


def torque_sensitivity(motor: InductionMotor, slip_speed: ArrayLike) -> FloatArray:
    """Derivatives of the steady torque by the logarithm of each parameter, N m (..., parameters).

    A column is the torque's change in N m for a parameter that grows by the factor e, to first
    order; columns as in `parameter_names`. The voltage needs none: torque goes with its square.
    Leading axes of the motor and of `slip_speed` (rad/s, mechanical) broadcast.
    """
    circuit = at_slip(motor, slip_speed)
    p, voltage = np.asarray(motor.pole_pairs), np.asarray(motor.phase_voltage)
    frequency = np.asarray(p * np.asarray(slip_speed, dtype=float))[..., None]
    resistance, leakage = np.asarray(motor.rotor_resistance), np.asarray(motor.rotor_leakage)
    squared = (resistance + 1j * frequency * leakage) ** 2
    nothing = np.zeros_like(circuit.inverse_inductance)[..., None]
    in_admittance = np.concatenate(
        [
            nothing,
            nothing,
            nothing - 1.0 / np.asarray(motor.magnetising_inductance)[..., None],
            -1j * frequency * resistance / squared,
            frequency**2 * leakage / squared,
        ],
        axis=-1,
    )
    in_divisor = circuit.stator[..., None] * in_admittance
    in_divisor[..., 0] += circuit.stator.real * circuit.inverse_inductance
    in_divisor[..., 1] += 1j * circuit.stator.imag * circuit.inverse_inductance
    admittance, stator, divisor, size = circuit
    column = Circuit(admittance[..., None], stator[..., None], divisor[..., None], size[..., None])
    first, second = change_of_torque(column, in_admittance, in_divisor)
    return np.asarray((1.5 * p * voltage**2)[..., None] * (first + second))
