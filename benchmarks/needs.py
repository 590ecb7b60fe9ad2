"""What a table of a case costs: seconds and modules of a run with it and without it.

Each run is a process of its own, as a user starts it; seconds are CPU seconds, the least of a few
repeats in turns. Next to them stands what `vibecalc check` says.
"""

import copy
import json
import math
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w
from rows import Report, Table, reported, seconds

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.report.check import counted_seconds, time_in_words
from vibecalc.core.study.execute import load_checked

REPEATS = 2
CASES = Path(__file__).resolve().parents[1] / "cases"
#: case and the optional tables that are left out of it, one at a time
TABLES: dict[str, tuple[str, ...]] = {
    "generator": ("kinematics", "isolation.run_up", "isolation"),
    "compressor_switching": ("response.operations+response.switching", "response.switching"),
    "engine_damped": ("response.torsion.speeds",),
    "engine_run_up": ("response.torsion.transient", "response.torsion.speeds"),
    "engine_v8": ("isolation", "response.torsion.limits"),
    "roll": ("response.roll.compare", "response.roll.sensitivity", "response.roll.interpolations"),
    "absorber": ("tuning.compare", "tuning.mistuning", "response"),
    "roll_startup": ("response.start_up.angles+response.start_up.start_within",),
}
PROBE = """
import json, resource, sys
sys.argv = ["vibecalc", "run", *sys.argv[1:], "-q"]
from vibecalc.__main__ import main
try:
    main()
except SystemExit as stop:
    assert not stop.code
used = resource.getrusage(resource.RUSAGE_SELF)
names = [name for name in sys.modules if name.startswith("vibecalc.")]
parts = {name for name in sys.modules if name in ("scipy.optimize", "scipy.linalg", "scipy.sparse")}
print("@@" + json.dumps([used.ru_utime + used.ru_stime, len(names), len(parts), used.ru_maxrss]))
"""


class Taken(NamedTuple):
    """CPU seconds, modules of this package, heavy parts of scipy, peak memory in MB."""

    seconds: float
    modules: int
    libraries: int
    megabytes: float


class Row(NamedTuple):
    """A case with one table less; `said` are the seconds that `check` counts for the same run."""

    case: str
    left_out: str
    taken: Taken
    said: float


def rows(repeats: int = 3) -> Iterator[Row]:
    """Each case whole, then without each of its tables."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case, tables in TABLES.items():
            variants = {
                left_out: folder / f"{case}_{n}.toml" for n, left_out in enumerate(("", *tables))
            }
            for left_out, path in variants.items():
                path.write_text(tomli_w.dumps(_without(case, left_out)), encoding="utf-8")
            best: dict[str, Taken] = {}
            for _ in range(repeats):
                for left_out, path in variants.items():
                    found = _run(path)
                    if left_out not in best or found.seconds < best[left_out].seconds:
                        best[left_out] = found
            for left_out, path in variants.items():
                (loaded,) = load_checked([path])
                yield Row(case, left_out, best[left_out], counted_seconds(loaded.case))


def _without(case: str, left_out: str) -> dict[str, Any]:
    table: dict[str, Any] = tomllib.loads((CASES / f"{case}.toml").read_text(encoding="utf-8"))
    attach_files(table, CASES)
    for key in ("reference", "reference_table", "limit"):
        table.pop(key, None)
    table = copy.deepcopy(table)
    for path in filter(None, left_out.split("+")):
        *outer, last = path.split(".")
        inside = table
        for key in outer:
            inside = inside[key]
        del inside[last]
        if path == "response.roll.compare":
            del inside["step"]
    return _plain(table)


def _plain(value: Any) -> Any:
    """Tables that TOML can write again."""
    if isinstance(value, dict):
        return {key: _plain(inside) for key, inside in value.items() if inside is not None}
    return [_plain(one) for one in value] if isinstance(value, list | tuple) else value


def _run(path: Path) -> Taken:
    threads = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    program = [sys.executable, "-c", PROBE, str(path), "-o", f"{path.parent}/"]
    done = subprocess.run(program, capture_output=True, text=True, check=False, env=threads)
    if done.returncode:
        raise RuntimeError(f"{path.name}: {done.stderr[-2000:]}")
    spent, modules, libraries, peak = json.loads(done.stdout.rsplit("@@", 1)[1])
    return Taken(spent, modules, libraries, peak / 1024.0)


def measure() -> Report:
    """Each case whole and with one table less, and how near `check` comes."""
    lines, off, whole = [], [], 1.0
    for row in rows(REPEATS):
        taken = row.taken
        whole = whole if row.left_out else taken.seconds
        lines.append(
            [row.case, row.left_out or "(whole)", seconds(taken.seconds),
             f"{taken.seconds / whole:.2f}", time_in_words(row.said), str(taken.modules),
             str(taken.libraries), f"{taken.megabytes:.0f}"]
        )  # fmt: skip
        off.append(abs(math.log(row.said / taken.seconds)))
    columns = [
        "case", "without", "CPU time", "of the whole case", "said by `check`", "modules",
        "heavy parts of scipy", "MiB",
    ]  # fmt: skip
    return Report(
        "What a table of a case costs",
        f"Whole processes, the least of {REPEATS} in turns; references and limits are left out.",
        tables=[Table("With and without each table", columns, lines)],
        remarks=[
            "The counted work behind what `vibecalc check` says of the time is off by a factor of "
            f"{math.exp(max(off)):.2g} at most."
        ],
    )


if __name__ == "__main__":
    reported(measure)
