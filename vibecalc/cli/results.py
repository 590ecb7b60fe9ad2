"""The commands that look into files and write them for others: parse, call, print, exit code."""

from collections.abc import Sequence
from pathlib import Path

import typer

from vibecalc.cli.completion import quantities
from vibecalc.cli.saying import answer, asked, note, say, say_json, say_written
from vibecalc.cli.sweep import SETTINGS, UNSET, Texts
from vibecalc.core.results.files import SUFFIXES
from vibecalc.errors import UsageError

FILE = typer.Argument(metavar="RESULT", help="Result file (HDF5).")


def info(result: Path = FILE) -> None:
    """List the contents of a result file: its case, each quantity with unit, axes and size."""
    from vibecalc.core.report.contents import contents_object, render_contents
    from vibecalc.core.results.store import read_result

    read = read_result(result)
    answer(lambda: contents_object(read), lambda: render_contents(read))


def get(
    result: Path = FILE,
    path: str = typer.Argument(
        metavar="PATH", help="Quantity, as `info` lists it.", autocompletion=quantities
    ),
    where: list[str] | None = typer.Option(
        None, metavar="AXIS=ENTRY", help="Only this entry of an axis; may be repeated."
    ),
    unit: str = typer.Option("", metavar="UNIT", help="Unit of the values; default: SI."),
) -> None:
    """Print one quantity: a number alone, or comma-separated rows with a column for each axis."""
    from vibecalc.core.results.plain import comma_separated, picked
    from vibecalc.core.results.store import read_result

    entries: dict[str, int | float | str] = {}
    for given in where or ():
        axis, sign, entry = (part.strip() for part in given.partition("="))
        if not (axis and sign and entry):
            raise UsageError(f"--where needs AXIS=ENTRY, as in --where mount=1; found {given!r}")
        entries[axis] = _entry(entry)
    quantity = picked(read_result(result)[path], entries, unit)
    if asked.json:
        from vibecalc.core.report.text import quantity_object

        say_json(quantity_object(quantity))
    say(comma_separated(quantity))


#: what reads and writes shaft lines
EXCHANGE = "vibecalc.torsion.adapters.exchange"
#: what writes measured orders
_ORDERS = "vibecalc.measurement.export"


def export(
    file: Path = typer.Argument(metavar="FILE", help="Result (HDF5) or case (TOML)."),
    wanted: list[str] | None = typer.Argument(
        None,
        metavar="QUANTITY",
        help="Of a result: only these, or groups of them.",
        autocompletion=quantities,
    ),
    output: Path = typer.Option(
        Path("outputs"), "--output", "-o", help="Folder; for a case also a file named .json."
    ),
    csv: bool = typer.Option(False, "--csv", help="Of a result: CSV files (default)."),
    mat: bool = typer.Option(False, "--mat", help="Of a result: a MATLAB file."),
    netcdf: bool = typer.Option(False, "--netcdf", help="Of a result: a netCDF file."),
    orders: bool = typer.Option(
        False, "--orders", help="Of a result: measured orders, for [[reference_table]]."
    ),
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
) -> None:
    """Write the quantities of a result, or the shaft line of a case, for other programs."""
    if file.suffix not in SUFFIXES:
        if wanted or csv or mat or netcdf or orders:
            raise UsageError(f"{file} is no result: quantities and forms are those of a .h5 file")
        _export_line(file, output, settings or (), unset or ())
        return
    if settings or unset:
        raise UsageError("--set and --unset change a case, a result stays as it is")
    from vibecalc.core.results.export import export_result
    from vibecalc.core.results.store import read_result

    if orders:
        from vibecalc.core.results.named import named

        say_written(*named(f"{_ORDERS}:export_orders")(read_result(file), output, file.stem))
        return
    forms = [name for name, asked in (("csv", csv), ("mat", mat), ("netcdf", netcdf)) if asked]
    result = read_result(file)
    written = [
        path
        for form in forms or ["csv"]
        for path in export_result(result, form, output, file.stem, wanted or ())
    ]
    say_written(*written)


def _export_line(case: Path, output: Path, settings: Sequence[str], unset: Sequence[str]) -> None:
    from vibecalc.core.results.named import named
    from vibecalc.core.study.execute import load_checked

    (loaded,) = load_checked([case], settings, unset)
    paths, left = named(f"{EXCHANGE}:export_shaft_line")(loaded, output)
    say_written(*paths, not_carried=list(left))
    if left:
        note(f"not exported: {', '.join(left)}")


def _entry(text: str) -> int | float | str:
    """A number if it is one, else a name or a value with a unit."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
