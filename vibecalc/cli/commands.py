"""The command line: parse, call, print, exit code. Heavy imports stand inside the commands."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vibecalc.cli.completion import beginnings, completion, names_of_pictures
from vibecalc.cli.help_page import Command, Group
from vibecalc.cli.results import EXCHANGE, export, get, info
from vibecalc.cli.saying import asked, note, say, say_json, say_written, spoken
from vibecalc.cli.sweep import Settings, Unset, merge, sweep
from vibecalc.core.results.visible import put
from vibecalc.errors import (
    EXIT_BUG,
    EXIT_DIFFERS,
    EXIT_FINE,
    Defect,
    NumericalFailure,
    UsageError,
    VibecalcError,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.results.record import Result

# ----------------------------------------------------------------------------
# The command `accuracy`: parse, call, print, exit code. Heavy imports stand inside it.
# ----------------------------------------------------------------------------


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
        typer.Option(metavar="S", help="Seconds for the whole case, shared between its questions."),
    ] = 30.0,
    settings: Settings = None,
    unset: Unset = None,
) -> None:
    """Measure every method of a case: seconds against error over a series of settings."""
    from vibecalc.cli.outputs import check_suffix
    from vibecalc.core.accuracy.environment import pin_threads

    threads = pin_threads()
    if output is not None:
        check_suffix(output)
    from vibecalc.core.accuracy.run import measure_case
    from vibecalc.core.study.execute import load_checked

    (loaded,) = load_checked([case], settings or (), unset or ())
    path = output or Path("outputs") / f"{loaded.name}.accuracy.h5"
    measured = measure_case(
        loaded, stage or (), topic or (), longest=longest, progress=not asked.silent,
        threads=threads,
    )  # fmt: skip
    _write_measured(measured, path)


def _write_measured(result: "Result", path: Path) -> None:
    """Write the file, the table and, with matplotlib, the picture; print what is asked for."""
    from vibecalc.cli.outputs import write_text
    from vibecalc.core.report.accuracy import render_answer
    from vibecalc.core.report.defects import as_defect, defects
    from vibecalc.core.report.plots import draw_file
    from vibecalc.core.report.sweep.text import report_file
    from vibecalc.core.results.store import write_result

    write_result(result, path)
    written = [path]
    with defects("the report") as met:
        write_text(report_file(result), path.with_suffix(".txt"))
        written.append(path.with_suffix(".txt"))
        try:
            written += draw_file(path, path.parent)
        except UsageError as error:
            note(f"no picture: {error}")
        if asked.json:
            from vibecalc.core.report.accuracy import accuracy_object

            say_json(accuracy_object(result, path) | {"written": [str(one) for one in written]})
        else:
            say(render_answer(result), nl=False)
            say(f"wrote {path}, {' and '.join(one.name for one in written[1:])}")
    if met:
        raise as_defect(met, path)


# ----------------------------------------------------------------------------
# The command line: parse, call, print, exit code. Heavy imports stand inside the commands.
# ----------------------------------------------------------------------------

HELP = "Vibration of machines with pistons: a TOML case in, an HDF5 result and a report out."

app = typer.Typer(
    cls=Group,
    help=HELP,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Cases = Annotated[list[Path], typer.Argument(metavar="CASE", help="Case files (TOML).")]
Results = Annotated[list[Path], typer.Argument(metavar="RESULT", help="Result files (HDF5).")]
Full = Annotated[bool, typer.Option("--full", help="With --json: print the arrays, too.")]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="New file to write, instead of stdout.")
]
Force = Annotated[bool, typer.Option("--force", help="Write over files that exist.")]
Folder = Annotated[
    Path | None, typer.Option("--output", "-o", help="Folder for the pictures; made if missing.")
]


def _show_version(asked: bool) -> None:
    if asked:
        from vibecalc import __version__

        put(f"vibecalc {__version__}\n")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    pass


def command(function: "Callable[..., None]") -> "Callable[..., None]":
    """Enter a command of the program, with the options that all have."""
    app.command(cls=Command)(spoken(function))
    return function


@command
def run(
    cases: Cases,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", help="File, or folder when it exists or ends with '/'."),
    ] = None,
    settings: Settings = None,
    unset: Unset = None,
    if_needed: Annotated[
        bool,
        typer.Option(
            "--if-needed", help="Skip results that are up to date: case, files, settings, versions."
        ),
    ] = False,
    full: Full = False,
) -> None:
    """Run cases: write outputs/<case>.h5 and outputs/<case>.txt and print a summary."""
    from vibecalc.cli.outputs import result_paths, up_to_date, write_outputs
    from vibecalc.core.report.defects import as_defect, defects

    changes = (settings or (), unset or ())
    kept = up_to_date(cases, output, *changes) if if_needed else {}
    left = [case for case in cases if case not in kept]
    loaded = _load(left, *changes) if left else []
    names = [*(case.name for case in loaded), *(path.stem for path in kept)]
    paths = dict(zip(names, result_paths(names, output), strict=True))
    objects: list[dict[str, Any]] = []
    for path in kept.values():
        if asked.json:
            from vibecalc.core.report.text import as_json
            from vibecalc.core.results.store import read_result

            objects.append(as_json(read_result(path), path, full=full) | {"written": []})
        say(f"{path} is up to date")

    def run_one(case: "LoadedCase") -> str:
        result, path = _execute(case), paths[case.name]
        failed = result.record.failure
        written = write_outputs(result, path, "" if failed else case.inputs)  # tried again
        with defects("the summary") as met:
            if asked.json:
                from vibecalc.core.report.text import as_json

                files = {"written": [str(one) for one in written]}
                objects.append(as_json(result, path, full=full) | files)
            elif not asked.quiet:
                from vibecalc.core.report.terminal import print_summary

                print_summary(result, path)
        if met:
            raise as_defect(met, path)
        return failed

    raise typer.Exit(_for_each(loaded, run_one, objects))


@command
def check(
    cases: Cases,
    settings: Settings = None,
    unset: Unset = None,
    depfile: Annotated[
        Path | None,
        typer.Option(metavar="NAME.d", help="Write for make: which files NAME is made from."),
    ] = None,
) -> None:
    """Validate cases and show what a run would do and why. Nothing is computed."""
    from vibecalc.core.report.check import check_rows

    if depfile is not None and (len(cases) > 1 or depfile.suffix != ".d"):
        raise UsageError(
            "--depfile needs one case, and the name of its result with .d behind it, as in "
            "--depfile outputs/generator.h5.d"
        )
    loaded = _load(cases, settings, unset)
    plans = [(case, *check_rows(case.case)) for case in loaded]
    if depfile is not None:
        from vibecalc.cli.outputs import write_text
        from vibecalc.core.case.inputs import dependencies

        (case,) = loaded
        if not case.inputs:
            raise UsageError(f"--depfile needs a case that is a file, not {case.path}")
        write_text(dependencies(depfile.with_suffix(""), case.path, case.inputs), depfile)
    if asked.json:
        from vibecalc.core.report.check import plan_object

        say_json([plan_object(case, rows, total) for case, rows, total in plans])
        return
    from vibecalc.core.report.check import render_plan

    shown = (render_plan(str(case.path), case.case, rows, total) for case, rows, total in plans)
    say("\n\n".join(shown))


@command
def verify(
    cases: Cases,
    settings: Settings = None,
    unset: Unset = None,
    full: Full = False,
) -> None:
    """Run cases, exit 1 if a counted reference or limit is missed or undecided; no files."""
    from vibecalc.core.report.verdicts import counted_misses

    objects: list[dict[str, Any]] = []
    misses: list[int] = []
    loaded = _load(cases, settings, unset)

    def verify_one(case: "LoadedCase") -> str:
        result = _execute(case)
        misses.append(counted_misses(result))
        if asked.json:
            from vibecalc.core.report.text import as_json

            objects.append(as_json(result, None, full=full))
        else:
            from vibecalc.core.report.text import render_verdicts

            say(render_verdicts(result))
        missed = EXIT_DIFFERS if misses[-1] else EXIT_FINE
        if asked.json:
            objects[-1]["exit_code"] = missed
        return result.record.failure

    worst = _for_each(loaded, verify_one, objects)
    raise typer.Exit(max(worst, EXIT_DIFFERS if any(misses) else EXIT_FINE))


@command
def report(
    results: Results,
    full: Annotated[bool, typer.Option("--full", help="List every quantity.")] = False,
    html: Annotated[
        bool, typer.Option("--html", help="Write a page with pictures next to each file.")
    ] = False,
) -> None:
    """Print the text report of result files; nothing is recomputed."""
    if html:
        from vibecalc.cli.outputs import write_text
        from vibecalc.core.report.page import html_page

        def write_page(path: Path) -> None:
            page = path.with_suffix(".html")
            write_text(html_page(path, full=full), page)
            written.append(str(page))
            say(str(page))

        written: list[str] = []
        failed = _each_result(results, write_page)
        if asked.json:
            say_json({"written": written})
    elif asked.json:
        from vibecalc.core.report.sweep.text import file_object

        objects: list[dict[str, Any]] = []
        failed = _each_result(results, lambda path: objects.append(file_object(path, full=full)))
        say_json(objects)
    else:
        from vibecalc.core.report.sweep.text import file_lines
        from vibecalc.core.report.writing import screen, text_of

        def print_report(path: Path) -> None:
            say(text_of(file_lines(path, full=full), screen()), nl=False)

        failed = _each_result(results, print_report)
    if failed:
        raise typer.Exit(failed)


def _each_result(results: "Sequence[Path]", work: "Callable[[Path], None]") -> int:
    """Words or pictures of every result; what fails by a fault of ours stops none of the others."""
    from vibecalc.core.report.defects import as_defect, defects

    worst = EXIT_FINE
    for path in results:
        with defects("the whole") as met:
            work(path)
        if met:
            note(f"error: {as_defect(met, path)}")
            worst = EXIT_BUG
    return worst


@command
def diff(
    reference: Annotated[
        Path, typer.Argument(metavar="REFERENCE", help="Golden result file, or folder of them.")
    ],
    candidates: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT",
            help="Files, or folders, held against it or the golden file of a name.",
        ),
    ],
    rules: Annotated[Path | None, typer.Option(help="Tolerances per quantity (TOML).")] = None,
    junit: Annotated[Path | None, typer.Option(help="Also write a JUnit XML file.")] = None,
    partial: Annotated[
        bool, typer.Option("--partial", help="Golden files of other results are not missed.")
    ] = False,
    accept: Annotated[
        bool, typer.Option("--accept", help="Make the candidate's numbers the golden ones.")
    ] = False,
) -> None:
    """Compare results with tolerances that know physics: exit 0 same, 1 differ, 2 unusable."""
    from vibecalc.core.results.compare import file_pairs

    pairs = file_pairs(reference, candidates, partial=partial)
    if accept:
        from vibecalc.core.results.compare import accept as make_golden

        for option, given in (("--rules", rules), ("--junit", junit)):
            if given:
                raise UsageError(f"--accept compares nothing, leave {option} out")
        made: list[str] = []
        for pair in pairs:
            if pair.result is None:
                note(f"{pair.golden} has no result, and stays as it is")
                continue
            make_golden(pair.result, pair.golden)
            made.append(str(pair.golden))
            say(f"{pair.golden} now holds the numbers of {pair.result}")
        if asked.json:
            say_json({"written": made})
        return
    from vibecalc.core.report.differences import differences_object, render_files, render_junit
    from vibecalc.core.results.compare import compare_files
    from vibecalc.core.results.compare_rules import Rules, read_rules

    try:
        tolerances = Rules() if rules is None else read_rules(rules)
        compared = compare_files(pairs, tolerances)
    except UsageError as error:  # of the rules: nothing is compared
        if junit is not None:
            _write_junit(render_junit([pair.refused(str(error)) for pair in pairs]), junit)
        raise
    if junit is not None:
        _write_junit(render_junit(compared), junit)
    unused = [] if partial else tolerances.unused(path for one in compared for path in one.paths)
    for pattern in unused:
        note(f"warning: the rule for {pattern!r} in {rules} fits no quantity")
    for one in compared:
        if one.problem:
            note(f"error: {one.problem}")
    if asked.json:
        say_json(differences_object(compared, unused))
    else:
        say(render_files(compared, by_name=reference.is_dir()), nl=False)
    raise typer.Exit(max(one.exit_code for one in compared))


def _write_junit(text: str, path: Path) -> None:
    from vibecalc.cli.outputs import write_text

    write_text(text, path)


@command
def plot(
    results: Results,
    output: Folder = None,
    formats: Annotated[
        str, typer.Option("--format", metavar="NAMES", help="svg, pdf, png, by commas.")
    ] = "png",
    dpi: Annotated[
        int | None, typer.Option(metavar="N", help="Dots in an inch of a png, 50 to 1200.")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Only these pictures, by commas or repeated.",
            autocompletion=names_of_pictures,
        ),
    ] = None,
    no_title: Annotated[
        bool, typer.Option("--no-title", help="Leave out the title of the figures.")
    ] = False,
) -> None:
    """Draw the pictures of result files next to them, or into a folder, 160 mm wide."""
    from vibecalc.core.report.defects import failed_parts
    from vibecalc.core.report.plots import draw_files, look_of

    look = look_of(formats, dpi, only or (), not no_title)
    drawn: list[Path] = []
    made = draw_files(results, output, look)

    def draw(path: Path) -> None:
        pictures = next(made)[1]
        drawn.extend(pictures)
        for picture in pictures:
            say(str(picture))
        if not pictures and not failed_parts():
            note(f"{path}: nothing to draw, it holds no curve or map")

    failed = _each_result(results, draw)
    if asked.json:
        say_json({"written": [str(picture) for picture in drawn]})
    if failed:
        raise typer.Exit(failed)


@command
def new(
    scene: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="Kind of scene; `list` names them.", autocompletion=beginnings
        ),
    ] = "list",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File to write; of an example, it or a folder."),
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Copy a shipped case of this NAME and its files.")
    ] = False,
    assembly: Annotated[
        Path | None,
        typer.Option("--from", metavar="JSON", help="Instead: the line of an openTorsion file."),
    ] = None,
    force: Force = False,
    schema: Annotated[
        bool, typer.Option("--schema", help="With -o: also the JSON schema that editors read.")
    ] = False,
) -> None:
    """Write a commented starter case to stdout or to a file, or a shipped case with its files."""
    from vibecalc.cli import starters

    if schema and output is None:
        raise UsageError("--schema writes the schema next to the case, which needs -o")
    if assembly is not None:
        from vibecalc.core.results.named import named

        if scene != "list" or example:
            what = "--example" if example else repr(scene[:60])
            raise UsageError(f"--from writes a case of its own, leave {what} out")
        text: str = named(f"{EXCHANGE}:case_of_assembly")(assembly)
    elif example:
        if schema:
            raise UsageError("--schema goes with a starter; `vibecalc schema -o FOLDER` writes one")
        if scene == "list":
            if asked.json:
                say_json(starters.examples())
            say(starters.example_table())
            return
        copied = starters.files_of_example(scene)
        file = output is not None and output.suffix == ".toml"
        folder = output.parent if output and file else output or Path()
        files = {folder / name: data for name, data in copied.items()}
        if output and file:  # the case comes first
            files = {output: files.pop(next(iter(files)))} | files
        _write_new(files, force)
        say_written(*files)
        return
    elif scene == "list":
        if asked.json:
            say_json(starters.scenes())
        for name, about in starters.scenes().items():
            say(f"{name:<13}  {about}")
        return
    else:
        text = starters.starter(scene)
    if schema and output is not None:
        from vibecalc.cli.editors import kind_in, with_directive, write_schema

        kind = kind_in(text)
        _write_new({output: with_directive(text, kind).encode("utf-8")}, force)
        say_written(output, write_schema(output.parent, kind))
    else:
        _write_text(text, output, force)


@command
def schema(
    kind: Annotated[
        str, typer.Option(metavar="KIND", help="Of cases of one kind of machine alone.")
    ] = "",
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", help="New file, or folder when it exists or ends with '/'."),
    ] = None,
    force: Force = False,
) -> None:
    """Print the JSON schema of case files, for editors."""
    from vibecalc.cli.editors import schema_text, write_schema

    if output is not None and (output.endswith("/") or Path(output).is_dir()):
        say_written(write_schema(Path(output), kind))
    elif output is None and asked.json:
        put(schema_text(kind))
    else:
        _write_text(schema_text(kind), Path(output) if output else None, force)


def help_(
    ctx: typer.Context,
    command: Annotated[
        str | None,
        typer.Argument(metavar="COMMAND", help="Name of a command, or `start`; default: all."),
    ] = None,
) -> None:
    """Show the help page of a command, or how to start."""
    program = ctx.parent
    assert program is not None
    if asked.quiet:
        return
    if command == "start":
        from vibecalc.cli.starters import carried

        say((carried("docs") / "start.md").read_text(encoding="utf-8"), nl=False)
        return
    if command is None:
        program.get_help()
        return
    group: Any = program.command
    named = group.get_command(program, command)
    if named is None:
        from vibecalc.core.results.select import nearest

        near = ", ".join(nearest(command, group.list_commands(program))[:3])
        raise UsageError(f"no command {command[:40]!r}; there are {near} and others")
    named.get_help(typer.Context(named, info_name=command, parent=program))


def _load(paths: list[Path], *changes: "Sequence[str] | None") -> "list[LoadedCase]":
    from vibecalc.core.study.execute import load_checked

    return load_checked(paths, *(change or () for change in changes))


def _for_each(
    cases: "list[LoadedCase]",
    work: "Callable[[LoadedCase], str]",
    objects: list[dict[str, Any]],
) -> int:
    """Work on every case, which says why it failed; the worst exit code. Prints `objects`."""
    worst = EXIT_FINE
    for case in cases:
        try:
            failure, code = work(case), NumericalFailure.exit_code
        except VibecalcError as error:
            if asked.json:
                objects.append({"case": case.name, "error": error.as_object()})
            elif len(cases) == 1:
                raise
            failure, code = str(error), error.exit_code
        except Exception as error:
            if len(cases) == 1 and not asked.json:
                raise
            import traceback

            from vibecalc.core.report.defects import described

            traceback.print_exc()
            defect = Defect(f"a bug in vibecalc, please report it: {described(error)}")
            objects += [{"case": case.name, "error": defect.as_object()}] if asked.json else []
            failure, code = str(defect), defect.exit_code
        if failure:
            if asked.json:
                objects[-1].setdefault("error", NumericalFailure(failure).as_object())
                objects[-1]["exit_code"] = code
            note(f"error: {case.path}: {failure}")
            worst = max(worst, code)
    if asked.json:
        say_json([{**one, "exit_code": one.get("exit_code", EXIT_FINE)} for one in objects])
    return worst


def _execute(case: "LoadedCase") -> "Result":
    from vibecalc.core.study.execute import execute

    return execute(case, progress=not (asked.silent or asked.verbose))


def _write_text(text: str, output: Path | None, force: bool) -> None:
    if output is None:
        if asked.json:
            say_json({"text": text})
        say(text, nl=False)
    else:
        _write_new({output: text.encode("utf-8")}, force)
        say_written(output)


def _write_new(files: dict[Path, bytes], force: bool) -> None:
    """Write files that do not exist yet, all or none; with `force` others too."""
    from vibecalc.core.results.files import write_together

    for path in files:
        if path.exists() and not force:
            raise UsageError(f"{path} exists already; choose another place or add --force")
    write_together(list(files.items()))


for one in (sweep, merge, accuracy, info, get, export):
    command(one)
# what these print is for a person and for a shell: JSON of it would serve nobody
app.command(cls=Command)(spoken(completion, json=False))
app.command("help", cls=Command)(spoken(help_, json=False))
