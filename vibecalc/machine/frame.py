"""Directions of a crank train in the body's axes x, y, z."""

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

DIRECTIONS = ("x", "y", "z")


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Right-handed unit vectors (3,): the crank turns right-handed about `axis`.

    `stroke` points up a cylinder at bank angle zero and `across = stroke x axis`, so that a throw
    that has turned by 90 degrees from the stroke points along `-across`.
    """

    axis: NDArray[np.float64]
    stroke: NDArray[np.float64]
    across: NDArray[np.float64]


def unit_vector(name: str) -> NDArray[np.float64]:
    """Unit vector (3,) along the body axis called `x`, `y` or `z`."""
    vector = np.zeros(3)
    vector[DIRECTIONS.index(name)] = 1.0
    return vector


@functools.lru_cache(maxsize=9)
def build_frame(axis: str, stroke: str) -> Frame:
    """Frame of a train from the names of its crankshaft axis and stroke, which differ."""
    along, up = unit_vector(axis), unit_vector(stroke)
    frame = Frame(axis=along, stroke=up, across=np.cross(up, along))
    for vector in (frame.axis, frame.stroke, frame.across):
        vector.flags.writeable = False  # every machine of these directions shares them
    return frame
