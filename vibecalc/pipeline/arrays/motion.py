"""Piston motion at many points: as the stage `kinematics`, each number with a leading axis."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.adapter import BEYOND_GUARD, MOST_GUARD_ORDERS, last_order
from vibecalc.kinematics.harmonics import dropped_with_error, harmonics_with_error, pole
from vibecalc.kinematics.truncated_series import (
    RELATIVE_ERROR,
    truncated_dropped_acceleration,
    truncated_harmonics,
)
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.arrays.columns import Columns
from vibecalc.pipeline.arrays.train import Train

#: of the highest order that a search for enough orders tries
_HIGHEST = 1024


class Motion(NamedTuple):
    """Harmonics of s / R (points or 1, h + 1) for orders 0 .. h, as `PistonMotion`.

    `kept` (points or 1,) is the highest order that counts at each point; those above it are guards,
    and all that is dropped weighs `tail` times as much as they do. `lacking` is the acceleration
    that the orders kept leave out, in units of R w^2.
    """

    harmonics: np.ndarray
    error: FloatArray
    kept: IntArray
    tail: FloatArray
    dropped_after_guard: FloatArray
    lacking: WithError


def piston_motion(columns: Columns, train: Train) -> Motion:
    """Motion at all points; points with the same crank and rod share it."""
    ratio, offset = np.broadcast_arrays(
        train.crank_radius / train.rod_length, train.wrist_pin_offset / train.crank_radius
    )
    pairs, back = np.unique(np.stack([ratio, offset]), axis=1, return_inverse=True)
    options = columns.case.kinematics
    if options is not None and options.series == "truncated":
        found = _cut_series(columns, pairs[0], options.terms or 1)
    else:
        found = _exact_series(columns, pairs[0], pairs[1], train.position.shape[1])
    back = back.reshape(-1)
    if len(pairs[0]) == 1:
        return found
    return Motion(
        harmonics=found.harmonics[back],
        error=found.error[back],
        kept=found.kept[back],
        tail=found.tail[back],
        dropped_after_guard=found.dropped_after_guard[back],
        lacking=WithError(found.lacking.value[back], found.lacking.error[back]),
    )


def _exact_series(
    columns: Columns, ratio: FloatArray, offset: FloatArray, cylinders: int
) -> Motion:
    kept = _kept(columns, enough_orders(ratio, columns.case.accuracy.rtol, offset))
    decay = -np.log(pole(ratio, np.abs(offset)).radius)
    guard = np.maximum(np.ceil(-math.log(BEYOND_GUARD) / decay) + 2, 2 * cylinders)
    highest = int(np.max(kept + np.minimum(guard, MOST_GUARD_ORDERS)))
    exact = harmonics_with_error(ratio, highest, offset)
    beyond = dropped_with_error(ratio, highest, offset)
    orders = np.arange(highest + 1)
    above = orders > kept[:, None]
    size = np.where(above, orders**2 * np.abs(exact.values), 0.0)
    dropped = size[:, ::-1].sum(-1) + beyond.value
    doubt = np.where(above, orders**2 * exact.error, 0.0).sum(-1) + beyond.error
    rest = dropped - beyond.value
    tail = np.where(rest > 0.0, dropped / np.where(rest > 0.0, rest, 1.0), 1.0)
    reach = ratio * (1.0 + np.abs(offset))
    slip = EPSILON * (kept + 2.0 + 1.0 / decay) / np.sqrt(1.0 - reach * reach)
    lacking = WithError(dropped, doubt + (3.0 * EPSILON + slip) * dropped)
    error = _with_ratio_error(exact.values, exact.error, ratio)
    return Motion(exact.values, error, kept, tail, beyond.value, lacking)


def _cut_series(columns: Columns, ratio: FloatArray, terms: int) -> Motion:
    last = last_order(columns.case, terms)
    kept = _kept(columns, np.full(ratio.shape, last))
    highest = int(kept[0])
    values = truncated_harmonics(ratio, terms, max(highest, last))
    error = _with_ratio_error(values, RELATIVE_ERROR * np.abs(values), ratio)
    dropped = truncated_dropped_acceleration(ratio, terms, highest)
    relative = EPSILON * (8.0 + 4.0 * terms / (1.0 - ratio * ratio))
    tail = np.full(ratio.shape, 1.0 if values.shape[-1] > highest + 1 else 0.0)
    nothing = np.zeros(ratio.shape)
    return Motion(values, error, kept, tail, nothing, WithError(dropped, relative * dropped))


def enough_orders(ratio: FloatArray, rtol: float, offset: FloatArray) -> IntArray:
    """`kinematics.dropped_orders.order_for_tolerance` of many cranks (n,) at once.

    Raises NumericalFailure where one of them would need more than 1024 orders.
    """
    found = np.zeros(ratio.shape, dtype=np.int64)
    left = np.arange(ratio.size)
    highest = 16
    while left.size and highest <= _HIGHEST:
        some, moved = ratio[left], offset[left]
        size = np.abs(harmonics_with_error(some, highest, moved, derivative=2).values)
        allowed = rtol * size.max(-1)
        dropped = dropped_with_error(some, highest, moved)
        settled = dropped.value + dropped.error <= allowed
        rest = np.cumsum(size[:, :0:-1], axis=-1)[:, ::-1] + dropped.value[:, None]
        rest = np.concatenate([rest, dropped.value[:, None]], axis=-1)
        first = np.argmax(rest <= allowed[:, None], axis=-1)
        found[left[settled]] = first[settled]
        left, highest = left[~settled], highest * 4
    if left.size:
        raise NumericalFailure(f"more than {_HIGHEST} orders are needed")
    return found


def _kept(columns: Columns, enough: IntArray) -> IntArray:
    options = columns.case.excitation
    if options is not None and options.orders is not None:
        return np.full(enough.shape, options.orders)
    shafts = columns.case.machine.crank_train.balance_shafts
    fastest = max([1, *(abs(shaft.speed_ratio) for shaft in shafts)])
    return np.maximum(enough, fastest)


def _with_ratio_error(values: np.ndarray, error: FloatArray, ratio: FloatArray) -> FloatArray:
    steepness = np.arange(values.shape[-1]) / np.sqrt(1.0 - ratio * ratio)[:, None]
    total: FloatArray = error + 0.5 * EPSILON * steepness * np.abs(values)
    return total
