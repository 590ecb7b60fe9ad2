"""Every case and sweep in every environment of the matrix, held against the golden files.

`python tests/matrix/run.py` makes the environments below `.venv/matrix`, runs one after the
other, and writes the differences into ENVIRONMENTS.md beside it. Ends with 1 if any differs, a run
fails or the quick tests do; a Python that is not there is said and recorded.
"""

import argparse
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from environments import (
    ENVIRONMENTS,
    ROOT,
    Environment,
    find_python,
    make,
    surroundings,
    versions,
)
from record import Line, record

from vibecalc.core.results.compare import compare
from vibecalc.core.results.compare_rules import Rules, read_rules
from vibecalc.core.results.store import read_result
from vibecalc.errors import VibecalcError

#: files written and read back, estimates, round-off, one stage of each source
QUICK = (
    "test_bad_cases_results.py",
    "test_property_store.py",
    "test_consistency_store.py",
    "test_property_golden_tolerances.py",
)


@dataclass(kw_only=True)
class Found:
    """Outcome of one environment: names of cases, and the worst difference over its tolerance."""

    same: list[str] = field(default_factory=list)
    differ: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    worst: float = 0.0
    where: str = ""


def main() -> int:
    """Run what was asked for; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    names = [environment.name for environment in ENVIRONMENTS]
    parser.add_argument("--only", action="append", choices=names, help="environment, repeatable")
    parser.add_argument("--environments", type=Path, default=ROOT / ".venv" / "matrix")
    parser.add_argument("--reference", type=Path, default=ROOT / "tests" / "golden")
    parser.add_argument("--rules", type=Path, default=ROOT / "tests" / "golden" / "rules.toml")
    parser.add_argument("--results", type=Path, default=ROOT / "outputs" / "matrix")
    parser.add_argument("--case", action="append", help="only this case, repeatable")
    parser.add_argument("--again", action="store_true", help="compare what --results has")
    parser.add_argument("--dry", action="store_true", help="leave ENVIRONMENTS.md as it is")
    asked = parser.parse_args()
    fine = True
    for environment in ENVIRONMENTS:
        if asked.only and environment.name not in asked.only:
            continue
        line = one(environment, asked)
        fine = fine and line.fine
        print(line.as_row(), flush=True)
        if not asked.dry:
            record(line)
    return 0 if fine else 1


def one(environment: Environment, asked: argparse.Namespace) -> Line:
    """Make an environment, run everything in it, and compare."""
    date = time.strftime("%Y-%m-%d")
    interpreter = find_python(environment.python)
    if interpreter is None:
        print(f"{environment.name}: there is no Python {environment.python} here", flush=True)
        return Line(name=environment.name, date=date, python=f"{environment.python} not found")
    try:
        python = make(environment, interpreter, asked.environments / environment.folder)
        around = surroundings(environment, python)
        known = versions(python, around)
    except (subprocess.CalledProcessError, RuntimeError) as error:
        return Line(
            name=environment.name, date=date, python=f"{environment.python}, not made: {error}"
        )
    results = asked.results / environment.name.replace(" ", "_")
    results.mkdir(parents=True, exist_ok=True)
    rules = read_rules(asked.rules)
    found = Found()
    for case in sorted((ROOT / "cases").glob("*.toml")):
        if asked.case and case.stem not in asked.case:
            continue
        written = _run(python, case, results, around, asked.again)
        name = written.stem if written else case.stem
        if written is None:
            found.failed.append(name)
        else:
            _held(name, asked.reference / written.name, written, rules, found)
    tests = _quick(python, around)
    return Line(
        name=environment.name,
        date=date,
        **known,
        threads=environment.threads,
        same=len(found.same),
        differ=tuple(found.differ),
        failed=tuple(found.failed),
        worst=found.worst,
        where=found.where,
        tests=tests,
    )


def _run(
    python: Path, case: Path, results: Path, around: dict[str, str], again: bool
) -> Path | None:
    """The result file of a case or sweep; None, with the words of the run shown, if it failed.

    `again`: that of an earlier run.
    """
    command = [python, "-m", "vibecalc"]
    if case.stem.endswith("_sweep"):
        written = results / f"{case.stem}.sweep.h5"
        command += ["sweep", case, "-q", "--fresh", "-j", "1", "-o", written]
    else:
        written = results / f"{case.stem}.h5"
        command += ["run", case, "-q", "-o", results]
    if again:
        return written if written.exists() else None
    written.unlink(missing_ok=True)
    done = subprocess.run(
        command, cwd=ROOT, env=around, capture_output=True, text=True, check=False
    )
    # 1 says that a limit of the case is broken, and the result is there
    if done.returncode not in (0, 1) or not written.exists():
        print(f"{case.stem}: exit {done.returncode}\n{done.stderr[-2000:]}", flush=True)
        return None
    return written


def _held(name: str, reference: Path, written: Path, rules: Rules, found: Found) -> None:
    try:
        comparison = compare(read_result(reference), read_result(written), rules)
    except VibecalcError as error:
        print(f"{name}: {error}", flush=True)
        found.failed.append(name)
        return
    (found.same if comparison.same else found.differ).append(name)
    for row in comparison.worst(3):
        if not row.same:
            reported = "; ".join(row.problems) or f"{row.ratio:.2g} of its tolerance at {row.entry}"
            print(f"{name}: {row.path}: {reported}", flush=True)
        if row.ratio > found.worst:
            found.worst, found.where = row.ratio, f"{name}: {row.path}"


def _quick(python: Path, around: dict[str, str]) -> str:
    """What pytest says last of the quick tests."""
    tests = [str(ROOT / "tests" / name) for name in QUICK]
    done = subprocess.run(
        [python, "-m", "pytest", "-m", "not long", *tests],
        cwd=ROOT,
        env=around,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        print(done.stdout[-3000:], done.stderr[-2000:], flush=True)
    last = next((line for line in reversed(done.stdout.splitlines()) if line.strip()), "")
    return f"{'passed' if done.returncode == 0 else 'FAILED'}: {last.strip('= ')}"


if __name__ == "__main__":
    sys.exit(main())
