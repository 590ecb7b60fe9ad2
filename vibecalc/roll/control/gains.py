"""Gains of the controller: grids of them evaluated in one call, and the best of them found."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.roll.control.loop import (
    Controller,
    LoopHarmonics,
    ReducedModel,
    harmonics,
    loop_of,
    speed_feedback_for,
    steady_speed,
)
from vibecalc.roll.control.margins import Margins, margins

# ----------------------------------------------------------------------------
# Everything about a grid of gains in one call: speed, levels, margins; nothing praised in vain.
# ----------------------------------------------------------------------------

_DECIBEL = 20.0 / np.log(10.0)


class LoopLoad(NamedTuple):
    """What the machine does to its rotor at constant speed, and what it is set to run at.

    `reference` R (rad/s); `mean` d_0 (N m, negative for a machine that takes power);
    `harmonics` (..., orders) complex 0-pk, order 1 first; absolute errors of the two torques.
    """

    reference: ArrayLike
    mean: ArrayLike
    harmonics: ArrayLike
    mean_error: ArrayLike = 0.0
    harmonics_error: ArrayLike = 0.0


class ControlledLoop(NamedTuple):
    """Closed loops (...), orders last where there are any.

    `speed` rad/s (the equilibrium, also of a loop that leaves it); `speed_feedback` (1);
    `harmonics` complex 0-pk and `level` in dB re 1 rad/s^2 0-pk of the shell's acceleration,
    both infinite where the loop is not stable; `command_rate` (rad/s^2): what the actuator has
    to follow at most, the sum of n W |U_n|; `margins` with the flag `stable`.
    """

    speed: Bounded
    speed_feedback: Bounded
    harmonics: LoopHarmonics
    level: Bounded
    command_rate: Bounded
    margins: Margins


def evaluate(model: ReducedModel, controller: Controller, load: LoopLoad) -> ControlledLoop:
    """Behaviour under given feedbacks; all inputs broadcast. Herold 1977, eqs. 98 to 113."""
    return _evaluated(model, controller, load, np.zeros(()))


def evaluate_at_speed(
    model: ReducedModel, controller: Controller, load: LoopLoad, target: ArrayLike
) -> ControlledLoop:
    """The same with the speed feedback that keeps `target` (rad/s); the controller's is ignored.

    The gain must not be zero.
    """
    feedback = speed_feedback_for(model, controller.gain, load.reference, load.mean, target)
    with_feedback = controller._replace(speed_feedback=feedback.value)
    return _evaluated(model, with_feedback, load, feedback.error)


def _evaluated(
    model: ReducedModel, controller: Controller, load: LoopLoad, feedback_error: np.ndarray
) -> ControlledLoop:
    speed = steady_speed(model, controller, load.reference, load.mean)
    motor = np.asarray(model.motor_gain)
    forward = np.abs(np.asarray(controller.gain) * motor)
    under = np.abs(
        motor + model.viscous + np.asarray(controller.gain) * motor * controller.speed_feedback
    )
    extra = (np.asarray(load.mean_error) + forward * np.abs(speed.value) * feedback_error) / under
    speed = Bounded(speed.value, speed.error + extra)
    stability = margins(loop_of(model, controller))
    answer = harmonics(
        model, controller, speed.value, np.asarray(load.harmonics, dtype=complex),
        load.harmonics_error, speed.error,
    )  # fmt: skip
    # what an uncertainty of the feedback does to the response, through the stiffness of the loop
    stiff = np.abs(forward * feedback_error / under)[..., None]
    answer = LoopHarmonics(*(_masked(part, stability.stable, stiff) for part in answer))
    level = decibels(answer.shell_acceleration)
    rate = _rate(answer.command, speed)
    feedback = np.broadcast_to(
        np.asarray(controller.speed_feedback, dtype=float), stability.stable.shape
    )
    return ControlledLoop(
        _full(speed, stability.stable),
        _full(Bounded(feedback, feedback_error), stability.stable),
        answer, level, rate, stability,
    )  # fmt: skip


def _masked(part: Bounded, stable: np.ndarray, stiff: np.ndarray) -> Bounded:
    """An unstable loop has no bound: complex infinity, of which only the modulus means anything."""
    held = stable[..., None]
    value = np.where(held, part.value, complex(np.inf, 0.0))
    error = part.error + stiff * np.abs(part.value)
    return Bounded(value, np.where(held, error, 0.0))


def _full(part: Bounded, like: np.ndarray) -> Bounded:
    return Bounded(np.broadcast_to(part.value, like.shape), np.broadcast_to(part.error, like.shape))


def decibels(amplitude: Bounded) -> Bounded:
    """Level in dB re 1 (0-pk), 20 log10 |X|: infinite for infinite X, minus infinity for zero."""
    size = np.abs(amplitude.value)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = 20.0 * np.log10(size)
        error = _DECIBEL * -np.log1p(-np.minimum(amplitude.error / size, 1.0))
    plain = np.isfinite(level)
    error = np.where(plain, error + 4.0 * UNIT_ROUNDOFF * (np.abs(level) + _DECIBEL), 0.0)
    return Bounded(level, error)


def _rate(command: Bounded, speed: Bounded) -> Bounded:
    size = np.abs(command.value)
    rate = np.arange(1, size.shape[-1] + 1) * np.abs(speed.value)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        value = np.sum(rate * size, axis=-1)
        off = speed.error / np.abs(speed.value) + 8.0 * UNIT_ROUNDOFF
        error = np.sum(rate * command.error, axis=-1) + value * off
    return Bounded(value, np.where(np.isfinite(value), error, 0.0))


# ----------------------------------------------------------------------------
# Another motor and no controller: what its torque per slip does to speed and levels.
# ----------------------------------------------------------------------------

#: the motor fed at constant speed of its field: u = R
UNCONTROLLED = Controller(gain=1.0, speed_feedback=0.0, acceleration_feedback=0.0)


def motor_gain_study(model: ReducedModel, motor_gains: ArrayLike, load: LoopLoad) -> ControlledLoop:
    """Speed and levels for `motor_gains` (m,) in N m s/rad: Herold 1977, Table 8, Fig. 27.

    The speed is R + d_0 / K_M, with R the synchronous speed and d_0 negative. Eq. 114 prints
    203.4 / K_M in place of 303.3 / K_M; the table was computed with the latter. The torque
    d(t) is taken as it is at one speed, though the speed moves a little with the motor.
    """
    return evaluate(model._replace(motor_gain=np.asarray(motor_gains)), UNCONTROLLED, load)


# ----------------------------------------------------------------------------
# Least value over an interval, by grids that close in; for many intervals at once.
# ----------------------------------------------------------------------------

#: points of every grid but the first
FINE = 9


class ZoomedWindow(NamedTuple):
    """Best point, its merit, and the window that is left around it; all (...)."""

    at: np.ndarray
    level: np.ndarray
    low: np.ndarray
    high: np.ndarray


def zoom(
    merit: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray,
    points: int, rounds: int,
) -> ZoomedWindow:  # fmt: skip
    """Least merit on [low, high] (...), all of them at once, by grids around the best point.

    merit takes (..., points). A window keeps the neighbours of its best point, so that a minimum
    on the edge of what is allowed stays inside as one within does. Grids after the first have
    FINE points.
    """
    for _ in range(rounds):
        share = np.linspace(0.0, 1.0, points)
        x = low[..., None] + (high - low)[..., None] * share
        level = merit(x)
        best = np.argmin(level, axis=-1)[..., None]
        least = np.take_along_axis(level, best, axis=-1)[..., 0]
        at = np.take_along_axis(x, best, axis=-1)[..., 0]
        low = np.take_along_axis(x, np.maximum(best - 1, 0), axis=-1)[..., 0]
        high = np.take_along_axis(x, np.minimum(best + 1, points - 1), axis=-1)[..., 0]
        points = FINE
    return ZoomedWindow(at, least, low, high)


# ----------------------------------------------------------------------------
# The gains that calm the shell most, among those that keep their distance from diverging.
# ----------------------------------------------------------------------------

_COARSE, _ROUNDS = 33, 16

#: so many of the first gains are followed for so many rounds, then the best of them alone
_BEST, _TOGETHER = 3, 4
_INNER = 33

#: step in ln K that shows how flat the minimum is
_ASIDE = 1e-3

#: merit of gains that break a bound: above any level, growing with the shortfall
_BROKEN, _DIVERGES = 1e6, 1e9


class Demands(NamedTuple):
    """What the tuned loop must keep: margins at least these, gains inside these bounds.

    `gain_margin` dB, up and down; `phase_margin` rad; `delay_margin` s; zero asks for nothing but
    stability. `gain` K (positive) and `acceleration_feedback` k_S (s): (lower, upper).
    """

    gain: tuple[float, float]
    acceleration_feedback: tuple[float, float]
    gain_margin: float = 0.0
    phase_margin: float = 0.0
    delay_margin: float = 0.0


class TunedGains(NamedTuple):
    """The best gains, with errors from the last bracket and from how flat the minimum is.

    `objective` dB re 1 rad/s^2, its error how much it changes across that bracket: the search is
    local at the end, and samples everywhere at first on a grid only. `controlled`: all of the
    chosen loop; its margins' `bandwidth` and its `command_rate` are what the actuator must bear.
    """

    gain: Bounded
    acceleration_feedback: Bounded
    objective: Bounded
    controlled: ControlledLoop


def objective_of(controlled: ControlledLoop, orders: ArrayLike) -> np.ndarray:
    """Level in dB to be lowered, the largest of `orders`."""
    level = controlled.level.value[..., np.asarray(orders, dtype=int) - 1]
    return np.asarray(np.max(level, axis=-1))


def slacks(controlled: ControlledLoop, demands: Demands) -> np.ndarray:
    """Margins minus demands (..., 3), each over its demand or as it is where none is made.

    Order: gain (dB), phase (rad), delay (s).
    """
    margin = controlled.margins
    with np.errstate(divide="ignore"):
        up = 20.0 * np.log10(margin.gain.value)
        down = -20.0 * np.log10(margin.gain_lower.value)
    have = np.stack([np.minimum(up, down), margin.phase.value, margin.delay.value], axis=-1)
    want = np.array([demands.gain_margin, demands.phase_margin, demands.delay_margin])
    slack: np.ndarray = (have - want) / np.where(want > 0.0, want, 1.0)
    return slack


def tune(
    model: ReducedModel, controller: Controller, load: LoopLoad, target: float, demands: Demands,
    orders: ArrayLike = (1, 2),
) -> TunedGains:  # fmt: skip
    """Lower the level of `orders` over gain and acceleration feedback, the speed kept at `target`.

    `controller` gives lag and delay (scalars). For each gain the best feedback is bracketed, and
    the gain over that: no random numbers, the same answer each time. Raises NumericalFailure if
    no gains within the bounds meet the demands.
    """
    bend = _bend(model, demands)

    def merit(gain: np.ndarray, feedback: np.ndarray) -> np.ndarray:
        tried = controller._replace(gain=gain, acceleration_feedback=feedback)
        found = evaluate_at_speed(model, tried, load, target)
        short = np.maximum(-np.min(slacks(found, demands), axis=-1), 0.0)
        level = np.where(short > 0.0, _BROKEN + short, objective_of(found, orders))
        return np.where(found.margins.stable, level, _DIVERGES)

    low, high = (np.arcsinh(k / bend) for k in demands.acceleration_feedback)

    def best_feedback(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        gain = np.exp(u)[..., None]
        ends = (np.full(u.shape, low), np.full(u.shape, high))
        found = zoom(lambda v: merit(gain, bend * np.sinh(v)), *ends, _INNER, _ROUNDS)
        return found.at, found.level

    first, last = np.log(demands.gain[0]), np.log(demands.gain[1])
    grid = np.linspace(first, last, _COARSE)
    _, level = best_feedback(grid)
    step = (last - first) / (_COARSE - 1)
    starts = grid[np.argsort(level, kind="stable")[:_BEST]]
    near = (np.maximum(starts - step, first), np.minimum(starts + step, last))
    rough = zoom(lambda u: best_feedback(u)[1], *near, FINE, _TOGETHER)
    chosen = int(np.argmin(rough.level))
    window = (rough.low[chosen : chosen + 1], rough.high[chosen : chosen + 1])
    fine = zoom(lambda u: best_feedback(u)[1], *window, FINE, _ROUNDS - _TOGETHER)
    u = float(fine.at[0])
    if fine.level[0] >= _BROKEN:
        bounds = demands.acceleration_feedback
        raise NumericalFailure(
            f"no gain from {demands.gain[0]:g} to {demands.gain[1]:g} with an acceleration "
            f"feedback from {bounds[0]:g} to {bounds[1]:g} s "
            f"meets the margins asked for: ask for less, or widen the bounds"
        )
    v, _ = best_feedback(fine.at)
    gain, feedback = float(np.exp(u)), float(bend * np.sinh(v[0]))
    gain = float(np.clip(gain, *demands.gain))
    feedback = float(np.clip(feedback, *demands.acceleration_feedback))
    final = controller._replace(gain=gain, acceleration_feedback=feedback)
    controlled = evaluate_at_speed(model, final, load, target)
    objective = objective_of(controlled, orders)
    width = (2.0 / (FINE - 1)) ** (_ROUNDS - 1)
    gain_error = gain * step * width
    feedback_error = float(np.hypot(bend, feedback)) * (high - low) * width
    around = _around(merit, gain, feedback, gain_error, feedback_error)
    level_error = float(np.max(controlled.level.error)) + float(np.max(np.abs(around - objective)))
    nearby, at = best_feedback(np.clip(u + _ASIDE * np.array([-1.0, 1.0]), first, last))
    loose, lean = _looseness(nearby, at, float(v[0]), float(objective), level_error)
    gain_error += gain * loose
    feedback_error += float(np.hypot(bend, feedback)) * lean * loose
    return TunedGains(
        Bounded(np.asarray(gain), np.asarray(gain_error)),
        Bounded(np.asarray(feedback), np.asarray(feedback_error)),
        Bounded(objective, np.asarray(level_error)), controlled,
    )  # fmt: skip


def _looseness(
    nearby: np.ndarray, level: np.ndarray, centre: float, least: float, noise: float
) -> tuple[float, float]:
    """How far ln K may be off a flat minimum, and how fast the best feedback moves with ln K.

    From the best levels a step _ASIDE to both sides, of which the smaller rise counts.
    """
    increase = max(float(np.min(level)) - least, noise)
    lean = float(np.max(np.abs(nearby - centre))) / _ASIDE
    return _ASIDE * float(np.sqrt(noise / increase)), lean


def _bend(model: ReducedModel, demands: Demands) -> float:
    """Feedback (s) that doubles the rotor's inertia at the highest gain: finer below it."""
    inertia, ratio = np.max(np.asarray(model.inertia)), np.min(np.asarray(model.ratio))
    return float(inertia / (ratio * np.max(np.asarray(model.motor_gain)) * demands.gain[1]))


def _around(
    merit: Callable[[np.ndarray, np.ndarray], np.ndarray],
    gain: float, feedback: float, gain_error: float, feedback_error: float,
) -> np.ndarray:  # fmt: skip
    """Levels at the corners of the last bracket; those that break a bound do not count."""
    one = np.array([-1.0, 1.0])
    level = merit(gain + gain_error * one[:, None], feedback + feedback_error * one)
    usable: np.ndarray = level[level < _BROKEN]
    return usable if usable.size else merit(np.asarray(gain), np.asarray(feedback))


# ----------------------------------------------------------------------------
# Which bounds hold a tuned loop where it is, and whether anything better lies next to it.
# ----------------------------------------------------------------------------

#: what may bind, in the order of `Certificate.active`
BOUNDS = (
    "gain margin", "phase margin", "delay margin", "least gain", "largest gain",
    "least acceleration feedback", "largest acceleration feedback",
)  # fmt: skip

_STEP = 1e-5
_ACTIVE = 1e-6


class Certificate(NamedTuple):
    """`active` (7,): which of `BOUNDS` bind. `multiplier` (7,): dB that the best level would gain
    for a relative loosening of the bound by one (zero where it does not bind; for a bound on a
    gain: for the logarithm of it). `residual` (1): the part of the slope of the level that no bound
    holds, relative to the whole; near zero at an optimum.
    """

    active: np.ndarray
    multiplier: np.ndarray
    residual: float


def certify(
    model: ReducedModel, controller: Controller, load: LoopLoad, target: float, demands: Demands,
    tuned: TunedGains, orders: ArrayLike = (1, 2),
) -> Certificate:  # fmt: skip
    """First-order conditions at a tuned loop, from central differences in ln K and ln |k_S|.

    A level at its least is a sum of slopes of what binds, none with the wrong sign (Karush, Kuhn
    and Tucker); the signs are found by non-negative least squares.
    """
    order = np.asarray(orders, dtype=int)
    gain, feedback = float(tuned.gain.value), float(tuned.acceleration_feedback.value)
    low, high = demands.acceleration_feedback
    span = abs(feedback) if feedback != 0.0 else 1e-3 * (high - low)
    offset = _STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    tried = controller._replace(
        gain=gain * np.exp(offset[:, 0]), acceleration_feedback=feedback + span * offset[:, 1]
    )
    controlled = evaluate_at_speed(model, tried, load, target)
    slack = slacks(controlled, demands)
    levels = controlled.level.value[:, order - 1]

    room = np.array([
        np.log(gain / demands.gain[0]), np.log(demands.gain[1] / gain),
        (feedback - low) / span, (high - feedback) / span,
    ])  # fmt: skip
    wanted = np.array([demands.gain_margin, demands.phase_margin, demands.delay_margin]) > 0.0
    active = np.concatenate([wanted & (slack[0] <= _ACTIVE), room <= _ACTIVE])
    tied = levels[0] >= np.max(levels[0]) - 1e-5
    margin_slope = _slopes(np.where(np.isfinite(slack), slack, 0.0))
    bound_slope = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    level_slope = _slopes(levels)[tied]
    bounds = np.concatenate([margin_slope, bound_slope])[active]

    scale = float(np.max(np.abs(level_slope))) or 1.0
    columns = np.concatenate([level_slope, -bounds]).T / scale
    heavy = np.concatenate([np.ones(len(level_slope)), np.zeros(len(bounds))]) * 1e3
    weights = nonnegative_least_squares(np.vstack([columns, heavy]), np.array([0.0, 0.0, 1e3]))
    multiplier = np.zeros(len(BOUNDS))
    multiplier[active] = weights[len(level_slope) :]
    return Certificate(active, multiplier, float(np.linalg.norm(columns @ weights)))


def _slopes(value: np.ndarray) -> np.ndarray:
    """Central differences (functions, 2) of rows at centre, +u, -u, +v, -v."""
    slopes: np.ndarray = np.stack([value[1] - value[2], value[3] - value[4]], axis=-1) / (2 * _STEP)
    return slopes
