"""The short summary on the terminal: what came out, against what it is held, in colour."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

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
    not_shown,
)
from vibecalc.report.sections.summary import limits as limit_table
from vibecalc.report.sections.summary import references as reference_table
from vibecalc.report.sections.tolerance import tolerance_line
from vibecalc.report.tables import WIDTH, fold, paragraph
from vibecalc.report.tables import table as fixed_table
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

_MOST_REFERENCES = 10


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
    for table in (_scalars(result), _limits(result), _references(result)):
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


def _scalars(result: Result) -> "Table | None":
    rows = key_rows(result.record, result.case)
    if not rows:
        return None
    table = _table("quantity", ">value", "unit", "")
    for row in rows:
        table.add_row(*_plain(row))
    return table


def _limits(result: Result) -> "Table | None":
    rows = judge_limits(result)
    if not rows:
        return None
    table = _table("limit on", ">bound", ">computed", ">margin", "unit", "verdict")
    for row in rows:
        bounds = [
            f"{side} {value:.6g}"
            for side, value in (("min", row.min), ("max", row.max))
            if value is not None
        ]
        name = row.quantity + (f" [{row.label}]" if row.label else "")
        cells = [name, " ".join(bounds), show(row.computed, row.error_estimate)]
        cells += [show(row.margin, row.error_estimate), row.unit]
        colour = "green" if row.satisfied else "bold red"
        table.add_row(*_plain(cells), f"[{colour}]{limit_verdict(row)}[/{colour}]")
    return table


def _references(result: Result) -> "Table | None":
    rows = judge_references(result)
    if not rows:
        return None
    colours = {WITHIN: "green", OUTSIDE: "bold red"}
    table = _table("reference (source)", ">value", ">computed", "unit", ">difference", "verdict")
    for row in brief(rows, _MOST_REFERENCES):
        picks = ", ".join(f"{axis}={entry}" for axis, entry in row.where.items())
        name = row.quantity + (f" [{picks}]" if picks else "") + f" ({row.source})"
        printed = row.printed if len(row.printed) <= LONGEST_PRINTED else show(row.value)
        cells = [name, printed, computed(row), row.unit]
        cells.append(difference(row))
        colour = colours.get(row.verdict, "yellow")
        table.add_row(*_plain(cells), f"[{colour}]{row.verdict}[/{colour}]")
    return table


def _table(*heads: str) -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    for head in heads:
        # Where the terminal is narrow, names go on below; a number cut short is another number.
        if head.startswith(">"):
            table.add_column(head.removeprefix(">"), justify="right", no_wrap=True)
        else:
            table.add_column(head, overflow="fold")
    return table


def _plain(cells: list[str]) -> list[str]:
    from rich.markup import escape

    return [escape(cell) for cell in cells]
