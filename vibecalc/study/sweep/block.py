"""What an evaluator hands back for some consecutive points of a sweep."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.results.record import Axis, Quantity

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
        (n,) int8, see `vibecalc.results.sweep_layout`.
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
    quantities: Mapping[str, BlockQuantity]
    left_out: Mapping[str, str] = {}


def make_block(
    indices: np.ndarray,
    status: Sequence[int] | np.ndarray,
    message: Sequence[str],
    found: Sequence[Mapping[str, Quantity]],
    keep: Sequence[str],
) -> Block:
    """Stack what was found at each point (nothing where it failed) under the paths of `keep`."""
    quantities: dict[str, BlockQuantity] = {}
    left_out: dict[str, str] = {}
    for path in keep:
        stacked = stack([one.get(path) for one in found], [int(index) for index in indices])
        if isinstance(stacked, str):
            left_out[path] = stacked
        elif stacked is not None:
            quantities[path] = stacked
    return Block(
        indices=np.asarray(indices, dtype=np.int64),
        status=np.asarray(status, dtype=np.int8),
        message=tuple(message),
        quantities=quantities,
        left_out=left_out,
    )


def stack(
    quantities: Sequence[Quantity | None], numbers: Sequence[int]
) -> BlockQuantity | str | None:
    """One quantity at several points; a text says why not, None that no point has it."""
    there = [
        (number, one) for number, one in zip(numbers, quantities, strict=True) if one is not None
    ]
    if not there:
        return None
    axes = there[0][1].axes
    for number, one in there:
        if np.asarray(one.values).dtype.kind not in "fciub":
            return "its values are texts"
        joined = joined_axes(axes, one.axes)
        if isinstance(joined, str):
            return f"{joined} (points {there[0][0]} and {number})"
        axes = joined
    first = there[0][1]
    shape = tuple(len(axis.values) for axis in axes)
    is_complex = any(np.iscomplexobj(one.values) for _, one in there)
    values = np.full((len(quantities), *shape), np.nan, dtype=complex if is_complex else float)
    for row, found in enumerate(quantities):
        if found is not None:
            values[row] = padded(np.asarray(found.values), shape)
    errors = [np.nan if one is None else one.error_estimate for one in quantities]
    spread = [one.standard_error if one else None for one in quantities]
    return BlockQuantity(
        values=values,
        errors=np.array(errors, dtype=float),
        standard_errors=(
            np.array([np.nan if one is None else one for one in spread], dtype=float)
            if any(one is not None for one in spread)
            else None
        ),
        axes=axes,
        unit=first.unit,
        long_name=first.long_name,
        amplitude=first.amplitude,
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


def padded(values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """`values` continued with zeros to a shape that is at least as large along every axis."""
    if values.shape == shape:
        return values
    return np.pad(values, [(0, size - old) for size, old in zip(shape, values.shape, strict=True)])
