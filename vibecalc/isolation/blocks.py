"""Many speeds at many orders, taken in blocks that bound the memory."""

from collections.abc import Callable

import numpy as np

#: speeds times orders that are worked on at once: some 60 MB for a rigid body on four mounts
MOST_AT_ONCE = 30_000


def in_blocks(
    function: Callable[[np.ndarray], tuple[np.ndarray, ...]], speed: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The arrays `function` gives for speeds (speeds,), each joined along its first axis."""
    count = -(-len(speed) * len(orders) // MOST_AT_ONCE)
    if count < 2:
        return function(speed)
    parts = [function(part) for part in np.array_split(speed, min(count, len(speed)))]
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))
