"""The command `accuracy`: parse, call, print, exit code. Heavy imports stand inside it."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vibecalc.errors import UsageError

if TYPE_CHECKING:
    from vibecalc.results.record import Result


def accuracy(
    case: Annotated[Path, typer.Argument(metavar="CASE", help="Case file (TOML).")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File; default: outputs/<case>.accuracy.h5."),
    ] = None,
    stage: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this stage; may be repeated."),
    ] = None,
    topic: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this topic of it; may be repeated."),
    ] = None,
    longest: Annotated[
        float,
        typer.Option(metavar="S", help="Seconds after which a ladder of settings ends."),
    ] = 5.0,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a key, the value read as TOML."),
    ] = None,
    unset: Annotated[
        list[str] | None, typer.Option(metavar="KEY", help="Take a key out of the case.")
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print JSON on stdout and nothing else.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print no table.")] = False,
) -> None:
    """Measure every method of a case: seconds against error over a ladder of settings."""
    from vibecalc.accuracy.environment import pin_threads

    threads = pin_threads()
    if not (math.isfinite(longest) and longest > 0.0):
        raise UsageError(f"--longest needs a number of seconds above 0, found {longest:g}")
    if output is not None and output.suffix not in (".h5", ".hdf5"):
        raise UsageError(f"-o {output}: a result file ends in .h5")
    from vibecalc.accuracy.measure import Timed
    from vibecalc.accuracy.run import Asked, measure_case
    from vibecalc.study.load import load_checked

    (loaded,) = load_checked([case], settings or (), unset or ())
    path = output or Path("outputs") / f"{loaded.name}.accuracy.h5"
    asked = Asked(
        stages=stage or (),
        topics=topic or (),
        timed=Timed(longest=longest),
        progress=not (quiet or json),
        threads=threads,
    )
    _report(measure_case(loaded, asked), path, json, quiet)


def _report(result: "Result", path: Path, json: bool, quiet: bool) -> None:
    """Write the file, the table and, with matplotlib, the picture; print what is asked for."""
    from vibecalc.report.accuracy.text import render_accuracy
    from vibecalc.report.files import write_text
    from vibecalc.report.plots import draw_accuracy
    from vibecalc.results.store import write_result

    text = render_accuracy(result)
    write_result(result, path)
    write_text(text, path.with_suffix(".txt"))
    try:
        pictures = draw_accuracy(result, path.with_suffix(".png"))
    except UsageError as error:
        pictures = []
        typer.echo(f"no picture: {error}", err=True)
    if json:
        import json as format_json

        from vibecalc.report.accuracy.machine_readable import accuracy_object

        found = accuracy_object(result, path)
        typer.echo(format_json.dumps(found, indent=2, allow_nan=False))
    elif not quiet:
        names = [path.with_suffix(".txt").name, *(picture.name for picture in pictures)]
        typer.echo(text, nl=False)
        typer.echo(f"wrote {path}, {' and '.join(names)}")
