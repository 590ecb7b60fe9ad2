"""Claim: the stage gives what the kernels give for the machine of the case; no loop that is not
stable has a finite level; what the reduced model leaves out is said.
"""

import numpy as np
import pytest
from roll_control_cases import PATH, case_of, record_of, shipped, value_of
from roll_control_loops import load_by_hand
from roll_machines import SYNCHRONOUS, source_drive, source_machine

from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.roll.control.loop import disturbance, model_from_full, tangent
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.motor_checks import control_problems
from vibecalc.roll.running import running_state


def test_the_load_is_that_of_the_machine_at_constant_speed():
    found = disturbance(as_batch(source_machine()), source_drive(), 10)
    by_hand, _ = load_by_hand(92.76)
    assert float(found.mean.value) == pytest.approx(by_hand.mean, rel=1e-5)
    at = found.at(92.76)
    np.testing.assert_allclose(at.value, by_hand.harmonics, atol=5e-3)
    finer = disturbance(as_batch(source_machine()), source_drive(), 40).at(92.76)
    assert np.all(np.abs(finer.value[:10] - at.value) <= at.error + finer.error[:10])
    assert np.max(at.error) < 1e-9


def test_no_loop_that_is_not_stable_has_a_level():
    record = shipped().record
    status, level = value_of(record, "grid/status"), value_of(record, "grid/level")
    assert 0 < np.sum(status >= 2) < status.size
    np.testing.assert_array_equal(np.isfinite(level).all(axis=-1), status < 2)
    assert np.all(level[status >= 2] == np.inf)
    np.testing.assert_array_equal(np.isfinite(value_of(record, "grid/torque_peak")), status < 2)
    assert np.all(value_of(record, "grid/delay_margin")[status >= 2] == 0.0)

    lost = record_of(gain=10.0, acceleration_feedback=10.0)
    assert value_of(lost, "status") == 3 and np.all(value_of(lost, "level") == np.inf)
    assert np.all(value_of(lost, "attenuation") == -np.inf)
    assert value_of(lost, "pole")[0].real > 0.0
    assert any("the loop is unstable: amplitudes unbounded" in words for words in lost.warnings)
    assert PATH + "range/level" in lost


def test_the_tangent_carries_the_mean_where_the_curve_does():
    """The default motor gain: same mean slip as the curve, its slope, a torque at no slip."""
    record = record_of(motor_gain=None, reduction="momentum")
    machine, drive = as_batch(source_machine()), source_drive()
    line = tangent(machine, drive)
    assert value_of(record, "motor_gain") == pytest.approx(line.gain)
    assert value_of(record, "motor_offset") == pytest.approx(line.offset)
    assert value_of(record, "speed_without") == pytest.approx(SYNCHRONOUS - line.slip, rel=1e-12)
    torque = line.gain * line.slip + line.offset
    assert torque == pytest.approx(-float(value_of(record, "mean_torque")), rel=1e-12)
    # between 6 and 11 rpm the table has a slope of 122 N m in 5 rpm
    assert line.gain == pytest.approx(122.0 / (5.0 * np.pi / 30.0), rel=1e-12)
    known = disturbance(machine, drive, 10)
    model = model_from_full(known.whole, known.coupling, known.crank, line.gain)
    assert value_of(record, "inertia") == pytest.approx(float(model.inertia), rel=1e-12)


def test_the_range_is_full_less_reduced():
    record = shipped().record
    state = running_state(as_batch(source_machine()), source_drive(), rtol=1e-9, orders=10).state
    assert 2.0 * np.pi / float(state.turn.period[0]) == pytest.approx(92.97002725, rel=1e-9)
    difference = value_of(record, "range/level") - value_of(record, "level_without")
    np.testing.assert_allclose(value_of(record, "range/difference"), difference, atol=1e-12)
    # orders 3 and 7 are those of the bends of the motor's curve
    assert np.all(np.abs(difference[[0, 1, 3]]) < 0.5) and difference[6] > 10.0
    straight = value_of(record, "range/linear_difference")
    assert np.all(np.abs(straight[[0, 1, 2, 3, 6]]) < 0.35)


def test_an_unstable_motion_of_the_full_model_has_no_levels():
    record = record_of(machine__shell__stiffness=3e4, machine__shell__damping=60.0, full_model=True)
    assert value_of(record, "status") == 0 and value_of(record, "full/stable") == 0
    assert np.max(np.abs(value_of(record, "full/multiplier"))) > 1.01
    assert np.all(value_of(record, "full/level") == np.inf)
    assert np.all(value_of(record, "full/difference") == np.inf)
    said = " ".join(record.warnings)
    assert "full model is unstable" in said and "has no mounts" in said


@pytest.mark.long
def test_swings_beyond_the_table_of_the_motor_are_refused_in_words():
    with pytest.raises(NumericalFailure, match="beyond the motor's table"):
        record_of(gain=10.0, acceleration_feedback=-10.0, actuator_lag=1e-3, full_model=True)


def test_gains_beyond_the_motor_are_refused_in_words():
    with pytest.raises(NumericalFailure, match="does not carry the mean torque"):
        record_of(motor_gain=3.0)
    with pytest.raises(NumericalFailure, match="no mean speed balances"):
        record_of(gain=2.0, speed_feedback=-0.5)


def test_what_is_found_keeps_its_margins():
    record = shipped().record
    assert value_of(record, "tuned/delay_margin") >= 5e-4
    assert value_of(record, "tuned/phase_margin") >= np.radians(45.0)
    worst = np.max(value_of(record, "tuned/level")[:2])
    assert value_of(record, "tuned/objective") == pytest.approx(worst, abs=1e-12)
    bounds = record["response/control/tuned/active"].axes[0].values
    active = value_of(record, "tuned/active") > 0.0
    assert [str(name) for name in bounds[active]] == ["delay margin"]
    # it beats every pair of the grid that keeps them
    keeps = (value_of(record, "grid/delay_margin") >= 5e-4) & (
        value_of(record, "grid/phase_margin") >= np.radians(45.0)
    )
    keeps &= value_of(record, "grid/gain_margin") >= 6.0
    others = np.max(value_of(record, "grid/level")[keeps][:, :2], axis=-1)
    assert len(others) > 10 and np.all(worst <= others)


@pytest.mark.long
def test_a_search_may_look_at_orders_that_are_not_shown():
    tune = {
        "orders": [3], "gain": {"min": 1.0, "max": 5.0},
        "acceleration_feedback": {"min": -1.0, "max": 1.0},
    }  # fmt: skip
    record = record_of(orders=2, tune=tune)
    assert value_of(record, "tuned/level").shape == (2,)
    assert record_of(orders=3, tune=tune)["response/control/tuned/level"].values[2] == (
        pytest.approx(float(value_of(record, "tuned/objective")), abs=1e-9)
    )


def test_equal_pressures_have_no_odd_orders():
    """Zero to rounding is zero: minus infinity, and no error without bound."""
    case = case_of(motor_gains=[203.4])
    cylinders = case.machine.crank_train.cylinders
    twin = cylinders[1].model_copy(
        update={
            "gas_force": cylinders[0].gas_force,
            "reciprocating_mass": cylinders[0].reciprocating_mass,
        }
    )
    train = case.machine.crank_train.model_copy(update={"cylinders": (cylinders[0], twin)})
    machine = case.machine.model_copy(update={"crank_train": train})
    record = run_case(case.model_copy(update={"machine": machine}))
    for name in ("level", "level_without", "range/level"):
        level = value_of(record, name)
        assert np.all(level[::2] == -np.inf) and np.all(np.isfinite(level[1::2]))
        assert np.isfinite(record[f"response/control/{name}"].error_estimate)
    assert np.all(value_of(record, "attenuation")[::2] == 0.0)


def test_a_full_model_with_transients_of_the_motor_is_refused() -> None:
    case = case_of(full_model=True)
    motor = case.machine.motor
    assert motor is not None and control_problems(case) == []
    machine = case.machine.model_copy(
        update={"motor": motor.model_copy(update={"kind": "dynamic"})}
    )
    (problem,) = control_problems(case.model_copy(update={"machine": machine}))
    assert problem.path == ("response", "control", "full_model")
    assert "transients of the motor's fluxes" in problem.message


def unstable(full_model: bool) -> Record:
    record = record_of(gain=10.0, acceleration_feedback=1.0, full_model=full_model)
    assert value_of(record, "status") == 3 and np.all(np.isposinf(value_of(record, "level")))
    assert any("the loop is unstable" in text for text in record.warnings)
    return record


@pytest.mark.long
def test_an_unstable_loop_is_called_so_with_the_full_model_too() -> None:
    """The full model has no motion to look at there; the reduced results stand all the same."""
    found, alone = unstable(full_model=True), unstable(full_model=False)
    (words,) = [text for text in found.warnings if "full model under control is left out" in text]
    assert "the loop is unstable in the reduced model" in words
    assert PATH + "full/level" not in found and PATH + "range/level" in found
    np.testing.assert_array_equal(value_of(found, "pole"), value_of(alone, "pole"))
