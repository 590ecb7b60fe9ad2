"""Whole-process CPU of the shipped commands against Python's own imports, paired in one run.

Ratios, not seconds: `--help` against `import typer`, `run` and `check` against `import numpy,
h5py`, `plot` against saving an empty figure. Both sides run as an installed program does, with
compiled bytecode (in a folder of its own, filled by a first pair that is not counted), and with one
thread, which favours the yardstick.
"""

import os
import sys
import tempfile
from pathlib import Path

from rows import Report, Row, Table, digits, reported, seconds
from timing import cpu_of_process, memory_of_process, paired

REPEATS = 9
CASE = Path(__file__).resolve().parents[1] / "cases" / "generator.toml"
DAMPED = CASE.with_name("engine_damped.toml")
IMPORTS = "import numpy, h5py"
FIGURE = """\
import matplotlib
matplotlib.use("agg")
from matplotlib import pyplot
pyplot.figure()
pyplot.savefig("empty.png")
"""
#: name, arguments, yardstick in words and as code, aim
PAIRS = (
    ("vibecalc --help", ["--help"], "import typer", "import typer", 2.5),
    ("vibecalc check generator.toml", ["check", str(CASE)], IMPORTS, IMPORTS, 2.0),
    ("vibecalc run generator.toml", ["run", str(CASE)], IMPORTS, IMPORTS, 2.0),
    ("vibecalc run engine_damped.toml", ["run", str(DAMPED), "-q"], IMPORTS, IMPORTS, 3.5),
    (
        "vibecalc run --if-needed engine_damped.toml, nothing changed",
        ["run", str(DAMPED), "-q", "--if-needed"],
        IMPORTS,
        IMPORTS,
        1.5,
    ),
    (
        "vibecalc plot engine_damped.h5, 8 pictures",
        ["plot", "outputs/engine_damped.h5"],
        "pyplot and an empty figure",
        FIGURE,
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
        for name, given, yardstick, code, aim in PAIRS:
            command = ["-m", "vibecalc", *given]
            mine, theirs, ratio = paired(
                lambda command=command: cpu_seconds(command, folder),  # type: ignore[misc]
                lambda code=code: cpu_seconds(["-c", code], folder),  # type: ignore[misc]
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
                (IMPORTS, ["-c", IMPORTS]),
                *((name, ["-m", "vibecalc", *given]) for name, given, *_ in PAIRS),
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
