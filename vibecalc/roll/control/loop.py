"""Rotor, shell and controller as a linear loop: its reduction, its mean speed, its harmonics."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.excitation.slip_torque import SlipCurve, slip_torque
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.roll.mechanism import WIDEST, RollDrive, RollMachine, motor_torque, smooth_angles
from vibecalc.roll.rates import demand, terms_of_turn

# ----------------------------------------------------------------------------
# The motor's curve as a straight line through the slip at which the machine runs.
# ----------------------------------------------------------------------------

_HALVINGS = 80
_STEPS = 8


class Tangent(NamedTuple):
    """Torque = gain slip + offset near `slip` (rad/s); `gain` N m s/rad, `offset` N m."""

    slip: float
    gain: float
    offset: float


def tangent(machine: RollMachine, drive: RollDrive) -> Tangent:
    """Tangent of the motor's curve of one machine (B = 1) where it meets the mean demand.

    Raises NumericalFailure where the motor never gives what gas and friction ask for.
    """
    need = demand(machine, drive)
    if not need.possible[0]:
        raise NumericalFailure(
            f"control: no running state exists: gas and friction ask for {need.torque[0]:.6g} N*m "
            f"on average, more than the motor gives ({need.breakdown[0]:.6g} N*m at breakdown)"
        )
    sync = float(np.max(drive.synchronous_speed))
    drag = float(machine.friction_damping[0])

    def spare(slip: float) -> float:
        at = motor_torque(machine, drive, np.array([[sync - slip]]))
        return float(at.value[0, 0]) - drag * (sync - slip) - float(need.torque[0])

    slip = _rising_zero(spare, float(need.slip[0]), sync)
    curve = slip_torque(drive.motor, np.array([slip]))
    scale = float(machine.motor_scale[0])
    gain, torque = scale * float(curve.slope[0]), scale * float(curve.value[0])
    if gain <= 0.0:
        raise NumericalFailure(
            f"control: the motor's torque does not rise with the slip at {slip:.6g} rad/s, where "
            "the machine runs: give motor_gain"
        )
    return Tangent(slip, gain, torque - gain * slip)


def straight(gain: float, offset: float = 0.0) -> SlipCurve:
    """The curve of such a line, for any slip."""
    return SlipCurve(np.empty(0), np.zeros(1), np.array([[offset, gain]]), np.inf)


def _rising_zero(spare: Callable[[float], float], near: float, size: float) -> float:
    """Where a function rises through zero, by halving a bracket around a guess."""
    width = 1e-6 * size
    low, high = near - width, near + width
    for _ in range(_STEPS):
        if spare(low) <= 0.0 <= spare(high):
            break
        width *= 10.0
        low, high = near - width, near + width
    else:
        return near
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if spare(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)


# ----------------------------------------------------------------------------
# What gas, inertia and friction do to a rotor at constant speed: the load of the reduced model.
# ----------------------------------------------------------------------------

#: Gauss points on a panel next to those that the highest order needs, and on the finer sampling
_POINTS, _MORE = 10, 4


class Disturbance(NamedTuple):
    """Torque on the rotor of one machine, N m, and what it turns against.

    `mean` d_0 is negative where the machine takes power, without viscous friction; `gas` and
    `inertia` (orders,) are harmonics of order 1 and up, complex 0-pk with t = 0 at crank angle 0,
    the second for a crank speed of 1 rad/s. `whole`, `coupling` and `crank` are the means over the
    turn of J, N and Q, kg m^2.
    """

    mean: Bounded
    gas: Bounded
    inertia: Bounded
    whole: float
    coupling: float
    crank: float

    def at(self, speed: float) -> Bounded:
        """Harmonics (orders,) in N m at a crank speed in rad/s; what rounding leaves is zero."""
        value = self.gas.value + speed**2 * self.inertia.value
        error = self.gas.error + speed**2 * self.inertia.error
        return Bounded(np.where(np.abs(value) > error, value, 0.0), error)


def disturbance(machine: RollMachine, drive: RollDrive, orders: int) -> Disturbance:
    """Load of one machine (B = 1): d(t) = gas and dry friction - Q'(W t) W^2 / 2.

    Source: Herold 1977, section 7.1, the torque f of Fig. 24 at a speed that does not vary; here
    with the exact motion of the pistons. The integrals stop at every node of the gas tables.
    """
    edges = smooth_angles(machine, drive)
    points = _POINTS + int(np.ceil(0.5 * orders * WIDEST))
    sums = []
    for count in (points, points + _MORE):
        terms = terms_of_turn(machine, drive, edges, count)
        weight, moved = terms.weight / TURN, terms.place.moved
        wave = weight * np.exp(-1j * np.arange(orders + 1)[:, None] * terms.angle)
        # Q' / 2, and twice the mean for an amplitude
        signals = (terms.place.load[0], -0.5 * moved.crank_slope[0])
        sums.append([(1.0 + (np.arange(orders + 1) > 0)) * (wave @ one) for one in signals])
    load, inertia = (
        Bounded(fine, np.abs(fine - plain) + 128.0 * EPSILON * float(np.max(np.abs(signal))))
        for plain, fine, signal in zip(*sums, signals, strict=True)
    )
    means = (
        float(np.sum(np.broadcast_to(part, (1, len(weight))) * weight))
        for part in (moved.shell, moved.coupling, moved.crank)
    )
    return Disturbance(load[0].real, load[1:], inertia[1:], *means)


# ----------------------------------------------------------------------------
# Rotor, shell and controller as a linear loop, and the characteristic function of that loop.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# The mean speed that a controller holds, and the speed feedback that holds a wanted one.
# ----------------------------------------------------------------------------


def steady_speed(
    model: ReducedModel, controller: Controller, reference: ArrayLike, mean_torque: ArrayLike
) -> Bounded:
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
    return Bounded(speed, error)


def speed_feedback_for(
    model: ReducedModel, gain: ArrayLike, reference: ArrayLike, mean_torque: ArrayLike,
    target: ArrayLike,
) -> Bounded:  # fmt: skip
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
    return Bounded(np.where(np.abs(value) > error, value, 0.0), error)


# ----------------------------------------------------------------------------
# Steady harmonics of shell, rotor, motor and controller in the closed loop.
# ----------------------------------------------------------------------------


class LoopHarmonics(NamedTuple):
    """Complex amplitudes (..., orders), 0-to-peak, x(t) = Re sum X_n exp(i n W t); orders 1, 2, ...

    `shell_acceleration`, `rotor_acceleration` (rad/s^2), `rotor_speed` (rad/s), `motor_torque`
    (N m, between shell and rotor), `command` (rad/s, what the actuator delivers next to its mean).
    """

    shell_acceleration: Bounded
    rotor_acceleration: Bounded
    rotor_speed: Bounded
    motor_torque: Bounded
    command: Bounded


def harmonics(
    model: ReducedModel, controller: Controller, speed: ArrayLike, disturbance: ArrayLike,
    disturbance_error: ArrayLike = 0.0, speed_error: ArrayLike = 0.0,
) -> LoopHarmonics:  # fmt: skip
    """Response to the disturbance: Herold 1977, eqs. 112 and 113, with phases and any order.

    Parameters
    ----------
    speed : (...) mean speed W in rad/s.
    disturbance : (..., orders) complex torque on the rotor in N m, order 1 first.
    disturbance_error, speed_error : absolute, of the shapes above.

    This is the motion that the equations allow. Whether the loop ever settles to it is another
    question: `vibecalc.roll.control.gains` asks it. Infinite on a pole.
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
    uncertainty = 12.0 * UNIT_ROUNDOFF * size * (1.0 + np.abs(s) * delay) + slope * speed_off
    with np.errstate(divide="ignore", invalid="ignore"):
        rotor = torque / under
        relative = uncertainty / np.abs(under) + 4.0 * UNIT_ROUNDOFF
        rotor_error = np.abs(rotor) * relative + np.asarray(disturbance_error) / np.abs(under)
        drift = speed_off / np.abs(s)
    command = -back / _wide(model.motor_gain)

    def times(factor: np.ndarray, relative: ArrayLike = 0.0) -> Bounded:
        value = factor * rotor
        error = np.abs(factor) * rotor_error + np.abs(value) * (
            8.0 * UNIT_ROUNDOFF + np.asarray(relative)
        )
        return Bounded(value, error)

    turned = np.abs(s) * delay
    loose = 12.0 * UNIT_ROUNDOFF * (1.0 + turned)
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = (np.abs(q1 * s) + np.abs(q0)) / np.maximum(np.abs(q1 * s + q0), 1e-300)
    back_off = loose * gap + drift * (1.0 + turned + gap)
    moved = _wide(model.motor_gain) * (command - 1.0)
    moved_off = (np.abs(back) * back_off) / np.maximum(np.abs(moved), 1e-300)
    return LoopHarmonics(
        times(-_wide(model.ratio) * s, drift), times(s, drift), times(np.ones_like(s)),
        times(moved, moved_off), times(command, back_off),
    )  # fmt: skip


def _wide(value: ArrayLike) -> np.ndarray:
    wide: np.ndarray = np.asarray(value, dtype=float)[..., None]
    return wide
