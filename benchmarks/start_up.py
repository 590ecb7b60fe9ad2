"""Whole-process CPU of the shipped commands against Python's own imports, paired in one run.

Ratios, not seconds: `--help` against `import typer`, `run` against `import numpy, h5py`. Both sides
run as an installed program does, with compiled bytecode (in a folder of its own, filled by a first
pair that is not counted), and with one thread, which favours the yardstick.
"""

import os
import sys
import tempfile
from pathlib import Path

from rows import Report, Row, Table, digits, reported, seconds
from timing import cpu_of_process, memory_of_process, paired

REPEATS = 9
CASE = Path(__file__).resolve().parents[1] / "cases" / "generator.toml"
PAIRS = (
    ("vibecalc --help", ["-m", "vibecalc", "--help"], "import typer", 2.5),
    (
        "vibecalc run generator.toml",
        ["-m", "vibecalc", "run", str(CASE)],
        "import numpy, h5py",
        3.0,
    ),
    (
        "vibecalc run engine_damped.toml",
        ["-m", "vibecalc", "run", str(CASE.with_name("engine_damped.toml")), "-q"],
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
    return cpu_of_process([sys.executable, *arguments], cwd=folder, env=environment(folder))


def measure() -> Report:
    """One row per pair: the median of the paired ratios."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, command, yardstick, aim in PAIRS:
            mine, theirs, ratio = paired(
                lambda command=command: cpu_seconds(command, folder),  # type: ignore[misc]
                lambda line=yardstick: cpu_seconds(["-c", line], folder),  # type: ignore[misc]
                REPEATS,
            )
            rows.append(
                Row(
                    name, "whole process", yardstick, ratio, aim, cost=True,
                    note=f"{seconds(mine)} against {seconds(theirs)}",
                )
            )  # fmt: skip
        lines = [
            [name, digits(memory_of_process([sys.executable, *command], cwd=folder))]
            for name, command in (
                ("import numpy, h5py", ["-c", "import numpy, h5py"]),
                *((name, command) for name, command, *_ in PAIRS),
            )
        ]
    return Report(
        "Whole commands",
        f"CPU time of whole processes against Python's own imports, median of {REPEATS} pairs.",
        rows,
        [Table("Largest resident memory", ["command", "MiB"], lines)],
    )


if __name__ == "__main__":
    reported(measure)
