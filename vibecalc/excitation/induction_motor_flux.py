"""Induction motor in time: flux linkages as states, time constants, power, drive of a machine."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import (
    InductionMotor,
    at_slip,
    torque_curve,
    torque_of,
    torque_slope,
)
from vibecalc.excitation.slip_torque import Torque
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, SINGULAR, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Induction motor in time: flux linkages as states, torque, and where the power goes.
#
# See `induction_motor.py` for equations and conventions. The state is real, two entries for each
# winding: Re f_stator, Im f_stator, Re f_1, Im f_1, ... in V s. The currents are the inverse of the
# inductances times f, so that the rates are linear in f, linear in the crank's speed, and contain
# one product of both, and the torque is a quadratic form:
#
#     df/dt = (A + w_crank B) f + u,   T = f' S f / 2.
#
# Whoever calls often forms the arrays once by `flux_system`.
# ----------------------------------------------------------------------------


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
    combined = magnetising[..., None] + np.stack(others, axis=-1)
    total = magnetising + shares.sum(axis=-1)
    scale = 1.0 / (1.0 + stator * total)
    matrix = np.empty((*scale.shape, 1 + cages, 1 + cages))
    matrix[..., 0, 0] = total * scale
    matrix[..., 0, 1:] = matrix[..., 1:, 0] = -shares * scale[..., None]
    outer = shares[..., :, None] * shares[..., None, :]
    matrix[..., 1:, 1:] = -(stator * scale)[..., None, None] * outer
    diagonal = np.arange(1, 1 + cages)
    matrix[..., diagonal, diagonal] = (
        shares * (1.0 + stator[..., None] * combined) * scale[..., None]
    )
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


def steady_flux(motor: InductionMotor, slip_speed: ArrayLike) -> Bounded:
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
    return Bounded(value, np.repeat(rounding[..., None] * np.abs(flux), 2, axis=-1))


def _real(matrix: ComplexArray) -> FloatArray:
    """Complex matrix (..., m, m) as the real one (..., 2 m, 2 m) on real and imaginary parts."""
    size = 2 * matrix.shape[-1]
    real = np.empty((*matrix.shape[:-2], size, size))
    real[..., 0::2, 0::2] = real[..., 1::2, 1::2] = matrix.real
    real[..., 1::2, 0::2] = matrix.imag
    real[..., 0::2, 1::2] = -matrix.imag
    return real


# ----------------------------------------------------------------------------
# Transients of an induction motor: time constants, eigenvalues, the torque's answer to speed.
# ----------------------------------------------------------------------------


class TimeConstants(NamedTuple):
    """Times in s. `stator` (...,): of the stator with the rotor's fluxes held; infinite without
    stator resistance. `rotor_open` and `rotor_short` (..., cages), longest first: of the rotor
    with open and with shorted stator (of no resistance)."""

    stator: Bounded
    rotor_open: Bounded
    rotor_short: Bounded


def time_constants(motor: InductionMotor) -> TimeConstants:
    """Time constants of the electrical transients, each with the other side held."""
    with np.errstate(divide="ignore"):
        stator = 1.0 / (np.asarray(motor.stator_resistance) * inverse_inductance(motor)[..., 0, 0])
    magnetising = np.asarray(motor.magnetising_inductance, dtype=float)
    leakage = np.asarray(motor.stator_leakage, dtype=float)
    shorted = magnetising * leakage / (magnetising + leakage)
    rounding = np.where(np.isfinite(stator), 16.0 * EPSILON * stator, 0.0)
    return TimeConstants(
        Bounded(stator, rounding), _rotor_times(motor, magnetising), _rotor_times(motor, shorted)
    )


def eigenvalues(motor: InductionMotor, slip_speed: ArrayLike) -> Bounded:
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
    return Bounded(values, np.broadcast_to(bound[..., None], values.shape).copy())


def torque_answer(
    motor: InductionMotor, slip_speed: ArrayLike, frequency: ArrayLike
) -> tuple[Bounded, Bounded]:
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

    def answer(rate: FloatArray) -> Bounded:
        at = 1j * rate[..., None, None] * np.eye(flux.shape[-1]) - matrix
        loss = 8.0 * flux.shape[-1] * EPSILON * np.linalg.cond(at)
        if not np.all(loss < SINGULAR):
            raise NumericalFailure(
                "an electrical transient of the motor without damping has the frequency asked for"
            )
        moved = np.linalg.solve(at, np.broadcast_to(push, at.shape[:-1])[..., None])[..., 0]
        size = np.linalg.norm(pull, axis=-1) * np.linalg.norm(moved, axis=-1)
        return Bounded((pull * moved).sum(axis=-1), np.asarray(loss * size))

    return answer(given), answer(np.zeros_like(given))


def _rotor_times(motor: InductionMotor, shared: FloatArray) -> Bounded:
    """Eigenvalues of R^-1 (leakages + shared inductance), by its symmetric form."""
    root = np.sqrt(np.asarray(motor.rotor_resistance, dtype=float))
    leakage = np.asarray(motor.rotor_leakage, dtype=float)
    inductance = leakage[..., None] * np.eye(leakage.shape[-1]) + shared[..., None, None]
    times = np.linalg.eigvalsh(inductance / (root[..., :, None] * root[..., None, :]))[..., ::-1]
    return Bounded(times, 8.0 * times.shape[-1] * EPSILON * np.abs(times[..., :1] + 0.0 * times))


# ----------------------------------------------------------------------------
# Where the power of an induction motor goes while its fluxes change.
# ----------------------------------------------------------------------------


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
    by_rates = flux_rates(system, state, crank_speed)
    rate = by_rates.rates[..., 0::2] + 1j * by_rates.rates[..., 1::2]
    heat = 1.5 * np.abs(current) ** 2
    torque = flux_torque(system, state)
    speed = np.asarray(crank_speed, dtype=float)
    stator = np.asarray(motor.stator_resistance) * heat[..., 0]
    rotor = (np.asarray(motor.rotor_resistance) * heat[..., 1:]).sum(axis=-1)
    # rounding grows with what the matrix products sum up, not with what is left
    gross = np.einsum("...ij,...j->...i", np.abs(matrix), np.abs(vector))
    rough = np.einsum("...ij,...j->...i", np.abs(by_rates.by_flux), np.abs(state))
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


# ----------------------------------------------------------------------------
# An induction motor as what drives a machine: its steady curve, or its fluxes as states.
# ----------------------------------------------------------------------------


class CircuitMotor(NamedTuple):
    """One motor as an equivalent circuit, and how far its transients are followed.

    `breakdown` is the slip (rad/s) and the torque (N m) of the peak of its steady curve.
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
    peak = float(curve.breakdown_slip.value), float(curve.breakdown_torque.value)
    return CircuitMotor(motor, flux_system(motor), peak)


def circuit_torque(circuit: CircuitMotor, slip: FloatArray) -> Torque:
    """Steady torque at slips (...,) in rad/s, and its slope."""
    return Torque(torque_of(circuit.motor, slip), torque_slope(circuit.motor, slip))
