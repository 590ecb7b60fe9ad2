"""Points of a sweep side by side: what an evaluator hands back for some of them."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.layout import NOT_RUN
from vibecalc.core.results.record import Axis, Quantity

#: axis along which a shorter series is continued with zeros
PADDED = "order"


class BlockQuantity(NamedTuple):
    """One quantity at n points.

    values
        (n, own axes...), real or complex; NaN at points that do not have the quantity.
    errors
        (n,) absolute, in `unit`; NaN at points that do not have the quantity.
    standard_errors
        (n,) in `unit`, of a statistic; None of anything else.
    axes
        Own axes of the quantity, shared by all points.
    """

    values: np.ndarray
    errors: np.ndarray
    standard_errors: np.ndarray | None
    axes: tuple[Axis, ...]
    unit: str
    long_name: str
    amplitude: str | None = None


class Block(NamedTuple):
    """n points of a sweep, in ascending order.

    indices
        (n,) int64, numbers of the points.
    status
        (n,) int8, see `vibecalc.core.results.layout`.
    message
        n texts, empty for points that are done.
    quantities
        By path. A path may be absent if none of the points has it.
    left_out
        Paths that these points have and that cannot be stacked, each with its reason.
    """

    indices: np.ndarray
    status: np.ndarray
    message: tuple[str, ...]
    quantities: Mapping[str, BlockQuantity] = {}
    left_out: Mapping[str, str] = {}


def one_point(
    number: int, status: int, message: str = "", found: Mapping[str, Quantity] | None = None
) -> Block:
    """What became of one point, with the results that were found there."""
    quantities, left_out = {}, {}
    for path, one in (found or {}).items():
        values, spread = np.asarray(one.values), one.standard_error
        if values.dtype.kind not in "fciub":
            left_out[path] = "its values are texts"
            continue
        quantities[path] = BlockQuantity(
            values=values[None],
            errors=np.array([one.error_estimate], dtype=float),
            standard_errors=None if spread is None else np.array([spread], dtype=float),
            axes=one.axes,
            unit=one.unit,
            long_name=one.long_name,
            amplitude=one.amplitude,
        )
    return Block(np.array([number]), np.array([status], np.int8), (message,), quantities, left_out)


def rows_of(block: Block, rows: np.ndarray) -> Block:
    """Some points of a block, by their rows."""
    quantities = {
        path: one._replace(
            values=one.values[rows],
            errors=one.errors[rows],
            standard_errors=None if one.standard_errors is None else one.standard_errors[rows],
        )
        for path, one in block.quantities.items()
    }
    message = tuple(block.message[row] for row in rows)
    return block._replace(
        indices=block.indices[rows],
        status=block.status[rows],
        message=message,
        quantities=quantities,
    )


def combined(blocks: Sequence[Block], numbers: np.ndarray, keep: Sequence[str]) -> Block:
    """The points `numbers` (n,), ascending, of blocks that each have some of them.

    Where two have a point the later one counts; what none has is not run.
    """
    status, message = np.full(len(numbers), NOT_RUN, dtype=np.int8), [""] * len(numbers)
    places = [np.searchsorted(numbers, block.indices) for block in blocks]
    for rows, block in zip(places, blocks, strict=True):
        status[rows] = block.status
        for row, words in zip(rows.tolist(), block.message, strict=True):
            message[row] = words
    quantities: dict[str, BlockQuantity] = {}
    left_out: dict[str, str] = {}
    for path in keep:
        reason = next((one.left_out[path] for one in blocks if path in one.left_out), None)
        pieces = [
            (rows, block.quantities[path])
            for rows, block in zip(places, blocks, strict=True)
            if path in block.quantities
        ]
        whole = reason or (_laid_out(pieces, numbers) if pieces else None)
        if isinstance(whole, str):
            left_out[path] = whole
        elif whole is not None:
            quantities[path] = whole
    return Block(np.asarray(numbers, np.int64), status, tuple(message), quantities, left_out)


def _laid_out(
    pieces: Sequence[tuple[np.ndarray, BlockQuantity]], numbers: np.ndarray
) -> BlockQuantity | str:
    """One quantity at the points `numbers` (n,), NaN where no piece has it.

    A piece is the rows of its points among the n, and what it has there. A text says why they
    cannot be put together.
    """
    rows, first = pieces[0]
    if len(pieces) == 1 and len(rows) == len(numbers):
        return first
    axes = first.axes
    for others, one in pieces:
        joined = joined_axes(axes, one.axes)
        if isinstance(joined, str):
            return f"{joined} (points {numbers[rows[0]]} and {numbers[others[0]]})"
        axes = joined
    shape = tuple(len(axis.values) for axis in axes)
    dtype = np.result_type(float, *{one.values.dtype for _, one in pieces})
    values = np.full((len(numbers), *shape), np.nan, dtype=dtype)
    errors, spread = np.full(len(numbers), np.nan), np.full(len(numbers), np.nan)
    for others, one in pieces:
        values[others] = padded(one, shape)
        errors[others] = one.errors
        if one.standard_errors is not None:
            spread[others] = one.standard_errors
    has_spread = any(one.standard_errors is not None for _, one in pieces)
    return first._replace(
        values=values, errors=errors, standard_errors=spread if has_spread else None, axes=axes
    )


def joined_axes(axes: tuple[Axis, ...], others: tuple[Axis, ...]) -> tuple[Axis, ...] | str:
    """Axes that hold both, or in words why there are none.

    Axes have to be equal, except that one of two axes `order` may go on where the other ends.
    """
    if [axis.name for axis in axes] != [axis.name for axis in others]:
        return "its axes are not the same at all points"
    joined = []
    for axis, other in zip(axes, others, strict=True):
        shared = min(len(axis.values), len(other.values))
        may_go_on = axis.name == PADDED or len(axis.values) == len(other.values)
        if not (may_go_on and np.array_equal(axis.values[:shared], other.values[:shared])):
            return f"its axis {axis.name} is not the same at all points"
        joined.append(axis if len(axis.values) >= len(other.values) else other)
    return tuple(joined)


def padded(quantity: BlockQuantity, shape: tuple[int, ...]) -> np.ndarray:
    """Values (n, *shape), at least as large along every axis: continued with zeros.

    Points without the quantity stay NaN.
    """
    values = quantity.values
    if values.shape[1:] == shape:
        return values
    more = [size - old for size, old in zip(shape, values.shape[1:], strict=True)]
    values = np.pad(values, [(0, 0), *((0, one) for one in more)])
    values[np.isnan(quantity.errors)] = np.nan
    return values
