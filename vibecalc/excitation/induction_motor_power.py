"""Where the power of an induction motor goes while its fluxes change."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_flux import (
    flux_rates,
    flux_system,
    flux_torque,
    inverse_inductance,
)
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray


class PowerFlow(NamedTuple):
    """Powers in W and the magnetic energy in J, all (...,).

    `electrical` is taken from the line; `stator_copper` and `rotor_copper` (all cages) become heat;
    `mechanical` = torque times the crank's speed against the stator: what rotor and stator get
    together, also where both turn. `magnetic_rate` is the rate of `magnetic_energy`. At every
    instant electrical = copper + mechanical + magnetic_rate; what rounding leaves of it is below
    `error`, which also bounds the error of each term.
    """

    electrical: FloatArray
    stator_copper: FloatArray
    rotor_copper: FloatArray
    mechanical: FloatArray
    magnetic_rate: FloatArray
    magnetic_energy: FloatArray
    error: FloatArray


def power_flow(motor: InductionMotor, flux: ArrayLike, crank_speed: ArrayLike) -> PowerFlow:
    """Powers at any fluxes (..., n) in V s and any crank speed (...,) in rad/s, steady or not."""
    system = flux_system(motor)
    state = np.asarray(flux, dtype=float)
    vector = state[..., 0::2] + 1j * state[..., 1::2]
    matrix = inverse_inductance(motor)
    current = np.einsum("...ij,...j->...i", matrix, vector)
    found = flux_rates(system, state, crank_speed)
    rate = found.rates[..., 0::2] + 1j * found.rates[..., 1::2]
    heat = 1.5 * np.abs(current) ** 2
    torque = flux_torque(system, state)
    speed = np.asarray(crank_speed, dtype=float)
    stator = np.asarray(motor.stator_resistance) * heat[..., 0]
    rotor = (np.asarray(motor.rotor_resistance) * heat[..., 1:]).sum(axis=-1)
    # rounding grows with what the matrix products sum up, not with what is left
    gross = np.einsum("...ij,...j->...i", np.abs(matrix), np.abs(vector))
    rough = np.einsum("...ij,...j->...i", np.abs(found.by_flux), np.abs(state))
    rough = rough[..., 0::2] + rough[..., 1::2] + np.abs(system.source[..., 0::2])
    error = 8.0 * state.shape[-1] * EPSILON * 1.5 * (gross * rough).sum(axis=-1)
    return PowerFlow(
        electrical=1.5 * np.asarray(motor.phase_voltage) * current[..., 0].real,
        stator_copper=np.asarray(stator),
        rotor_copper=np.asarray(rotor),
        mechanical=torque.value * speed,
        magnetic_rate=1.5 * (np.conj(current) * rate).real.sum(axis=-1),
        magnetic_energy=0.75 * (np.conj(current) * vector).real.sum(axis=-1),
        error=np.asarray(error + torque.error * np.abs(speed)),
    )
