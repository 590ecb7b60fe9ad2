"""The axes of a sweep: one key each, or several that take their values in step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vibecalc.case.overrides import key_text
from vibecalc.case.sweep_tables import Along, Axis, Sweep
from vibecalc.case.walk import Shape
from vibecalc.errors import KeyPath, Problem, UnitError, UsageError
from vibecalc.pipeline.catalogue import AXES
from vibecalc.study.sweep.courses import Course, Listed
from vibecalc.study.sweep.keys import label, target
from vibecalc.study.sweep.reading import Place, read_course
from vibecalc.units import split_number

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
    courses: tuple[Course, ...]
    labels: tuple[str, ...]
    written_units: tuple[str, ...]
    places: tuple[KeyPath, ...]

    @property
    def count(self) -> int | None:
        """Points along the axis; None if it is only drawn from."""
        return self.courses[0].count

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each key; "" for choices and plain numbers."""
        return tuple(shape.unit or "" for shape in self.shapes)

    @property
    def choices(self) -> tuple[tuple[str, ...], ...]:
        """For each key the names that its values count from 0; empty for a number."""
        return tuple(course.names for course in self.courses)

    @property
    def values(self) -> np.ndarray:
        """All values (n, k); takes memory for all of them. ValueError if it is drawn from."""
        if self.count is None:
            raise ValueError(f"the axis {self.name} is drawn from, it has no values of its own")
        return self.at(np.arange(self.count))

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values (len, k) at positions along the axis."""
        return np.stack([course.at(positions) for course in self.courses], axis=1)

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Values (len, k) at shares in (0, 1) of the axis; all keys take the same share."""
        return np.stack([course.drawn(shares) for course in self.courses], axis=1)


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
    rows: list[tuple[Place, KeyPath, Course]] = []
    tables: list[tuple[Along, KeyPath]] = [(table, path)]
    tables += [(one, (*path, "with", index)) for index, one in enumerate(table.together)]
    points = table.points if table.points is not None else len(table.values) or None
    for one, where in tables:
        found = _target(one.key, where, resolved, seen, problems)
        if found is None:
            continue
        place = Place(one, where, found[1], problems)
        course = read_course(place, sampled, points)
        if course is None:
            continue
        if one is table:
            points = course.count
        elif course.count is not None and points is not None and course.count != points:
            problems.append(
                Problem(
                    path=(*where, "key"),
                    message="keys that vary together need equally many values",
                    found=f"{course.count} for {one.key}, {points} for {table.key}",
                    also=(*path, "key"),
                )
            )
        rows.append((place, found[0], course))
    if len(rows) < len(tables):
        return None
    if not _points_differ(rows, path, problems):
        return None
    return SweepAxis(
        name="",
        keys=tuple(key_text(key) for _, key, _ in rows),
        paths=tuple(key for _, key, _ in rows),
        shapes=tuple(place.shape for place, _, _ in rows),
        courses=tuple(course for _, _, course in rows),
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
    rows: Sequence[tuple[Place, KeyPath, Course]], path: KeyPath, problems: list[Problem]
) -> bool:
    """Whether no two points of the axis are the same; only lists can repeat themselves."""
    listed = [course.values for _, _, course in rows if isinstance(course, Listed)]
    if len(listed) < len(rows) or len({len(values) for values in listed}) > 1:
        return True
    seen: dict[tuple[float | str, ...], int] = {}
    for position, point in enumerate(zip(*listed, strict=True)):
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


def _written_unit(place: Place) -> str:
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
    for mine, own in enumerate(endings):
        others = {end for index, ends in enumerate(endings) if index != mine for end in ends}
        free = [end for end in own if end not in others and end not in _TAKEN]
        names.append((free or [own[-1]])[0])
    return tuple(replace(axis, name=name) for axis, name in zip(axes, names, strict=True))


def _endings(key: str) -> list[str]:
    parts = key.split(".")
    return [".".join(parts[start:]) for start in range(len(parts) - 1, -1, -1)]
