"""Claim: what the guides try gives what is printed; that they run is in test_docs_pages.py."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from pages import table
from shipped_cases import ROOT

from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.units import convert

GUIDES = ("guide_propulsion", "guide_absorber")
TEXT = {name: (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in GUIDES}
ROWS = [(name, row) for name in GUIDES for row in table(TEXT[name], "change")]


def propulsion(record: Record) -> list[str]:
    """The highest utilisation of a limit, and the barred ranges."""
    ends = [record[f"response/torsion/barred/{name}"].values for name in ("from", "to")]
    shown = [[f"{convert(one, 'rad/s', 'rpm'):.4g}" for one in end] for end in ends]
    ranges = ", ".join(f"{low} to {high}" for low, high in zip(*shown, strict=True)) or "none"
    use = float(record["response/torsion/limit/largest_utilisation"].values[0])
    return [f"{100.0 * use:.4g} %", ranges]


def absorber(record: Record) -> list[str]:
    """Stiffness in N/mm, damping, and acceleration in mm/s^2."""
    motion = "response/absorber/motion/largest/acceleration"
    paths = {"tuning/linear_stiffness": 1e-3, "tuning/linear_damping": 1.0, motion: 1e3}
    return [f"{float(record[path].values) * scale:.4g}" for path, scale in paths.items()]


@pytest.mark.long
@pytest.mark.parametrize(("name", "row"), ROWS, ids=lambda one: one if type(one) is str else "")
def test_what_is_tried_gives_what_is_printed(name: str, row: list[str], tmp_path: Path) -> None:
    case = "\n".join(re.findall(r"```toml\n(.*?)```", TEXT[name], re.S))
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    for card in (ROOT / "cases").glob("marine_gas_pressure_*.csv"):
        shutil.copy(card, tmp_path)
    settings = [word for word in shlex.split(row[1].strip("`")) if word != "--set"]
    (loaded,) = load_checked([tmp_path / "case.toml"], settings)
    found = {"guide_propulsion": propulsion, "guide_absorber": absorber}[name]
    assert [one.replace(".0 ", " ") for one in found(run_case(loaded.case))] == row[2:]
