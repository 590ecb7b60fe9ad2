"""Claim: a machine on a foundation or a base that moves is refused where nothing steady is, and
errors hold what is off in mass and mounts.

That they move as the equations of motion say `test_consistency_random_machines.py` holds.
"""

import copy
import dataclasses
from typing import Any

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.base_motion.model import on_base
from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, NumericalFailure, in_hertz
from vibecalc.foundation.systems import Curve, FlexibleFoundation, on_tables
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import response
from vibecalc.parts.body import RigidBody
from vibecalc.parts.machine import build_machine
from vibecalc.parts.mounts import Mounts


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
            with pytest.raises(NumericalFailure, match=f"order 2 .*of mode 1, {in_hertz(lower)}"):
                run_case(validate(table))
        else:
            assert run_case(validate(table))["foundation/ground_force"].values[2] == 0.0


def deck() -> dict[str, Any]:
    """The shipped case without its run-up and its base."""
    (loaded,) = load_checked([CASES["genset_on_deck"]], [])
    table = copy.deepcopy(dict(loaded.resolved))
    table = {key: table[key] for key in ("schema", "title", "machine", "excitation", "foundation")}
    table["isolation"] = {"model": "rigid_body"}
    table["machine"]["mounts"]["positions"][0][2] = -0.4
    table["machine"]["mounts"]["each"]["damping"] = 300.0
    return table


def test_a_foundation_that_carries_nothing_is_refused() -> None:
    table = deck()
    w = 2.0 * table["machine"]["speed"]
    columns = {"frequency": [1.0], "real": [0.0], "imaginary": [0.0]}
    table["foundation"] = {
        "kind": "impedance", "flexibilities": [{"direction": "z", "dynamic_stiffness": columns}],
    }  # fmt: skip
    with pytest.raises(NumericalFailure, match="nothing carries it"):
        run_case(validate(table))
    columns = {"frequency": [1.0, 0.9 * w], "real": [1e6, 1e6], "imaginary": [1e4, 1e4]}
    table["foundation"]["flexibilities"][0]["dynamic_stiffness"] = columns
    with pytest.raises(NumericalFailure, match="beyond the tables"):
        run_case(validate(table))


@pytest.mark.parametrize("kind", ["base", "body", "tables"])
def test_what_is_uncertain_of_mass_and_mounts_is_in_the_errors(kind: str) -> None:
    """Results of a machine that is off by so much are as far away as the errors say, or nearer."""
    case = validate(deck())
    alone = validate({key: value for key, value in deck().items() if key != "foundation"})
    machine = build_machine(case)
    assert machine.body is not None and machine.mounts is not None
    share, w = 1.0e-6, np.array([60.0, 157.0])
    rough = share * np.abs(machine.body.mass_matrix)
    given = dataclasses.replace(machine.body, mass_error=rough)
    known = dataclasses.replace(machine.mounts, relative_error=np.full(6, share))
    unit = np.broadcast_to(np.eye(6, dtype=complex), (2, 6, 6))
    feet = {(n, 2): Curve(w[:1], np.array([3e6 + 3e5j]), False) for n in range(6)}
    foundation = FlexibleFoundation(feet, {}, np.zeros(3))

    def results(body: RigidBody, mounts: Mounts) -> Bounded:
        if kind == "tables":
            tables = on_tables(body, mounts, foundation)
            load = Bounded(unit[:, 0], np.zeros((2, 6))) @ tables.reach
            motion = response(tables.dynamics(w), load.value, load.error)
            return tables.force(tables.at_mounts(motion), w)
        system = on_base(case if kind == "body" else alone, body, mounts)
        relative, _ = system.moved_by_base(Bounded(unit[:, 0], np.zeros((2, 6))), w)
        return system.force(system.at_mounts(relative), w)

    plain, told = results(machine.body, machine.mounts), results(given, known)
    assert np.array_equal(plain.value, told.value)
    for sign in (1.0, -1.0):
        heavy = dataclasses.replace(
            machine.body, mass_matrix=machine.body.mass_matrix * (1.0 + sign * share)
        )
        stiff = dataclasses.replace(
            machine.mounts,
            stiffness=machine.mounts.stiffness * (1.0 - sign * share),
            structural=machine.mounts.structural * (1.0 - sign * share),
        )
        for other in (results(heavy, machine.mounts), results(machine.body, stiff)):
            moved = np.abs(other.value - plain.value)
            assert np.max(moved) > 1e3 * np.max(plain.error)
            assert np.all(moved <= 1.001 * told.error + plain.error)
    assert np.max(told.error) < 1e2 * share * np.max(np.abs(plain.value))


def test_a_base_in_resonance_is_refused() -> None:
    """A plain block on four springs without damping at the height of its centre."""
    w = 18.0 * np.pi
    places = [[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    table: dict[str, Any] = {
        "schema": 1, "title": "block",
        "machine": {
            "kind": "plate",
            "body": {"mass": 120.0, "inertia": [8.0, 9.0, 12.0]},
            "mounts": {"each": {"stiffness": 30.0 * w**2}, "positions": places},
        },
    }  # fmt: skip
    shaken = {"name": "a", "frequency": w, "displacement": [0.0, 0.0, 1e-3]}
    white = {"frequency": [0.5 * w, 2.0 * w], "density": [1.0, 1.0]}
    for motion, words in (
        ({"harmonics": [shaken]}, r"undamped|singular"),
        ({"spectra": [{"direction": "z", "acceleration": white}]}, r"mode 3 .* has no damping"),
    ):
        with pytest.raises(NumericalFailure, match=words):
            run_case(validate(table | {"base_motion": motion}))
