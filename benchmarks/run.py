"""All benchmarks, or those named, each in a process of its own; writes RESULTS.md and the README.

python benchmarks/run.py                  # all: benchmarks/RESULTS.md and README's table
python benchmarks/run.py roll torsion     # some: printed, nothing written
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from rows import COLUMNS, Report, Row, in_markdown, shown, unpacked

HERE = Path(__file__).resolve().parent
RESULTS, README = HERE / "RESULTS.md", HERE.parent / "README.md"
BEGIN, END = "<!-- ratios -->", "<!-- ratios end -->"
THREADS = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: in this order; what is not there is left out
NAMES = (
    "start_up", "kernels", "response", "impact", "search", "absorber", "roll", "torsion", "sweep",
    "defaults", "needs", "sizes", "scaling", "best_possible",
)  # fmt: skip

#: rows of the front page: how what, way and yardstick begin
FRONT = (
    ("forced response of 7 inertias, 6 driven", "with", "opentorsion"),
    ("forced response of 200 inertias, 6 driven", "with", "opentorsion"),
    ("modes of 200 inertias, uniform", "", "opentorsion"),
    ("joint with play", "batch", "scipy"),
    ("levels for 1000 rods", "collocation", "scipy"),
    ("ten levels of one machine", "collocation, 6", "the source's"),
    ("tuning of an absorber", "a point of a batch", "scipy"),
    ("tuning of an absorber", "one point alone, to", "scipy"),
    ("balance masses", "own search", "the source's"),
    ("peak over the cycle", "", "numpy"),
    ("largest force over rod and throw", "by arrays", "a process"),
)
SHOWN = ("what", "way", "yardstick", "ratio", "error reached")


def present() -> list[str]:
    """Benchmarks that are there."""
    return [name for name in NAMES if (HERE / f"{name}.py").exists()]


def measured(name: str, folder: Path) -> Report | None:
    """One benchmark in a process of its own; None where it fails, with its words on stderr."""
    path = folder / f"{name}.json"
    command = [sys.executable, str(HERE / f"{name}.py"), "--json", str(path)]
    done = subprocess.run(
        command, env={**os.environ, **THREADS}, capture_output=True, text=True, check=False
    )
    if done.returncode or not path.exists():
        print(done.stderr[-4000:], file=sys.stderr)
        return None
    return unpacked(path.read_text(encoding="utf-8"))


def all_of(names: list[str]) -> dict[str, Report | None]:
    """Reports by name, with progress on stderr."""
    found: dict[str, Report | None] = {}
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(names, 1):
            print(f"[{number}/{len(names)}] {name} ...", end=" ", file=sys.stderr, flush=True)
            started = time.perf_counter()
            found[name] = measured(name, Path(folder))
            word = "failed" if found[name] is None else "done"
            print(f"{word}, {time.perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
    return found


def machine() -> str:
    """Processor, cores, load and versions, one line each."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines()
        named = [line.partition(":")[2] for line in lines if line.startswith("model name")]
        model = " ".join(named[0].split()) if named else model
    load = " ".join(f"{one:.2f}" for one in os.getloadavg()) if hasattr(os, "getloadavg") else "?"
    packages = ("numpy", "scipy", "mpmath", "opentorsion", "vibecalc")
    versions = ", ".join(f"{name} {version(name)}" for name in packages)
    return (
        f"- machine: {model}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}\n"
        f"- load average before the run (1, 5, 15 minutes): {load}\n"
        f"- versions: Python {platform.python_version()}, {versions}; BLAS on one thread\n"
    )


def missed(reports: list[Report]) -> str:
    """The aims that were missed, as a list."""
    lines = [
        f"- {row.what}; {row.way}: {row.ratio_text} against {row.yardstick}, aim {row.aim_text}\n"
        for report in reports
        for row in report.rows
        if row.missed
    ]
    return "".join(lines) or "None.\n"


def front_rows(reports: list[Report]) -> list[Row]:
    """Rows of the front page, the first that fits each entry of `FRONT`."""
    every = [row for report in reports for row in report.rows]
    chosen = []
    for what, way, yardstick in FRONT:
        fitting = (
            row
            for row in every
            if row.what.startswith(what)
            and row.way.startswith(way)
            and row.yardstick.startswith(yardstick)
        )
        row = next(fitting, None)
        if row is not None:
            chosen.append(row)
    return chosen


def front_table(reports: list[Report]) -> str:
    """The table of the front page."""
    places = [COLUMNS.index(name) for name in SHOWN]
    return in_markdown(SHOWN, [[row.cells()[k] for k in places] for row in front_rows(reports)])


def results(found: dict[str, Report | None], head: str, spent: float) -> str:
    """RESULTS.md."""
    reports = [one for one in found.values() if one is not None]
    failed = [name for name, one in found.items() if one is None]
    parts = [
        "# Results of `make bench`\n",
        f"One run of {spent / 60.0:.1f} minutes, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC. Written "
        "by `benchmarks/run.py`; do not edit.\n",
        head,
        "Times are CPU seconds of one thread, the least of some repeats, the ways taking turns; "
        "only ratios mean something on another machine. \"77 times faster\" is the yardstick's "
        "time over ours, \"3 times its time\" is ours over the yardstick's.\n",
        "## Aims missed\n",
        missed(reports),
        *(shown(report) for report in reports),
    ]  # fmt: skip
    if failed:
        parts.append(f"## Failed\n\n{', '.join(failed)}: no result.\n")
    return "\n".join(parts)


def with_table(readme: str, table: str) -> str:
    """README with its table between the markers replaced."""
    before, found, rest = readme.partition(BEGIN)
    _, closed, after = rest.partition(END)
    if not (found and closed):
        raise SystemExit(f"README.md has no {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n{table}{END}{after}"


def main() -> int:
    """Run; exit code 1 if a benchmark failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(present())}")
    names = parser.parse_args().names
    unknown = sorted(set(names) - set(present()))
    if unknown:
        parser.error(f"no benchmark {', '.join(unknown)}; there are {', '.join(present())}")
    head, started = machine(), time.perf_counter()
    found = all_of(names or present())
    reports = [one for one in found.values() if one is not None]
    if names:
        print("\n".join(shown(report) for report in reports))
    else:
        RESULTS.write_text(results(found, head, time.perf_counter() - started), encoding="utf-8")
        text = with_table(README.read_text(encoding="utf-8"), front_table(reports))
        README.write_text(text, encoding="utf-8")
        print(f"wrote {RESULTS} and the table of {README}", file=sys.stderr)
    return 1 if len(reports) < len(found) else 0


if __name__ == "__main__":
    sys.exit(main())
