"""What an engineer reads off a torque curve: breakdown, locked rotor, the slip under a load.

One motor at a time. Im Y / |D|^2 of `induction_motor.py` is a quotient N / P of real polynomials of
the slip, so the extremes of the curve are the roots of N' P - N P': none is missed, also with two
cages, whose curve may have two summits.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor, steady_torque, torque_slope
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import ComplexArray, FloatArray


class TorqueCurve(NamedTuple):
    """Points of the curve of one motor; slips in rad/s, mechanical, torques in N m.

    `breakdown_slip` and `breakdown_torque`: the largest torque at slips above 0. `extreme_slips`
    are all slips above 0 at which the torque is largest or smallest among its neighbours.
    `gain` (N m s) is the slope at synchronous speed.
    """

    gain: WithError
    breakdown_slip: WithError
    breakdown_torque: WithError
    locked_rotor_torque: WithError
    extreme_slips: FloatArray


def torque_curve(motor: InductionMotor) -> TorqueCurve:
    """Gain, breakdown and locked-rotor torque of one motor, with errors."""
    slips, errors = _extremes(motor, 1.0)
    torque = steady_torque(motor, slips)
    top = int(np.argmax(torque.value))
    return TorqueCurve(
        gain=torque_slope(motor, 0.0),
        breakdown_slip=WithError(slips[top], errors[top]),
        breakdown_torque=WithError(torque.value[top], torque.error[top]),
        locked_rotor_torque=steady_torque(motor, motor.synchronous_speed),
        extreme_slips=slips,
    )


def running_slip(motor: InductionMotor, torque: float) -> WithError:
    """Slip (rad/s) at which one motor carries a torque (N m), on the branch nearest to slip 0.

    A negative torque, of a generator, gives a negative slip.

    Raises
    ------
    NumericalFailure
        The torque is beyond breakdown: no steady slip exists.
    """
    from scipy.optimize import brentq

    if torque == 0.0:
        return WithError(np.asarray(0.0), np.asarray(0.0))
    side = 1.0 if torque > 0.0 else -1.0
    slips, _ = _extremes(motor, side)
    heights = side * steady_torque(motor, slips).value
    reached = np.flatnonzero(heights >= abs(torque))
    if reached.size == 0:
        top = int(np.argmax(heights))
        raise NumericalFailure(
            f"the motor has no steady slip at {torque:.6g} N m: its breakdown torque is "
            f"{side * heights[top]:.6g} N m, at a slip of {slips[top]:.6g} rad/s"
        )
    end = reached[0]
    below = slips[end - 1] if end else 0.0
    slip = brentq(
        lambda s: float(steady_torque(motor, s).value) - torque,
        min(below, slips[end]), max(below, slips[end]), xtol=1e-300, rtol=4.0 * EPSILON,
    )  # fmt: skip
    slope = float(torque_slope(motor, slip).value)
    rounding = float(steady_torque(motor, slip).error) + EPSILON * abs(torque)
    # where the curve is flat, the parabola over the summit is the safer guide
    reach = rounding / max(slope, np.sqrt(rounding * abs(torque)) / abs(slip))
    return WithError(np.asarray(slip), np.asarray(2.0 * reach + 8.0 * EPSILON * abs(slip)))


def _extremes(motor: InductionMotor, side: float) -> tuple[FloatArray, FloatArray]:
    """Slips of one sign at which the slope is zero, by growing size, and their errors."""
    pairs = float(np.asarray(motor.pole_pairs))
    resistance, leakage = np.asarray(motor.rotor_resistance), np.asarray(motor.rotor_leakage)
    unit = float(np.exp(np.mean(np.log(resistance / leakage))))
    above, below = _quotient(motor, unit)
    above_slope = np.asarray(np.polyder(above), dtype=np.float64)
    below_slope = np.asarray(np.polyder(below), dtype=np.float64)
    roots = np.roots(np.polysub(np.polymul(above_slope, below), np.polymul(above, below_slope)))
    real = np.asarray(roots.real[np.abs(roots.imag) <= 1e-7 * np.abs(roots)])
    rough = np.sort(np.abs(real[real * side > 0.0])) * side * unit / pairs
    if rough.size == 0:
        raise NumericalFailure("the motor's torque curve has no breakdown: parameters out of range")
    return _polished(motor, rough)


def _polished(motor: InductionMotor, slip: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Newton steps on the slope. Where they fail, two extremes merge, and the roots stay."""
    found, error = slip.copy(), np.zeros_like(slip)
    for index, start in enumerate(slip):
        place, step = float(start), float(np.inf)
        for _ in range(4):
            width = 1e-4 * abs(place)
            sides = torque_slope(motor, place + width * np.array([-1.0, 1.0])).value
            curvature = float(sides[1] - sides[0]) / (2.0 * width)
            slope = torque_slope(motor, place)
            if curvature == 0.0:
                break
            step = float(slope.value / curvature)
            place -= step
        if abs(place - start) < 1e-5 * abs(start):
            noise = float(torque_slope(motor, place).error) / abs(curvature)
            found[index], error[index] = place, 2.0 * (abs(step) + noise)
        else:
            error[index] = max(1e-5 * abs(start), abs(place - start))
    return found, error


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
