"""Points of a sweep without a result, grouped by their cause."""

import re
from typing import NamedTuple

import numpy as np

from vibecalc.report.sweep.view import SweepView
from vibecalc.report.tables import Column, fold, number, table
from vibecalc.results.sweep_layout import DONE, NOT_RUN, STATUS_WORDS

_NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_COLUMNS = (Column("cause", 46), number("points", 9), number("share", 8), Column("example", 32))


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
        words = sweep.message(int(point))
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
        point = int(cause.points[0])
        head = "\n  ".join(fold(cause.title, _COLUMNS[0].width - 2)[:8])
        share = f"{100.0 * cause.points.size / sweep.count:.3g} %"
        rows.append([head, str(cause.points.size), share, example(sweep, point, 32)])
    return table(_COLUMNS, rows) if rows else []


def example(sweep: SweepView, point: int, width: int) -> str:
    """A point by number and values, one key on a line where they do not fit into one."""
    words = sweep.words_of(point)
    whole = f"point {point}: {words}"
    return whole if len(whole) <= width else f"point {point}\n" + words.replace(", ", "\n")
