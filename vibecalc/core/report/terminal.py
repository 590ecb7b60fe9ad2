"""The short summary on the terminal: what came out, against what it is held, in colour."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.core.report.headline import first_table
from vibecalc.core.report.html import VERDICTS
from vibecalc.core.report.pages import conclusion, missed, references
from vibecalc.core.report.verdicts import judge_references, misses
from vibecalc.core.report.writing import WIDTH, Table, fold, paragraph, read
from vibecalc.core.results.record import Result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.results.visible import put, visible

if TYPE_CHECKING:
    from rich.console import Console

_COLOURS = {"missed": "bold red", "open": "yellow", "kept": "green"}


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
    from rich.text import Text

    console.print(Text(visible(_title(result, console.width)), style="bold"))
    for style, block in _blocks(result):
        text = Text(visible(f"\n{read(block.at(console.width))}"), style=style)
        if isinstance(block, Table):
            for name, words in VERDICTS:
                text.highlight_regex(rf"(?m){words.pattern}(?=\W*$)", _COLOURS[name])
        console.print(text)


def plain_summary(result: Result) -> str:
    """The same without colour and without importing rich, for pipes and files."""
    return "\n\n".join([_title(result, WIDTH), *(block for _, block in _blocks(result))]) + "\n"


def _title(result: Result, width: int) -> str:
    return "\n".join(fold(str(result.case.get("title") or result.name), width))


def _blocks(result: Result) -> Iterator[tuple[str, Any]]:
    """Blocks of the summary, each with the style of its words."""
    limits, compared = verdicts_of(result), judge_references(result)
    verdict = "red" if misses(compared, limits) else "green"
    for block in (*first_table(result, limits), *references(missed(compared))):
        yield "", block
    said = [("yellow", "warning:", text) for text in dict.fromkeys(result.record.warnings)]
    said.append((verdict, "", conclusion(compared, limits)))
    for style, mark, words in said:
        if words:
            yield style, paragraph(words, mark)[0]
