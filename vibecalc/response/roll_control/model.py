"""Rotor, shell and controller as a linear loop, and the characteristic function of that loop."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class ReducedModel(NamedTuple):
    """The machine about its mean speed w; arrays that broadcast, SI.

    inertia w' = T + d(t) and shell acceleration = -ratio w', with the torque of the motor
    T = motor_gain (u - w) - viscous w. `inertia` (kg m^2) is what the torque between shell and
    rotor accelerates, `ratio` (1) the share of the rotor's acceleration that the shell takes.
    """

    inertia: ArrayLike
    ratio: ArrayLike
    motor_gain: ArrayLike
    viscous: ArrayLike = 0.0


class Controller(NamedTuple):
    """u = gain (reference - speed_feedback w - acceleration_feedback alpha_shell), late and slow.

    `gain` K (1), `speed_feedback` k_R (1), `acceleration_feedback` k_S (s); arrays that
    broadcast. The actuator follows u with a first-order `lag` (s) after a pure `delay` (s).
    A negative acceleration feedback acts as rotor inertia: it resists the rotor's acceleration.
    """

    gain: ArrayLike
    speed_feedback: ArrayLike
    acceleration_feedback: ArrayLike
    lag: ArrayLike = 0.0
    delay: ArrayLike = 0.0


class Loop(NamedTuple):
    """Characteristic function P(s) + Q(s) exp(-s delay) of the closed loop, and what it is made of.

    P = p2 s^2 + p1 s + p0, Q = q1 s + q0, real coefficients of one shape. Broken at the
    controller's output, the open loop is L = Q exp(-s delay) / P.
    """

    p2: np.ndarray
    p1: np.ndarray
    p0: np.ndarray
    q1: np.ndarray
    q0: np.ndarray
    delay: np.ndarray


def source_model(
    rotor_inertia: ArrayLike, shell_inertia: ArrayLike, motor_gain: ArrayLike
) -> ReducedModel:
    """The source's reduction (Herold 1977, Fig. 24 and eq. 108).

    Pistons and rods have no inertia of their own here, and the rotor turns against a shell that
    its own motion does not carry along: inertia I_R, ratio I_R / I_S.
    """
    rotor, shell = np.asarray(rotor_inertia, dtype=float), np.asarray(shell_inertia, dtype=float)
    return ReducedModel(rotor, rotor / shell, motor_gain)


def model_from_full(
    whole: ArrayLike, coupling: ArrayLike, crank: ArrayLike, motor_gain: ArrayLike,
    viscous: ArrayLike = 0.0,
) -> ReducedModel:  # fmt: skip
    """The reduction with exact angular momentum and mean inertias, without mounts.

    `whole` J, `coupling` N and `crank` Q are the means over a turn of M11, M12 and M22 of the
    kinetic energy in shell rate and crank speed. J s + N w is constant, so that s' = -(N/J) w'
    and the torque accelerates Q - N^2/J. Source: derivation in docs/theory_roll_control.md.
    """
    j, n, q = (np.asarray(a, dtype=float) for a in (whole, coupling, crank))
    return ReducedModel(q - n * n / j, n / j, motor_gain, viscous)


def loop_of(model: ReducedModel, controller: Controller) -> Loop:
    """Coefficients of the closed loop for every machine and controller, broadcast together.

    (lag s + 1) (inertia s + b) + K K_M exp(-s delay) (k_R - k_S ratio s), b = K_M + viscous.
    """
    inertia, ratio, motor, viscous, gain, speed, acceleration, lag, delay = np.broadcast_arrays(
        *(np.asarray(a, dtype=float) for a in (*model, *controller))
    )
    drag = motor + viscous
    forward = gain * motor
    return Loop(
        p2=lag * inertia,
        p1=inertia + lag * drag,
        p0=drag,
        q1=-forward * acceleration * ratio,
        q0=forward * speed,
        delay=delay.copy(),
    )


def feedthrough(loop: Loop) -> np.ndarray:
    """Open-loop gain at high frequency, signed: K K_M (-k_S) ratio / inertia; zero with a lag."""
    with np.errstate(divide="ignore", invalid="ignore"):
        level: np.ndarray = np.where(loop.p2 > 0.0, 0.0, loop.q1 / loop.p1)
    return level
