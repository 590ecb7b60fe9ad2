"""Everything about a grid of gains in one call: speed, levels, margins; nothing praised in vain."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.roll_control.margins import Margins, margins
from vibecalc.response.roll_control.model import Controller, ReducedModel, loop_of
from vibecalc.response.roll_control.response import Harmonics, harmonics
from vibecalc.response.roll_control.steady import speed_feedback_for, steady_speed

_DECIBEL = 20.0 / np.log(10.0)


class Load(NamedTuple):
    """What the machine does to its rotor at constant speed, and what it is told to run at.

    `reference` R (rad/s); `mean` d_0 (N m, negative for a machine that takes power);
    `harmonics` (..., orders) complex 0-pk, order 1 first; absolute errors of the two torques.
    """

    reference: ArrayLike
    mean: ArrayLike
    harmonics: ArrayLike
    mean_error: ArrayLike = 0.0
    harmonics_error: ArrayLike = 0.0


class Controlled(NamedTuple):
    """Closed loops (...), orders last where there are any.

    `speed` rad/s (the equilibrium, also of a loop that leaves it); `speed_feedback` (1);
    `harmonics` complex 0-pk and `level` in dB re 1 rad/s^2 0-pk of the shell's acceleration,
    both infinite where the loop is not stable; `command_rate` (rad/s^2): what the actuator has
    to follow at most, the sum of n W |U_n|; `margins` with the flag `stable`.
    """

    speed: WithError
    speed_feedback: WithError
    harmonics: Harmonics
    level: WithError
    command_rate: WithError
    margins: Margins


def evaluate(model: ReducedModel, controller: Controller, load: Load) -> Controlled:
    """Behaviour under given feedbacks; all inputs broadcast. Herold 1977, eqs. 98 to 113."""
    return _evaluated(model, controller, load, np.zeros(()))


def evaluate_at_speed(
    model: ReducedModel, controller: Controller, load: Load, target: ArrayLike
) -> Controlled:
    """The same with the speed feedback that keeps `target` (rad/s); the controller's is ignored.

    The gain must not be zero.
    """
    feedback = speed_feedback_for(model, controller.gain, load.reference, load.mean, target)
    kept = controller._replace(speed_feedback=feedback.value)
    return _evaluated(model, kept, load, feedback.error)


def _evaluated(
    model: ReducedModel, controller: Controller, load: Load, feedback_error: np.ndarray
) -> Controlled:
    speed = steady_speed(model, controller, load.reference, load.mean)
    motor = np.asarray(model.motor_gain)
    forward = np.abs(np.asarray(controller.gain) * motor)
    under = np.abs(
        motor + model.viscous + np.asarray(controller.gain) * motor * controller.speed_feedback
    )
    extra = (np.asarray(load.mean_error) + forward * np.abs(speed.value) * feedback_error) / under
    speed = WithError(speed.value, speed.error + extra)
    found = margins(loop_of(model, controller))
    answer = harmonics(
        model, controller, speed.value, np.asarray(load.harmonics, dtype=complex),
        load.harmonics_error, speed.error,
    )  # fmt: skip
    # what a doubt of the feedback does to the response, through the stiffness of the loop
    stiff = np.abs(forward * feedback_error / under)[..., None]
    answer = Harmonics(*(_masked(part, found.stable, stiff) for part in answer))
    level = decibels(answer.shell_acceleration)
    rate = _rate(answer.command, speed)
    feedback = np.broadcast_to(
        np.asarray(controller.speed_feedback, dtype=float), found.stable.shape
    )
    return Controlled(
        _full(speed, found.stable), _full(WithError(feedback, feedback_error), found.stable),
        answer, level, rate, found,
    )  # fmt: skip


def _masked(part: WithError, stable: np.ndarray, stiff: np.ndarray) -> WithError:
    """An unstable loop has no bound: complex infinity, of which only the modulus means anything."""
    held = stable[..., None]
    value = np.where(held, part.value, complex(np.inf, 0.0))
    error = part.error + stiff * np.abs(part.value)
    return WithError(value, np.where(held, error, 0.0))


def _full(part: WithError, like: np.ndarray) -> WithError:
    return WithError(
        np.broadcast_to(part.value, like.shape), np.broadcast_to(part.error, like.shape)
    )


def decibels(amplitude: WithError) -> WithError:
    """Level in dB re 1 (0-pk), 20 log10 |X|: infinite for infinite X, minus infinity for zero."""
    size = np.abs(amplitude.value)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = 20.0 * np.log10(size)
        error = _DECIBEL * -np.log1p(-np.minimum(amplitude.error / size, 1.0))
    plain = np.isfinite(level)
    error = np.where(plain, error + 4.0 * UNIT_ROUNDOFF * (np.abs(level) + _DECIBEL), 0.0)
    return WithError(level, error)


def _rate(command: WithError, speed: WithError) -> WithError:
    size = np.abs(command.value)
    rate = np.arange(1, size.shape[-1] + 1) * np.abs(speed.value)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        value = np.sum(rate * size, axis=-1)
        off = speed.error / np.abs(speed.value) + 8.0 * UNIT_ROUNDOFF
        error = np.sum(rate * command.error, axis=-1) + value * off
    return WithError(value, np.where(np.isfinite(value), error, 0.0))
