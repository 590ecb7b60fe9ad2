"""Help pages: panels drawn with rich, without the parts of rich and typer that no page needs.

typer's own pages also import Markdown, syntax colouring and tracebacks, which takes longer than
everything else that `vibecalc --help` does.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from typer.core import TyperCommand, TyperGroup

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

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the page; the formatter stays empty."""
        named = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        rows = [
            (name, _first_paragraph(command.help or ""))
            for name, command in named
            if command is not None and not command.hidden
        ]
        _print_page(self, ctx, rows)


def _print_page(command: TyperCommand | TyperGroup, ctx: Any, commands: list[Row]) -> None:
    from rich.console import Console
    from rich.padding import Padding

    console = Console(highlight=False)
    usage = command.get_usage(ctx).replace("Usage:", "[bold yellow]Usage:[/]", 1)
    console.print(Padding(usage.replace("[OPTIONS]", r"\[OPTIONS]"), 1), style="bold")
    console.print(Padding(command.help or "", (0, 1, 1, 1)), markup=False)
    records = _records(command, ctx)
    for title, rows in (
        ("Arguments", [row for kind, row in records if kind == "argument"]),
        ("Options", [row for kind, row in records if kind == "option"]),
        ("Commands", commands),
    ):
        if rows:
            console.print(_panel(title, rows))


def _records(command: TyperCommand | TyperGroup, ctx: Any) -> list[tuple[str, Row]]:
    """Kind, names and words of every parameter that is not hidden."""

    def all_records() -> Iterator[tuple[str, Row]]:
        for parameter in command.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                yield parameter.param_type_name, record

    return list(all_records())


def _panel(title: str, rows: list[Row]) -> "RenderableType":
    from rich.panel import Panel
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for names, words in rows:
        table.add_row(Text(names, style="bold cyan"), Text(words))
    return Panel(table, title=title, title_align="left", border_style="dim")


def _first_paragraph(text: str) -> str:
    return " ".join(text.split("\n\n")[0].split())
