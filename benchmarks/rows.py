"""What a benchmark hands over: rows of ratios against named yardsticks, tables, and how it shows.

Every benchmark offers `measure() -> Report` and ends with `reported(measure)`: printed as Markdown,
or written as JSON for `run.py`, which collects all of them in RESULTS.md.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

COLUMNS = ("what", "way", "yardstick", "ratio", "aim", "error reached", "note")


class Row(NamedTuple):
    """One ratio.

    `ratio` is the yardstick's time (or evaluations) over ours, so that more is better; with `cost`
    it is ours over the yardstick's, and less is better. `aim` is then the least or the largest
    ratio that was asked for. `error` is what our way reaches, in words with its unit.
    """

    what: str
    way: str
    yardstick: str
    ratio: float
    aim: float | None = None
    error: str = ""
    note: str = ""
    cost: bool = False
    of: str = "times faster"

    @property
    def missed(self) -> bool:
        """Whether there is an aim and the ratio does not keep it."""
        if self.aim is None:
            return False
        return self.ratio > self.aim if self.cost else self.ratio < self.aim

    @property
    def ratio_text(self) -> str:
        """The ratio in words."""
        if not self.cost and self.of == "times faster" and self.ratio < 0.995:
            return f"{digits(1.0 / self.ratio)} times slower"
        return f"{digits(self.ratio)} {'times its time' if self.cost else self.of}"

    @property
    def aim_text(self) -> str:
        """The aim in words, and whether it is kept."""
        if self.aim is None:
            return ""
        word = "at most" if self.cost else "at least"
        aim = f"{self.aim:g}" if self.aim < 1e5 else digits(self.aim)
        return f"{word} {aim}: {'**missed**' if self.missed else 'kept'}"

    def cells(self) -> tuple[str, ...]:
        """The row as text, in the order of `COLUMNS`."""
        return (
            self.what, self.way, self.yardstick, self.ratio_text, self.aim_text, self.error,
            self.note,
        )  # fmt: skip


class Table(NamedTuple):
    """More numbers of a benchmark: a title, the names of the columns, and lines of text."""

    title: str
    columns: Sequence[str]
    lines: Sequence[Sequence[str]]


class Report(NamedTuple):
    """A benchmark's title, how it was measured, its ratios, its tables, and what is to say."""

    title: str
    words: str
    rows: Sequence[Row] = ()
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()


def digits(number: float) -> str:
    """Two significant digits below 10, three below 1000, without an exponent up to 99999."""
    if number == 0.0 or not 1e-3 <= abs(number) < 1e5:
        return f"{number:.1e}"
    return f"{number:.2g}" if abs(number) < 10.0 else f"{number:.0f}"


def seconds(spent: float) -> str:
    """A time with its unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if spent >= size:
            return f"{spent / size:.3g} {unit}"
    return f"{1e9 * spent:.3g} ns"


def in_markdown(columns: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table."""
    every = [columns, ["---"] * len(columns), *lines]
    return "".join(f"| {' | '.join(one)} |\n".replace("|  |", "| |") for one in every)


def shown(report: Report) -> str:
    """A report as a section in Markdown."""
    parts = [f"## {report.title}\n", f"{report.words}\n"]
    if report.rows:
        parts.append(in_markdown(COLUMNS, [row.cells() for row in report.rows]))
    for table in report.tables:
        parts += [f"### {table.title}\n", in_markdown(table.columns, table.lines)]
    if report.remarks:
        parts.append("".join(f"- {one}\n" for one in report.remarks))
    return "\n".join(parts)


def packed(report: Report) -> str:
    """The report as JSON."""
    lists = report._replace(
        rows=[row._asdict() for row in report.rows], tables=[t._asdict() for t in report.tables]
    )
    return json.dumps(lists._asdict())


def unpacked(text: str) -> Report:
    """The report from its JSON."""
    found = json.loads(text)
    found["rows"] = [Row(**row) for row in found["rows"]]
    found["tables"] = [Table(**table) for table in found["tables"]]
    return Report(**found)


def reported(measure: Callable[[], Report]) -> None:
    """Measure and print, or write JSON into the file that `--json` names."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    report = measure()
    if asked.json is None:
        print(shown(report))
    else:
        asked.json.write_text(packed(report), encoding="utf-8")
