"""A checked case to a finished result: one run, a run to the optimum, or one with searches."""

import platform
import shlex
import socket
import sys
import time
from typing import TYPE_CHECKING

from vibecalc import __version__
from vibecalc.case.load import LoadedCase
from vibecalc.results.record import Record, Result
from vibecalc.study.progress import telling

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: packages whose import costs something, and the parts of scipy
LIBRARIES = ("numpy", "h5py", "pint", "rich", "matplotlib", "mpmath")
SCIPY = ("fft", "integrate", "interpolate", "linalg", "optimize", "sparse", "special", "stats")


def execute(loaded: LoadedCase, progress: bool = False) -> Result:
    """Run a case as it asks to be run.

    `progress` says on stderr what long work is at, on a terminal only. Raises NumericalFailure.
    """
    timings: dict[str, float] = {}
    if loaded.case.optimisation is None:
        from vibecalc.pipeline.run import run_case

        with telling(progress) as tell:
            record = run_case(loaded.case, timings=timings, tell=tell)
        if loaded.case.find:
            from vibecalc.study.find import add_found

            add_found(record, loaded, timings=timings, progress=progress)
    else:
        from vibecalc.study.optimise import optimise

        record = optimise(loaded, timings=timings, progress=progress)
    return as_result(loaded, record, timings)


def plan_texts(case: "Case") -> list[dict[str, str]]:
    """What a run of `case` does and why, one row of short texts per stage."""
    from vibecalc.pipeline.plan import plan_case

    rows = [stage.as_texts() for stage in plan_case(case)]
    if case.optimisation is not None:
        from vibecalc.study.optimise_paths import describe_study

        rows.append(describe_study(case))
    if case.find:
        from vibecalc.study.find_paths import describe_find

        rows.append(describe_find(case))
    return rows


def as_result(loaded: LoadedCase, record: Record, timings: dict[str, float]) -> Result:
    """Put a record together with its case and where it comes from."""
    return Result(
        name=loaded.name,
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
        "command": shlex.join(["vibecalc", *sys.argv[1:]]),
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
