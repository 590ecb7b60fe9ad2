"""A sweep as the report reads it from its open file: keys, results, and points without any."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.core.report.goals import key_words
from vibecalc.core.report.writing import number, table
from vibecalc.core.results.layout import DAMPING, DONE, NATURAL, NOT_RUN, SPEED, STATUS_WORDS
from vibecalc.core.results.record import Quantity
from vibecalc.core.results.sweep_file import SweepHead, SweepResult, Swept, SweptAxis, SweptKey

# ----------------------------------------------------------------------------
# A sweep as the report reads it: its keys in the units of the case, its results at all points.
# ----------------------------------------------------------------------------

#: order up to which passed natural frequencies are looked for
_HIGHEST = 24.0


class StackedResult(NamedTuple):
    """A result at all points: values (points, own axes), error (points,), perhaps spread."""

    values: np.ndarray
    errors: np.ndarray
    standard_errors: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True)
class SweepView(Swept):
    """A sweep as its file has it, with short words for labels of keys. Points are counted in C
    order; `quantities` describes each result without its values.

    `read` gives the values of one path, so that no more than one result is in memory at a time.
    `reasons` says of points without a result why, `left_out` the same of each path that could not
    be kept.
    """

    head: SweepHead
    status: np.ndarray
    reasons: Mapping[int, str]
    quantities: Mapping[str, Quantity]
    read: Callable[[str], StackedResult]
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.head.result.name

    @property
    def indices(self) -> bool:
        """Whether the points are those of a design for Sobol indices."""
        return bool(self.head.design.get("indices"))

    @property
    def together(self) -> list[range]:
        """Places of the keys that are drawn, or vary, together."""
        ends = np.cumsum([0, *map(len, self.head.design["axes"])]).tolist()
        return list(map(range, ends, ends[1:]))

    @property
    def keys(self) -> tuple[SweptKey, ...]:
        """All keys, in the order of the axes."""
        return tuple(key for axis in self.head.axes for key in axis.keys)

    @property
    def grid(self) -> tuple[SweptAxis, ...]:
        """The axes of a grid; none of a sampling."""
        return self.head.axes if self.head.sampling == "grid" else ()

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

    @cached_property
    def crossings(self) -> "list[Crossing]":
        """Where an order passes a natural frequency that is kept, and no damping of it is."""
        speeds = [i for i, axis in enumerate(self.grid) if axis.keys[0].key == SPEED]
        found: list[Crossing] = []
        for path in self.quantities if speeds else ():
            if not path.endswith(NATURAL):
                continue
            modes = np.where(self.done, self.read(path).values.reshape(self.count, -1).T, np.nan)
            damping = path.removesuffix(NATURAL) + DAMPING
            told = damping in self.quantities
            if told:
                ratio = self.read(damping).values.reshape(self.count, -1).T
                modes = np.where(ratio == 0.0, modes, np.nan)
            turning = self.grid[speeds[0]].columns[0]
            points = np.moveaxis(np.arange(self.count).reshape(self.shape), speeds[0], -1)
            for mode, line in product(range(len(modes)), points.reshape(-1, len(turning))):
                halves = np.floor(2.0 * modes[mode, line] / turning)
                for i in np.flatnonzero(np.abs(np.diff(halves)) > 0.0).tolist():
                    near = np.arange(max(i - 1, 0), min(i + 3, len(line)))
                    low, high = np.sort(np.minimum(halves[i : i + 2], 2.0 * _HIGHEST))
                    for order in 0.5 * np.arange(low + 1.0, high + 1.0):
                        away = np.abs(order * turning[near] - modes[mode, line[near]])
                        words = f"order {order:g} on mode {mode + 1}"
                        found.append(Crossing(line[near], int(i > 0), away, words, told))
        return found

    def values_of(self, points: np.ndarray) -> np.ndarray:
        """What the keys are at some points, (len, keys) in SI."""
        places = np.unravel_index(points, self.shape)
        return np.concatenate(
            [axis.table[place] for axis, place in zip(self.head.axes, places, strict=True)], axis=-1
        )

    def words_of(self, point: int) -> str:
        """One point as a reader wants it: `stiffness = 12.5 N/mm, damping = 50 N*s/m`."""
        return self.words(self.values_of(np.array([point]))[0])

    def words(self, row: np.ndarray) -> str:
        """The same of the values (keys,) of a point."""
        pairs = zip(self.keys, row, strict=True)
        return ", ".join(f"{key.label} = {key.shown(value)}" for key, value in pairs)


class Crossing(NamedTuple):
    """Up to four neighbours (k,) along the speed: the natural frequency lies after the one at
    `first`. `away` (k,) in rad/s is how far the order is from it at each; `bare` says that it is
    known to have no damping."""

    points: np.ndarray
    first: int
    away: np.ndarray
    words: str
    bare: bool

    @property
    def pair(self) -> tuple[int, int]:
        """The points before and after it."""
        one, other = self.points[self.first : self.first + 2].tolist()
        return one, other

    def peaks(self, values: np.ndarray) -> bool:
        """Whether a result (points,) rises to there from both sides, as next to a pole."""
        near = values[self.points]
        sides = [(self.first, self.first - 1), (self.first + 1, self.first + 2)]
        sides = [(i, j) for i, j in sides if 0 <= j < len(near) and np.isfinite(near[i] + near[j])]
        steep = [near[i] * self.away[i] >= 0.5 * near[j] * self.away[j] for i, j in sides]
        return any(steep) and all(near[i] > near[j] > 0.0 for i, j in sides)


# ----------------------------------------------------------------------------
# The open file of a sweep as what the report reads.
# ----------------------------------------------------------------------------


def view_of(result: SweepResult) -> SweepView:
    """The view of a sweep; its results are read from the file one by one, when asked for."""
    head = result.head
    words = iter(key_words([key.key for axis in head.axes for key in axis.keys], head.result.case))
    axes = tuple(
        replace(axis, keys=tuple(replace(key, label=next(words)) for key in axis.keys))
        for axis in head.axes
    )

    def read(path: str) -> StackedResult:
        return StackedResult(*(result.read(name, 0, result.count) for name in result.stored(path)))

    return SweepView(
        head=replace(head, axes=axes),
        status=result.status().ravel(),
        reasons=result.reasons(),
        quantities=result.quantities,
        read=read,
        left_out=result.left_out,
    )


# ----------------------------------------------------------------------------
# Points of a sweep without a result, grouped by their cause.
# ----------------------------------------------------------------------------

_NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


class Cause(NamedTuple):
    """Points that came to nothing for one reason, with the words of the first.

    `alike` says whether those of the others are the same to every digit.
    """

    status: int
    words: str
    points: np.ndarray
    alike: bool

    @property
    def title(self) -> str:
        """Kind of failure and its words, in one line."""
        kind = STATUS_WORDS.get(self.status, f"status {self.status}")
        first = self.words.strip().splitlines()[-1].strip() if self.words.strip() else ""
        if not first:
            return kind
        return f"{kind}: {first}" if self.alike else f"{kind}, such as: {first}"


def causes(sweep: SweepView) -> list[Cause]:
    """Failures, most frequent first; messages that differ in their numbers only are one cause."""
    groups: dict[tuple[int, str], tuple[list[int], dict[str, None]]] = {}
    for point in np.flatnonzero((sweep.status != DONE) & (sweep.status != NOT_RUN)):
        words = sweep.reasons.get(int(point), "")
        key = (int(sweep.status[point]), _NUMBER.sub("#", words))
        points, texts = groups.setdefault(key, ([], {}))
        points.append(int(point))
        texts.setdefault(words)
    found = [
        Cause(status, next(iter(texts)), np.array(points), len(texts) == 1)
        for (status, _), (points, texts) in groups.items()
    ]
    return sorted(found, key=lambda cause: (-cause.points.size, int(cause.points[0])))


def failure_lines(sweep: SweepView) -> list[str]:
    """A table of the causes with counts, shares and an example; empty if nothing failed."""
    rows = []
    for cause in causes(sweep):
        share = f"{100.0 * cause.points.size / sweep.count:.3g} %"
        rows.append([cause.title, str(cause.points.size), share, example(sweep, cause)])
    return table(("cause", number("points"), number("share"), "example"), rows)


def example(sweep: SweepView, cause: Cause) -> str:
    """The first point of a cause, by number and values."""
    point = int(cause.points[0])
    return f"point {point}: {sweep.words_of(point)}"
