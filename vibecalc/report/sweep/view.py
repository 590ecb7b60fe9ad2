"""A sweep as the report reads it: its keys in the units of the case, its results at all points."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vibecalc.results.record import Quantity
from vibecalc.results.sweep_layout import DONE

_LOG_RTOL = 1e-6
_DIGITS = 6


class Key(NamedTuple):
    """A key that varies; a value in SI times `factor` is in `unit`, a choice counts `names`."""

    key: str
    words: str
    unit: str
    factor: float
    names: tuple[str, ...]

    def shown(self, value: float) -> str:
        """One value as a reader wants it: `12.5 N/mm`, or the name of a choice."""
        if self.names:
            return self.names[round(float(value))]
        return f"{self.number(value)} {self.unit}".rstrip()

    def number(self, value: float) -> str:
        """The same without its unit."""
        if self.names:
            return self.names[round(float(value))]
        return f"{float(value) * self.factor:.{_DIGITS}g}"

    @property
    def title(self) -> str:
        """Words and unit for the axis of a picture."""
        return f"{self.words} in {self.unit}" if self.unit else self.words


class GridAxis(NamedTuple):
    """One axis of a grid: its keys and their values (n, keys) in SI, or the number of a choice."""

    keys: tuple[Key, ...]
    values: np.ndarray

    @property
    def logarithmic(self) -> bool:
        """Whether its first key goes up, or down, in equal ratios."""
        first = self.values[:, 0]
        if self.keys[0].names or first.size < 3 or np.min(first) <= 0.0:
            return False
        steps = np.diff(np.log(first))
        return bool(np.ptp(steps) <= _LOG_RTOL * abs(steps[0]) and steps[0] != 0.0)


class Stacked(NamedTuple):
    """A result at all points: values (points, own axes), error (points,), perhaps spread."""

    values: np.ndarray
    errors: np.ndarray
    standard_errors: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True)
class SweepView:
    """A sweep. Points are counted in C order; `kept` describes each result without its values.

    `read` gives the values of one path, so that no more than one result is in memory at a time.
    `grid` is empty for a sampling, `drawn` (points, keys) is None for a grid; `together` has the
    places of the keys of each axis. `left_out` says of each path that could not be kept why.
    """

    name: str
    case: Mapping[str, Any]
    sampling: str
    keys: tuple[Key, ...]
    grid: tuple[GridAxis, ...] = ()
    drawn: np.ndarray | None = None
    together: tuple[tuple[int, ...], ...]
    indices: bool = False
    status: np.ndarray
    message: Callable[[int], str]
    kept: Mapping[str, Quantity]
    read: Callable[[str], Stacked]
    facts: Sequence[tuple[str, str]] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of the grid; of a sampling, how many points it has."""
        return tuple(len(axis.values) for axis in self.grid) or (int(self.status.size),)

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    @cached_property
    def done(self) -> np.ndarray:
        """Which points were computed, (points,)."""
        return np.asarray(self.status == DONE)

    @cached_property
    def independent(self) -> np.ndarray:
        """Points that are samples on their own, (points,): for Sobol indices the two halves."""
        if not self.indices:
            return np.ones(self.count, dtype=bool)
        return np.asarray(np.arange(self.count) % (len(self.together) + 2) < 2)

    def values_of(self, points: np.ndarray) -> np.ndarray:
        """What the keys are at some points, (len, keys) in SI."""
        points = np.asarray(points)
        if self.drawn is not None:
            return np.asarray(self.drawn[points])
        places = np.unravel_index(points, self.shape)
        return np.concatenate(
            [axis.values[place] for axis, place in zip(self.grid, places, strict=True)], axis=-1
        )

    def words_of(self, point: int) -> str:
        """One point as a reader wants it: `stiffness = 12.5 N/mm, damping = 50 N*s/m`."""
        row = self.values_of(np.array([point]))[0]
        pairs = zip(self.keys, row, strict=True)
        return ", ".join(f"{key.words} = {key.shown(value)}" for key, value in pairs)
