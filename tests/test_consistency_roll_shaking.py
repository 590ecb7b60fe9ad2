"""Claim: the textbook's shaking in a roll case is that of its crank train at the speed found."""

import copy
from typing import Any

import numpy as np
import pytest
from response_machines import run, shipped

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.roll.report.running import shaking

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
