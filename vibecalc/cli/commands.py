"""The command line: parse, call, print, exit code. Heavy imports stand inside the commands."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from vibecalc.cli.completion import beginnings, completion, names_of_pictures
from vibecalc.cli.help_page import Command, Group
from vibecalc.cli.migration import migrate
from vibecalc.cli.results import EXCHANGE, export, get, info
from vibecalc.cli.saying import answer, asked, note, say, say_json, say_written, spoken
from vibecalc.cli.sweep import SETTINGS, UNSET, Texts, merge, sweep
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


def accuracy(
    case: Path = typer.Argument(metavar="CASE", help="Case file (TOML)."),
    output: Path | None = typer.Option(
        None, "--output", "-o", help="File; default: outputs/<case>.accuracy.h5."
    ),
    stage: list[str] | None = typer.Option(
        None, metavar="NAME", help="Only this stage; may be repeated."
    ),
    topic: list[str] | None = typer.Option(
        None, metavar="NAME", help="Only this topic of it; may be repeated."
    ),
    longest: float = typer.Option(
        30.0, metavar="S", help="Time limit for the case in seconds, shared by its topics."
    ),
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
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
    result = measure_case(
        loaded, stage or (), topic or (), longest=longest, progress=not asked.silent,
        threads=threads,
    )  # fmt: skip
    from vibecalc.cli.outputs import write_text
    from vibecalc.core.report.accuracy import accuracy_object, render_answer
    from vibecalc.core.report.defects import reporting
    from vibecalc.core.report.plots import draw_file
    from vibecalc.core.report.sweep.text import report_file
    from vibecalc.core.results.store import write_result

    write_result(result, path)
    written = [path, path.with_suffix(".txt")]
    with reporting("the report", path):
        write_text(report_file(result), written[1])
        try:
            written += draw_file(path, path.parent)
        except UsageError as error:
            note(f"no picture: {error}")
        names = " and ".join(one.name for one in written[1:])
        answer(
            lambda: accuracy_object(result, path) | {"written": [str(one) for one in written]},
            lambda: f"{render_answer(result)}wrote {path}, {names}",
        )


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

CASES = typer.Argument(metavar="CASE", help="Case files (TOML).")
RESULTS = typer.Argument(metavar="RESULT", help="Result files (HDF5).")
FULL = typer.Option(False, "--full", help="With --json: include the arrays.")
FORCE = typer.Option(False, "--force", help="Overwrite existing files.")


def _show_version(asked: bool) -> None:
    if asked:
        from vibecalc import __version__

        put(f"vibecalc {__version__}\n")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(
        False, "--version", callback=_show_version, is_eager=True, help="Show the version."
    ),
) -> None:
    pass


def command(function: "Callable[..., None]") -> "Callable[..., None]":
    """Enter a command of the program, with the options that all have."""
    app.command(cls=Command)(spoken(function))
    return function


@command
def run(
    cases: list[Path] = CASES,
    output: str | None = typer.Option(
        None, "--output", "-o", help="File, or folder when it exists or ends with '/'."
    ),
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
    if_needed: bool = typer.Option(
        False,
        "--if-needed",
        help="Skip results that are up to date: case, files, settings, versions.",
    ),
    full: bool = FULL,
) -> None:
    """Run cases: write outputs/<case>.h5 and outputs/<case>.txt and print a summary."""
    from vibecalc.cli.outputs import result_paths, write_outputs
    from vibecalc.core.case.inputs import is_up_to_date
    from vibecalc.core.report.defects import reporting

    changes = (settings or (), unset or ())
    kept: dict[Path, Path] = {}
    if if_needed:
        targets = result_paths([case.stem for case in cases], output)
        pairs = zip(cases, targets, strict=True)
        kept = {case: path for case, path in pairs if is_up_to_date(path, case, *changes)}
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

    def run_one(case: "LoadedCase") -> Done:
        result, path = _execute(case), paths[case.name]
        failed, told = result.record.failure, {}
        written = write_outputs(result, path, "" if failed else case.inputs)  # tried again
        with reporting("the summary", path):
            if asked.json:
                from vibecalc.core.report.text import as_json

                told = as_json(result, path, full=full)
                told["written"] = [str(one) for one in written]
            elif not asked.quiet:
                from vibecalc.core.report.terminal import print_summary

                print_summary(result, path)
        return told, failed

    raise typer.Exit(_for_each(loaded, run_one, objects))


@command
def check(
    cases: list[Path] = CASES,
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
    depfile: Path | None = typer.Option(
        None, metavar="NAME.d", help="Write a rule for make: the input files of NAME."
    ),
) -> None:
    """Validate cases and show what a run would do and why. Nothing is computed."""
    from vibecalc.core.report.check import check_rows, plan_object, render_plan

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
    answer(
        lambda: [plan_object(*plan) for plan in plans],
        lambda: "\n\n".join(
            render_plan(str(case.path), case.case, rows, total) for case, rows, total in plans
        ),
    )


@command
def verify(
    cases: list[Path] = CASES,
    settings: Texts = SETTINGS,
    unset: Texts = UNSET,
    full: bool = FULL,
) -> None:
    """Run cases, exit 1 if a counted reference or limit is missed or undecided; no files."""
    from vibecalc.core.report.text import as_json, render_verdicts
    from vibecalc.core.report.verdicts import counted_misses

    codes: list[int] = []

    def verify_one(case: "LoadedCase") -> Done:
        result = _execute(case)
        codes.append(EXIT_DIFFERS if counted_misses(result) else EXIT_FINE)
        say(render_verdicts(result))
        told = as_json(result, None, full=full) | {"exit_code": codes[-1]} if asked.json else {}
        return told, result.record.failure

    worst = _for_each(_load(cases, settings, unset), verify_one, [])
    raise typer.Exit(max([worst, *codes]))


@command
def report(
    results: list[Path] = RESULTS,
    full: bool = typer.Option(False, "--full", help="List every quantity."),
    html: bool = typer.Option(
        False, "--html", help="Write a page with pictures, next to each file if no -o is given."
    ),
    output: str | None = typer.Option(
        None,
        "--output",
        "-o",
        help="File in .html or .txt, or folder that exists or ends with '/' (--html: pages).",
    ),
) -> None:
    """Print the report of result files, or write it to a file; nothing is recomputed."""
    from vibecalc.cli.outputs import report_path, write_text
    from vibecalc.core.report.sweep.text import file_lines, file_object
    from vibecalc.core.report.writing import screen, text_of

    told: list[Any] = []

    def show(path: Path) -> None:
        target = report_path(path, output, html, len(results) > 1)
        if target is not None:
            if target.suffix == ".html":
                from vibecalc.core.report.page import html_page

                write_text(html_page(path, full=full), target)
            else:
                write_text(text_of(file_lines(path, full=full)), target)
            told.append(str(target))
            say(str(target))
        elif asked.json:
            told.append(file_object(path, full=full))
        else:
            say(text_of(file_lines(path, full=full), screen()))

    _each_result(results, show, lambda: {"written": told} if html or output else told)


def _each_result(
    results: "Sequence[Path]", work: "Callable[[Path], None]", told: "Callable[[], object]"
) -> None:
    """Words or pictures of every result; what fails by a fault of ours stops none of the others.

    `told` is the object of `--json` in the end.
    """
    from vibecalc.core.report.defects import reporting

    worst = EXIT_FINE
    for path in results:
        try:
            with reporting("the whole", path):
                work(path)
        except Defect as defect:
            note(f"error: {defect}")
            worst = EXIT_BUG
    if asked.json:
        say_json(told())
    if worst:
        raise typer.Exit(worst)


@command
def diff(
    reference: Path = typer.Argument(
        metavar="REFERENCE", help="Golden result file, or folder of them."
    ),
    candidates: list[Path] = typer.Argument(
        ...,
        metavar="RESULT",
        help="Files or folders to compare with the golden file of the same name.",
    ),
    rules: Path | None = typer.Option(None, help="Tolerances per quantity (TOML)."),
    junit: Path | None = typer.Option(None, help="Also write a JUnit XML file."),
    partial: bool = typer.Option(False, "--partial", help="Ignore golden files without a result."),
    accept: bool = typer.Option(False, "--accept", help="Replace the golden file by the result."),
) -> None:
    """Compare results with golden files within tolerances: exit 0 same, 1 differ, 2 unusable."""
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
    from vibecalc.cli.outputs import write_text
    from vibecalc.core.report.differences import differences_object, render_files, render_junit
    from vibecalc.core.results.compare_rules import Rules, read_rules

    error = None
    try:
        tolerances = Rules() if rules is None else read_rules(rules)
        compared = [pair.compared(tolerances) for pair in pairs]
    except UsageError as met:  # of the rules: nothing is compared
        error, compared = met, [pair.refused(str(met)) for pair in pairs]
    if junit is not None:
        write_text(render_junit(compared), junit)
    if error is not None:
        raise error
    unused = [] if partial else tolerances.unused(path for one in compared for path in one.paths)
    for pattern in unused:
        note(f"warning: the rule for {pattern!r} in {rules} fits no quantity")
    for one in compared:
        if one.problem:
            note(f"error: {one.problem}")
    answer(
        lambda: differences_object(compared, unused),
        lambda: render_files(compared, by_name=reference.is_dir()),
    )
    raise typer.Exit(max(one.exit_code for one in compared))


@command
def plot(
    results: list[Path] = RESULTS,
    output: Path | None = typer.Option(
        None, "--output", "-o", help="Folder for the pictures; created if missing."
    ),
    formats: str = typer.Option(
        "png", "--format", metavar="NAMES", help="svg, pdf, png, separated by commas."
    ),
    dpi: int | None = typer.Option(None, metavar="N", help="Resolution of png in dpi, 50 to 1200."),
    only: list[str] | None = typer.Option(
        None,
        metavar="NAME",
        help="Only these pictures; separated by commas, or repeat the option.",
        autocompletion=names_of_pictures,
    ),
    no_title: bool = typer.Option(False, "--no-title", help="Leave out the title of the figures."),
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

    _each_result(results, draw, lambda: {"written": [str(picture) for picture in drawn]})


@command
def new(
    scene: str = typer.Argument(
        "list",
        metavar="NAME",
        help="Name of a starter; `list` shows them.",
        autocompletion=beginnings,
    ),
    output: Path | None = typer.Option(
        None, "--output", "-o", help="File to write; for an example also a folder."
    ),
    example: bool = typer.Option(
        False, "--example", help="Copy a shipped case of this NAME and its files."
    ),
    assembly: Path | None = typer.Option(
        None, "--from", metavar="JSON", help="Import the shaft line of an openTorsion file."
    ),
    force: bool = FORCE,
    schema: bool = typer.Option(
        False, "--schema", help="With -o: also write the JSON schema for editors."
    ),
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
        _example(scene, output, force)
        return
    elif scene == "list":
        scenes = starters.scenes()
        answer(
            lambda: scenes,
            lambda: "\n".join(f"{name:<13}  {about}" for name, about in scenes.items()),
        )
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


def _example(name: str, output: Path | None, force: bool) -> None:
    """A shipped case with its files, into a folder or with a name of its own; or the list."""
    from vibecalc.cli import starters

    if name == "list":
        answer(starters.examples, starters.example_table)
        return
    copied = starters.files_of_example(name)
    own = output if output is not None and output.suffix == ".toml" else None
    folder = own.parent if own else output or Path()
    files = {folder / name: data for name, data in copied.items()}
    if own:  # the case comes first
        files = {own: files.pop(next(iter(files)))} | files
    _write_new(files, force)
    say_written(*files)


@command
def schema(
    kind: str = typer.Option("", metavar="KIND", help="Only for cases of one kind of machine."),
    output: str | None = typer.Option(
        None, "--output", "-o", help="New file, or folder when it exists or ends with '/'."
    ),
    force: bool = FORCE,
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
    command: str | None = typer.Argument(
        None, metavar="COMMAND", help="Name of a command, or `start`; default: all."
    ),
) -> None:
    """Show the help page of a command, or how to start."""
    program = ctx.parent
    assert program is not None
    if asked.quiet:
        return
    if command == "start":
        from vibecalc.cli.starters import carried

        say((carried("docs") / "start.md").read_text(encoding="utf-8"))
        return
    group: Any = program.command
    named = group if command is None else group.get_command(program, command)
    if named is None:
        from vibecalc.core.results.select import nearest

        near = ", ".join(nearest(str(command), group.list_commands(program))[:3])
        raise UsageError(f"no command {str(command)[:40]!r}; there are {near} and others")
    page = typer.Context(named, info_name=command, parent=program) if command else program
    named.get_help(page)


def _load(paths: list[Path], *changes: "Sequence[str] | None") -> "list[LoadedCase]":
    from vibecalc.core.study.execute import load_checked

    return load_checked(paths, *(change or () for change in changes))


#: what `--json` prints of a case that was worked on, and why it failed, empty if it did not
Done = tuple[dict[str, Any], str]


def _for_each(
    cases: "list[LoadedCase]",
    work: "Callable[[LoadedCase], Done]",
    objects: list[dict[str, Any]],
) -> int:
    """Work on every case; the worst exit code. Prints what comes after `objects`, with them."""
    worst = EXIT_FINE
    for case in cases:
        told: dict[str, Any] = {"case": case.name}
        alone = len(cases) == 1 and not asked.json
        error: VibecalcError | None = None
        try:
            told, failure = work(case)
            error = NumericalFailure(failure) if failure else None
        except VibecalcError as met:
            if alone:
                raise
            error = met
        except Exception as met:
            if alone:
                raise
            import traceback

            from vibecalc.core.report.defects import described

            traceback.print_exc()
            error = Defect(f"a bug in vibecalc, please report it: {described(met)}")
        if error is not None:
            told = {**told, "error": error.as_object(), "exit_code": error.exit_code}
            note(f"error: {case.path}: {error}")
            worst = max(worst, error.exit_code)
        objects.append(told)
    if asked.json:
        say_json([{"exit_code": EXIT_FINE} | one for one in objects])
    return worst


def _execute(case: "LoadedCase") -> "Result":
    from vibecalc.core.study.execute import execute

    return execute(case, progress=not (asked.silent or asked.verbose))


def _write_text(text: str, output: Path | None, force: bool) -> None:
    if output is None:
        if asked.json:
            say_json({"text": text})
        say(text)
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


for one in (sweep, merge, accuracy, info, get, export, migrate):
    command(one)
# what these print is for a person and for a shell: JSON of it would serve nobody
app.command(cls=Command)(spoken(completion, json=False))
app.command("help", cls=Command)(spoken(help_, json=False))
