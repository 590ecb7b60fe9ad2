"""Claim: isolation efficiency is that of the closed form, and orders left out make no zero of it.

All freedoms `test_consistency_random_machines.py` holds against dense solves.
"""

from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import UNDECIDED
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked

ROOT = "isolation/efficiency"


def test_of_a_pitching_body_it_is_what_does_not_pass() -> None:
    (loaded,) = load_checked([CASES["generator"]], ["isolation.efficiency=true"])
    record = run_case(loaded.case)
    passing = np.abs(record["isolation/pitch/transmissibility"].values)
    by_order = record[f"{ROOT}/couple/by_order"]
    assert [*by_order.axes[1].values] == ["ry", "resultant"]
    assert by_order.values[:, 1] == pytest.approx(1.0 - passing, rel=1e-9)
    assert f"{ROOT}/force/held" not in record


FEW_ORDERS = f"""
schema = 1
title = "one order of a series with two"
[machine]
kind = "machine"
speed = "1500 rpm"
body = {{ mass = 400.0, inertia = [20.0, 30.0, 30.0] }}
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.2
reciprocating_mass = 1.0
cylinders = [{{ name = "1" }}]
[machine.mounts]
positions = [[-0.5, -0.3, 0.0], [-0.5, 0.3, 0.0], [0.5, -0.3, 0.0], [0.5, 0.3, 0.0]]
each = {{ stiffness = 39226.6, damping = 198.057 }}
[kinematics]
series = "truncated"
terms = 1
[excitation]
orders = 1
[isolation]
model = "rigid_body"
efficiency = true
[[limit]]
quantity = "{ROOT}/couple/held_rms"
max = 10.0
source = "tested"
"""


def test_orders_left_out_make_no_zero(tmp_path: Path) -> None:
    """A zero is one for rounding only: with too few orders a limit on the couple is undecided."""
    (tmp_path / "few.toml").write_text(FEW_ORDERS)
    few, whole = (
        execute(load_checked([tmp_path / "few.toml"], [f"excitation.orders={orders}"])[0])
        for orders in (1, 4)
    )
    (limit,) = verdicts_of(few)
    assert limit.kept is None
    for path in (f"{ROOT}/couple/held_rms", f"{ROOT}/couple/ground_peak"):
        exact, found = float(whole[path].values), few[path]
        assert found.error_estimate is not None
        assert abs(exact - float(found.values)) <= found.error_estimate
        assert float(found.values) > 0.0
    assert f"{ROOT}/couple/rms" in few


BOXER = """
schema = 1
title = "a boxer whose pistons differ by one part in a million"
[machine]
kind = "machine"
speed = "3000 rpm"
body = { mass = 400.0, inertia = [20.0, 30.0, 30.0] }
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.2
[[machine.crank_train.cylinders]]
name = "1"
position = -0.05
reciprocating_mass = 1.0
[[machine.crank_train.cylinders]]
name = "2"
position = 0.05
bank_angle = "180 deg"
crank_phase = "180 deg"
reciprocating_mass = 1.000001
[machine.mounts]
positions = [[-0.5, -0.3, -0.3], [-0.5, 0.3, -0.3], [0.5, -0.3, -0.3], [0.5, 0.3, -0.3]]
each = { stiffness = 39226.6, damping = 198.057 }
[excitation]
[isolation]
model = "rigid_body"
efficiency = true
"""


def test_a_force_that_is_no_measure_of_what_arrives_has_no_efficiency(tmp_path: Path) -> None:
    """The couple moves the mounts along x: a thousand times the force of the rigid machine."""
    (tmp_path / "boxer.toml").write_text(BOXER)
    record = execute(load_checked([tmp_path / "boxer.toml"])[0]).record
    acts, arrives = (float(record[f"{ROOT}/force/{one}_rms"].values) for one in ("held", "ground"))
    assert 0.0 < 1e3 * acts < arrives
    shares = {f"{ROOT}/force/{one}" for one in ("rms", "rms_level", "peak", "peak_level")}
    assert shares.isdisjoint(record)
    assert 0.0 < float(record[f"{ROOT}/couple/rms"].values) < 1.0
    for path in ("force/by_order", "by_direction"):
        each = record[f"{ROOT}/{path}"].values
        assert np.all((each > -1e3) | np.isneginf(each))
    (words,) = (one for one in record.warnings if one.startswith("no isolation efficiency"))
    assert f"of the force: the rigidly mounted machine passes on {acts:.4g} N r.m.s." in words
    assert f"{arrives:.4g} N r.m.s. on the ground come from its other loads" in words


def test_a_limit_on_what_is_left_out_is_undecided(tmp_path: Path) -> None:
    """Equal pistons: nothing acts, so that there is no share; its limit loses no report."""
    limit = f'[[limit]]\nquantity = "{ROOT}/force/rms"\nmin = "90 %"\n'
    (tmp_path / "boxer.toml").write_text(BOXER.replace("1.000001", "1.0") + limit)
    result = execute(load_checked([tmp_path / "boxer.toml"])[0])
    (words,) = (one for one in result.record.warnings if "no isolation efficiency" in one)
    assert "the rigidly mounted machine passes on 0 N r.m.s." in words
    (row,) = verdicts_of(result)
    assert (row.state, row.decided_by) == (UNDECIDED, "a run that does not leave it out")
    assert "is undecided: a run that does not leave it out would decide it" in " ".join(
        render_report(result).split()
    )
