"""Transients of an induction motor: time constants, eigenvalues, the torque's answer to speed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_flux import flux_system, inverse_inductance, steady_flux
from vibecalc.numerics.rounding import EPSILON, SINGULAR, WithError
from vibecalc.numerics.typing import FloatArray


class TimeConstants(NamedTuple):
    """Times in s. `stator` (...,): of the stator with the rotor's fluxes held; infinite without
    stator resistance. `rotor_open` and `rotor_short` (..., cages), longest first: of the rotor
    with open and with shorted stator (of no resistance)."""

    stator: WithError
    rotor_open: WithError
    rotor_short: WithError


def time_constants(motor: InductionMotor) -> TimeConstants:
    """Time constants of the electrical transients, each with the other side held."""
    with np.errstate(divide="ignore"):
        stator = 1.0 / (np.asarray(motor.stator_resistance) * inverse_inductance(motor)[..., 0, 0])
    magnetising = np.asarray(motor.magnetising_inductance, dtype=float)
    leakage = np.asarray(motor.stator_leakage, dtype=float)
    shorted = magnetising * leakage / (magnetising + leakage)
    rounding = np.where(np.isfinite(stator), 16.0 * EPSILON * stator, 0.0)
    return TimeConstants(
        WithError(stator, rounding), _rotor_times(motor, magnetising), _rotor_times(motor, shorted)
    )


def eigenvalues(motor: InductionMotor, slip_speed: ArrayLike) -> WithError:
    """Eigenvalues (..., 1 + cages) in 1/s at a speed that is held, least damped first.

    Seen from the field's frame: a flux that stands still in the stator has an imaginary part near
    minus the line frequency (so its torque pulsates with nearly the line frequency), one that turns
    with the rotor one of about minus the slip frequency. The real system has these and their
    conjugates. `error` is that of Bauer and Fike, of rounding alone, for all eigenvalues at once.

    Raises
    ------
    NumericalFailure
        The eigenvectors are parallel to working precision: no digits can be promised.
    """
    system = flux_system(motor)
    speed = motor.synchronous_speed - np.asarray(slip_speed, dtype=float)
    matrix = system.constant + speed[..., None, None] * system.by_speed
    compact = matrix[..., 0::2, 0::2] + 1j * matrix[..., 1::2, 0::2]
    values, vectors = np.linalg.eig(compact)
    size = np.linalg.norm(compact, axis=(-2, -1))
    bound = 8.0 * compact.shape[-1] * EPSILON * size * np.linalg.cond(vectors)
    if not np.all(bound <= SINGULAR * size):
        raise NumericalFailure("two electrical eigenvalues of the motor fall together")
    order = np.argsort(-values.real, axis=-1, kind="stable")
    values = np.take_along_axis(values, order, axis=-1)
    return WithError(values, np.broadcast_to(bound[..., None], values.shape).copy())


def torque_answer(
    motor: InductionMotor, slip_speed: ArrayLike, frequency: ArrayLike
) -> tuple[WithError, WithError]:
    """Small answer of the torque to the crank's speed, complex, N m s: T = Re(G w exp(i W t)).

    Parameters
    ----------
    slip_speed
        Slip of the steady state about which the speed varies, rad/s.
    frequency
        W in rad/s, as seen from the stator, of a variation of the crank's speed (not the slip).

    Returns
    -------
    torque, static
        G and its value at W = 0 from the same equations: minus the slope of the static curve. A
        static motor model has G = static at every frequency.

    Raises
    ------
    NumericalFailure
        An undamped transient of the motor has this frequency (no stator resistance).
    """
    system = flux_system(motor)
    flux = steady_flux(motor, slip_speed).value
    slip, given = np.asarray(slip_speed, dtype=float), np.asarray(frequency, dtype=float)
    speed = motor.synchronous_speed - slip
    matrix = system.constant + speed[..., None, None] * system.by_speed
    push = np.einsum("...ij,...j->...i", system.by_speed, flux)
    pull = np.einsum("...ij,...j->...i", system.torque_form, flux)

    def answer(rate: FloatArray) -> WithError:
        at = 1j * rate[..., None, None] * np.eye(flux.shape[-1]) - matrix
        loss = 8.0 * flux.shape[-1] * EPSILON * np.linalg.cond(at)
        if not np.all(loss < SINGULAR):
            raise NumericalFailure(
                "an electrical transient of the motor without damping has the frequency asked for"
            )
        moved = np.linalg.solve(at, np.broadcast_to(push, at.shape[:-1])[..., None])[..., 0]
        size = np.linalg.norm(pull, axis=-1) * np.linalg.norm(moved, axis=-1)
        return WithError((pull * moved).sum(axis=-1), np.asarray(loss * size))

    return answer(given), answer(np.zeros_like(given))


def _rotor_times(motor: InductionMotor, shared: FloatArray) -> WithError:
    """Eigenvalues of R^-1 (leakages + shared inductance), by its symmetric form."""
    root = np.sqrt(np.asarray(motor.rotor_resistance, dtype=float))
    leakage = np.asarray(motor.rotor_leakage, dtype=float)
    inductance = leakage[..., None] * np.eye(leakage.shape[-1]) + shared[..., None, None]
    times = np.linalg.eigvalsh(inductance / (root[..., :, None] * root[..., None, :]))[..., ::-1]
    return WithError(times, 8.0 * times.shape[-1] * EPSILON * np.abs(times[..., :1] + 0.0 * times))
