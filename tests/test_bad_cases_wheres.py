"""Claim: a `where` that selects nothing is found by `check`, before anything is computed."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError

CASES = Path(__file__).parents[1] / "cases"
ROW = """
[[reference]]
quantity = "{quantity}"
where = {{ {axis} = {entry} }}
value = 1
unit = "rad/s"
source = "none"
"""
MODES = "response/torsion/modes/natural_frequency"
SHAFT = "a shaft line has at most one mode for each station and each damper"


def problem(case: str, folder: Path, **row: Any) -> str:
    """What checking a shipped case with one more reference says; "" for no problem."""
    for table in CASES.glob("*.csv"):
        shutil.copy(table, folder)
    path = folder / "case.toml"
    path.write_text((CASES / f"{case}.toml").read_text(encoding="utf-8") + ROW.format(**row))
    try:
        load_checked([path], ())
    except CaseError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("case", "quantity", "axis", "entry", "allowed"),
    [
        ("engine_undamped", MODES, "mode", 3000, SHAFT),
        ("engine_undamped", MODES, "mode", 0.15, SHAFT),
        ("engine_undamped", MODES, "mode", 0, SHAFT),
        ("engine_damped", "response/torsion/peak/speed", "peak", 0.5, "1, 2, 3"),
        ("compressor", "response/modes/natural_frequency", "mode", 7, "6 degrees of freedom"),
    ],
)  # fmt: skip
def test_a_mode_that_no_machine_of_the_kind_has(
    case: str, quantity: str, axis: str, entry: float, allowed: str, tmp_path: Path
) -> None:
    said = problem(case, tmp_path, quantity=quantity, axis=axis, entry=entry)
    assert f"asks for a {axis} that {quantity} lacks" in said
    assert f"found {axis} = {entry}" in said
    assert allowed in said
    assert not problem(case, tmp_path, quantity=quantity, axis=axis, entry=2)


def test_ten_thousand_unknown_keys_are_counted(tmp_path: Path) -> None:
    """All of them; the nearest known keys are looked for where the first ones are."""
    path = tmp_path / "case.toml"
    keys = "".join(f"sped{number} = 1\n" for number in range(10_000))
    text = (CASES / "generator.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("[machine]\n", f"[machine]\n{keys}", 1), encoding="utf-8")
    with pytest.raises(CaseError) as raised:
        load_checked([path], ())
    assert len(raised.value.problems) == 10_000
    assert str(raised.value).count("did you mean 'speed'?") == 10
