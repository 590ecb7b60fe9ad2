"""The short summary on the terminal: what came out, against what it is held, in colour."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vibecalc.pipeline.tolerance import UNRESOLVED
from vibecalc.report.limits import judge_limits
from vibecalc.report.numbers import show
from vibecalc.report.references import OUTSIDE, WITHIN, judge_references
from vibecalc.report.sections.key_rows import key_rows
from vibecalc.report.sections.section import SCALARS
from vibecalc.report.sections.summary import (
    LONGEST_PRINTED,
    brief,
    computed,
    conclusion,
    difference,
    known_notes,
    limit_verdict,
    margin,
    not_shown,
)
from vibecalc.report.sections.summary import limits as limit_table
from vibecalc.report.sections.summary import references as reference_table
from vibecalc.report.sections.tolerance import tolerance_line
from vibecalc.report.tables import WIDTH, filled, fold, paragraph
from vibecalc.report.tables import table as fixed_table
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

_MOST_REFERENCES = 10
#: characters that names get on the narrowest terminal
LEAST_NAME = 16


def print_summary(result: Result, path: Path) -> None:
    """Print the summary on stdout, in colour on a terminal, and where the files are."""
    if sys.stdout.isatty():
        from rich.console import Console

        summary(result, Console(highlight=False))
    else:
        sys.stdout.write(plain_summary(result))
    sys.stdout.write(f"wrote {path} and {path.with_suffix('.txt').name}\n")
    sys.stdout.flush()


def summary(result: Result, console: "Console") -> None:
    """Print title, key numbers, limits, references, warnings and the conclusion.

    Colours are left to `console`, which drops them where the output is no terminal.
    """
    from rich.markup import escape

    references, limits = judge_references(result), judge_limits(result)
    console.print(f"[bold]{escape(str(result.case.get('title') or result.name))}[/bold]")
    for make in (_scalars, _limits, _references):
        table = make(result, console.width)
        if table is not None:
            console.print(table)
    shown = brief(references, _MOST_REFERENCES)
    hidden = not_shown(references, shown)
    if hidden:
        console.print(escape(hidden))
    for note in known_notes(shown):
        console.print(f"[yellow]known:[/yellow] {escape(note)}")
    for text in dict.fromkeys(result.record.warnings):
        console.print(f"[yellow]warning:[/yellow] {escape(text)}")
    reached = tolerance_line(result)
    if reached:
        console.print(escape(reached))
    good = all(row.satisfied for row in limits) and all(
        row.within is not False for row in references
    )
    colour = "green" if good else "red"
    console.print(f"[{colour}]{escape(conclusion(references, limits))}[/{colour}]")


def plain_summary(result: Result) -> str:
    """The same without colour and without importing rich, for pipes and files."""
    references, limits = judge_references(result), judge_limits(result)
    rows = key_rows(result.record, result.case)
    tables = (
        fixed_table(SCALARS, rows) if rows else [],
        limit_table(limits),
        reference_table(references, _MOST_REFERENCES),
        [
            line
            for text in dict.fromkeys(result.record.warnings)
            for line in paragraph(text, "warning:")
        ],
    )
    lines = fold(str(result.case.get("title") or result.name), WIDTH)
    for table in tables:
        lines += ["", *table] if table else []
    reached = tolerance_line(result)
    lines += ["", *paragraph(reached)] if reached else []
    lines += ["", *paragraph(conclusion(references, limits))]
    return "\n".join(lines) + "\n"


def _scalars(result: Result, width: int) -> "Table | None":
    rows = key_rows(result.record, result.case)
    if not rows:
        return None
    return _table(width, ("quantity", ">value", "unit", ""), [list(row) for row in rows])


def _limits(result: Result, width: int) -> "Table | None":
    rows = judge_limits(result)
    if not rows:
        return None
    lines, colours = [], []
    for row in rows:
        bounds = [
            f"{side} {value:.6g}"
            for side, value in (("min", row.min), ("max", row.max))
            if value is not None
        ]
        name = row.quantity + (f" [{row.label}]" if row.label else "")
        cells = [name, " ".join(bounds), show(row.computed, row.error_estimate)]
        cells += [margin(row), row.unit]
        lines.append([*cells, limit_verdict(row)])
        colours.append("green" if row.satisfied else "bold red")
    heads = ("limit on", ">bound", ">computed", ">margin", "unit", "verdict")
    return _table(width, heads, lines, colours)


def _references(result: Result, width: int) -> "Table | None":
    rows = judge_references(result)
    if not rows:
        return None
    lines, colours = [], []
    for row in brief(rows, _MOST_REFERENCES):
        picks = ", ".join(f"{axis}={entry}" for axis, entry in row.where.items())
        name = row.quantity + (f" [{picks}]" if picks else "") + f" ({row.source})"
        printed = row.printed if len(row.printed) <= LONGEST_PRINTED else show(row.value)
        cells = [name, printed, computed(row), row.unit]
        lines.append([*cells, difference(row), row.verdict])
        missed = dict.fromkeys((OUTSIDE, UNRESOLVED), "bold red")
        colours.append(({WITHIN: "green"} | missed).get(row.verdict, "yellow"))
    heads = ("reference (source)", ">value", ">computed", "unit", ">difference", "verdict")
    return _table(width, heads, lines, colours)


def _table(
    width: int, heads: Sequence[str], rows: Sequence[Sequence[str]], colours: Sequence[str] = ()
) -> "Table":
    """A table of at most `width` characters; `colours` are those of the last cells.

    Where the terminal is narrow the names of the first column, and only they, go on below: after
    a `/` of a path, never within a word. A number cut short would be another number.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    places = filled(rows, len(heads))
    heads, *rows = ([cells[place] for place in places] for cells in (heads, *rows))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    others = zip(*(heads, *rows), strict=True)
    taken = sum(max(map(len, column)) + 2 for column in list(others)[1:])
    name = max(width - taken - 2, LEAST_NAME)
    for number, head in enumerate(heads):
        right = head.startswith(">")
        table.add_column(
            head.removeprefix(">"),
            justify="right" if right else "left",
            no_wrap=number == 0 or right,
            overflow="fold",
        )
    for cells, colour in zip(rows, colours or [""] * len(rows), strict=True):
        first = Text("\n".join(fold(cells[0], name)))
        table.add_row(first, *map(Text, cells[1:-1]), Text(cells[-1], style=colour))
    return table
