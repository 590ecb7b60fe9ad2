"""Whole-process CPU of the shipped commands against Python's own imports, paired in one run.

Ratios, not seconds: `--help` against `import typer`, `run` against `import numpy, h5py`. Both sides
run as an installed program does, with compiled bytecode (in a folder of its own, filled by a first
pair that is not counted), and with one thread, which favours the yardstick.
"""

import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

REPEATS = 15
CASE = Path(__file__).resolve().parents[1] / "cases" / "generator.toml"
PAIRS = (
    ("vibecalc --help", ["-m", "vibecalc", "--help"], "import typer", 2.5),
    (
        "vibecalc run generator.toml",
        ["-m", "vibecalc", "run", str(CASE)],
        "import numpy, h5py",
        3.0,
    ),
)


def environment(folder: str) -> dict[str, str]:
    """Variables for the child processes: bytecode is written to and read from below `folder`."""
    kept = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, "PYTHONPYCACHEPREFIX": f"{folder}/bytecode", "OPENBLAS_NUM_THREADS": "1"}


def cpu_seconds(arguments: list[str], folder: str) -> float:
    """User and system seconds of one child process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, *arguments]
    subprocess.run(
        command, cwd=folder, env=environment(folder), stdout=subprocess.DEVNULL, check=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)


def main() -> None:
    """Print one row per pair: medians and the median of the paired ratios."""
    print(f"whole-process CPU, {REPEATS} pairs, Python {platform.python_version()}")
    print(f"{'command':<30} {'ms':>7}   {'yardstick':<22} {'ms':>7} {'ratio':>6} {'aim':>5}")
    with tempfile.TemporaryDirectory() as folder:
        for name, command, yardstick, aim in PAIRS:
            rows = []
            for _ in range(REPEATS + 1):
                rows.append((cpu_seconds(command, folder), cpu_seconds(["-c", yardstick], folder)))
            rows = rows[1:]
            mine, theirs = (1e3 * statistics.median(column) for column in zip(*rows, strict=True))
            ratio = statistics.median(a / b for a, b in rows)
            print(f"{name:<30} {mine:7.0f}   {yardstick:<22} {theirs:7.0f} {ratio:6.2f} {aim:5.1f}")


if __name__ == "__main__":
    main()
