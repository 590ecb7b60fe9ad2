"""The commands for sweeps: parse, call, print, exit code. Heavy imports stand inside them."""

from pathlib import Path
from typing import Any

import typer

from vibecalc.cli.completion import keys, names_of_keys
from vibecalc.cli.saying import answer, asked, note, say, say_json
from vibecalc.errors import EXIT_FINE, EXIT_POINTS_FAILED

Texts = list[str] | None
SETTINGS = typer.Option(
    None,
    "--set",
    metavar="KEY=VALUE",
    help="Change a key, the value read as TOML.",
    autocompletion=keys,
)
UNSET = typer.Option(
    None, metavar="KEY", help="Remove a key from the case.", autocompletion=names_of_keys
)


def sweep(
    case: Path = typer.Argument(metavar="CASE", help="Case file (TOML)."),
    output: Path | None = typer.Option(
        None, "--output", "-o", help="File; default: outputs/<case>.sweep.h5."
    ),
    grid: list[str] | None = typer.Option(
        None,
        metavar="KEY=SPEC",
        help="An axis: start:stop:n, start:stop:nlog or a,b,c.",
        autocompletion=keys,
    ),
    zipped: list[str] | None = typer.Option(
        None, "--zip", metavar="KEY=SPEC", help="Keys that vary together, as one axis."
    ),
    sample: str | None = typer.Option(
        None, metavar="METHOD:N[:SEED]", help="latin_hypercube, sobol or monte_carlo, N points."
    ),
    keep: list[str] | None = typer.Option(
        None, metavar="PATH", help="A result to keep; may be repeated."
    ),
    jobs: int | None = typer.Option(None, "--jobs", "-j", metavar="N", min=1, help="Processes."),
    timeout: float | None = typer.Option(
        None, metavar="S", help="Time limit for each point, in seconds."
    ),
    resume: bool = typer.Option(False, "--resume", help="Continue from the finished chunks."),
    if_needed: bool = typer.Option(
        False,
        "--if-needed",
        help="Skip a complete file that is up to date: case, files, settings, versions.",
    ),
    fresh: bool = typer.Option(False, "--fresh", help="Replace a sweep that does not match."),
    shard: str | None = typer.Option(None, metavar="I/N", help="Only the I-th of N parts, from 1."),
    cluster: str | None = typer.Option(
        None, metavar="ADDRESS", help="Dask scheduler: address or file."
    ),
    dry_run: bool = typer.Option(
        False, "--dry-run", help="Print the plan and an estimate of the time."
    ),
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
) -> None:
    """Run a case at many points into one file; --resume continues an interrupted sweep."""
    from vibecalc.cli.outputs import check_suffix
    from vibecalc.core.study.execute import load_checked
    from vibecalc.core.study.sweep.prepare import (
        Options,
        parse_shard,
        prepare,
        processors,
        seconds_allowed,
        sweep_settings,
    )

    part = parse_shard(shard)
    if timeout is not None:
        seconds_allowed(timeout)
    texts = sweep_settings(grid or (), zipped or (), sample, keep or ())
    changes = [*(settings or ()), *texts], unset or ()
    suffix = f".{part[0]}of{part[1]}" if part[1] > 1 else ""
    target = output or Path("outputs") / f"{case.stem}.sweep{suffix}.h5"
    check_suffix(target)
    if if_needed:
        from vibecalc.core.case.inputs import is_up_to_date
        from vibecalc.errors import UsageError

        if part[1] > 1:
            raise UsageError("--if-needed is for a whole sweep, leave --shard out")
        if is_up_to_date(target, case, *changes):
            say(f"{target} is up to date")
            raise typer.Exit(_kept(target))
    (loaded,) = load_checked([case], *changes)
    options = Options(
        output=target,
        jobs=jobs,
        timeout=timeout,
        resume=resume,
        fresh=fresh or if_needed,
        again=if_needed,
        shard=part,
        cluster=cluster,
        progress=not (asked.silent or asked.verbose),
        note=note,
    )
    prepared = prepare(loaded, jobs or processors())
    if dry_run:
        from vibecalc.core.report.sweep.text import render_forecast
        from vibecalc.core.study.sweep.prepare import forecast

        found = forecast(prepared, options)
        answer(lambda: found, lambda: render_forecast(loaded, found, target))
        return
    from vibecalc.core.results.layout import UNLUCKY
    from vibecalc.core.study.sweep.run import sweep as compute

    made = compute(prepared, options)
    # of another try, with more time or on another machine, such points may have a result
    line = "" if made.counts.keys() & {*UNLUCKY} else loaded.inputs
    _report(target, line, taken_up=made.taken_up, seconds=made.seconds)
    raise typer.Exit(EXIT_POINTS_FAILED if made.failed else EXIT_FINE)


def merge(
    parts: list[Path] = typer.Argument(metavar="PART", help="Files of parts of one sweep."),
    output: Path = typer.Option(..., "--output", "-o", help="File to write."),
) -> None:
    """Merge the parts of a sweep into one file; exit 4 if points failed or are still missing."""
    from vibecalc.cli.outputs import check_suffix
    from vibecalc.core.report.sweep.text import missing_words
    from vibecalc.core.results.layout import DONE
    from vibecalc.core.study.execute import provenance
    from vibecalc.core.study.sweep.assemble import merge as put_together

    check_suffix(output)
    made = put_together(parts, output, provenance())
    if made.missing:
        note(f"missing points: {missing_words(made.missing)}")
    _report(output, "", taken_up=0, seconds=0.0)
    raise typer.Exit(EXIT_FINE if made.counts.keys() <= {DONE} else EXIT_POINTS_FAILED)


def _kept(output: Path) -> int:
    """Exit code of a sweep that is there already, printed where JSON is asked for."""
    from vibecalc.core.report.sweep.text import outcome_object
    from vibecalc.core.report.sweep.view import view_of
    from vibecalc.core.results.layout import DONE
    from vibecalc.core.results.sweep_file import open_sweep

    with open_sweep(output) as opened:
        counts = opened.counts()
        if asked.json:
            points = sum(counts.values())
            more = {"taken_up": points, "seconds": 0.0, "written": []}
            say_json(outcome_object(view_of(opened), output) | more)
    return EXIT_FINE if counts.keys() <= {DONE} else EXIT_POINTS_FAILED


def _report(output: Path, made_from: str, **more: Any) -> None:
    """Write the report next to the file, print it or the object, and say on stderr what failed.

    `made_from` is the line by which `--if-needed` knows both again; the object has `more`.
    """
    from vibecalc.cli.outputs import write_text
    from vibecalc.core.case.inputs import mark
    from vibecalc.core.report.defects import reporting
    from vibecalc.core.report.sweep.text import failure_words, outcome_object, render_sweep
    from vibecalc.core.report.sweep.view import view_of
    from vibecalc.core.results.sweep_file import open_sweep

    with reporting("the text report", output), open_sweep(output) as opened:
        view = view_of(opened)
        text = render_sweep(view)
        failed = failure_words(view)
        outcome = outcome_object(view, output) if asked.json else {}
    beside = output.with_suffix(".txt")
    write_text(text, beside)
    mark(output, made_from, text.encode("utf-8"))
    for line in [f"some points of {output} have no result:", *failed] if failed else []:
        note(line)
    if asked.json:
        say_json(outcome | more | {"written": [str(output), str(beside)]})
    say(text)
    say(f"wrote {output} and {beside.name}")
