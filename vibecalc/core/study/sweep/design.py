"""Which points a sweep has: its axes, and each point from its number alone."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.core.case.study_tables import Along, Axis, Sweep
from vibecalc.core.results.catalogue import AXES
from vibecalc.core.study.sweep.keys import AxisKey, read_key, refused
from vibecalc.core.study.sweep.sampling import MOST_POINTS, drawn, drawn_by
from vibecalc.errors import CaseError, KeyPath, Problem, dotted

# ----------------------------------------------------------------------------
# The axes of a sweep: one key each, or several that take their values in step.
# ----------------------------------------------------------------------------

_TAKEN = {*AXES, "sample", "key"}


@dataclass(frozen=True, kw_only=True)
class SweepAxis:
    """One axis of a sweep with its k keys; `name` is short and unlike any axis of a result."""

    name: str
    keys: tuple[AxisKey, ...]

    @property
    def count(self) -> int | None:
        """Points along the axis; None if it is only drawn from."""
        return self.keys[0].values.count

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values (len, k) in SI at positions along the axis; a choice is counted from 0."""
        return np.stack([key.values.at(positions) for key in self.keys], axis=1)

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Values (len, k) at shares in (0, 1) of the axis; all keys take the same share."""
        return np.stack([key.values.drawn(shares) for key in self.keys], axis=1)


def _axes_of(sweep: Sweep, resolved: Mapping[str, Any]) -> tuple[SweepAxis, ...]:
    """The axes of `[sweep]` for a case in SI; CaseError with all problems found."""
    problems: list[Problem] = []
    places: dict[KeyPath, KeyPath] = {}  # of the keys so far
    axes: list[list[AxisKey]] = []
    for n, axis in enumerate(sweep.axes):
        path: KeyPath = ("sweep", "axes", n)
        tables: list[tuple[Along, KeyPath]] = [(axis, path)]
        tables += [(one, (*path, "in_step", index)) for index, one in enumerate(axis.together)]
        points = axis.points if axis.points is not None else len(axis.values) or None
        keys: list[AxisKey] = []
        for table, place in tables:
            try:
                key = read_key(table, place, resolved, sweep.sampling != "grid", points)
                _refuse_twice(key, places)
                places[key.path] = place
                points = key.values.count if table is axis else points
                _refuse_unequal(key, axis, points)
                keys.append(key)
            except CaseError as error:
                problems += error.problems
        if len(keys) == len(tables):
            problems += _same_points(axis, keys, path)
        axes.append(keys)
    if problems:
        raise CaseError(problems)
    return _named(axes)


def _refuse_twice(key: AxisKey, places: Mapping[KeyPath, KeyPath]) -> None:
    for other, at in places.items():
        size = min(len(key.path), len(other))
        if key.path[:size] == other[:size]:
            first, second = sorted((key.path, other), key=len)
            whole = f", which is in {dotted(first)}" if first != second else ""
            message = f"two axes vary {dotted(second)}{whole}"
            raise refused((*key.place, "key"), message, also=(*at, "key"))


def _refuse_unequal(key: AxisKey, axis: Axis, points: int | None) -> None:
    count = key.values.count
    if None not in (count, points) and count != points:
        raise refused(
            (*key.place, "key"),
            "keys that vary together need equally many values",
            found=f"{count} for {key.key}, {points} for {axis.key}",
            also=(*key.place[:3], "key"),
        )


def _same_points(axis: Axis, keys: Sequence[AxisKey], path: KeyPath) -> list[Problem]:
    """A problem if two points of the axis are the same; only lists can repeat themselves."""
    lists = [key.values.described.get("values") for key in keys]
    seen: dict[str, int] = {}
    for position, each in enumerate(zip(*lists, strict=True) if None not in lists else ()):
        first = seen.setdefault(repr(each), position)
        if first != position:
            found = f"{axis.values[position]} as number {first + 1} and number {position + 1}"
            message = "two points of an axis are the same"
            return [Problem(path=(*path, "values"), message=message, found=found)]
    return []


def _named(axes: Sequence[Sequence[AxisKey]]) -> tuple[SweepAxis, ...]:
    """Name each axis by the shortest end of its first key that nothing else is called."""
    parts = [keys[0].key.split(".") for keys in axes]
    endings = [[".".join(one[k:]) for k in reversed(range(len(one)))] for one in parts]
    named = []
    for mine, (keys, ends) in enumerate(zip(axes, endings, strict=True)):
        others = {end for n, ends_of in enumerate(endings) if n != mine for end in ends_of}
        free = [end for end in ends if end not in others and end not in _TAKEN]
        named.append(SweepAxis(name=(free or ends[-1:])[0], keys=tuple(keys)))
    return tuple(named)


# ----------------------------------------------------------------------------
# Which points a sweep has, each from its number alone: nothing is stored for them.
#
# A grid has the points of its axes in C order, the last axis varies fastest. A sampling has its
# points in the order of its sequence. With Sobol indices a sampling of two halves, A and B, gives
# k + 2 runs in a row for each of its points: A, B, and A with axis j taken from B for j = 1 to k
# (Saltelli et al. 2010, Computer Physics Communications 181).
# ----------------------------------------------------------------------------

LARGEST = 1_000_000_000
STANDARD_POINTS = 1024
STANDARD_SEED = 1


@dataclass(frozen=True, kw_only=True)
class Design:
    """The points of a sweep; `points` are those of a sampling before k + 2 runs come of each."""

    axes: tuple[SweepAxis, ...]
    sampling: str = "grid"
    points: int = 0
    seed: int = STANDARD_SEED
    indices: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis of the results: of the grid, or the number of runs."""
        if self.sampling == "grid":
            return tuple(axis.count or 0 for axis in self.axes)
        return (self.points * (len(self.axes) + 2) if self.indices else self.points,)

    @property
    def count(self) -> int:
        """Number of runs."""
        return math.prod(self.shape)

    @property
    def every(self) -> tuple[AxisKey, ...]:
        """All keys that vary, axis by axis."""
        return tuple(key for axis in self.axes for key in axis.keys)

    @property
    def keys(self) -> tuple[str, ...]:
        """The same as a case names them."""
        return tuple(key.key for key in self.every)

    def value_of(self, numbers: np.ndarray) -> np.ndarray:
        """Values (len, keys) in SI at point numbers (len,); a choice is counted from 0.

        IndexError for a number that the design does not have.
        """
        numbers = np.asarray(numbers, dtype=np.int64)
        if numbers.size and not 0 <= numbers.min() <= numbers.max() < self.count:
            raise IndexError(f"the sweep has the points 0 to {self.count - 1}")
        if self.sampling == "grid":
            places = np.unravel_index(numbers, self.shape)
            parts = [axis.at(place) for axis, place in zip(self.axes, places, strict=True)]
        else:
            shares = self._shares(numbers)
            parts = [axis.drawn(shares[:, column]) for column, axis in enumerate(self.axes)]
        return np.concatenate(parts, axis=1)

    def settings_of(self, numbers: np.ndarray) -> list[dict[str, Any]]:
        """What each point sets by key: values in SI, names of choices, lists or tables."""
        values = self.value_of(numbers)
        columns = [key.typed(values[:, place]) for place, key in enumerate(self.every)]
        return [dict(zip(self.keys, row, strict=True)) for row in zip(*columns, strict=True)]

    def settings(self, number: int) -> dict[str, Any]:
        """What one point sets."""
        return self.settings_of(np.array([number]))[0]

    def description(self) -> dict[str, Any]:
        """The design as plain values, for hashes and result files."""
        drawing: dict[str, Any] = {}
        if self.sampling != "grid":
            drawing = {"points": self.points, "seed": self.seed, "drawn_by": drawn_by()}
        return {
            "sampling": self.sampling,
            **drawing,
            "indices": self.indices,
            "axes": [
                [{"key": key.key, **key.values.described} for key in axis.keys]
                for axis in self.axes
            ],
        }

    def _shares(self, numbers: np.ndarray) -> np.ndarray:
        size = len(self.axes)
        if not self.indices:
            return drawn(self.sampling, numbers, size, self.points, self.seed)
        base, role = np.divmod(numbers, size + 2)  # 0 for A, 1 for B, 1 + j
        both = drawn(self.sampling, base, 2 * size, self.points, self.seed)
        from_b = (role[:, None] == 1) | (role[:, None] == np.arange(size) + 2)
        return np.where(from_b, both[:, size:], both[:, :size])


def make_design(sweep: Sweep, resolved: Mapping[str, Any]) -> Design:
    """Read `[sweep]` for a case in SI with its defaults; CaseError with all problems found."""
    if not sweep.axes:
        raise refused(
            ("sweep",),
            "a sweep needs at least one axis",
            allowed='axes = [{ key = "machine.speed", from = ..., to = ..., points = 21 }]',
        )
    design = Design(
        axes=_axes_of(sweep, resolved),
        sampling=sweep.sampling,
        points=STANDARD_POINTS if sweep.points is None else sweep.points,
        seed=STANDARD_SEED if sweep.seed is None else sweep.seed,
        indices=sweep.indices,
    )
    most = min(LARGEST, MOST_POINTS.get(design.sampling, LARGEST))
    if design.count > most:
        key, factors = "axes", " x ".join(map(str, design.shape))
        if design.sampling != "grid":
            runs = f" x {len(design.axes) + 2} runs" if design.indices else ""
            key, factors = "points", f"{design.points}{runs}"
        raise refused(
            ("sweep", key),
            f"the sweep would have {design.count:.6g} points",
            found=factors,
            allowed=f"at most {most:.6g}",
            hint="fewer points on an axis, or a sampling",
        )
    return design
