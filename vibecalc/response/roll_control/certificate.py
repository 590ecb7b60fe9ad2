"""Which bounds hold a tuned loop where it is, and whether anything better lies next to it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.nonnegative import nonnegative_least_squares
from vibecalc.response.roll_control.evaluate import Load, evaluate_at_speed
from vibecalc.response.roll_control.model import Controller, ReducedModel
from vibecalc.response.roll_control.tune import Demands, Tuned, objective_of, slacks

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
    gain: for the logarithm of it). `share` (orders,): weight of each order, 1 in sum; more than
    one is positive where the minimum is a tie. `residual` (1): the part of the slope of the level
    that no bound holds, relative to the whole; near zero at an optimum.
    """

    active: np.ndarray
    multiplier: np.ndarray
    share: np.ndarray
    residual: float


def certify(
    model: ReducedModel, controller: Controller, load: Load, target: float, demands: Demands,
    tuned: Tuned, orders: ArrayLike = (1, 2), weight: str = "largest",
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
    found = evaluate_at_speed(model, tried, load, target)
    slack = slacks(found, demands)
    pieces = found.level.value[:, order - 1]
    if weight != "largest":
        pieces = objective_of(found, order, weight)[:, None]

    room = np.array([
        np.log(gain / demands.gain[0]), np.log(demands.gain[1] / gain),
        (feedback - low) / span, (high - feedback) / span,
    ])  # fmt: skip
    wanted = np.array([demands.gain_margin, demands.phase_margin, demands.delay_margin]) > 0.0
    active = np.concatenate([wanted & (slack[0] <= _ACTIVE), room <= _ACTIVE])
    tied = pieces[0] >= np.max(pieces[0]) - 1e-5
    margin_slope = _slopes(np.where(np.isfinite(slack), slack, 0.0))
    bound_slope = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    level_slope = _slopes(pieces)[tied]
    bounds = np.concatenate([margin_slope, bound_slope])[active]

    scale = float(np.max(np.abs(level_slope))) or 1.0
    columns = np.concatenate([level_slope, -bounds]).T / scale
    heavy = np.concatenate([np.ones(len(level_slope)), np.zeros(len(bounds))]) * 1e3
    weights = nonnegative_least_squares(np.vstack([columns, heavy]), np.array([0.0, 0.0, 1e3]))
    share, multiplier = np.zeros(pieces.shape[1]), np.zeros(len(BOUNDS))
    share[tied] = weights[: len(level_slope)]
    multiplier[active] = weights[len(level_slope) :]
    return Certificate(active, multiplier, share, float(np.linalg.norm(columns @ weights)))


def _slopes(value: np.ndarray) -> np.ndarray:
    """Central differences (functions, 2) of rows at centre, +u, -u, +v, -v."""
    slopes: np.ndarray = np.stack([value[1] - value[2], value[3] - value[4]], axis=-1) / (2 * _STEP)
    return slopes
