"""vibecalc from Python: what the commands do, with results as objects and problems as exceptions.

Cases are files, or their tables as nested dicts. `set` and `unset` change keys, as `--set` and
`--unset` do: `run("case.toml", set={"machine.speed": "3000 rpm"})`, or shorter
`run("case.toml", **{"machine.speed": "3000 rpm"})`. What is wrong with a case
raises `CaseError`, whose `problems` are those that the screen shows, each with key, file, line,
message and hint; what has no trustworthy answer raises `NumericalFailure`. These and all others
are `VibecalcError`.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.core.results.record import Result
from vibecalc.errors import NumericalFailure, UsageError

if TYPE_CHECKING:
    from vibecalc.core.case.load import CaseSource, LoadedCase
    from vibecalc.core.case.raw import Setting
    from vibecalc.core.report.text import Verdicts
    from vibecalc.core.results.compare import Comparison

PathLike = str | os.PathLike[str]
#: one name, or several
Names = str | Iterable[str] | None
#: keys of a case, as `machine.speed`, with their values
Keys = Mapping[str, Any] | None


def run(
    case: "CaseSource",
    /,
    *,
    set: Keys = None,
    unset: Names = (),
    progress: bool = False,
    **keys: Any,
) -> Result:
    """Run a case as it asks to be run: once, to its optimum, or with its searches.

    Parameters
    ----------
    case : a file, `-` for standard input, or the tables of a case.
    set, keys : keys of the case with their values; texts carry units. `**{"machine.speed": 300}`
        is short for `set={"machine.speed": 300}`, which a type checker can follow.
    unset : key, or keys, to take out of the case.
    progress : say on stderr what long work is at, on a terminal only.

    Raises
    ------
    CaseError
        Everything that is wrong with the case, each with its place.
    NumericalFailure
        No trustworthy answer exists. Where no values of an optimisation keep the limits, `result`
        of the exception holds what comes nearest.
    """
    from vibecalc.core.study.execute import execute

    result = execute(_checked(case, set, keys, unset), progress=progress)
    if result.record.failure:
        failure = NumericalFailure(result.record.failure)
        failure.result = result
        raise failure
    return result


def check(
    case: "CaseSource", /, *, set: Keys = None, unset: Names = (), **keys: Any
) -> dict[str, Any]:
    """What a run of a case would do and why, and what it would need; nothing is computed.

    Returns what `vibecalc check --json` prints of it. Raises CaseError.
    """
    from vibecalc.core.report.check import check_rows, plan_object

    loaded = _checked(case, set, keys, unset)
    return plan_object(loaded, *check_rows(loaded.case))


def sweep(
    case: "CaseSource",
    output: PathLike,
    /,
    *,
    grid: Mapping[str, Any] | None = None,
    zip: Mapping[str, Any] | None = None,
    sample: str | None = None,
    keep: Names = (),
    jobs: int | None = None,
    timeout: Any = None,
    resume: bool = False,
    fresh: bool = False,
    shard: str | None = None,
    cluster: str | None = None,
    progress: bool = False,
    set: Keys = None,
    unset: Names = (),
    **keys: Any,
) -> Result:
    """Run a case at many points into the file `output`, and read it.

    Parameters
    ----------
    grid : an axis for each key: a list of values, or `start:stop:n` or `start:stop:nlog`; default:
        the axes of the case. Values are numbers, also with units, names, lists or tables.
    zip : the same for keys that vary together, as one axis.
    sample : `METHOD:N` or `METHOD:N:SEED` instead of a grid.
    keep : results to keep; default: those of the case, else all scalars that can be stacked.
    jobs : processes; default: as many as there are processors.
    timeout : seconds that one point may take.
    resume, fresh : take up the chunks that are there; throw away what is there and does not fit.
    shard : only the I-th of N parts, as `I/N` from 1; `merge` puts them together.
    cluster : scheduler of dask, address or file.

    The axes of the sweep come first in every quantity; points without a result are NaN there, and
    `report` says why they have none. Raises CaseError, and UsageError for a file of another sweep.
    """
    from vibecalc.cli.outputs import check_suffix
    from vibecalc.core.study.sweep.prepare import (
        Options,
        axis_tables,
        parse_shard,
        prepare,
        processors,
        seconds_allowed,
        sweep_settings,
    )
    from vibecalc.core.study.sweep.run import sweep as compute

    axes = [_axis(key, given, "--grid") for key, given in _keys("grid", grid).items()]
    together = [_axis(key, given, "--zip") for key, given in _keys("zip", zip).items()]
    for name, text in (("sample", sample), ("shard", shard), ("cluster", cluster)):
        if not isinstance(text, str | None):
            raise _misfit(name, text, "a text, as on the command line")
    part = parse_shard(shard)
    seconds = None if timeout is None else seconds_allowed(_seconds("timeout", timeout))
    tables = axis_tables(axes, together)
    asked: dict[str, Any] = {"sweep.axes": tables} if tables else {}
    texts = sweep_settings((), (), sample, _names(keep))
    loaded = _checked(case, set, {**keys, **asked}, unset, texts)
    target = _file(output, "the file of a sweep")
    check_suffix(target)
    processes: Any = jobs
    if processes is not None and (not isinstance(processes, Integral) or processes < 1):
        raise UsageError(f"a sweep needs one process or more, found jobs={jobs!r}")
    options = Options(
        output=target,
        jobs=jobs,
        timeout=seconds,
        resume=resume,
        fresh=fresh,
        shard=part,
        cluster=cluster,
        progress=progress,
    )
    compute(prepare(loaded, jobs or processors()), options)
    return read(target)


def merge(parts: Sequence[PathLike], output: PathLike, /) -> Result:
    """Put the files of parts of one sweep together in the file `output`, and read it.

    Points that no part has are NaN there, and `report` counts them. UsageError for parts of
    different sweeps, ResultError for files that are none.
    """
    from vibecalc.cli.outputs import check_suffix
    from vibecalc.core.study.execute import provenance
    from vibecalc.core.study.sweep.assemble import merge as put_together

    if isinstance(parts, str | os.PathLike) or not isinstance(parts, Iterable):
        raise _misfit("parts", parts, "a list of the files of parts of a sweep")
    target = _file(output, "the file of a sweep")
    check_suffix(target)
    put_together([_file(one, "a part of a sweep") for one in parts], target, provenance())
    return read(target)


def verify(
    case: "CaseSource",
    /,
    *,
    set: Keys = None,
    unset: Names = (),
    progress: bool = False,
    **keys: Any,
) -> "Verdicts":
    """Run a case and hold it to its references and limits; `kept` tells the verdict.

    `misses` counts what a reference or limit that counts misses or leaves undecided, `result` is
    the run, and the text (`str`) is what `vibecalc verify` prints. Raises as `run` does.
    """
    from vibecalc.core.report.text import Verdicts

    return Verdicts(run(case, set={**_keys("set", set), **keys}, unset=unset, progress=progress))


def accuracy(
    case: "CaseSource",
    /,
    *,
    stages: Names = (),
    topics: Names = (),
    longest: float = 30.0,
    progress: bool = False,
    set: Keys = None,
    unset: Names = (),
    **keys: Any,
) -> Result:
    """Measure the methods of a case, seconds against error, within about `longest` seconds.

    `stages` and `topics` are those to measure; default: all. Seconds are those of one thread only
    where numpy was imported so, as `vibecalc accuracy` does. Raises CaseError, UsageError for a
    stage or topic that is not there, NumericalFailure.
    """
    from vibecalc.core.accuracy.environment import pin_threads

    longest = _seconds("longest", longest)
    threads = pin_threads()
    from vibecalc.core.accuracy.run import measure_case

    loaded = _checked(case, set, keys, unset)
    return measure_case(
        loaded, _names(stages), _names(topics), longest=longest, progress=progress, threads=threads
    )


def read(path: PathLike, /) -> Result:
    """A result file of a run, a sweep or measured methods; ResultError if none, or damaged."""
    from vibecalc.core.results.store import read_result

    return read_result(_file(path, "a result file"))


def write(result: Result, path: PathLike, /) -> Path:
    """Write a result as HDF5, with its report next to it as `run` does; that of a sweep whole."""
    from vibecalc.cli.outputs import check_suffix, write_outputs

    if not isinstance(result, Result):
        raise _misfit("what is written", result, "a result")
    target = _file(path, "a result file")
    check_suffix(target)
    write_outputs(result, target)
    return target


def report(result: Result | PathLike, /, *, full: bool = False, html: bool = False) -> str:
    """The text report of a result, or of a file; `html`: a page with its pictures.

    Raises Defect, by a fault of vibecalc, where parts fail; its `made` is the report without them.
    """
    if html:
        from vibecalc.core.report.page import html_page as make
    else:
        from vibecalc.core.report.sweep.text import report_file as make
    source = _source(result)
    text: str = _whole(source, "the report", lambda: make(source, full=full))
    return text


def plot(
    result: Result | PathLike,
    folder: PathLike = ".",
    /,
    *,
    only: Names = (),
    formats: Names = "png",
    dpi: int | None = None,
    title: bool = True,
) -> list[Path]:
    """Draw the pictures of a result or of a file into a folder; their files.

    `only` names those that are wanted, `formats` are png, svg and pdf. UsageError for a picture
    that the result does not have; Defect, by a fault of vibecalc, where pictures fail; its `made`
    are the files of the others.
    """
    from vibecalc.core.report.plots import draw_files, look_of

    if not isinstance(dpi, Real | None):
        raise _misfit("dpi", dpi, "a number")
    look = look_of(",".join(_names(formats)), dpi, _names(only), title)
    source, target = _source(result), _file(folder, "a folder")
    pictures: list[Path] = _whole(
        source, "the pictures", lambda: next(draw_files([source], target, look))[1]
    )
    return pictures


def diff(
    reference: Result | PathLike, result: Result | PathLike, /, *, rules: PathLike | None = None
) -> "Comparison":
    """Compare a result with a golden one as `vibecalc diff` does; `same` tells the verdict."""
    from vibecalc.core.results.compare import compare
    from vibecalc.core.results.compare_rules import read_rules

    sources = [_source(one) for one in (reference, result)]
    golden, value = (one if isinstance(one, Result) else read(one) for one in sources)
    return compare(
        golden, value, None if rules is None else read_rules(_file(rules, "a file of rules"))
    )


def _whole(source: Result | Path, part: str, make: Callable[[], Any]) -> Any:
    """What `make` gives; Defect with what is left of it where parts of it fail."""
    from vibecalc.core.report.defects import as_defect, defects

    made = None
    with defects(part) as met:
        made = make()
    if met:
        defect = as_defect(met, source if isinstance(source, Path) else source.name)
        defect.made = made
        raise defect
    return made


def _source(result: Result | PathLike) -> Result | Path:
    return result if isinstance(result, Result) else _file(result, "a result file, or a result")


def _file(given: PathLike, what: str) -> Path:
    if not isinstance(given, str | os.PathLike):
        raise _misfit("a path", given, f"the name of {what}")
    return Path(given)


def _names(given: Names) -> Sequence[str]:
    if given is None or isinstance(given, str):
        return () if given is None else (given,)
    names = [*given] if isinstance(given, Iterable) else [None]
    if not all(isinstance(name, str) for name in names):
        raise _misfit("names", given, "a text, or a list of texts")
    return names


def _keys(name: str, given: Mapping[str, Any] | None) -> Mapping[str, Any]:
    keys = {} if given is None else given
    if not isinstance(keys, Mapping) or not all(isinstance(key, str) for key in keys):
        raise _misfit(name, given, 'keys with their values, as {"machine.speed": "3000 rpm"}')
    return keys


def _misfit(what: str, given: object, wanted: str) -> UsageError:
    """An argument of the wrong kind, which a command line cannot have."""
    from reprlib import repr as short

    return UsageError(f"{what}: needs {wanted}; found {short(given)}, a {type(given).__name__}")


def _checked(
    case: "CaseSource",
    given: Keys,
    keys: Mapping[str, Any],
    unset: Names,
    texts: Sequence[str] = (),
) -> "LoadedCase":
    from vibecalc.core.case.given import plain
    from vibecalc.core.study.execute import load_checked

    if isinstance(case, Result):
        raise UsageError("a result is no case; its `case` is: run(result.case)")
    if not isinstance(case, Mapping | str | os.PathLike):
        raise _misfit("a case", case, "its file, or its tables as a dict")
    settings: list[Setting] = [
        *((key, _value(key, one)) for key, one in {**_keys("set", given), **keys}.items()),
        *texts,
    ]
    source = plain(case, of_toml=True) if isinstance(case, Mapping) else os.fspath(case)
    (loaded,) = load_checked([source], settings, _names(unset))
    return loaded


def _axis(key: str, values: Any, option: str) -> dict[str, Any]:
    if isinstance(values, str):
        from vibecalc.core.study.sweep.prepare import axis_table

        return axis_table(f"{key}={values}", option)
    listed = _value(key, values) if isinstance(values, Iterable) else None
    if not isinstance(listed, list):
        raise _misfit(f"the axis {key}", values, "a list of values, or a text `start:stop:n`")
    return {"key": key, "values": listed}


def _value(key: str, value: Any) -> Any:
    """A value of a key as TOML has it, with the unit that it brings along."""
    from vibecalc.core.case.given import plain
    from vibecalc.core.case.raw import parse_key

    return plain([*value] if isinstance(value, range) else value, parse_key(key.strip()))


def _seconds(name: str, given: Any) -> float:
    """A time: a number of seconds, or one with a unit."""
    from vibecalc.core.case.given import plain
    from vibecalc.errors import UnitError
    from vibecalc.units import parse_quantity

    value = plain(given)
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise _misfit(name, given, "a number of seconds")
    try:
        return parse_quantity(value, "s")
    except UnitError as error:
        raise _misfit(name, given, f"a number of seconds ({error.message})") from None
