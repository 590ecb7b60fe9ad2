"""The short summary on the terminal: what came out, against what it is held, in colour."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vibecalc.core.report.headline import cells, columns, with_limits
from vibecalc.core.report.pages import (
    LONGEST_PRINTED,
    computed,
    conclusion,
    difference,
    missed,
    tolerance_line,
)
from vibecalc.core.report.pages import references as reference_table
from vibecalc.core.report.verdicts import judge_references, misses
from vibecalc.core.report.writing import (
    WIDTH,
    filled,
    fold,
    paragraph,
    show,
)
from vibecalc.core.report.writing import table as fixed_table
from vibecalc.core.results.record import Result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.results.visible import put, visible

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

# ----------------------------------------------------------------------------
# The short summary on the terminal: what came out, against what it is held, in colour.
# ----------------------------------------------------------------------------

#: characters that names get on the narrowest terminal
LEAST_NAME = 16


def print_summary(result: Result, path: Path) -> None:
    """Print the summary on stdout, in colour on a terminal, and where the files are."""
    if sys.stdout.isatty():
        from rich.console import Console

        summary(result, Console(highlight=False))
    else:
        put(plain_summary(result))
    put(f"wrote {visible(str(path))} and {visible(path.with_suffix('.txt').name)}\n")


def summary(result: Result, console: "Console") -> None:
    """Print title, key numbers, limits, references, warnings and the conclusion.

    Colours are left to `console`, which drops them where the output is no terminal.
    """
    from rich.markup import escape

    references, limits = judge_references(result), verdicts_of(result)
    console.print(f"[bold]{escape(visible(str(result.case.get('title') or result.name)))}[/bold]")
    for make in (_answers, _references):
        table = make(result, console.width)
        if table is not None:
            console.print(table)
    for text in dict.fromkeys(result.record.warnings):
        console.print(f"[yellow]warning:[/yellow] {escape(text)}")
    reached = tolerance_line(result)
    if reached:
        console.print(escape(reached))
    colour = "red" if misses(references, limits) else "green"
    if references or limits:
        console.print(f"[{colour}]{escape(conclusion(references, limits))}[/{colour}]")


def plain_summary(result: Result) -> str:
    """The same without colour and without importing rich, for pipes and files."""
    references, limits = judge_references(result), verdicts_of(result)
    rows = with_limits(result, limits)
    tables = (
        fixed_table(columns(rows), cells(rows)) if rows else [],
        reference_table(missed(references)),
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
    said = conclusion(references, limits)
    lines += ["", *paragraph(said)] if said else []
    return "\n".join(lines) + "\n"


def _answers(result: Result, width: int) -> "Table | None":
    rows = with_limits(result, verdicts_of(result))
    if not rows:
        return None
    colours = ["" if not row.limit else "bold red" if row.missed else "green" for row in rows]
    heads = ("result", ">value", "unit", "where", *["limit"] * any(row.limit for row in rows))
    return _table(width, heads, cells(rows), colours)


def _references(result: Result, width: int) -> "Table | None":
    rows = missed(judge_references(result))
    if not rows:
        return None
    lines, colours = [], []
    for row in rows:
        picks = ", ".join(f"{axis}={entry}" for axis, entry in row.where.items())
        name = row.quantity + (f" [{picks}]" if picks else "") + f" ({row.source})"
        printed = row.printed if len(row.printed) <= LONGEST_PRINTED else show(row.value)
        texts = [name, printed, computed(row), row.unit]
        lines.append([*texts, difference(row), row.verdict])
        colours.append("bold red")
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
    for texts, colour in zip(rows, colours or [""] * len(rows), strict=True):
        first = Text("\n".join(fold(texts[0], name)))
        table.add_row(first, *map(Text, texts[1:-1]), Text(texts[-1], style=colour))
    return table
