"""Claim: a machine that does not run says so, why, and what would help; the exit code is 3."""

from pathlib import Path

import pytest
from fuzzing import command
from long_but import long_but
from roll_machines import RPM, SYNCHRONOUS, source_drive, source_machine
from shipped_cases import CASES

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import linear_motor
from vibecalc.roll import running
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.running import running_state

FILES = ("roll_first_stage.csv", "roll_second_stage.csv", "roll_motor.csv")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """The shipped machine, without references and studies, in a folder of its own."""
    text = CASES["roll"].read_text(encoding="utf-8").split("[response.roll]")[0]
    for name in FILES:
        (tmp_path / name).write_text((CASES["roll"].parent / name).read_text(encoding="utf-8"))
    path = tmp_path / "case.toml"
    path.write_text(f'{text}[response.roll]\nstarted_at = "900 rpm"\n', encoding="utf-8")
    return path


def scaled(case: Path, factor: float) -> None:
    """All gas forces times a factor."""
    for name in FILES[:2]:
        path = case.parent / name
        lines = path.read_text().splitlines()
        head = next(n for n, line in enumerate(lines) if not line.startswith("#"))
        rows = [line.split(",") for line in lines[head + 1 :]]
        lines[head + 1 :] = [f"{angle},{factor * float(force)!r}" for angle, force in rows]
        path.write_text("\n".join(lines) + "\n")


def said(case: Path, *settings: str) -> str:
    """What a run says that ends with exit code 3, and leaves no result behind."""
    options = [part for setting in settings for part in ("--set", setting)]
    out = case.with_suffix(".h5")
    outcome = command("run", str(case), "-q", "-o", str(out), *options)
    assert outcome.code == 3, outcome.err
    assert not out.exists()
    return " ".join(outcome.err.split())


def test_demand_beyond_breakdown(case: Path) -> None:
    scaled(case, 3.5)
    words = said(case)
    assert "no running state exists: gas and friction ask for 1061.35 N*m on average" in words
    assert "more than the motor gives (1009 N*m at breakdown)" in words


@pytest.mark.parametrize("hold", long_but([False, True], False))
def test_a_stall_below_breakdown(case: Path, hold: bool) -> None:
    scaled(case, 3.2)
    words = said(case, *(["machine.motor.extrapolation=hold"] if hold else []))
    assert "from any speed the machine comes to a standstill" in words
    assert "mean demand of 970.373 N*m is below the breakdown torque of 1009 N*m" in words
    assert "a heavier rotor carries it through" in words


def test_a_rotor_too_light_to_get_over_compression(case: Path) -> None:
    words = said(case, "machine.rotor.inertia=0.03")
    assert "comes to a standstill, beyond a crank angle of" in words


def test_slip_beyond_the_table(case: Path) -> None:
    path = case.parent / "roll_motor.csv"
    lines = path.read_text().splitlines()
    # up to a slip of 34 rpm; the machine swings a little further
    head = next(n for n, line in enumerate(lines) if not line.startswith("#"))
    path.write_text("\n".join(lines[: head + 5]) + "\n")
    words = said(case)
    assert "beyond the motor's table, which ends at" in words
    assert 'machine.motor.extrapolation = "hold"' in words
    outcome = command(
        "run", str(case), "-q", "-o", str(case.with_suffix(".h5")), "--set",
        "machine.motor.extrapolation=hold",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err


def refused(machine: RollMachine, drive: RollDrive) -> str:
    with pytest.raises(NumericalFailure) as caught:
        running_state(as_batch(machine), drive, rtol=1e-8, orders=10, started_at=SYNCHRONOUS)
    return str(caught.value)


def test_a_linear_motor_too_weak() -> None:
    drive = source_drive()._replace(motor=linear_motor(3.0))
    words = refused(source_machine(), drive)
    assert "ask for 303.242 N*m" in words and "more slip than its synchronous speed" in words
    assert "inf" not in words


def test_viscous_friction_counts_in_the_demand() -> None:
    machine = source_machine(friction_damping=10.0)
    words = refused(machine, source_drive(holds=True))
    # at the speed of breakdown, 792 rpm
    asked = 303.242 + 10.0 * 792.0 * RPM
    assert f"ask for {asked:.4g}"[:-1] in words


def test_a_tolerance_that_few_points_do_not_keep(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "POINT_LEVELS", ((0.0, (2, 3)),))
    words = refused(source_machine(), source_drive())
    assert "with 3 points on each of 48 panels the spectrum is known to" in words
    assert "allow that much with [accuracy] rtol" in words


def test_on_mounts_too() -> None:
    held = {"shell_stiffness": 3e5, "shell_damping": 3e3}
    words = refused(source_machine(gas_scale=[3.5, 3.5], **held), source_drive(holds=True))
    assert "ask for 1061.35 N*m" in words
    words = refused(source_machine(rotor_inertia=0.01, **held), source_drive(holds=True))
    assert "no running state" in words
