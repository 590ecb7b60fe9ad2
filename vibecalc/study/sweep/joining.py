"""Two blocks of the same points, from two parts of a sweep, as one."""

from pathlib import Path

import numpy as np

from vibecalc.errors import UsageError
from vibecalc.results.record import Axis
from vibecalc.results.sweep_layout import NOT_RUN, STATUS_WORDS
from vibecalc.study.sweep.block import Block, BlockQuantity, joined_axes, padded


def join(block: Block, other: Block, path: Path) -> Block:
    """Take from `other` the points that `block` does not have.

    UsageError for a point that both have, unless they say the same of it; `path` is the file that
    `other` is from.
    """
    ours, theirs = block.status != NOT_RUN, other.status != NOT_RUN
    both = np.flatnonzero(ours & theirs)
    new = np.flatnonzero(theirs & ~ours)
    for row in both:
        if block.status[row] != other.status[row] or block.message[row] != other.message[row]:
            said = [
                f"{STATUS_WORDS.get(int(one.status[row]), '?')} {one.message[row]}".rstrip()
                for one in (block, other)
            ]
            raise _differ(int(block.indices[row]), path, f"{said[0]!r} and {said[1]!r}")
    quantities: dict[str, BlockQuantity] = {}
    left_out = {**other.left_out, **block.left_out}
    for name in {**block.quantities, **other.quantities}:
        mine, yours = block.quantities.get(name), other.quantities.get(name)
        if mine is None or yours is None:
            # an absent quantity is one that no point of that part has
            there = mine if mine is not None else yours
            assert there is not None
            mine, yours = mine or _nowhere(there), yours or _nowhere(there)
        axes = joined_axes(mine.axes, yours.axes)
        if isinstance(axes, str):
            left_out.setdefault(name, axes)
            continue
        mine, yours = _on(mine, axes), _on(yours, axes)
        wrong = _different(mine, yours, both)
        if wrong.size:
            raise _differ(int(block.indices[wrong[0]]), path, f"different values of {name}")
        quantities[name] = _taken(mine, yours, new)
    message = list(block.message)
    for row in new:
        message[row] = other.message[row]
    return Block(
        indices=block.indices,
        status=np.where(ours, block.status, other.status),
        message=tuple(message),
        quantities=quantities,
        left_out=left_out,
    )


def _differ(point: int, path: Path, what: str) -> UsageError:
    return UsageError(
        f"two parts have point {point} and do not agree on it, {path} and one before it: {what}"
    )


def _nowhere(quantity: BlockQuantity) -> BlockQuantity:
    """The same quantity at points that do not have it."""
    spread = quantity.standard_errors
    return quantity._replace(
        values=np.full_like(quantity.values, np.nan),
        errors=np.full_like(quantity.errors, np.nan),
        standard_errors=None if spread is None else np.full_like(spread, np.nan),
    )


def _on(quantity: BlockQuantity, axes: tuple[Axis, ...]) -> BlockQuantity:
    """The same quantity with longer axes."""
    own = tuple(len(axis.values) for axis in axes)
    values = padded(quantity.values, (len(quantity.values), *own))
    if values is not quantity.values:
        values[np.isnan(quantity.errors)] = np.nan
    return quantity._replace(values=values, axes=axes)


def _different(mine: BlockQuantity, yours: BlockQuantity, rows: np.ndarray) -> np.ndarray:
    """Rows among `rows` that are not the same in both."""
    if not rows.size:
        return rows
    same = np.ones(rows.size, dtype=bool)
    pairs = [(mine.values, yours.values), (mine.errors, yours.errors)]
    if mine.standard_errors is not None and yours.standard_errors is not None:
        pairs.append((mine.standard_errors, yours.standard_errors))
    for one, two in pairs:
        a, b = one[rows], two[rows]
        equal = (a == b) | (np.isnan(a) & np.isnan(b))
        same &= equal.reshape(rows.size, -1).all(axis=1)
    return rows[~same]


def _taken(mine: BlockQuantity, yours: BlockQuantity, rows: np.ndarray) -> BlockQuantity:
    """`mine` with some rows of `yours`."""
    if not rows.size:
        return mine
    values = mine.values.astype(np.result_type(mine.values, yours.values))
    values[rows] = yours.values[rows]
    errors = mine.errors.copy()
    errors[rows] = yours.errors[rows]
    spread, other = mine.standard_errors, yours.standard_errors
    if spread is not None or other is not None:
        empty = np.full(errors.shape, np.nan)
        spread, other = (empty if one is None else one for one in (spread, other))
        spread = spread.copy()
        spread[rows] = other[rows]
    return mine._replace(values=values, errors=errors, standard_errors=spread)
