"""Claim: the balanced machine puts no force and no couple on its body, and rolls all the same."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

CASE = Path(__file__).parents[1] / "cases" / "roll_balanced.toml"


def _written() -> dict[str, Any]:
    return tomllib.loads(CASE.read_text(encoding="utf-8"))


def _forces(tmp_path: Path, speed: float, without_second: bool) -> LoadedCase:
    """The crank train alone, at a given speed, as a case that asks for its forces."""
    train = _written()["machine"]["crank_train"]
    first, second = train["cylinders"]
    kept = [first] if without_second else [first, second]
    rows = ", ".join(
        f'{{ name = "{c["name"]}", bank_angle = "{c["bank_angle"]}", '
        f'crank_phase = "{c["crank_phase"]}" }}'
        for c in kept
    )
    text = f"""
schema = 1
title = "forces"
[machine]
kind = "compressor"
speed = {speed}
[machine.crank_train]
crank_radius = "{train["crank_radius"]}"
rod_length = "{train["rod_length"]}"
reciprocating_mass = "{train["reciprocating_mass"]}"
cylinders = [{rows}]
[excitation]
orders = 10
driven_machine = "cancels_torque"
"""
    path = tmp_path / "forces.toml"
    path.write_text(text, encoding="utf-8")
    return load_checked([path])[0]


def test_no_force_and_no_couple_but_roll(tmp_path: Path) -> None:
    record = run_case(load_checked([CASE])[0].case)
    speed = float(record["response/roll/speed"].values)
    level = record["response/roll/level/shell_acceleration"].values
    balanced = run_case(_forces(tmp_path, speed, without_second=False).case)
    alone = run_case(_forces(tmp_path, speed, without_second=True).case)
    force = float(np.max(balanced["excitation/force_peak"].values))
    single = float(np.max(alone["excitation/force_peak"].values))
    couple = float(np.max(balanced["excitation/couple_peak"].values))
    assert single > 1000.0
    assert force < 1e-12 * single
    assert couple < 1e-12 * single
    # both pistons work at once: one order as strong as those of the machine that is not balanced
    assert float(np.max(level)) > 5.0
