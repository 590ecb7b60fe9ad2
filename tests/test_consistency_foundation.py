"""Claim: a machine on a second mass is refused where nothing steady is, and agrees with isolation.

That both move as their matrices say `test_consistency_random_machines.py` holds.
"""

import copy

import numpy as np
import pytest
from dense_machine import arm
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import BROKEN
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import CaseError, NumericalFailure


def test_the_case_agrees_with_its_isolation_on_the_floor_and_on_a_rigid_ground() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    record = run_case(loaded.case)
    force = record["foundation/rigid_force"].values
    # the couples of this machine lift nothing: all mounts together pass the same force
    path = "isolation/support_force/steady_harmonics"
    table = {key: one for key, one in loaded.resolved.items() if key not in ("foundation", "limit")}
    rigidly = run_case(validate(table))[path].values
    assert rigidly[:, 2].sum(axis=0) == pytest.approx(force, rel=1e-9, abs=1e-9)
    # of what the mounts pass on, the ground gets what the mass of the floor leaves
    arrived, moved = (record[f"foundation/{name}"].values for name in ("ground_force", "motion"))
    rate = record["foundation/motion"].axes[0].values * loaded.case.machine.speed
    passed = arrived - rate**2 * 1200.0 * moved
    assert record[path].values[:, 2].sum(axis=0) == pytest.approx(passed, rel=1e-9, abs=1e-9)
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


def test_a_floor_of_one_mass_moves_under_the_mounts() -> None:
    """A piston on four mounts on 300 kg: seven coordinates, dense, order by order."""
    speed, crank, rod, piston = 1450.0 * np.pi / 30.0, 0.036, 0.125, 0.72
    places = np.array([[x, y, -0.2] for x in (-0.2, 0.2) for y in (-0.18, 0.18)])
    each, dashpot = np.diag([30e3, 30e3, 45e3]), 90.0
    case = {
        "schema": 1, "title": "one cylinder on a light floor",
        "machine": {
            "kind": "machine", "speed": speed,
            "crank_train": {
                "crank_radius": crank, "rod_length": rod, "reciprocating_mass": piston,
                "origin": [0.05, 0.0, 0.1], "cylinders": [{"name": "1"}],
            },
            "body": {"mass": 48.0, "box": {"length": 0.5, "width": 0.6, "height": 0.35}},
            "mounts": {
                "each": {"stiffness": [30e3, 30e3, 45e3], "damping": dashpot},
                "positions": places.tolist(),
            },
        },
        "excitation": {"driven_machine": "cancels_torque"},
        "isolation": {"model": "rigid_body"},
        "foundation": {"kind": "mass", "mass": 300.0, "stiffness": 2.5e6, "damping": 1500.0},
        "limit": [
            {"quantity": "isolation/support_force/steady_peak", "max": 47.0, "source": "floor"},
        ],
    }  # fmt: skip
    result = execute(load_checked([case])[0])
    turn = np.arange(4096) * 2.0 * np.pi / 4096
    # position of the piston along the stroke, and its second derivative by the angle
    sine = crank / rod * np.sin(turn)
    stroke = np.fft.rfft(crank * np.cos(turn) + rod * np.sqrt(1.0 - sine**2)) / 2048.0
    order = np.arange(1, 13)
    force = piston * speed**2 * order**2 * stroke[1:13]
    rows = [np.hstack([arm(place), [[0.0], [0.0], [-1.0]]]) for place in places]
    inertia = 4.0 * np.array([0.6**2 + 0.35**2, 0.5**2 + 0.35**2, 0.5**2 + 0.6**2])
    mass = np.diag([48.0, 48.0, 48.0, *inertia, 300.0])
    passed = np.zeros((4, 3, 13), dtype=complex)
    for n, one in zip(order, force, strict=True):
        w = n * speed
        spring = each + 1j * w * dashpot * np.eye(3)
        stiff = sum((row.T @ spring @ row for row in rows), np.zeros((7, 7)))
        stiff[6, 6] += 2.5e6 + 1500.0j * w
        load = one * np.array([0.0, 0.0, 1.0, 0.0, -0.05, 0.0, 0.0])
        motion = np.linalg.solve(stiff - w**2 * mass, load)
        passed[..., n] = [spring @ (row @ motion) for row in rows]
    course = np.real(passed @ np.exp(1j * np.outer(np.arange(13), turn)))
    peak = np.sqrt(np.square(course).sum(axis=1)).max(axis=1)
    # a mount carries its share of the weight less what pulls it up
    least = 48.0 * 9.80665 / 4.0 - course[:, 2].max(axis=1)
    names = ("steady_peak", "minimum_load")
    found = {name: result.record[f"isolation/support_force/{name}"].values for name in names}
    assert found["steady_peak"] == pytest.approx(peak, rel=1e-6)
    assert found["steady_peak"].max() == pytest.approx(48.053, abs=1e-3)
    assert found["minimum_load"].min() == pytest.approx(76.315, abs=1e-3)
    assert found["minimum_load"] == pytest.approx(least, rel=1e-6)
    (verdict,) = verdicts_of(result)
    assert verdict.state == BROKEN
