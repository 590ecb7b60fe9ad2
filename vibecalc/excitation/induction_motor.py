"""Equivalent circuit of an induction motor: steady torque over slip, breakdown."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Equivalent circuit of an induction motor: its torque at a steady slip.
#
# Conventions, for all files `induction_motor*.py`. Three phases in star, constant balanced voltage
# of constant frequency. Space vectors are complex and of peak size (amplitude-invariant), seen from
# a frame that turns with the field of the stator; so powers carry 3/2 and a steady state stands
# still. All that stands on the rotor is referred to the stator. The frame of the stator may turn (a
# shell that rolls): only the crank's speed against it enters. With the slip s (mechanical, rad/s:
# the speed of the field less the speed of the rotor, both against the stator), p pairs of poles,
# line frequency w and slip frequency v = p s, currents i and flux linkages f obey
#
#     f_stator = l_stator i_stator + f_m,   f_k = l_k i_k + f_m,   f_m = M (i_stator + sum i_k),
#     V = R i_stator + d f_stator/dt + i w f_stator,   0 = R_k i_k + d f_k/dt + i v f_k,
#
# with one or more cages k. Torque is positive on the rotor in the sense of the field, and acts on
# the stator with the opposite sign. (P. C. Krause, O. Wasynczuk and S. D. Sudhoff, Analysis of
# Electric Machinery, 2nd ed. 2002, ch. 4; there the rotor's voltages are kept and the cage is one.)
#
# Two cages as separate branches are general: a leakage that both share adds nothing that terminals
# or shaft could tell, since it can be taken up by the other four (R. M. Foster, Bell System
# Technical Journal 3, 1924, of networks in general).
# ----------------------------------------------------------------------------


class InductionMotor(NamedTuple):
    """A motor per phase of the equivalent star. Leading axes broadcast; cages are the last axis.

    `line_frequency` in rad/s; `pole_pairs` (half the number of poles); `phase_voltage`, peak V
    (the line voltage times sqrt(2/3)); `stator_resistance` in ohm, `stator_leakage` and
    `magnetising_inductance` in H, all (...,); `rotor_resistance` in ohm and `rotor_leakage` in H,
    (..., cages), above 0 and referred to the stator. `stator_leakage` may be 0.
    """

    line_frequency: ArrayLike
    pole_pairs: ArrayLike
    phase_voltage: ArrayLike
    stator_resistance: ArrayLike
    stator_leakage: ArrayLike
    magnetising_inductance: ArrayLike
    rotor_resistance: ArrayLike
    rotor_leakage: ArrayLike

    @property
    def synchronous_speed(self) -> FloatArray:
        """Mechanical speed of the field against the stator, rad/s."""
        return np.asarray(np.asarray(self.line_frequency) / np.asarray(self.pole_pairs))


class Circuit(NamedTuple):
    """The circuit at a steady slip, complex (...,).

    `inverse_inductance` Y = i_stator / f_m in 1/H, `divisor` D = i w + Z Y, so that f_m = V / D,
    with Z = R + i w l_stator in ohm; `size` is the sum of the magnitudes in D.
    """

    inverse_inductance: ComplexArray
    divisor: ComplexArray
    size: FloatArray


def steady_torque(motor: InductionMotor, slip_speed: ArrayLike) -> Bounded:
    """Torque at a steady slip, N m (...,), with its rounding error.

    Parameters
    ----------
    motor
        Its leading axes broadcast with those of `slip_speed`.
    slip_speed
        s in rad/s, mechanical: 0 at synchronous speed, the synchronous speed with locked rotor,
        more when the rotor turns against the field, negative as a generator.

    Returns
    -------
    Bounded
        (3/2) p V^2 Im Y / |D|^2. Nothing cancels in Im Y; what cancels in D as a generator is
        in the error.
    """
    value, circuit = (
        torque_of(motor, np.asarray(slip_speed, dtype=float)),
        at_slip(motor, slip_speed),
    )
    rounding = 16.0 + 8.0 * circuit.size / np.abs(circuit.divisor)
    return Bounded(value, np.asarray(EPSILON * rounding * np.abs(value)))


#: a step into the imaginary of that size leaves nothing but the derivative: no digits cancel
STEP = 1e-30


def torque_of(motor: InductionMotor, slip_speed: Any) -> Any:
    """`steady_torque` by functions that are analytic in the slip and in each parameter.

    With an imaginary part h of one of them the imaginary part over h is the derivative by it
    (W. Squire and G. Trapp, SIAM Review 40, 1998, p. 110).
    """
    real, imaginary = _admittance(motor, slip_speed)
    line, resistance = np.asarray(motor.line_frequency), np.asarray(motor.stator_resistance)
    reactance = line * np.asarray(motor.stator_leakage)
    along, across = (
        resistance * real - reactance * imaginary,
        line + resistance * imaginary + reactance * real,
    )
    power = 1.5 * np.asarray(motor.pole_pairs) * np.asarray(motor.phase_voltage) ** 2
    return np.asarray(power * imaginary / (along * along + across * across))


def torque_slope(motor: InductionMotor, slip_speed: ArrayLike) -> FloatArray:
    """Derivative of `steady_torque` by the slip, N m s (...,).

    Positive where the motor runs stably; at slip 0 it is the motor's gain.
    """
    moved = np.asarray(slip_speed, dtype=float) + 1j * STEP
    return np.asarray(torque_of(motor, moved).imag / STEP)


def at_slip(motor: InductionMotor, slip_speed: ArrayLike) -> Circuit:
    """The equivalent circuit at a steady slip (rad/s, mechanical), see `Circuit`."""
    real, imaginary = _admittance(motor, np.asarray(slip_speed, dtype=float))
    admittance, line = real + 1j * imaginary, np.asarray(motor.line_frequency)
    stator = np.asarray(motor.stator_resistance) + 1j * line * np.asarray(motor.stator_leakage)
    size = line + (np.abs(stator.real) + np.abs(stator.imag)) * np.abs(admittance)
    return Circuit(admittance, 1j * line + stator * admittance, np.asarray(size))


def _admittance(motor: InductionMotor, slip_speed: Any) -> tuple[Any, Any]:
    """Real and imaginary part of Y, of the slip frequency v = p s in the rotor."""
    frequency = (np.asarray(motor.pole_pairs) * slip_speed)[..., None]
    resistance, leakage = np.asarray(motor.rotor_resistance), np.asarray(motor.rotor_leakage)
    reactance = frequency * leakage
    squared = resistance**2 + reactance**2
    real = 1.0 / np.asarray(motor.magnetising_inductance)
    return (
        real + (frequency * reactance / squared).sum(axis=-1),
        (frequency * resistance / squared).sum(axis=-1),
    )


# ----------------------------------------------------------------------------
# What an engineer reads off a torque curve: breakdown, locked rotor, the slip under a load.
#
# One motor at a time. Im Y / |D|^2 of `induction_motor.py` is a quotient N / P of real polynomials
# of the slip, so the extremes of the curve are the roots of N' P - N P': none is missed, also with
# two cages, whose curve may have two peaks.
# ----------------------------------------------------------------------------


class TorqueCurve(NamedTuple):
    """Points of the curve of one motor; slips in rad/s, mechanical, torques in N m; or `Bounded`.

    `breakdown_slip` and `breakdown_torque`: the largest torque at slips above 0. `gain` (N m s)
    is the slope at synchronous speed.
    """

    gain: Any
    breakdown_slip: Any
    breakdown_torque: Any
    locked_rotor_torque: Any


def torque_curve(motor: InductionMotor) -> TorqueCurve:
    """Gain, breakdown and locked-rotor torque of one motor, with errors."""
    found: TorqueCurve = with_errors(_curve, motor)
    return found


def _curve(motor: InductionMotor) -> TorqueCurve:
    slips = _extremes(motor)
    torque = torque_of(motor, slips)
    top = int(np.argmax(torque))
    return TorqueCurve(
        gain=torque_slope(motor, 0.0),
        breakdown_slip=slips[top],
        breakdown_torque=torque[top],
        locked_rotor_torque=torque_of(motor, motor.synchronous_speed),
    )


def _extremes(motor: InductionMotor) -> FloatArray:
    """Slips above 0 at which the slope is zero, ascending."""
    pairs = float(np.asarray(motor.pole_pairs))
    resistance, leakage = np.asarray(motor.rotor_resistance), np.asarray(motor.rotor_leakage)
    unit = float(np.exp(np.mean(np.log(resistance / leakage))))
    above, below = _quotient(motor, unit)
    above_slope = np.asarray(np.polyder(above), dtype=np.float64)
    below_slope = np.asarray(np.polyder(below), dtype=np.float64)
    roots = np.roots(np.polysub(np.polymul(above_slope, below), np.polymul(above, below_slope)))
    real = np.asarray(roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots)])
    slips = np.sort(real[real > 0.0]) * unit / pairs
    if slips.size == 0:
        raise NumericalFailure("the motor's torque curve has no breakdown: parameters out of range")
    return np.asarray(slips)


def _quotient(motor: InductionMotor, unit: float) -> tuple[FloatArray, FloatArray]:
    """Im Y / |D|^2 as two real polynomials of the slip frequency over `unit`, highest first."""
    resistance = np.asarray(motor.rotor_resistance, dtype=float)
    reactance = unit * np.asarray(motor.rotor_leakage, dtype=float)
    factors = [np.array([1j * x, r]) for r, x in zip(resistance, reactance, strict=True)]
    common = _product(factors)
    admittance = common / float(np.asarray(motor.magnetising_inductance))
    for k in range(len(factors)):
        others = _product(factors[:k] + factors[k + 1 :])
        branch = np.polymul(np.array([1j * unit, 0.0]), others)
        admittance = np.polyadd(admittance, branch).astype(np.complex128)
    line = float(np.asarray(motor.line_frequency))
    reactance_stator = line * float(np.asarray(motor.stator_leakage))
    stator = complex(float(np.asarray(motor.stator_resistance)), reactance_stator)
    divisor = np.polyadd(1j * line * common, stator * admittance)
    above = np.polymul(admittance, np.conj(common)).imag
    below = np.polymul(divisor, np.conj(divisor)).real
    return above / np.max(np.abs(above)), below / np.max(np.abs(below))


def _product(factors: list[ComplexArray]) -> ComplexArray:
    """Of polynomials, highest power first."""
    result = np.ones(1, dtype=np.complex128)
    for factor in factors:
        result = np.polymul(result, factor).astype(np.complex128)
    return result
