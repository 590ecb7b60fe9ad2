"""Which points a sweep has: its axes, and each point from its number alone."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vibecalc.core.case.raw import key_text
from vibecalc.core.case.study_tables import Along, Axis, Sweep
from vibecalc.core.case.walk import Shape
from vibecalc.core.results.catalogue import AXES
from vibecalc.core.study.sweep.keys import KeyPlace, label, read_values, target
from vibecalc.core.study.sweep.sampling import MOST_POINTS, drawn, drawn_by
from vibecalc.core.study.sweep.values import AxisValues, ValueList
from vibecalc.errors import CaseError, KeyPath, Problem, UnitError, UsageError
from vibecalc.units import split_number

# ----------------------------------------------------------------------------
# The axes of a sweep: one key each, or several that take their values in step.
# ----------------------------------------------------------------------------

_TAKEN = {*AXES, "sample", "key"}


@dataclass(frozen=True, kw_only=True)
class SweepAxis:
    """One axis of a sweep with its k keys; values are in SI.

    `name` is short and unlike any axis of a result; `labels` say in words what the keys are,
    `written_units` in which unit the case gives them; `paths` are the keys taken apart, `places`
    where each stands in the case.
    """

    name: str
    keys: tuple[str, ...]
    paths: tuple[KeyPath, ...]
    shapes: tuple[Shape, ...]
    key_values: tuple[AxisValues, ...]
    labels: tuple[str, ...]
    written_units: tuple[str, ...]
    places: tuple[KeyPath, ...]

    @property
    def count(self) -> int | None:
        """Points along the axis; None if it is only drawn from."""
        return self.key_values[0].count

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each key; "" for choices and plain numbers."""
        return tuple(shape.unit or "" for shape in self.shapes)

    @property
    def choices(self) -> tuple[tuple[str, ...], ...]:
        """For each key the names that its values count from 0; empty for a number."""
        return tuple(axis_values.names for axis_values in self.key_values)

    @property
    def values(self) -> np.ndarray:
        """All values (n, k); takes memory for all of them. ValueError if it is drawn from."""
        if self.count is None:
            raise ValueError(f"the axis {self.name} is drawn from, it has no values of its own")
        return self.at(np.arange(self.count))

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values (len, k) at positions along the axis."""
        return np.stack([axis_values.at(positions) for axis_values in self.key_values], axis=1)

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Values (len, k) at shares in (0, 1) of the axis; all keys take the same share."""
        return np.stack([axis_values.drawn(shares) for axis_values in self.key_values], axis=1)


def read_axes(
    sweep: Sweep, resolved: Mapping[str, Any]
) -> tuple[tuple[SweepAxis, ...], list[Problem]]:
    """Read the axes of `[sweep]` for a case in SI; axes with problems are left out.

    Refused are keys that are not there or stand twice, values that cannot be read, and axes
    without at least two points that differ.
    """
    problems: list[Problem] = []
    seen: dict[KeyPath, KeyPath] = {}
    axes = []
    for position, table in enumerate(sweep.axes):
        path: KeyPath = ("sweep", "axes", position)
        axis = _read_axis(table, path, resolved, sweep.sampling != "grid", seen, problems)
        if axis is not None:
            axes.append(axis)
    return _named(axes), problems


def _read_axis(
    table: Axis,
    path: KeyPath,
    resolved: Mapping[str, Any],
    sampled: bool,
    seen: dict[KeyPath, KeyPath],
    problems: list[Problem],
) -> SweepAxis | None:
    rows: list[tuple[KeyPlace, KeyPath, AxisValues]] = []
    tables: list[tuple[Along, KeyPath]] = [(table, path)]
    tables += [(one, (*path, "with", index)) for index, one in enumerate(table.together)]
    points = table.points if table.points is not None else len(table.values) or None
    for one, where in tables:
        target_ = _target(one.key, where, resolved, seen, problems)
        if target_ is None:
            continue
        place = KeyPlace(one, where, target_[1], problems)
        values = read_values(place, sampled, points)
        if values is None:
            continue
        if one is table:
            points = values.count
        elif values.count is not None and points is not None and values.count != points:
            problems.append(
                Problem(
                    path=(*where, "key"),
                    message="keys that vary together need equally many values",
                    found=f"{values.count} for {one.key}, {points} for {table.key}",
                    also=(*path, "key"),
                )
            )
        rows.append((place, target_[0], values))
    if len(rows) < len(tables):
        return None
    if not _points_differ(rows, path, problems):
        return None
    return SweepAxis(
        name="",
        keys=tuple(key_text(key) for _, key, _ in rows),
        paths=tuple(key for _, key, _ in rows),
        shapes=tuple(place.shape for place, _, _ in rows),
        key_values=tuple(values for _, _, values in rows),
        labels=tuple(label(key) for _, key, _ in rows),
        written_units=tuple(_written_unit(place) for place, _, _ in rows),
        places=tuple(place.path for place, _, _ in rows),
    )


def _target(
    key: str,
    where: KeyPath,
    resolved: Mapping[str, Any],
    seen: dict[KeyPath, KeyPath],
    problems: list[Problem],
) -> tuple[KeyPath, Shape] | None:
    try:
        path, shape = target(key, resolved)
    except UsageError as error:
        problems.append(
            Problem(
                path=(*where, "key"),
                message="a sweep cannot vary this key",
                found=key[:80],
                allowed="a number or a choice of this case, as in machine.mounts.each.stiffness",
                hint=str(error),
            )
        )
        return None
    for other, place in seen.items():
        size = min(len(path), len(other))
        if path[:size] == other[:size]:
            whole = f", which is in {key_text(min(path, other, key=len))}" if path != other else ""
            problems.append(
                Problem(
                    path=(*where, "key"),
                    message=f"two axes vary {key_text(max(path, other, key=len))}{whole}",
                    also=(*place, "key"),
                )
            )
            return None
    seen[path] = where
    return path, shape


def _points_differ(
    rows: Sequence[tuple[KeyPlace, KeyPath, AxisValues]], path: KeyPath, problems: list[Problem]
) -> bool:
    """Whether no two points of the axis are the same; only lists can repeat themselves."""
    listed = [
        axis_values.contents or axis_values.values
        for _, _, axis_values in rows
        if isinstance(axis_values, ValueList)
    ]
    if len(listed) < len(rows) or len({len(values) for values in listed}) > 1:
        return True
    seen: dict[str, int] = {}
    for position, each in enumerate(zip(*listed, strict=True)):
        point = repr(each)
        if point in seen:
            written = rows[0][0].table.values[position]
            problems.append(
                Problem(
                    path=(*path, "values"),
                    message="two points of an axis are the same",
                    found=f"{written} as number {seen[point] + 1} and number {position + 1}",
                )
            )
            return False
        seen[point] = position
    return True


def _written_unit(place: KeyPlace) -> str:
    table, given = place.table, place.table.distribution
    ends = (table.stop, table.start, *table.values)
    drawn = (given.mean, given.upper, given.lower) if given else ()
    for written in (*ends, *drawn):
        if isinstance(written, str):
            try:
                unit = split_number(written)[1]
            except UnitError:  # the name of a choice
                return ""
            if unit:
                return unit
    return place.shape.unit or ""


def _named(axes: Sequence[SweepAxis]) -> tuple[SweepAxis, ...]:
    """Name each axis by the shortest end of its first key that nothing else is called."""
    endings = [_endings(axis.keys[0]) for axis in axes]
    names = []
    for mine, ends_of in enumerate(endings):
        others = {end for index, ends in enumerate(endings) if index != mine for end in ends}
        free = [end for end in ends_of if end not in others and end not in _TAKEN]
        names.append((free or [ends_of[-1]])[0])
    return tuple(replace(axis, name=name) for axis, name in zip(axes, names, strict=True))


def _endings(key: str) -> list[str]:
    parts = key.split(".")
    return [".".join(parts[start:]) for start in range(len(parts) - 1, -1, -1)]


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
    def axis_names(self) -> tuple[str, ...]:
        """Name of each axis of the results."""
        grid = self.sampling == "grid"
        return tuple(axis.name for axis in self.axes) if grid else ("sample",)

    @property
    def count(self) -> int:
        """Number of runs."""
        return math.prod(self.shape)

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that vary, axis by axis."""
        return tuple(key for axis in self.axes for key in axis.keys)

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each key."""
        return tuple(unit for axis in self.axes for unit in axis.units)

    @property
    def choices(self) -> tuple[tuple[str, ...], ...]:
        """For each key the names that its values count from 0; empty for a number."""
        return tuple(names for axis in self.axes for names in axis.choices)

    @property
    def contents(self) -> tuple[tuple[Any, ...], ...]:
        """For each key the lists or tables that its values count from 0; empty for others."""
        return tuple(values.contents for axis in self.axes for values in axis.key_values)

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
        return {key: self._typed(values[:, column], column) for column, key in enumerate(self.keys)}

    def settings(self, number: int) -> dict[str, Any]:
        """What one point sets: a value in SI, the name of a choice, a list or table, by key."""
        columns = self.columns(np.array([number]))
        return {key: column.tolist()[0] for key, column in columns.items()}

    def roles(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For Sobol indices: the sampled point behind each run, and 0 for A, 1 for B, 1 + j."""
        if not self.indices:
            raise ValueError("only a sweep for Sobol indices has roles")
        return np.divmod(np.asarray(numbers, dtype=np.int64), len(self.axes) + 2)

    def description(self) -> dict[str, Any]:
        """The design as plain values, for hashes and result files."""
        sampled = self.sampling != "grid"
        return {
            "sampling": self.sampling,
            **(
                {"points": self.points, "seed": self.seed, "drawn_by": drawn_by()}
                if sampled
                else {}
            ),
            "indices": self.indices,
            "axes": [
                [
                    {"key": key, **axis_values.description()}
                    for key, axis_values in zip(axis.keys, axis.key_values, strict=True)
                ]
                for axis in self.axes
            ],
        }

    def _typed(self, column: np.ndarray, index: int) -> np.ndarray:
        contents = self.contents[index]
        if contents:
            objects = np.empty(len(column), dtype=object)
            for row, place in enumerate(column.astype(np.int64).tolist()):
                objects[row] = contents[place]
            return objects
        if self.choices[index]:
            return np.array(self.choices[index])[column.astype(np.int64)]
        whole = [shape.kind == "whole" for axis in self.axes for shape in axis.shapes]
        return column.astype(np.int64) if whole[index] else column

    def _shares(self, numbers: np.ndarray) -> np.ndarray:
        size = len(self.axes)
        if not self.indices:
            return drawn(self.sampling, numbers, size, self.points, self.seed)
        base, role = self.roles(numbers)
        both = drawn(self.sampling, base, 2 * size, self.points, self.seed)
        from_b = (role[:, None] == 1) | (role[:, None] == np.arange(size) + 2)
        return np.where(from_b, both[:, size:], both[:, :size])


def make_design(sweep: Sweep, resolved: Mapping[str, Any]) -> Design:
    """Read `[sweep]` for a case in SI with its defaults; CaseError with all problems found."""
    axes, problems = read_axes(sweep, resolved)
    if not sweep.axes:
        problems.append(
            Problem(
                path=("sweep",),
                message="a sweep needs at least one axis",
                allowed='axes = [{ key = "machine.speed", from = ..., to = ..., points = 21 }]',
            )
        )
    if not problems:
        design = Design(
            axes=axes,
            sampling=sweep.sampling,
            points=STANDARD_POINTS if sweep.points is None else sweep.points,
            seed=STANDARD_SEED if sweep.seed is None else sweep.seed,
            indices=sweep.indices,
        )
        problems += _size_problems(design)
    if problems:
        raise CaseError(problems)
    return design


def size_words(count: int) -> str:
    """Say a large number: 1500 is "1500", 1 200 000 "1.2 million"."""
    for size, name in (
        (10**18, "million million million"),
        (10**12, "million million"),
        (10**9, "thousand million"),
        (10**6, "million"),
    ):
        if count >= size:
            shown = f"{count / size:.4g}" if count < 10**6 * size else f"{count / size:.3e}"
            return f"{shown} {name}"
    return str(count)


def _size_problems(design: Design) -> list[Problem]:
    most = min(LARGEST, MOST_POINTS.get(design.sampling, LARGEST))
    if design.count <= most:
        return []
    if design.sampling == "grid":
        path, factors = ("sweep", "axes"), " x ".join(str(size) for size in design.shape)
    else:
        path = ("sweep", "points")
        runs = f" x {len(design.axes) + 2} runs" if design.indices else ""
        factors = f"{design.points}{runs}"
    years = design.count / 1000.0 / 31_557_600.0
    return [
        Problem(
            path=path,
            message=f"the sweep would have {size_words(design.count)} points",
            found=factors,
            allowed=f"at most {size_words(most)}",
            hint=f"a thousand points a second would take {years:.2g} years"
            if years > 0.1
            else "fewer points on an axis, or a sampling",
        )
    ]
