"""A case from its file to its result: all checked that can be, then run, optimised or searched."""

import platform
import shlex
import socket
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from vibecalc import __version__
from vibecalc.core.case.load import CaseSource, LoadedCase, load_case, raise_with_location
from vibecalc.core.case.raw import Setting, read_number, table_at
from vibecalc.core.results.record import Entry, Record, Result
from vibecalc.core.results.steps import step
from vibecalc.core.results.visible import visible
from vibecalc.errors import CaseError, Problem, ResultError, leaves
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What physics and plan find wrong with a case whose form is still wrong.
#
# They work on the case as tomllib reads it: what they cannot read they leave to the schema.
# ----------------------------------------------------------------------------

#: result paths that a study adds, known once the whole case can be read
_OF_STUDIES = ("optimisation/", "find/", "fit/")


def early_problems(data: dict[str, Any]) -> list[Problem]:
    """A rod that is too short, and quantities that no case computes; never raises on nonsense."""
    return [*_rod(data), *_quantities(data)]


def _rod(data: dict[str, Any]) -> list[Problem]:
    from vibecalc.parts.crank_train import rod_problems

    train = table_at(data, "machine", "crank_train")
    radius, rod_length = (
        read_number(train.get(key), "m") for key in ("crank_radius", "rod_length")
    )
    offset = read_number(train.get("wrist_pin_offset", 0.0), "m")
    if radius is None or rod_length is None or offset is None or min(radius, rod_length) <= 0.0:
        return []
    return rod_problems(radius, rod_length, abs(offset))


def _quantities(data: dict[str, Any]) -> Iterator[Problem]:
    from vibecalc.core.results.catalogue import CATALOGUE
    from vibecalc.core.run.targets import unknown_quantity

    for table in ("reference", "limit", "find", "optimisation", "sweep"):
        for path, quantity in leaves(data.get(table), (table,)):
            if path[-1] != "quantity" or not isinstance(quantity, str):
                continue
            if quantity and quantity not in CATALOGUE and not quantity.startswith(_OF_STUDIES):
                yield unknown_quantity(path[:-1], quantity, CATALOGUE)


# ----------------------------------------------------------------------------
# Cases from disk with everything checked that can be without computing: form, physics, targets.
# ----------------------------------------------------------------------------


def load_checked(
    sources: Sequence[CaseSource], settings: Sequence[Setting] = (), unset: Sequence[str] = ()
) -> list[LoadedCase]:
    """Read every case, or raise one CaseError whose text shows all problems of all files."""
    loaded: list[LoadedCase] = []
    problems: list[Problem] = []
    texts: list[str] = []
    for source in sources:
        try:
            case = load_case(source, settings, early_problems, unset)
            raise_with_location(case, physics_problems(case))
            loaded.append(case)
            step(f"checked {case.path}: no problem")
        except CaseError as error:
            problems += error.problems
            texts.append(str(error))
    if texts:
        raise CaseError(problems, "\n\n".join(texts))
    return loaded


def physics_problems(loaded: LoadedCase) -> list[Problem]:
    """What the machine, the plan and a study find wrong with a case of good form."""
    from vibecalc.core.run.machine_checks import check_machine
    from vibecalc.core.run.targets import check_targets

    case, problems = loaded.case, list[Problem]()
    extra: dict[str, Entry] = {}
    if _has_study(case):
        from vibecalc.core.study.measured_points import fit_problems
        from vibecalc.core.study.planned import study_entries
        from vibecalc.core.study.variables import study_problems

        extra = study_entries(case)
        problems += [*study_problems(case), *fit_problems(case)]
    if case.sweep is not None and case.sweep.axes:
        from vibecalc.core.study.sweep.checks import sweep_problems

        problems += sweep_problems(loaded)
    return check_machine(case) + check_targets(case, extra) + problems


def _has_study(case: Case) -> bool:
    """Whether a case runs its stages many times."""
    return case.optimisation is not None or bool(case.find) or case.fit is not None


# ----------------------------------------------------------------------------
# A checked case to a finished result: one run, a run to the optimum, or one with searches.
# ----------------------------------------------------------------------------

#: what takes time besides stages
STUDIES = {"fit", "find", "optimisation", "front", "sensitivity"}
#: packages whose import costs something, and the parts of scipy
LIBRARIES = ("numpy", "h5py", "pint", "rich", "matplotlib", "mpmath")
SCIPY = ("fft", "integrate", "interpolate", "linalg", "optimize", "sparse", "special", "stats")


def execute(loaded: LoadedCase, progress: bool = False) -> Result:
    """Run a case as it asks to be run.

    `progress` says on stderr what long work is at, on a terminal only. Raises NumericalFailure.
    """
    timings: dict[str, float] = {}
    step(f"run {loaded.name}")
    if loaded.case.fit is not None:
        from vibecalc.core.study.fit import fit

        record = fit(loaded, timings=timings, progress=progress)
    elif loaded.case.optimisation is None:
        from vibecalc.core.run.run import run_case
        from vibecalc.core.study.variables import telling

        with telling(progress) as tell:
            record = run_case(loaded.case, timings=timings, tell=tell)
        if loaded.case.find:
            from vibecalc.core.study.find import add_solutions

            add_solutions(record, loaded, timings=timings, progress=progress)
    else:
        from vibecalc.core.study.optimise import optimise

        record = optimise(loaded, timings=timings, progress=progress)
    for name in sorted(STUDIES & timings.keys()):
        step(f"{name}: {timings[name]:.3f} s")
    result = as_result(loaded, record, timings)
    from vibecalc.core.results.verdicts import judged

    with suppress(ResultError):  # which is said where the rows are read
        result = replace(result, verdicts=judged(result))
    return result


def plan_texts(case: Case) -> list[dict[str, str]]:
    """What a run of `case` does and why, one row of short texts per stage."""
    from vibecalc.core.run.plan import plan_case

    rows = [stage.as_texts() for stage in plan_case(case)]
    if _has_study(case):
        from vibecalc.core.study.planned import study_rows

        rows += study_rows(case)
    return rows


def as_result(loaded: LoadedCase, record: Record, timings: dict[str, float]) -> Result:
    """Put a record together with its case and where it comes from."""
    return Result(
        name=visible(loaded.name),
        case=loaded.resolved,
        case_toml=loaded.text,
        case_toml_resolved=loaded.resolved_toml,
        case_sha256=loaded.sha256,
        record=record,
        version=__version__,
        plan=tuple(plan_texts(loaded.case)),
        provenance=provenance(),
        timings=timings,
    )


def provenance() -> dict[str, str | int | float]:
    """Where and with what this process runs; the part of a result that differs from run to run."""
    versions: dict[str, str | int | float] = {
        name: str(getattr(sys.modules[name], "__version__", ""))
        for name in ("numpy", "scipy", "h5py")
        if name in sys.modules
    }
    return {
        "command": visible(shlex.join(["vibecalc", *sys.argv[1:]])),
        "time": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "host": socket.gethostname(),
        "platform": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **versions,
        "vibecalc_version": __version__,
        "libraries": " ".join(_libraries()),
    }


def _libraries() -> list[str]:
    """Packages from elsewhere; of scipy, whose parts are imported one by one, the parts."""
    roots = {name.partition(".")[0] for name in sys.modules if not name.startswith("_")}
    found = roots & set(LIBRARIES)
    parts = {name.split(".")[1] for name in sys.modules if name.startswith("scipy.")}
    return sorted(found | {f"scipy.{part}" for part in parts & set(SCIPY)})
