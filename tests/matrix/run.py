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

from environments import ENVIRONMENTS, ROOT, Environment, find_python, make, surroundings, versions

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


PAGE = ROOT / "tests" / "matrix" / "ENVIRONMENTS.md"
START, END = "<!-- matrix: written by tests/matrix/run.py -->", "<!-- end of matrix -->"


@dataclass(kw_only=True)
class Line:
    """What one environment gave: its versions, names of cases, the worst difference over its
    tolerance, what pytest says. The defaults are those of a Python that is not there."""

    name: str
    date: str
    python: str
    numpy: str = ""
    scipy: str = ""
    h5py: str = ""
    kernel: str = ""
    wider: str = ""
    threads: int = 0
    same: list[str] = field(default_factory=list)
    differ: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    worst: float = 0.0
    where: str = ""
    tests: str = ""

    @property
    def fine(self) -> bool:
        """Nothing differs, failed or was left out."""
        return bool(self.same) and not self.differ and not self.failed and "passed" in self.tests

    def as_row(self) -> str:
        """The row of the table in ENVIRONMENTS.md, in Markdown."""
        bad = (f"{len(some)}" + (f" ({', '.join(some)})" if some else "")
               for some in (self.differ, self.failed))  # fmt: skip
        cells = (self.name, self.date, self.python, self.numpy, self.scipy, self.h5py)
        cells += (self.kernel, self.wider or "none")
        ran = self.same or self.differ or self.failed
        numbers = (self.threads, len(self.same), *bad, f"{self.worst:.2g}", self.where)
        shown = numbers if ran else ("",) * len(numbers)
        return "| " + " | ".join(str(cell) for cell in (*cells, *shown, self.tests)) + " |"

    def record(self) -> None:
        """Put the row where the environment has one, or behind the others."""
        before, rest = PAGE.read_text(encoding="utf-8").split(START)
        table, after = rest.split(END)
        rows = [row for row in table.strip().splitlines() if not row.startswith(f"| {self.name} |")]
        table = "\n".join([*rows, self.as_row()])
        PAGE.write_text(f"{before}{START}\n{table}\n{END}{after}", encoding="utf-8")


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
            line.record()
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
    threads = environment.threads
    line = Line(name=environment.name, date=date, **known, threads=threads)
    for case in sorted((ROOT / "cases").glob("*.toml")):
        if asked.case and case.stem not in asked.case:
            continue
        written = _run(python, case, results, around, asked.again)
        name = written.stem if written else case.stem
        if written is None:
            line.failed.append(name)
        else:
            _held(name, asked.reference / written.name, written, rules, line)
    line.tests = _quick(python, around)
    return line


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


def _held(name: str, reference: Path, written: Path, rules: Rules, line: Line) -> None:
    try:
        comparison = compare(read_result(reference), read_result(written), rules)
    except VibecalcError as error:
        print(f"{name}: {error}", flush=True)
        line.failed.append(name)
        return
    (line.same if comparison.same else line.differ).append(name)
    for row in comparison.worst(3):
        if not row.same:
            reported = "; ".join(row.problems) or f"{row.ratio:.2g} of its tolerance at {row.entry}"
            print(f"{name}: {row.path}: {reported}", flush=True)
        if row.ratio > line.worst:
            line.worst, line.where = row.ratio, f"{name}: {row.path}"


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
