"""Claim: peaks of a turn are no lower than any value of it, and each change of a parameter does
what a run of the machine so changed says, or is lost with the reason.
"""

import copy
from typing import Any

import numpy as np
import pytest
from response_machines import run, shipped
from roll_machines import ROTOR, SYNCHRONOUS, source_drive, source_machine
from shipped_cases import result_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.level import level_of
from vibecalc.roll.adapters.readings import MachineTurn, peaks_of
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.report.advice import parameter_words
from vibecalc.roll.report.running import shaking
from vibecalc.roll.running import motion_of_state, running_state
from vibecalc.roll.sensitivity import altered, changes, parameters
from vibecalc.roll.steady import SteadyTurn
from vibecalc.roll.turn import readings


def seen_of(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> MachineTurn:
    return MachineTurn(machine, drive, state.turn, motion_of_state(machine, drive, state))


@pytest.mark.parametrize(
    ("fields", "gas", "motor"),
    [
        ({"gas_scale": [1.3, 0.5], "rod_length": 0.1, "wrist_pin_offset": 0.005,
          "crank_angle_offset": [0.0, 0.5 * np.pi], "friction_damping": 0.3,
          "piston_friction": 100.0}, "parabola", "monotone"),
        ({"shell_stiffness": 3e5, "shell_damping": 2e3, "rotor_inertia": 5.0 * ROTOR,
          "shell_inertia": 20.0}, "trigonometric", "linear"),
    ],
    ids=["offset", "mounted"],
)  # fmt: skip
def test_peaks_are_no_lower_than_any_value_of_the_turn(
    fields: dict[str, object], gas: str, motor: str
) -> None:
    machine, drive = as_batch(source_machine(**fields)), source_drive(gas, motor, holds=True)
    running = running_state(machine, drive, rtol=1e-8, orders=10)
    seen = seen_of(machine, drive, running.state)
    angles = np.linspace(0.0, 2.0 * np.pi, 20001)
    read = readings(machine, drive, seen.motion(angles))
    for name, (tops, left) in peaks_of(seen).items():
        dense = np.abs(np.asarray(getattr(read, name))[0]).max(axis=0)
        assert np.all(tops + left >= dense * (1.0 - 1e-9))
        assert np.all(tops <= dense * (1.0 + 1e-4))


def test_levels_below_their_error_are_zero() -> None:
    levels, uncertainty = level_of(
        Bounded(np.array([1.0, 1e-3j]), np.array([1e-2, 1e-2])), reference=1.0
    )
    assert levels.tolist() == [0.0, -np.inf]
    assert uncertainty[0] == pytest.approx(-20.0 * np.log10(0.99)) and uncertainty[1] == 0.0


@pytest.mark.parametrize("points", [3, 8])
def test_points_of_the_case_are_kept(points: int) -> None:
    machine, drive = as_batch(source_machine()), source_drive()
    running = running_state(
        machine, drive, rtol=1e-10, orders=10, started_at=SYNCHRONOUS, points=points
    )
    assert (running.state.points, running.check.points) == (points, points + 2)


ORDERS = np.arange(1, 11)
NAMES = ("first stage", "second stage")
MACHINE = as_batch(source_machine())
DRIVE = source_drive()
ONLY = (
    "response.roll.interpolations=false",
    "response.roll.classical=false",
    'response.roll.compare=["euler"]',
)


def changed(words: str, factor: float) -> RollMachine:
    row = next(row for row in parameters(MACHINE, NAMES) if parameter_words(row.name) == words)
    return altered(MACHINE, [(row, factor)])


@pytest.mark.long
def test_the_same_changes_written_into_the_case_bring_the_same() -> None:
    level = "response/roll/level/shell_acceleration"
    base = result_of("roll", *ONLY)
    train = base.case["machine"]["crank_train"]  # type: ignore[index]
    rotor = base.case["machine"]["rotor"]["inertia"]  # type: ignore[index]
    radius = train["crank_radius"]
    for word, factor, name, key, value in (
        ("more", 1.1, "crank_radius", "machine.crank_train.crank_radius", radius),
        ("less", 0.9, "rotor_inertia", "machine.rotor.inertia", rotor),
    ):
        found = base.record[f"response/roll/sensitivity/ten_percent_{word}"]
        assert found.error_estimate < 1e-6
        rows = [str(name) for name in found.axes[0].values]
        quiet = (*ONLY, "response.roll.sensitivity=false")
        moved = result_of("roll", *quiet, f"{key}={factor * value!r}")
        np.testing.assert_allclose(
            moved.record[level].values - base.record[level].values,
            found.values[rows.index(name)],
            atol=found.error_estimate + 1e-7,
        )


def test_the_stated_error_bounds_the_true_one() -> None:
    for points in (3, 4):
        found = changes(
            MACHINE, DRIVE, ORDERS, NAMES, (1.1,), points=points, started_at=SYNCHRONOUS
        )[0]
        fine = changes(MACHINE, DRIVE, ORDERS, NAMES, (1.1,), points=10, started_at=SYNCHRONOUS)[0]
        off = np.abs(found.value - fine.value)
        assert found.parameters == fine.parameters
        assert np.all(off <= found.error + fine.error) and np.max(off) > 1e-9


def test_a_change_that_leaves_no_running_state_is_lost_with_the_reason() -> None:
    # a demand of nine tenths of what the motor gives at most: with less motor it stalls
    need = running_state(MACHINE, DRIVE, rtol=1e-6, orders=2, started_at=SYNCHRONOUS).state.demand
    weak = MACHINE._replace(
        motor_scale=0.95**-1 * need.torque / need.breakdown, rotor_inertia=np.array([200.0])
    )
    more, less = changes(weak, DRIVE, (1, 2), NAMES, (1.1, 0.9), points=4, started_at=SYNCHRONOUS)
    assert "motor_torque" in more.parameters and "motor_torque" not in less.parameters
    assert dict(less.lost)["motor_torque"].startswith("no running state exists")
    assert len(less.parameters) + len(less.lost) == len(more.parameters) + len(more.lost)


def test_a_rod_that_would_not_reach_over_the_crank_is_lost_with_the_reason() -> None:
    short = MACHINE._replace(rod_length=np.array([1.05 * 0.0635]))
    more, less = changes(short, DRIVE, (1, 2), NAMES, (1.1, 0.9), points=4, started_at=SYNCHRONOUS)
    assert dict(more.lost).get("crank_radius") == "the rod is too short for the crank"
    assert dict(less.lost).get("rod_length") == "the rod is too short for the crank"
    assert "rotor_inertia" in more.parameters


# ----------------------------------------------------------------------------
# The textbook's shaking is that of the crank train at the speed found.
# ----------------------------------------------------------------------------


SHAKING = "response/roll/shaking/"


def table(name: str, **options: Any) -> dict[str, Any]:
    found = copy.deepcopy(shipped(name))
    found["response"]["roll"] = {"orders": 6, "classical": True} | options
    found.pop("limit", None), found.pop("reference", None), found.pop("reference_table", None)
    return found


def placed() -> dict[str, Any]:
    """The two-stage machine with its cylinders apart, and a counterweight."""
    found = table("roll")
    train = found["machine"]["crank_train"]
    for cylinder, place in zip(train["cylinders"], ("-90 mm", "110 mm"), strict=True):
        cylinder["position"] = place
    train["counterweights"] = [
        {"name": "web", "unbalance": "0.2 kg*m", "phase": "170 deg", "position": "-150 mm"}
    ]
    return found


def at_speed(data: dict[str, Any], speed: float) -> Record:
    """The same crank train at a given speed, as a case that asks for its forces."""
    train = copy.deepcopy(data["machine"]["crank_train"])
    for cylinder in train["cylinders"]:
        cylinder.pop("gas_force")
    train.pop("gas_interpolation")
    machine = {"kind": "compressor", "speed": speed, "crank_train": train}
    case = {
        "schema": 1,
        "title": "forces",
        "machine": machine,
        "excitation": {"orders": 12, "driven_machine": "cancels_torque"},
    }
    return run(case)


def test_force_and_couple_are_those_of_the_crank_train() -> None:
    data = placed()
    record = run(data)
    speed = float(record["response/roll/speed"].values)
    alone = at_speed(data, speed)
    for name in ("force", "couple"):
        found, known = record[SHAKING + name], alone[f"excitation/{name}"]
        assert found.values.shape == (6, 3)
        size = float(np.max(np.abs(known.values)))
        assert size > 100.0
        np.testing.assert_allclose(found.values, known.values[:6], atol=1e-9 * size)
        assert found.error_estimate < 1e-8 * size
        peak, other = record[f"{SHAKING}{name}_peak"], alone[f"excitation/{name}_peak"]
        assert np.max(np.abs(peak.values - other.values)) <= (
            peak.error_estimate + other.error_estimate + 1e-9 * size
        )


def test_one_piston_less_shakes() -> None:
    data = table("roll_balanced")
    data["excitation"] = {"working": ["upper"], "idle": "stopped"}
    record = run(data)
    mass, radius, rod = 10.676483184793915, 0.0635, 0.2921
    speed = float(record["response/roll/speed"].values)
    # the largest acceleration of a piston is at top dead centre, where it is exactly this
    known = mass * radius * speed**2 * (1.0 + radius / rod)
    peak = float(record[SHAKING + "force_peak"].values[2])
    assert peak == pytest.approx(known, rel=1e-6)
    assert f"{peak:.4g} N along z" in " ".join(" ".join(shaking(record)).split())


def test_cylinders_in_one_place_are_said_where_couples_count() -> None:
    words = "no couple between them"
    assert any(words in text for text in machine_warnings(validate(table("roll"))))
    assert not any(
        words in text for text in machine_warnings(validate(table("roll", classical=False)))
    )
    assert not any(words in text for text in machine_warnings(validate(placed())))


@pytest.mark.parametrize("step", ["0.5 ms", "5 ms"])
def test_a_step_that_no_method_uses_is_a_caution(step: str) -> None:
    case = validate(table("roll", step=step))
    (text,) = [text for text in machine_warnings(case) if "response.roll.step" in text]
    assert "has no effect" in text and "euler and rk4" in text
    used = validate(table("roll", step="0.5 ms", compare=["rk4"]))
    assert not any("response.roll.step" in text for text in machine_warnings(used))
