"""Claim: a machine on a second mass is refused where nothing steady is, and agrees with isolation.

That both move as their matrices say `test_consistency_random_machines.py` holds.
"""

import copy

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, NumericalFailure


def test_the_case_agrees_with_its_isolation_on_a_rigid_ground() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    record = run_case(loaded.case)
    force = record["foundation/rigid_force"].values
    # the couples of this machine lift nothing: all mounts together pass the same force
    mounts = record["isolation/support_force/steady_harmonics"].values
    assert mounts[:, 2].sum(axis=0) == pytest.approx(force, rel=1e-9, abs=1e-9)
    assert record["foundation/rigid_force_peak"].values <= np.abs(force).sum() * (1.0 + 1e-9)
    hertz = record["foundation/natural_frequency"].values / (2.0 * np.pi)
    assert 9.0 < hertz[0] < 15.0 < hertz[1]


def test_what_it_needs_is_said() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    table = dict(loaded.resolved)
    del table["isolation"]
    with pytest.raises(CaseError, match=r"\[foundation\] needs \[isolation\]"):
        validate({key: table[key] for key in table if key != "limit"})
    plate = {"schema": 1, "title": "without a speed", "machine": {"kind": "plate"}}
    with pytest.raises(CaseError, match=r"\[foundation\] needs \[isolation\]"):
        load_checked([{**plate, "foundation": {"mass": 1.0, "stiffness": 1e7}}])
    table = {**loaded.resolved, "foundation": {"mass": -1.0, "stiffness": 1e7}}
    with pytest.raises(CaseError, match="mass"):
        validate(table)


def test_an_undamped_resonance_is_refused_and_an_undriven_one_is_nothing() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    table = copy.deepcopy(dict(loaded.resolved))
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    table["foundation"]["loss_factor"] = 0.0
    lower = float(run_case(validate(table))["foundation/natural_frequency"].values[0])
    # pistons have no force of order 3
    for order, driven in ((2, True), (3, False)):
        table["machine"]["speed"] = lower / order
        if driven:
            with pytest.raises(NumericalFailure, match=f"order 2 .*of mode 1, {lower:.9g}"):
                run_case(validate(table))
        else:
            assert run_case(validate(table))["foundation/ground_force"].values[2] == 0.0
