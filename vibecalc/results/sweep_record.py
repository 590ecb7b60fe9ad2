"""What the file of a sweep says besides its numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.results.record import Result


@dataclass(frozen=True, kw_only=True)
class SweptKey:
    """A key of the case that varies; `choices` are the names its values count from 0."""

    key: str
    label: str
    unit: str
    written_unit: str
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class SweptAxis:
    """One axis of a sweep, with its keys.

    A sampling has one axis, `sample`, with all keys. `read(first, last)` gives one array (last -
    first,) for each key: doubles, whole numbers, or positions in the choices of the key.
    """

    name: str
    count: int
    keys: tuple[SweptKey, ...]
    read: Callable[[int, int], list[np.ndarray]]

    def values(self) -> list[np.ndarray]:
        """All values of each key, choices by their names."""
        return [
            np.array(key.choices)[column] if key.choices else column
            for key, column in zip(self.keys, self.read(0, self.count), strict=True)
        ]


@dataclass(frozen=True, kw_only=True)
class SweepHead:
    """Case, design and provenance of a sweep.

    `result` has the case, plan, warnings and methods, and no quantities; `identity` and `base`
    are the hashes of the sweep and of what its points share; `design` says in plain values how
    the points were chosen; `kept` are the paths asked for.
    """

    result: Result
    axes: tuple[SweptAxis, ...]
    sampling: str
    design: Mapping[str, Any]
    kept: tuple[str, ...]
    identity: str
    base: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return tuple(axis.count for axis in self.axes)
