"""An induction motor as what drives a machine: its steady curve, or its fluxes as states."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.induction_motor import InductionMotor, steady_torque, torque_slope
from vibecalc.excitation.induction_motor_curve import torque_curve
from vibecalc.excitation.induction_motor_flux import FluxSystem, flux_system
from vibecalc.excitation.slip_torque import Torque
from vibecalc.numerics.typing import FloatArray


class CircuitMotor(NamedTuple):
    """One motor as an equivalent circuit, and how far its transients are followed.

    `breakdown` is the slip (rad/s) and the torque (N m) of the summit of its steady curve.
    `transient`: the torque follows from the fluxes, which are states; else it is the steady torque
    at each slip. With `pace` g the fluxes take g times their own time to follow: 1 is the motor,
    and towards 0 it becomes its steady curve.
    """

    motor: InductionMotor
    system: FluxSystem
    breakdown: tuple[float, float]
    transient: bool = True
    pace: float = 1.0

    @property
    def states(self) -> int:
        """Number of fluxes that are states: two for each winding."""
        return int(self.system.source.shape[-1]) if self.transient else 0

    @property
    def flux_size(self) -> float:
        """V s, the flux that the line holds in a stator without resistance."""
        return float(np.max(np.asarray(self.motor.phase_voltage) / self.motor.line_frequency))


def circuit_motor(motor: InductionMotor) -> CircuitMotor:
    """The motor with its transients; no leading axes. NumericalFailure if it has no breakdown."""
    curve = torque_curve(motor)
    summit = float(curve.breakdown_slip.value), float(curve.breakdown_torque.value)
    return CircuitMotor(motor, flux_system(motor), summit)


def circuit_torque(circuit: CircuitMotor, slip: FloatArray) -> Torque:
    """Steady torque at slips (...,) in rad/s, and its slope."""
    return Torque(steady_torque(circuit.motor, slip).value, torque_slope(circuit.motor, slip).value)
