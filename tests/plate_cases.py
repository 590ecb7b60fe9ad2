"""Cases of a measured plate, as texts to be changed and as runs."""

from pathlib import Path
from typing import Any

from vibecalc.core.case.load import LoadedCase, load_case
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import physics_problems
from vibecalc.errors import CaseError, Problem

PLATE = """schema = 1
title = "plate"
[machine]
kind = "plate"
[measurement]
amplitude = "zero_to_peak"
reference_level = "1e-5 m/s^2"
orders = [1, 2]
positions = [
  { name = "a", x = 0.5, y = -0.3 },
  { name = "b", x = 0.5, y = 0.3 },
  { name = "c", x = -0.5, y = -0.3 },
  { name = "d", x = -0.5, y = 0.3 },
]
readings = [
  { at = "a", level = [104.0, 107.3] },
  { at = "b", level = [108.7, 104.2] },
  { at = "c", level = [103.0, 101.5] },
  { between = ["a", "b"], level = [111.2, 102.0] },
  { between = ["a", "c"], level = [100.2, 102.3] },
]
"""
ON_A_LINE = """schema = 1
title = "three accelerometers in a row"
[machine]
kind = "plate"
[measurement]
amplitude = "zero_to_peak"
amplitude_step = 0.001
phase_step = "1 deg"
orders = [1]
positions = [
  { name = "a", x = -0.5, y = 0.2 },
  { name = "b", x = 0.1, y = 0.2 },
  { name = "c", x = 0.5, y = 0.2 },
  { name = "d", x = 0.5, y = -0.2 },
]
readings = [
  { at = "a", amplitude = [1.0], phase = ["0 deg"] },
  { at = "b", amplitude = [1.1], phase = ["5 deg"] },
  { at = "c", amplitude = [1.2], phase = ["9 deg"] },
]
"""


def load(folder: Path, text: str, **files: str) -> LoadedCase:
    """A case from a text, with CSV files next to it."""
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / "plate.toml"
    path.write_text(text, encoding="utf-8")
    return load_case(path)


def problems(folder: Path, text: str, **files: str) -> list[Problem]:
    """What the checks of form find, or else those of physics."""
    try:
        return physics_problems(load(folder, text, **files))
    except CaseError as error:
        return list(error.problems)


def run(folder: Path, text: str, **files: str) -> Record:
    """The results of a case without problems."""
    case = load(folder, text, **files).case
    found = check_machine(case)
    assert not found, found
    return run_case(case)


def replaced(old: str, new: str, text: str = PLATE) -> str:
    """The text with one piece changed; the piece has to be there."""
    assert old in text, old
    return text.replace(old, new, 1)


def entry(record: Record, path: str, **where: Any) -> float | complex:
    """One entry of a result."""
    from vibecalc.core.results.select import scalar

    return scalar(record[path], where)
