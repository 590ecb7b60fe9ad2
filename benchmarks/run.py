"""All benchmarks, or those named, each in a process of its own; writes RESULTS.md.

python benchmarks/run.py                  # all: benchmarks/RESULTS.md
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

from rows import Report, shown, unpacked

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "RESULTS.md"
THREADS = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: in this order; what is not there is left out
NAMES = (
    "start_up", "kernels", "response", "impact", "search", "absorber", "roll", "torsion", "sweep",
    "defaults", "needs", "sizes", "scaling", "best_possible",
)  # fmt: skip


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
        print(f"wrote {RESULTS}", file=sys.stderr)
    return 1 if len(reports) < len(found) else 0


if __name__ == "__main__":
    sys.exit(main())
