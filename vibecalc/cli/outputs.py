"""Where outputs go and how texts are written: next to their target, then renamed onto it."""

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from vibecalc.core.results.files import SUFFIXES, write_atomically
from vibecalc.core.results.visible import visible
from vibecalc.errors import ResultError, UsageError

if TYPE_CHECKING:
    from vibecalc.core.results.record import Result

DEFAULT_FOLDER = "outputs"


def result_paths(names: Sequence[str], output: str | None) -> list[Path]:
    """One result path per case name: `outputs/<name>.h5`, or as `output` says.

    `output` is a folder if it ends with a slash, exists as one, or several cases share it; a
    name like `one.h5` for several cases is taken for a slip.
    """
    doubled = [name for name, count in Counter(names).items() if count > 1]
    if doubled:
        raise UsageError(
            f"two cases are named {doubled[0]!r}: their results would overwrite each other; "
            "run them one by one, each with its own -o"
        )
    if output is None:
        return [Path(DEFAULT_FOLDER) / f"{name}.h5" for name in names]
    if not output:
        raise UsageError("-o needs the name of a file or folder, found ''")
    target = Path(output)
    is_folder = output.endswith(("/", "\\")) or target.is_dir()
    if len(names) > 1 and target.suffix in SUFFIXES and not is_folder:
        raise UsageError(
            f"-o {output} is one result file, for {len(names)} cases name a folder: -o {output}/"
        )
    if is_folder or len(names) > 1:
        return [target / f"{name}.h5" for name in names]
    if target.suffix not in SUFFIXES:
        raise UsageError(f"-o {output}: a result file ends in .h5; a folder ends in '/'")
    return [target]


def write_outputs(result: "Result", path: Path, made_from: str = "") -> list[Path]:
    """Write the result file, then the text report next to it.

    The result may have taken hours: it stands before words are made of it, and stays whatever
    becomes of them. `made_from` is the line by which `run --if-needed` knows both again; it is
    written last. Returns where they are.

    Raises
    ------
    ResultError
        A row of the case names what the result does not have.
    Defect
        The report, or parts of it, could not be made.
    """
    from vibecalc.core.case.inputs import mark
    from vibecalc.core.report.defects import as_defect, defects
    from vibecalc.core.results.store import write_result

    beside, text = path.with_suffix(".txt"), b""
    if result.swept is None:
        write_result(result, path)
        with suppress(OSError):  # the report of an earlier result; writing says what is wrong
            beside.unlink()
    try:
        with defects("the text report") as met:
            shown = visible(_report(result))  # of a sweep its file is still what was read
            text = shown.encode("utf-8")
    except ResultError as error:
        if result.swept is not None:
            raise
        raise ResultError(f"{error}; the result is written to {path}, without a report") from error
    if result.swept is not None:
        write_atomically(path, result.swept.read_bytes())
    if text:
        write_atomically(beside, text)
    if met:
        raise as_defect(met, path)
    mark(path, made_from, text)
    return [path, beside]


def _report(result: "Result") -> str:
    """The report; what a run has no need of is not imported for it."""
    from vibecalc.core.results.layout import is_accuracy

    if result.swept is None and not is_accuracy(result):
        from vibecalc.core.report.text import render_report

        return render_report(result)
    from vibecalc.core.report.sweep.text import report_file

    return report_file(result)


def report_path(result: Path, output: str | None, html: bool, several: bool) -> Path | None:
    """Where the report of a result goes, None for stdout; a name in `.html` asks for a page.

    UsageError for a name of another kind, or one file for several results.
    """
    if output is None:
        return result.with_suffix(".html") if html else None
    target = Path(output)
    if output.endswith(("/", "\\")) or target.is_dir():
        return target / f"{result.stem}{'.html' if html else '.txt'}"
    if target.suffix not in (".html", ".txt") or (html and target.suffix != ".html"):
        raise UsageError(f"-o {output}: a report ends in .html or .txt; a folder ends in '/'")
    if several:
        raise UsageError(f"-o {output} is one report, for several results name a folder")
    return target


def check_suffix(path: Path) -> None:
    """UsageError unless a name is that of a result file."""
    if path.suffix not in SUFFIXES:
        raise UsageError(f"-o {path}: a result file ends in .h5")


def write_text(text: str, path: Path) -> None:
    """Write a text file so that a reader sees the old one or the new one, never half."""
    write_atomically(path, visible(text).encode("utf-8"))
