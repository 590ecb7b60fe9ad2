"""The pieces of a chunk, whoever computed them and in how many calls, as one block."""

from collections.abc import Sequence

import numpy as np

from vibecalc.results.sweep_layout import NOT_RUN
from vibecalc.study.sweep.block import Block, BlockQuantity, joined_axes, padded
from vibecalc.study.sweep.pool import Done


def block_of(done: Done, keep: Sequence[str]) -> Block:
    """One block of a finished chunk; the same for the same points, however they were cut up."""
    points = np.array(done.work.points, dtype=np.int64)
    status = np.full(points.size, NOT_RUN, dtype=np.int8)
    message = [""] * points.size
    pieces: list[tuple[np.ndarray, Block]] = []
    for piece in sorted(done.pieces, key=lambda piece: piece.points[0]):
        block: Block = piece.block
        rows = block.indices - points[0]
        pieces.append((rows, block))
        status[rows] = block.status
        for row, words in zip(rows, block.message, strict=True):
            message[row] = words
    for lost in done.lost:
        status[lost.point - points[0]] = lost.status
        message[lost.point - points[0]] = lost.message
    quantities: dict[str, BlockQuantity] = {}
    left_out: dict[str, str] = {}
    for path in keep:
        reasons = [block.left_out[path] for _, block in pieces if path in block.left_out]
        found = [
            (rows, block.quantities[path]) for rows, block in pieces if path in block.quantities
        ]
        whole = reasons[0] if reasons else _whole(found, points) if found else None
        if isinstance(whole, str):
            left_out[path] = whole
        elif whole is not None:
            quantities[path] = whole
    return Block(points, status, tuple(message), quantities, left_out)


def _whole(
    pieces: Sequence[tuple[np.ndarray, BlockQuantity]], points: np.ndarray
) -> BlockQuantity | str:
    """One quantity of all pieces; a text says why they cannot be put together."""
    rows, first = pieces[0]
    if len(rows) == len(points):
        return first
    axes = first.axes
    for others, one in pieces:
        joined = joined_axes(axes, one.axes)
        if isinstance(joined, str):
            return f"{joined} (points {points[rows[0]]} and {points[others[0]]})"
        axes = joined
    shape = tuple(len(axis.values) for axis in axes)
    is_complex = any(np.iscomplexobj(one.values) for _, one in pieces)
    values = np.full((points.size, *shape), np.nan, dtype=complex if is_complex else float)
    errors = np.full(points.size, np.nan)
    spread = np.full(points.size, np.nan)
    for others, one in pieces:
        values[others] = padded(one.values, (len(others), *shape))
        values[others[np.isnan(one.errors)]] = np.nan
        errors[others] = one.errors
        if one.standard_errors is not None:
            spread[others] = one.standard_errors
    has_spread = any(one.standard_errors is not None for _, one in pieces)
    return first._replace(
        values=values, errors=errors, standard_errors=spread if has_spread else None, axes=axes
    )
