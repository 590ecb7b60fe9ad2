"""Induction motor in time: flux linkages as states, torque, and where the power goes.

See `induction_motor.py` for equations and conventions. The state is real, two entries for each
winding: Re f_stator, Im f_stator, Re f_1, Im f_1, ... in V s. The currents are the inverse of the
inductances times f, so that the rates are linear in f, linear in the crank's speed, and contain one
product of both, and the torque is a quadratic form:

    df/dt = (A + w_crank B) f + u,   T = f' S f / 2.

Whoever calls often forms the arrays once by `flux_system`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.induction_motor import InductionMotor, at_slip
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import ComplexArray, FloatArray


class FluxSystem(NamedTuple):
    """Arrays of the equations above, n = 2 (1 + cages) states.

    `constant` A (..., n, n) in 1/s, `by_speed` B (..., n, n) without unit (p on the rotor),
    `source` u (..., n) in V, `torque_form` S (..., n, n) in N m / (V s)^2, symmetric.
    """

    constant: FloatArray
    by_speed: FloatArray
    source: FloatArray
    torque_form: FloatArray


class FluxRates(NamedTuple):
    """`rates` (..., n) in V and their derivatives: `by_flux` (..., n, n), `by_speed` (..., n)."""

    rates: FloatArray
    by_flux: FloatArray
    by_speed: FloatArray


class FluxTorque(NamedTuple):
    """Torque on the rotor (...,) in N m, its gradient (..., n) by the fluxes, rounding `error`."""

    value: FloatArray
    by_flux: FloatArray
    error: FloatArray


def inverse_inductance(motor: InductionMotor) -> FloatArray:
    """Symmetric matrix (..., 1 + cages, 1 + cages) in 1/H: currents = matrix times fluxes.

    The closed inverse, written without differences: every entry is right to some roundings.
    """
    stator = np.asarray(motor.stator_leakage, dtype=float)
    shares = 1.0 / np.asarray(motor.rotor_leakage, dtype=float)
    magnetising = 1.0 / np.asarray(motor.magnetising_inductance, dtype=float)
    cages = shares.shape[-1]
    others = [np.delete(shares, k, axis=-1).sum(axis=-1) for k in range(cages)]
    rest = magnetising[..., None] + np.stack(others, axis=-1)
    total = magnetising + shares.sum(axis=-1)
    scale = 1.0 / (1.0 + stator * total)
    matrix = np.empty((*scale.shape, 1 + cages, 1 + cages))
    matrix[..., 0, 0] = total * scale
    matrix[..., 0, 1:] = matrix[..., 1:, 0] = -shares * scale[..., None]
    outer = shares[..., :, None] * shares[..., None, :]
    matrix[..., 1:, 1:] = -(stator * scale)[..., None, None] * outer
    diagonal = np.arange(1, 1 + cages)
    matrix[..., diagonal, diagonal] = shares * (1.0 + stator[..., None] * rest) * scale[..., None]
    return matrix


def flux_system(motor: InductionMotor) -> FluxSystem:
    """The arrays of the motor's equations, see `FluxSystem`; leading axes as the motor's."""
    currents = inverse_inductance(motor)
    windings = currents.shape[-1]
    lead = currents.shape[:-2]
    resistance = np.concatenate(
        [
            np.broadcast_to(np.asarray(motor.stator_resistance, dtype=float), lead)[..., None],
            np.broadcast_to(motor.rotor_resistance, (*lead, windings - 1)),
        ],
        axis=-1,
    )
    line, pairs, voltage = (
        np.broadcast_to(np.asarray(value, dtype=float), lead)
        for value in (motor.line_frequency, motor.pole_pairs, motor.phase_voltage)
    )
    turning = line[..., None, None] * np.eye(windings)
    on_rotor = np.diag((np.arange(windings) > 0).astype(float))
    source = np.zeros((*lead, 2 * windings))
    source[..., 0] = voltage
    form = np.zeros((*lead, 2 * windings, 2 * windings))
    pull = 1.5 * pairs[..., None] * currents[..., 0, 1:]  # of Im(conj(f_stator) f_k)
    form[..., 0, 3::2] = form[..., 3::2, 0] = pull
    form[..., 1, 2::2] = form[..., 2::2, 1] = -pull
    return FluxSystem(
        constant=_real(-resistance[..., :, None] * currents - 1j * turning),
        by_speed=_real(1j * pairs[..., None, None] * on_rotor),
        source=source,
        torque_form=form,
    )


def flux_rates(system: FluxSystem, flux: ArrayLike, crank_speed: ArrayLike) -> FluxRates:
    """Rates of the fluxes and their derivatives.

    `flux` (..., n) in V s, `crank_speed` (...,) in rad/s against the stator. The rounding of the
    rates is at most some 2 n units in the last place of |A + w B| |f| + |u|.
    """
    f, speed = np.asarray(flux), np.asarray(crank_speed)
    matrix = system.constant + speed[..., None, None] * system.by_speed
    turned = np.einsum("...ij,...j->...i", system.by_speed, f)
    rates = np.einsum("...ij,...j->...i", matrix, f) + system.source
    return FluxRates(rates, matrix, turned)


def flux_torque(system: FluxSystem, flux: ArrayLike) -> FluxTorque:
    """Torque on the rotor for fluxes (..., n) in V s; on the stator it is the opposite."""
    f = np.asarray(flux)
    gradient = np.einsum("...ij,...j->...i", system.torque_form, f)
    magnitudes = np.einsum("...i,...ij,...j->...", np.abs(f), np.abs(system.torque_form), np.abs(f))
    rounding = (4.0 + f.shape[-1]) * EPSILON
    return FluxTorque(0.5 * (f * gradient).sum(axis=-1), gradient, rounding * magnitudes)


def steady_flux(motor: InductionMotor, slip_speed: ArrayLike) -> WithError:
    """Fluxes (..., n) in V s of the steady state at a slip (rad/s, mechanical), with their error.

    From the equivalent circuit: f_m = V / D, f_stator = (1 + l Y) f_m and, since a cage's current
    is -i v f_k / R_k, f_k = f_m R_k / (R_k + i v l_k).
    """
    circuit = at_slip(motor, slip_speed)
    p, voltage = np.asarray(motor.pole_pairs), np.asarray(motor.phase_voltage)
    air_gap = np.asarray(voltage / circuit.divisor)
    stator = air_gap * (1.0 + np.asarray(motor.stator_leakage) * circuit.inverse_inductance)
    frequency = np.asarray(p * np.asarray(slip_speed, dtype=float))[..., None]
    resistance = np.asarray(motor.rotor_resistance)
    branch = 1.0 + 1j * frequency * np.asarray(motor.rotor_leakage) / resistance
    flux = np.concatenate([stator[..., None], air_gap[..., None] / branch], axis=-1)
    value = np.stack([flux.real, flux.imag], axis=-1).reshape(*flux.shape[:-1], -1)
    rounding = EPSILON * (12.0 + 4.0 * circuit.size / np.abs(circuit.divisor))
    return WithError(value, np.repeat(rounding[..., None] * np.abs(flux), 2, axis=-1))


def _real(matrix: ComplexArray) -> FloatArray:
    """Complex matrix (..., m, m) as the real one (..., 2 m, 2 m) on real and imaginary parts."""
    size = 2 * matrix.shape[-1]
    real = np.empty((*matrix.shape[:-2], size, size))
    real[..., 0::2, 0::2] = real[..., 1::2, 1::2] = matrix.real
    real[..., 1::2, 0::2] = matrix.imag
    real[..., 0::2, 1::2] = -matrix.imag
    return real
