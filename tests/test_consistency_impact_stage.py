"""Claim: the stage of impacts hands the case to the kernels in SI with the right signs, and what it
emits is what they compute, with errors that bound the error."""

import numpy as np
import pytest
from impact_machines import AREA, CLEARANCE, INCH, MASS, POUND_FORCE, ROD_MASS, STIFFNESS
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.impact.model import build_joints
from vibecalc.impact.runs import Study, run_fixed_steps
from vibecalc.impact.statistics import (
    carried_force,
    gas_harmonics,
    mean_over_runs,
    pin_acceleration,
)

SMALL = (
    "response.impact.clearances=['1e-2 in']",
    "response.impact.members=2",
    "response.impact.discard=0",
    "response.impact.revolutions=2",
    "response.impact.orders=6",
)
STUDY = Study(np.array([1e-2 * INCH]), members=2, discard=0, revolutions=2, orders=6)


def case_of(*settings: str):
    return load_case(CASES["compressor_impact"], settings).case


def record_of(*settings: str, wanted: tuple[str, ...] | None = None) -> Record:
    names = None if wanted is None else frozenset(f"response/impact/{name}" for name in wanted)
    return run_case(case_of(*SMALL, *settings), wanted=names)


@pytest.fixture(scope="module")
def exact() -> Record:
    return record_of()


def value(record: Record, name: str) -> np.ndarray:
    return np.asarray(record[f"response/impact/{name}"].values)


def test_the_case_reaches_the_kernels_in_si():
    machine = case_of().machine
    joints = build_joints(machine, None)
    linkage = joints.linkage
    assert joints.cylinder == "A"
    # piston and pin are beyond the gap; the rod's share is on the crank's side of it
    assert linkage.mass == pytest.approx(MASS - ROD_MASS, rel=1e-12)
    assert joints.reciprocating_mass == pytest.approx(MASS, rel=1e-12)
    assert linkage.drive.speed == 361.0
    assert float(linkage.wrist_pin.clearance) == pytest.approx(CLEARANCE, rel=1e-12)
    assert float(linkage.wrist_pin.stiffness) == pytest.approx(STIFFNESS, rel=1e-12)
    assert float(linkage.wrist_pin.film_damping) == pytest.approx(0.1 * POUND_FORCE / INCH)
    assert linkage.wrist_pin.law == "continuous"
    assert linkage.crank_pin is None and linkage.bore is None and linkage.rod_mass is None
    # at top dead centre a pressure of 221 psi pushes towards the crank, downwards
    assert linkage.gas.force[0] == pytest.approx(221 * POUND_FORCE / INCH**2 * AREA, rel=1e-9)
    assert linkage.gas.angle[-1] == pytest.approx(2 * np.pi)
    printed = build_joints(machine, None, gas_towards_crank=False).linkage
    np.testing.assert_array_equal(printed.gas.force, -linkage.gas.force)


def test_a_mass_without_a_rod_is_taken_as_it_is():
    machine = case_of().machine
    bare = machine.crank_train.model_copy(
        update={"reciprocating_mass": 0.4, "piston_mass": None, "pin_mass": None, "rod": None}
    )
    joints = build_joints(machine.model_copy(update={"crank_train": bare}), None)
    assert joints.linkage.mass == joints.reciprocating_mass == 0.4
    # a cylinder's own mass has the rod's share in it
    first = machine.crank_train.cylinders[0].model_copy(update={"reciprocating_mass": 0.5})
    own = machine.crank_train.model_copy(
        update={"cylinders": (first, *machine.crank_train.cylinders[1:])}
    )
    joints = build_joints(machine.model_copy(update={"crank_train": own}), None)
    assert joints.linkage.mass == pytest.approx(0.5 - ROD_MASS, rel=1e-12)


def test_a_rod_that_the_crank_drives_adds_nothing_but_its_own_inertia():
    """Without play all shakes with Y, whichever joint the load is examined."""
    play = "{clearance='1e-3 in', stiffness='1e6 lbf/in'}"
    driven = build_joints(case_of().machine, None).linkage
    free = build_joints(case_of(f"machine.joints.crank_pin={play}").machine, None).linkage
    pin = pin_acceleration(driven.drive, 8)
    at_the_crank = carried_force(driven, 8) + ROD_MASS * pin
    np.testing.assert_allclose(at_the_crank, carried_force(free, 8), rtol=1e-12)
    np.testing.assert_allclose(
        at_the_crank + gas_harmonics(driven.gas, 8), MASS * pin, rtol=1e-9, atol=1e-9
    )


def test_forces_nearby_the_impacts(exact):
    # half of the two pistons' second order, which adds where their throws are opposite
    shaking = value(exact, "shaking")
    acceleration = np.abs(exact["kinematics/acceleration_harmonics"].values)
    np.testing.assert_allclose(shaking[:6], MASS * acceleration[1:7], rtol=1e-10)
    motor = exact["excitation/motor/axial_force"]
    own = value(exact, "motor")
    for order, force in zip(motor.axes[0].values, motor.values, strict=True):
        if 1 <= order <= 6:
            assert own[order - 1] == pytest.approx(abs(force), rel=1e-12)
    three = np.stack([shaking, value(exact, "added_force")[0], own])
    np.testing.assert_array_equal(value(exact, "dominant")[0], np.argmax(three, axis=0))


@pytest.mark.long
def test_a_fixed_step_method_is_measured_by_exact_contacts_and_needs_no_motor(exact):
    case = case_of(*SMALL, "response.impact.method='rk4'", "response.impact.steps=256")
    without = case.model_copy(update={"machine": case.machine.model_copy(update={"motor": None})})
    assert "response/impact/motor" not in planned_quantities(without)
    record = run_case(without)
    assert "response/impact/motor" not in record
    assert set(value(record, "dominant").ravel()) <= {0, 1}
    linkage = build_joints(case_of().machine, None).linkage
    own = mean_over_runs(run_fixed_steps(linkage, STUDY, "rk4", 256).mean[0])
    quantity = record["response/impact/mean_force"]
    np.testing.assert_allclose(quantity.values, own.value, rtol=1e-9)
    difference = np.abs(value(record, "mean_force") - value(exact, "mean_force"))
    assert quantity.error_estimate > difference[0]
    for name in ("first_contacts", "parting", "dissipated", "shaking"):
        np.testing.assert_allclose(value(record, name), value(exact, name), rtol=1e-9)
    assert any("rk4 with 256 steps" in warning for warning in record.warnings)
    assert any("rk4" in method.name for method in record.methods)
    assert not any("rk4" in method.name for method in exact.methods)


@pytest.mark.long
def test_crank_pin_and_bore_have_results_of_their_own():
    play = "clearance='1e-3 in', stiffness='1e6 lbf/in', contact_damping='0.1 lbf*s/in'"
    record = record_of(
        f"machine.joints.crank_pin={{{play}}}",
        f"machine.joints.bore={{{play}, film_damping='10 lbf*s/in'}}",
        "response.impact.discard=1",
        "response.impact.clearances=['1.5e-3 in']",
        "response.impact.orders=4",
        wanted=(
            "mean_force", "energy_residual", "crank_pin/mean_force", "crank_pin/impacts",
            "bore/mean_force", "bore/impacts",
        ),
    )  # fmt: skip
    for joint in ("crank_pin", "bore"):
        assert value(record, f"{joint}/impacts")[0] > 0.0
    assert value(record, "energy_residual").max() < 1e-12
    # the film lets the piston lean on the wall with the side force: the axial one times the slope
    # of the rod, which is .22 at most
    mean = value(record, "mean_force")[0]
    assert 0.02 * mean < value(record, "bore/mean_force")[0] < 0.22 * mean
    # nearly all of the force at the crank end is the carried load, as at the wrist pin
    assert 0.7 < value(record, "crank_pin/mean_force")[0] / mean < 1.3
