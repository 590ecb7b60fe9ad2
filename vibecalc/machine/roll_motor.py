"""The motor of a validated case as a circuit with transients, fitted to its table of torques."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_fit import MotorFit, fit_induction_motor
from vibecalc.excitation.induction_motor_flux import CircuitMotor, circuit_motor
from vibecalc.excitation.induction_motor_identify import transient_inductance, with_stator_leakage
from vibecalc.parts.tables import Motor

#: number of cages by their name in a case
CAGES = {"single": 1, "double": 2, "triple": 3}
DEFAULT = "double"


class FittedMotor(NamedTuple):
    """A fit with its motor, and another one that is as far off as the search leaves open.

    What differs between the two is the error that the fit brings into a result.
    """

    fit: MotorFit
    circuit: CircuitMotor
    other: CircuitMotor


def fitted_motor(motor: Motor) -> FittedMotor | None:
    """The dynamic motor of a case; None for the other kinds.

    Raises
    ------
    NumericalFailure
        No search ends in a minimum, or the table leaves parameters of the cages open.
    """
    if motor.kind != "dynamic":
        return None
    table, pairs, cages = motor.slip_table, motor.poles // 2, motor.cages or DEFAULT
    fit = fit_induction_motor(
        np.array(table.slip),
        np.array(table.torque),
        line_frequency=pairs * motor.synchronous_speed,
        pole_pairs=pairs,
        phase_voltage=motor.voltage * math.sqrt(2.0 / 3.0),
        stator_resistance=motor.stator_resistance,
        cages=CAGES[cages],
    )
    if not math.isfinite(fit.log_error):
        raise NumericalFailure(
            f"motor: the slip table does not settle the parameters of a {cages} cage, so that its "
            "transients are anybody's; ask for fewer cages with machine.motor.cages"
        )
    return FittedMotor(fit, circuit_motor(fit.motor), circuit_motor(_moved(fit)))


def _moved(fit: MotorFit) -> InductionMotor:
    """Every fitted parameter moved by the error of its logarithm, to and fro in turn."""
    share = np.asarray(fit.motor.stator_leakage) / transient_inductance(fit.motor)
    gathered = with_stator_leakage(fit.motor, 0.0)
    resistance, leakage = (
        np.asarray(part) for part in (gathered.rotor_resistance, gathered.rotor_leakage)
    )
    signs = np.where(np.arange(2 * resistance.size) % 2, -1.0, 1.0)
    factors = np.exp(fit.log_error * signs).reshape(2, -1)
    moved = gathered._replace(
        rotor_resistance=resistance * factors[0], rotor_leakage=leakage * factors[1]
    )
    return with_stator_leakage(moved, share * transient_inductance(moved))
