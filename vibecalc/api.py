"""vibecalc from Python: what the commands do, with results as objects and problems as exceptions.

Cases are files, or their tables as nested dicts. Further keyword arguments are keys of the case,
as `--set` takes them: `run("case.toml", **{"machine.speed": "3000 rpm"})`. What is wrong with a
case raises `CaseError`, whose `problems` are those that the screen shows; what has no trustworthy
answer raises `NumericalFailure`.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.core.results.record import Result
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.case.load import CaseSource, LoadedCase
    from vibecalc.core.case.raw import Setting
    from vibecalc.core.results.compare import Comparison

PathLike = str | Path


def run(
    case: "CaseSource", /, *, unset: Sequence[str] = (), progress: bool = False, **keys: Any
) -> Result:
    """Run a case as it asks to be run: once, to its optimum, or with its searches.

    Parameters
    ----------
    case : a file, `-` for standard input, or the tables of a case.
    unset : keys to take out of the case.
    progress : say on stderr what long work is at, on a terminal only.
    keys : keys of the case with their values; texts carry units.

    Raises
    ------
    CaseError
        Everything that is wrong with the case, each with its place.
    NumericalFailure
        No trustworthy answer exists. Where no values of an optimisation keep the limits, `result`
        of the exception holds what comes nearest.
    """
    from vibecalc.core.study.execute import execute

    result = execute(_checked(case, unset, keys), progress=progress)
    if result.record.failure:
        failure = NumericalFailure(result.record.failure)
        failure.result = result
        raise failure
    return result


def check(case: "CaseSource", /, *, unset: Sequence[str] = (), **keys: Any) -> dict[str, Any]:
    """What a run of a case would do and why, and what it would need; nothing is computed.

    Returns what `vibecalc check --json` prints of it. Raises CaseError.
    """
    from vibecalc.core.report.check import check_rows, plan_object

    loaded = _checked(case, unset, keys)
    return plan_object(loaded, *check_rows(loaded.case))


def sweep(
    case: "CaseSource",
    output: PathLike,
    /,
    *,
    grid: Mapping[str, str | Sequence[Any]] | None = None,
    sample: str | None = None,
    keep: Sequence[str] = (),
    jobs: int | None = None,
    resume: bool = False,
    fresh: bool = False,
    progress: bool = False,
    unset: Sequence[str] = (),
    **keys: Any,
) -> Result:
    """Run a case at many points into the file `output`, and read it.

    Parameters
    ----------
    grid : an axis for each key: a list of values, or `start:stop:n` or `start:stop:nlog`; default:
        the axes of the case.
    sample : `METHOD:N` or `METHOD:N:SEED` instead of a grid.
    keep : results to keep; default: those of the case, else all scalars that can be stacked.
    jobs : processes; default: as many as there are processors.
    resume, fresh : take up the chunks that are there; throw away what is there and does not fit.

    The axes of the sweep come first in every quantity; points without a result are NaN there.
    """
    from vibecalc.core.study.sweep.prepare import (
        Options,
        axis_table,
        prepare,
        processors,
        sweep_settings,
    )
    from vibecalc.core.study.sweep.run import sweep as compute

    axes = [
        axis_table(f"{key}={given}") if isinstance(given, str) else _listed(key, given)
        for key, given in (grid or {}).items()
    ]
    asked: dict[str, Any] = {"sweep.axes": axes} if axes else {}
    texts = sweep_settings((), (), sample, keep)
    loaded = _checked(case, unset, {**keys, **asked}, texts)
    options = Options(output=Path(output), jobs=jobs, resume=resume, fresh=fresh, progress=progress)
    compute(prepare(loaded, jobs or processors()), options)
    return read(output)


def read(path: PathLike, /) -> Result:
    """A result file of a run or of a sweep; ResultError if it is none, or damaged."""
    from vibecalc.core.results.store import read_result

    return read_result(path)


def write(result: Result, path: PathLike, /) -> Path:
    """Write a result as HDF5, with its report next to it as `run` does."""
    from vibecalc.cli.outputs import write_outputs

    write_outputs(result, Path(path))
    return Path(path)


def report(result: Result | PathLike, /, *, full: bool = False) -> str:
    """The text report of a result, or of a file of a run, a sweep or measured methods."""
    if isinstance(result, Result):
        from vibecalc.core.report.text import render_report

        return render_report(result, full=full)
    from vibecalc.core.report.sweep.text import report_file

    return report_file(Path(result), full=full)


def plot(
    result: Result | PathLike,
    folder: PathLike = ".",
    /,
    *,
    only: Sequence[str] = (),
    formats: str = "png",
    dpi: int | None = None,
    title: bool = True,
) -> list[Path]:
    """Draw the pictures of a result or of a file into a folder; their files."""
    from vibecalc.core.report.plots import draw, draw_file, look_of

    look = look_of(formats, dpi, only, title)
    if isinstance(result, Result):
        return draw(result, Path(folder), look=look)
    return draw_file(Path(result), Path(folder), look)


def diff(
    reference: Result | PathLike, result: Result | PathLike, /, *, rules: PathLike | None = None
) -> "Comparison":
    """Compare a result with a golden one as `vibecalc diff` does; `same` tells the verdict."""
    from vibecalc.core.results.compare import compare
    from vibecalc.core.results.compare_rules import read_rules

    golden, value = (one if isinstance(one, Result) else read(one) for one in (reference, result))
    return compare(golden, value, None if rules is None else read_rules(Path(rules)))


def _checked(
    case: "CaseSource",
    unset: Sequence[str],
    keys: Mapping[str, Any],
    texts: Sequence[str] = (),
) -> "LoadedCase":
    from vibecalc.core.study.execute import load_checked

    settings: list[Setting] = [*((key, _plain(value)) for key, value in keys.items()), *texts]
    (loaded,) = load_checked([_plain(case)], settings, unset)
    return loaded


def _listed(key: str, values: Sequence[Any]) -> dict[str, Any]:
    return {"key": key, "values": _plain(values)}


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy, and tuples, as TOML has them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value
