"""The program and its commands as typer sees them, with help pages drawn with rich.

typer's own pages also import Markdown, syntax colouring and tracebacks, which takes longer than
everything else that `vibecalc --help` does.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from typer.core import TyperCommand, TyperGroup

from vibecalc import interrupts
from vibecalc.cli.examples import EXAMPLES
from vibecalc.core.results.visible import put
from vibecalc.errors import EXIT_CODES, Interrupted, OutputError, UsageError

if TYPE_CHECKING:
    from rich.console import RenderableType

Row = tuple[str, str]


class Command(TyperCommand):
    """A command whose `--help` is such a page."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the page; the formatter stays empty."""
        _print_page(self, ctx, [])


class Group(TyperGroup):
    """The program with its list of commands, on such a page."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the command line; `--help` and `--version` print here."""
        with _reported():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _reported():
            return super().invoke(ctx)

    def _main_shell_completion(self, *arguments: Any, **options: Any) -> None:
        """Answer a shell that completes a line, if one asks."""
        with _reported():
            super()._main_shell_completion(*arguments, **options)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the page; the formatter stays empty."""
        named = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        rows = [
            (name, _first_paragraph(command.help or ""))
            for name, command in named
            if command is not None and not command.hidden
        ]
        _print_page(self, ctx, rows)


@contextmanager
def _reported() -> Iterator[None]:
    """Ctrl-C and a stdout that takes no more become errors of ours; typer says neither.

    What vibecalc itself prints and writes raises `OutputError` and `UsageError` already.
    """
    try:
        yield
        interrupts.check()
        sys.stdout.flush()
    except KeyboardInterrupt:
        raise Interrupted from None
    except OSError as error:
        if error.filename is None:
            raise OutputError(error) from error
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot use the file {error.filename}: {reason}") from error


def _print_page(command: TyperCommand | TyperGroup, ctx: Any, commands: Sequence[Row]) -> None:
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console = Console(highlight=False)
    usage = Text(command.get_usage(ctx), style="bold")
    usage.highlight_words(["Usage:"], "yellow")
    # rich would end the process by itself where nobody reads on
    with console.capture() as page:
        console.print(Padding(usage, 1))
        console.print(Padding(Text(command.help or ""), (0, 1, 1, 1)))
        for title, rows in (
            ("Arguments", _rows(command, ctx, "argument")),
            ("Options", _rows(command, ctx, "option")),
            ("Commands", commands),
            ("Examples", EXAMPLES.get(ctx.info_name or "", ())),
            ("Exit codes", [(str(code), words) for code, words in EXIT_CODES.items()]),
        ):
            if rows:
                console.print(_panel(title, rows))
    put(page.get())


def _rows(command: TyperCommand | TyperGroup, ctx: Any, kind: str) -> list[Row]:
    """Names and words of every parameter of a kind that is not hidden."""
    parameters = [p for p in command.get_params(ctx) if p.param_type_name == kind]
    records = [parameter.get_help_record(ctx) for parameter in parameters]
    return [record for record in records if record is not None]


def _panel(title: str, rows: Sequence[Row]) -> "RenderableType":
    from rich.panel import Panel
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=title != "Examples")
    for names, words in rows:
        if title == "Examples":  # a line to type is as long as it is
            table.add_row(Text.assemble((names, "bold cyan"), "\n    ", words))
            continue
        table.add_row(Text(names, style="bold cyan"), Text(words))
    return Panel(table, title=title, title_align="left", border_style="dim")


def _first_paragraph(text: str) -> str:
    return " ".join(text.split("\n\n")[0].split())
