"""Steady harmonics of shell, rotor, motor and controller in the closed loop."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.roll_control.model import Controller, ReducedModel, loop_of


class Harmonics(NamedTuple):
    """Complex amplitudes (..., orders), 0-to-peak, x(t) = Re sum X_n exp(i n W t); orders 1, 2, ...

    `shell_acceleration`, `rotor_acceleration` (rad/s^2), `rotor_speed` (rad/s), `motor_torque`
    (N m, between shell and rotor), `command` (rad/s, what the actuator delivers beside its mean).
    """

    shell_acceleration: WithError
    rotor_acceleration: WithError
    rotor_speed: WithError
    motor_torque: WithError
    command: WithError


def harmonics(
    model: ReducedModel, controller: Controller, speed: ArrayLike, disturbance: ArrayLike,
    disturbance_error: ArrayLike = 0.0, speed_error: ArrayLike = 0.0,
) -> Harmonics:  # fmt: skip
    """Response to the disturbance: Herold 1977, eqs. 112 and 113, with phases and any order.

    Parameters
    ----------
    speed : (...) mean speed W in rad/s.
    disturbance : (..., orders) complex torque on the rotor in N m, order 1 first.
    disturbance_error, speed_error : absolute, of the shapes above.

    This is the motion that the equations allow. Whether the loop ever settles to it is another
    question: `vibecalc.response.roll_control.evaluate` asks it. Infinite on a pole.
    """
    loop = loop_of(model, controller)
    torque = np.asarray(disturbance, dtype=complex)
    order = np.arange(1, torque.shape[-1] + 1)
    base = np.asarray(speed, dtype=float)[..., None]
    s = 1j * order * base
    lag = (1.0 + s * _wide(controller.lag)) * np.exp(s * _wide(controller.delay))
    q1, q0, delay = (a[..., None] for a in (loop.q1, loop.q0, loop.delay))
    # inertia s + b + K K_M C (k_R - k_S ratio s) with C = 1 / lag
    inertia, drag = _wide(model.inertia), _wide(model.motor_gain) + _wide(model.viscous)
    stiff = inertia * s + drag
    back = (q1 * s + q0) / lag
    under = stiff + back

    size = np.abs(inertia * s) + drag + (np.abs(q1 * s) + np.abs(q0)) / np.abs(lag)
    slope = inertia + np.abs(q1) + np.abs(back) * (_wide(controller.lag) + delay)
    speed_off = order * np.asarray(speed_error, dtype=float)[..., None]
    doubt = 12.0 * UNIT_ROUNDOFF * size * (1.0 + np.abs(s) * delay) + slope * speed_off
    with np.errstate(divide="ignore", invalid="ignore"):
        rotor = torque / under
        relative = doubt / np.abs(under) + 4.0 * UNIT_ROUNDOFF
        rotor_error = np.abs(rotor) * relative + np.asarray(disturbance_error) / np.abs(under)
        drift = speed_off / np.abs(s)
    command = -back / _wide(model.motor_gain)

    def times(factor: np.ndarray, own: ArrayLike = 0.0) -> WithError:
        value = factor * rotor
        error = np.abs(factor) * rotor_error + np.abs(value) * (
            8.0 * UNIT_ROUNDOFF + np.asarray(own)
        )
        return WithError(value, error)

    turned = np.abs(s) * delay
    loose = 12.0 * UNIT_ROUNDOFF * (1.0 + turned)
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = (np.abs(q1 * s) + np.abs(q0)) / np.maximum(np.abs(q1 * s + q0), 1e-300)
    back_off = loose * gap + drift * (1.0 + turned + gap)
    moved = _wide(model.motor_gain) * (command - 1.0)
    moved_off = (np.abs(back) * back_off) / np.maximum(np.abs(moved), 1e-300)
    return Harmonics(
        times(-_wide(model.ratio) * s, drift), times(s, drift), times(np.ones_like(s)),
        times(moved, moved_off), times(command, back_off),
    )  # fmt: skip


def _wide(value: ArrayLike) -> np.ndarray:
    wide: np.ndarray = np.asarray(value, dtype=float)[..., None]
    return wide
