"""The gains that calm the shell most, among those that keep their distance from diverging."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.response.roll_control.evaluate import Controlled, Load, evaluate_at_speed
from vibecalc.response.roll_control.model import Controller, ReducedModel
from vibecalc.response.roll_control.zoom import FINE, zoom

_COARSE, _ROUNDS = 33, 16

#: so many of the first gains are followed for so many rounds, then the best of them alone
_KEPT, _TOGETHER = 3, 4
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


class Tuned(NamedTuple):
    """The best gains, with errors from the last bracket and from how flat the minimum is.

    `objective` dB re 1 rad/s^2, its error how much it changes across that bracket: the search is
    local at the end, and looks everywhere at first on a grid only. `controlled`: all of the
    chosen loop; its margins' `bandwidth` and its `command_rate` are what the actuator must bear.
    `evaluations`: how many loops were looked at.
    """

    gain: WithError
    acceleration_feedback: WithError
    objective: WithError
    controlled: Controlled
    evaluations: int


def objective_of(controlled: Controlled, orders: ArrayLike, weight: str) -> np.ndarray:
    """Level in dB to be lowered: of the "largest" of `orders`, or of their "energy" together."""
    level = controlled.level.value[..., np.asarray(orders, dtype=int) - 1]
    if weight == "largest":
        largest: np.ndarray = np.max(level, axis=-1)
        return largest
    with np.errstate(divide="ignore"):
        energy: np.ndarray = 10.0 * np.log10(np.sum(10.0 ** (level / 10.0), axis=-1))
    return energy


def slacks(controlled: Controlled, demands: Demands) -> np.ndarray:
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
    model: ReducedModel, controller: Controller, load: Load, target: float, demands: Demands,
    orders: ArrayLike = (1, 2), weight: str = "largest",
) -> Tuned:  # fmt: skip
    """Lower the level of `orders` over gain and acceleration feedback, the speed kept at `target`.

    `controller` gives lag and delay (scalars). For each gain the best feedback is bracketed, and
    the gain over that: no random numbers, the same answer each time. Raises NumericalFailure if
    no gains within the bounds meet the demands.
    """
    bend = _bend(model, demands)
    count = [0]

    def merit(gain: np.ndarray, feedback: np.ndarray) -> np.ndarray:
        tried = controller._replace(gain=gain, acceleration_feedback=feedback)
        found = evaluate_at_speed(model, tried, load, target)
        count[0] += found.margins.stable.size
        short = np.maximum(-np.min(slacks(found, demands), axis=-1), 0.0)
        level = np.where(short > 0.0, _BROKEN + short, objective_of(found, orders, weight))
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
    starts = grid[np.argsort(level, kind="stable")[:_KEPT]]
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
    objective = objective_of(controlled, orders, weight)
    width = (2.0 / (FINE - 1)) ** (_ROUNDS - 1)
    gain_error = gain * step * width
    feedback_error = float(np.hypot(bend, feedback)) * (high - low) * width
    around = _around(merit, gain, feedback, gain_error, feedback_error)
    level_error = float(np.max(controlled.level.error)) + float(np.max(np.abs(around - objective)))
    beside, at = best_feedback(np.clip(u + _ASIDE * np.array([-1.0, 1.0]), first, last))
    loose, lean = _looseness(beside, at, float(v[0]), float(objective), level_error)
    gain_error += gain * loose
    feedback_error += float(np.hypot(bend, feedback)) * lean * loose
    return Tuned(
        WithError(np.asarray(gain), np.asarray(gain_error)),
        WithError(np.asarray(feedback), np.asarray(feedback_error)),
        WithError(objective, np.asarray(level_error)), controlled, count[0],
    )  # fmt: skip


def _looseness(
    beside: np.ndarray, level: np.ndarray, centre: float, least: float, noise: float
) -> tuple[float, float]:
    """How far ln K may be off a flat minimum, and how fast the best feedback moves with ln K.

    From the best levels a step _ASIDE to both sides, of which the smaller rise counts.
    """
    rise = max(float(np.min(level)) - least, noise)
    lean = float(np.max(np.abs(beside - centre))) / _ASIDE
    return _ASIDE * float(np.sqrt(noise / rise)), lean


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
    kept: np.ndarray = level[level < _BROKEN]
    return kept if kept.size else merit(np.asarray(gain), np.asarray(feedback))
