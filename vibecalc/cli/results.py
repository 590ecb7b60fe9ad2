"""The commands that look into result files: parse, call, print, exit code."""

from pathlib import Path
from typing import Annotated

import typer

from vibecalc.cli.sweep import Json
from vibecalc.errors import UsageError

File = Annotated[Path, typer.Argument(metavar="RESULT", help="Result file (HDF5).")]


def info(result: File, json: Json = False) -> None:
    """Say what a result file holds: its case, and each quantity with unit, axes and size."""
    from vibecalc.core.report.contents import contents_object, render_contents
    from vibecalc.core.results.store import read_result

    read = read_result(result)
    if json:
        import json as format_json

        typer.echo(format_json.dumps(contents_object(read), indent=2, allow_nan=False))
        return
    typer.echo(render_contents(read), nl=False)


def get(
    result: File,
    path: Annotated[str, typer.Argument(metavar="PATH", help="Quantity, as `info` lists it.")],
    where: Annotated[
        list[str] | None,
        typer.Option(metavar="AXIS=ENTRY", help="Only this entry of an axis; may be repeated."),
    ] = None,
    unit: Annotated[
        str, typer.Option(metavar="UNIT", help="Unit of the values; default: SI.")
    ] = "",
    json: Json = False,
) -> None:
    """Print one quantity: a number alone, or comma-separated rows with a column for each axis."""
    from vibecalc.core.results.plain import comma_separated, picked, quantity_at
    from vibecalc.core.results.store import read_result

    entries: dict[str, int | float | str] = {}
    for given in where or ():
        axis, sign, entry = (part.strip() for part in given.partition("="))
        if not (axis and sign and entry):
            raise UsageError(f"--where needs AXIS=ENTRY, as in --where mount=1; found {given!r}")
        entries[axis] = _entry(entry)
    quantity = picked(quantity_at(read_result(result), path), entries, unit)
    if json:
        import json as format_json

        from vibecalc.core.report.text import quantity_object

        typer.echo(format_json.dumps(quantity_object(quantity), indent=2, allow_nan=False))
        return
    typer.echo(comma_separated(quantity), nl=False)


def _entry(text: str) -> int | float | str:
    """A number if it is one, else a name or a value with a unit."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
