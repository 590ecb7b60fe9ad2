"""Which points a sweep has: its axes, and each point from its number alone."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.core.case.study_tables import Along, Axis, Sweep
from vibecalc.core.case.walk import Shape
from vibecalc.core.results.catalogue import AXES
from vibecalc.core.results.sweep_file import SweptKey
from vibecalc.core.study.sweep.keys import KeyTable, label, read_values, refused, target
from vibecalc.core.study.sweep.sampling import MOST_POINTS, drawn, drawn_by
from vibecalc.core.study.sweep.values import AxisValues, ValueList
from vibecalc.errors import CaseError, KeyPath, Problem, UsageError, dotted
from vibecalc.units import split_number

# ----------------------------------------------------------------------------
# The axes of a sweep: one key each, or several that take their values in step.
# ----------------------------------------------------------------------------

_TAKEN = {*AXES, "sample", "key"}


@dataclass(frozen=True, kw_only=True)
class AxisKey(SweptKey):
    """A key that varies: taken apart, with what it may hold, its values, and its table's place."""

    path: KeyPath
    shape: Shape
    values: AxisValues
    place: KeyPath

    def typed(self, column: np.ndarray) -> np.ndarray:
        """Values as a case has them: doubles, whole numbers, names, lists or tables."""
        whole = column.astype(np.int64)
        if self.values.contents:
            objects = np.empty(len(column), dtype=object)
            for row, place in enumerate(whole.tolist()):
                objects[row] = self.values.contents[place]
            return objects
        if self.choices:
            return np.array(self.choices)[whole]
        return whole if self.shape.kind == "whole" else column


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


class _Reader:
    """Reads the axes of `[sweep]` for a case in SI, and gathers what is wrong with them."""

    def __init__(self, sweep: Sweep, resolved: Mapping[str, Any]):
        self.sampled, self.resolved = sweep.sampling != "grid", resolved
        self.problems: list[Problem] = []
        self.seen: dict[KeyPath, KeyPath] = {}
        found = [self.axis(one, ("sweep", "axes", n)) for n, one in enumerate(sweep.axes)]
        self.axes = _named([keys for keys in found if keys])

    def axis(self, table: Axis, path: KeyPath) -> tuple[AxisKey, ...]:
        """The keys of an axis; none if it has problems."""
        keys: list[AxisKey] = []
        tables: list[tuple[Along, KeyPath]] = [(table, path)]
        tables += [(one, (*path, "with", index)) for index, one in enumerate(table.together)]
        points = table.points if table.points is not None else len(table.values) or None
        before = len(self.problems)
        for one, place in tables:
            try:
                key = self.key(one, place, points)
            except CaseError as error:
                self.problems += error.problems
                continue
            count = key.values.count
            if one is table:
                points = count
            elif count is not None and points is not None and count != points:
                self.problems += refused(
                    (*place, "key"),
                    "keys that vary together need equally many values",
                    found=f"{count} for {one.key}, {points} for {table.key}",
                    also=(*path, "key"),
                ).problems
            keys.append(key)
        if len(self.problems) == before:
            self.check_points_differ(table, keys, path)
        return tuple(keys) if len(self.problems) == before else ()

    def key(self, table: Along, place: KeyPath, points: int | None) -> AxisKey:
        """One key with its values; CaseError for what is wrong with it."""
        try:
            path, shape = target(table.key, self.resolved)
        except UsageError as error:
            raise refused(
                (*place, "key"),
                "a sweep cannot vary this key",
                found=table.key[:80],
                allowed="a number or a choice of this case, as in machine.mounts.each.stiffness",
                hint=str(error),
            ) from error
        for other, at in self.seen.items():
            size = min(len(path), len(other))
            if path[:size] == other[:size]:
                first, second = sorted((path, other), key=len)
                whole = f", which is in {dotted(first)}" if path != other else ""
                message = f"two axes vary {dotted(second)}{whole}"
                raise CaseError([Problem(path=(*place, "key"), message=message, also=(*at, "key"))])
        self.seen[path] = place
        read = KeyTable(table, place, path, shape)
        values = read_values(read, self.sampled, points)
        return AxisKey(
            key=dotted(path),
            label=label(path),
            unit=shape.unit or "",
            written_unit=_written_unit(read),
            choices=values.names,
            path=path,
            shape=shape,
            values=values,
            place=place,
        )

    def check_points_differ(self, table: Axis, keys: Sequence[AxisKey], path: KeyPath) -> None:
        """No two points of the axis are the same; only lists can repeat themselves."""
        listed = [
            key.values.contents or key.values.values
            for key in keys
            if isinstance(key.values, ValueList)
        ]
        if len(listed) < len(keys):
            return
        seen: dict[str, int] = {}
        for position, each in enumerate(zip(*listed, strict=True)):
            first = seen.setdefault(repr(each), position)
            if first != position:
                written = table.values[position]
                found = f"{written} as number {first + 1} and number {position + 1}"
                message = "two points of an axis are the same"
                self.problems += refused((*path, "values"), message, found=found).problems
                return


def _written_unit(key: KeyTable) -> str:
    """The unit in which the values of a number are written, the first that has one."""
    table, given = key.table, key.table.distribution
    drawn = (given.mean, given.upper, given.lower) if given else ()
    for written in (table.stop, table.start, *table.values, *drawn):
        if isinstance(written, str) and key.shape.kind == "number":
            unit = split_number(written)[1]
            if unit:
                return unit
    return key.shape.unit or ""


def _named(axes: Sequence[tuple[AxisKey, ...]]) -> tuple[SweepAxis, ...]:
    """Name each axis by the shortest end of its first key that nothing else is called."""
    parts = [keys[0].key.split(".") for keys in axes]
    endings = [[".".join(one[k:]) for k in reversed(range(len(one)))] for one in parts]
    named = []
    for mine, (keys, ends) in enumerate(zip(axes, endings, strict=True)):
        others = {end for n, ends_of in enumerate(endings) if n != mine for end in ends_of}
        free = [end for end in ends if end not in others and end not in _TAKEN]
        named.append(SweepAxis(name=(free or ends[-1:])[0], keys=keys))
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

    def columns(self, numbers: np.ndarray) -> dict[str, np.ndarray]:
        """The values at some points by key: doubles, whole numbers, names, lists or tables."""
        values = self.value_of(numbers)
        return {key.key: key.typed(values[:, place]) for place, key in enumerate(self.every)}

    def settings(self, number: int) -> dict[str, Any]:
        """What one point sets: a value in SI, the name of a choice, a list or table, by key."""
        columns = self.columns(np.array([number]))
        return {key: column.tolist()[0] for key, column in columns.items()}

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
                [{"key": key.key, **key.values.description()} for key in axis.keys]
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
    read = _Reader(sweep, resolved)
    problems = read.problems
    if not sweep.axes:
        problems += refused(
            ("sweep",),
            "a sweep needs at least one axis",
            allowed='axes = [{ key = "machine.speed", from = ..., to = ..., points = 21 }]',
        ).problems
    if problems:
        raise CaseError(problems)
    design = Design(
        axes=read.axes,
        sampling=sweep.sampling,
        points=STANDARD_POINTS if sweep.points is None else sweep.points,
        seed=STANDARD_SEED if sweep.seed is None else sweep.seed,
        indices=sweep.indices,
    )
    _check_size(design)
    return design


def _check_size(design: Design) -> None:
    most = min(LARGEST, MOST_POINTS.get(design.sampling, LARGEST))
    if design.count <= most:
        return
    key, factors = "axes", " x ".join(str(size) for size in design.shape)
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
