"""The mean speed that a controller holds, and the speed feedback that holds a wanted one."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.roll_control.model import Controller, ReducedModel


def steady_speed(
    model: ReducedModel, controller: Controller, reference: ArrayLike, mean_torque: ArrayLike
) -> WithError:
    """Mean speed (rad/s) at which motor and load balance: Herold 1977, eq. 105.

    `reference` R in rad/s; `mean_torque` d_0 in N m, negative where the machine takes power
    (eq. 97: -303.3). It is the equilibrium, reached or not: an unstable loop leaves it.
    Infinite where no speed balances (K K_M k_R = -K_M - viscous).
    """
    gain, feedback = np.asarray(controller.gain), np.asarray(controller.speed_feedback)
    motor, viscous = np.asarray(model.motor_gain), np.asarray(model.viscous)
    push = gain * motor * reference
    brake = gain * motor * feedback
    over = mean_torque + push
    under = motor + viscous + brake
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(under == 0.0, np.inf, over / under)
        above = np.abs(mean_torque) + 3.0 * np.abs(push)
        below = motor + viscous + 3.0 * np.abs(brake)
        error = (above + np.abs(speed) * below) / np.abs(under) + 2.0 * np.abs(speed)
    error = np.where(np.isfinite(speed), UNIT_ROUNDOFF * error, 0.0)
    return WithError(speed, error)


def speed_feedback_for(
    model: ReducedModel, gain: ArrayLike, reference: ArrayLike, mean_torque: ArrayLike,
    target: ArrayLike,
) -> WithError:  # fmt: skip
    """Speed feedback k_R (1) that keeps the mean speed at `target` (rad/s): Herold 1977, eq. 107.

    The source's 1.016 (1 - 1/K) is this with its target of 92.76 rad/s, the speed without
    control. `gain` K must not be zero. What is below its own rounding is zero: a feedback of 1e-16
    would have a gain margin of 320 dB.
    """
    k, motor = np.asarray(gain, dtype=float), np.asarray(model.motor_gain)
    parts = (
        np.asarray(reference) / target,
        np.asarray(mean_torque) / (k * motor * target),
        -(motor + np.asarray(model.viscous)) / (k * motor),
    )
    value = parts[0] + parts[1] + parts[2]
    error = 6.0 * UNIT_ROUNDOFF * sum((np.abs(p) for p in parts), np.zeros(()))
    return WithError(np.where(np.abs(value) > error, value, 0.0), error)
