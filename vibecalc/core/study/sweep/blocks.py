"""Points of a sweep side by side: what an evaluator hands back for some of them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.layout import NOT_RUN
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.sweep_file import columns_of

#: axis along which a shorter series is continued with zeros
PADDED = "order"


class Block(NamedTuple):
    """n points of a sweep, in ascending order.

    indices
        (n,) int64, numbers of the points.
    status
        (n,) int8, see `vibecalc.core.results.layout`.
    message
        n texts, empty for points that are done.
    columns
        (n, own axes...) by the names of the file of a sweep: the path of a quantity, and (n,) for
        its errors and, of a statistic, its standard errors. NaN at points that do not have it.
    described
        Each quantity as one of the points has it, by path: unit, name and axes count.
    left_out
        Paths that these points have and that cannot be stacked, each with its reason.
    """

    indices: np.ndarray
    status: np.ndarray
    message: tuple[str, ...]
    columns: Mapping[str, np.ndarray] = {}
    described: Mapping[str, Quantity] = {}
    left_out: Mapping[str, str] = {}


def one_point(
    number: int, status: int, message: str = "", found: Mapping[str, Quantity] | None = None
) -> Block:
    """What became of one point, with the results that were found there."""
    columns, described, left_out = dict[str, np.ndarray](), dict[str, Quantity](), {}
    for path, one in (found or {}).items():
        if one.values.dtype.kind not in "fciub":
            left_out[path] = "its values are texts"
            continue
        described[path] = one
        each = one.values, one.error_estimate, one.standard_error
        for name, value in zip(columns_of(path), each, strict=True):
            if value is not None:
                columns[name] = np.array([value])
    return Block(
        np.array([number]), np.array([status], np.int8), (message,), columns, described, left_out
    )


def combined(blocks: Sequence[Block], numbers: np.ndarray, keep: Sequence[str]) -> Block:
    """The points `numbers` (n,), ascending, of blocks that each have some of them.

    Where two have a point the later one counts; what none has is not run.
    """
    if len(blocks) == 1 and len(blocks[0].indices) == len(numbers):
        return blocks[0]
    status, message = np.full(len(numbers), NOT_RUN, dtype=np.int8), [""] * len(numbers)
    columns = dict[str, np.ndarray]()
    described, left_out = joined(blocks, keep)
    for block in blocks:
        rows = np.searchsorted(numbers, block.indices)
        status[rows] = block.status
        for row, words in zip(rows.tolist(), block.message, strict=True):
            message[row] = words
        for name, values in stacked(block, described).items():
            if name not in columns:
                columns[name] = np.full((len(numbers), *values.shape[1:]), np.nan, values.dtype)
            columns[name][rows] = values
    return Block(
        np.asarray(numbers, np.int64), status, tuple(message), columns, described, left_out
    )


def joined(
    blocks: Iterable[Block], keep: Sequence[str]
) -> tuple[dict[str, Quantity], dict[str, str]]:
    """What each path of `keep` is in all blocks together, and why others cannot be stacked."""
    described, left_out = dict[str, Quantity](), dict[str, str]()
    for block in blocks:
        left_out = {**block.left_out, **left_out}
        for path, one in block.described.items():
            known = described.setdefault(path, one)
            axes = joined_axes(known.axes, one.axes)
            if isinstance(axes, str):
                left_out.setdefault(path, axes)
                continue
            kind = np.result_type(float, known.values, block.columns[path])
            longer = any(axis is not old for axis, old in zip(axes, known.axes, strict=True))
            if longer or kind != known.values.dtype:
                described[path] = replace(known, axes=axes, values=np.empty(0, kind))
    found = {path: described[path] for path in keep if path in described and path not in left_out}
    return found, {path: left_out[path] for path in keep if path in left_out}


def joined_axes(axes: tuple[Axis, ...], others: tuple[Axis, ...]) -> tuple[Axis, ...] | str:
    """Axes that hold both, or in words why there are none.

    Axes have to be equal, except that one of two axes `order` may go on where the other ends.
    """
    if axes is others:
        return axes
    if [axis.name for axis in axes] != [axis.name for axis in others]:
        return "its axes are not the same at all points"
    longer = []
    for axis, other in zip(axes, others, strict=True):
        shared = min(len(axis.values), len(other.values))
        may_go_on = axis.name == PADDED or len(axis.values) == len(other.values)
        if not (may_go_on and np.array_equal(axis.values[:shared], other.values[:shared])):
            return f"its axis {axis.name} is not the same at all points"
        longer.append(axis if len(axis.values) >= len(other.values) else other)
    return tuple(longer)


def stacked(block: Block, described: Mapping[str, Quantity]) -> dict[str, np.ndarray]:
    """The columns of a block as large along every axis as described: continued with zeros.

    Points without the quantity stay NaN.
    """
    columns = dict[str, np.ndarray]()
    for path, whole in described.items():
        for name in columns_of(path):
            if name not in block.columns:
                continue
            values, shape = block.columns[name], tuple(len(axis.values) for axis in whole.axes)
            if name == path:
                values = values.astype(whole.values.dtype, copy=False)
                if values.shape[1:] != shape:
                    more = np.subtract(shape, values.shape[1:])
                    values = np.pad(values, [(0, 0), *((0, one) for one in more)])
                    values[np.isnan(block.columns[columns_of(path)[1]])] = np.nan
            columns[name] = values
    return columns
