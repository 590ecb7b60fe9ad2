"""Consecutive points of a grid, in C order, as boxes of the array that holds the grid."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

_CHUNK_ENTRIES = 1 << 14

Box = tuple[tuple[slice, ...], int, int]


def boxes(first: int, last: int, shape: Sequence[int]) -> Iterator[Box]:
    """Cut the points first to last - 1 into boxes, ascending.

    Gives for each its place in the grid, its first point and the one after its last. There are at
    most two for each axis but the first, and one more.
    """
    if first >= last:
        return
    if len(shape) == 1:
        yield (slice(first, last),), first, last
        return
    row = math.prod(shape[1:])
    start = min(last, -(-first // row) * row)
    stop = max(start, last // row * row)
    yield from _within(first, start, shape)
    if stop > start:
        full = (slice(0, size) for size in shape[1:])
        yield (slice(start // row, stop // row), *full), start, stop
    yield from _within(stop, last, shape)


def _within(first: int, last: int, shape: Sequence[int]) -> Iterator[Box]:
    """The same for points that share their place along the first axis."""
    row = math.prod(shape[1:])
    number = first // row
    base = number * row
    for place, start, stop in boxes(first - base, last - base, shape[1:]):
        yield (slice(number, number + 1), *place), start + base, stop + base


def read_points(dataset: Any, first: int, last: int, shape: Sequence[int]) -> np.ndarray:
    """Rows (last - first, own axes...) of a dataset (grid..., own axes...)."""
    own = dataset.shape[len(shape) :]
    rows = np.empty((last - first, *own), dtype=dataset.dtype)
    for place, start, stop in boxes(first, last, shape):
        rows[start - first : stop - first] = dataset[place].reshape(stop - start, *own)
    return rows


def write_points(dataset: Any, values: np.ndarray, first: int, shape: Sequence[int]) -> None:
    """Put rows (n, own axes...) at the points from `first` on."""
    for place, start, stop in boxes(first, first + len(values), shape):
        sizes = [part.stop - part.start for part in place]
        rows = values[start - first : stop - first]
        dataset[place] = rows.reshape(*sizes, *values.shape[1:])


def chunk_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Chunks of consecutive entries in C order, so that consecutive points touch few of them."""
    sizes: list[int] = []
    room = _CHUNK_ENTRIES
    for size in reversed(shape):
        sizes.append(min(size, max(room, 1)))
        room //= size
    return tuple(reversed(sizes))
