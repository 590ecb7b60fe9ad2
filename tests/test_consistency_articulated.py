"""Claim: slave rods move as their constraints say, and shake the body with all of their masses."""

from typing import Any

import numpy as np
import pytest
from crank_trains import over_turn, slopes

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.kinematics.articulated_rod import SlaveRods, slave_motion

TURN = 2.0 * np.pi
SPEED = 190.0


def slave(
    on: str, radius: float, angle: float | None, length: float, rod: tuple[float, float, float]
) -> dict[str, Any]:
    """With the mass at its knuckle pin, its whole mass and its moment of inertia."""
    given = {"on": on, "knuckle_radius": radius, "rod_length": length}
    given |= dict(zip(("knuckle_mass", "rod_mass", "inertia"), rod, strict=True))
    return given if angle is None else {**given, "knuckle_angle": angle}


def engine(where: str) -> dict[str, Any]:
    """A V of two throws with master and slave each, cylinders off the axis, a rod of its own J."""
    return {
        "schema": 1,
        "title": "V of master and slave rods",
        "machine": {
            "kind": "machine",
            "speed": SPEED,
            "crank_train": {
                "crank_radius": 0.06,
                "rod_length": 0.2,
                "wrist_pin_offset": 0.004,
                "origin": [0.1, -0.02, 0.05],
                "piston_mass": 1.0,
                "rod": {"mass": 1.3, "crank_pin_to_mass_centre": 0.05, "inertia": 0.0121},
                "rotating_mass": 0.9,
                "cylinders": [
                    {"name": "1", "position": -0.1, "crank_phase": 0.3, "bank_angle": -0.4},
                    {
                        "name": "2", "position": -0.1, "crank_phase": 0.3, "bank_angle": 0.5,
                        "reciprocating_mass": 1.2,
                        "articulated": slave("1", 0.05, 0.95, 0.15, (0.7, 1.1, 0.0081)),
                    },
                    {"name": "3", "position": 0.15, "crank_phase": 2.0, "bank_angle": 0.5},
                    {
                        "name": "4", "position": 0.15, "crank_phase": 2.0, "bank_angle": -0.4,
                        "articulated": slave("3", 0.04, None, 0.17, (0.5, 0.9, 0.0017)),
                    },
                ],
            },
        },
        "kinematics": {},
        "excitation": {"driven_machine": where, "orders": 40},
    }  # fmt: skip


def wrist_pin(end: np.ndarray, length: float, bank: float, offset: float) -> np.ndarray:
    """Point on a cylinder's axis at a distance from the other end of its rod, by Newton."""
    place = np.abs(end) + length
    for _ in range(60):
        point = (place + 1j * offset) * np.exp(1j * bank)
        gap = np.abs(point - end) ** 2 - length**2
        place = place - gap / (2.0 * ((point - end) * np.exp(-1j * bank)).real)
    return (place + 1j * offset) * np.exp(1j * bank)


def by_points(table: dict[str, Any], angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force (3, n) and couple about the reference point (3, n), less the torque on the shaft.

    Every mass is a point of the plane that its constraint places, differentiated by transform; a
    slave rod is a rigid body, with its mass centre and its moment of inertia about that.
    """
    train = table["machine"]["crank_train"]
    rod, offset, length = train["rod"], train["wrist_pin_offset"], train["rod_length"]
    share = rod["crank_pin_to_mass_centre"] / length
    small, big = rod["mass"] * share, rod["mass"] * (1.0 - share)
    own = rod["inertia"] - rod["mass"] * length**2 * share * (1.0 - share)
    points, turning = [], []  # (position, place, mass); (rod angle, moment of inertia)
    masters = {}
    for cylinder in train["cylinders"]:
        pin = 0.06 * np.exp(1j * (angle + cylinder["crank_phase"]))
        along, bank = cylinder["position"], cylinder["bank_angle"]
        mass = cylinder.get("reciprocating_mass", train["piston_mass"] + small)
        given = cylinder.get("articulated")
        if given is None:
            wrist = wrist_pin(pin, length, bank, offset)
            masters[cylinder["name"]] = (pin, (wrist - pin) / length, bank)
            points += [(along, wrist, mass), (along, pin, big + train["rotating_mass"])]
            turning.append((np.unwrap(np.angle(wrist - pin)), own))
            continue
        pin, arm, its = masters[given["on"]]
        knuckle_angle = given.get("knuckle_angle", bank - its)
        knuckle = pin + given["knuckle_radius"] * arm * np.exp(1j * knuckle_angle)
        wrist = wrist_pin(knuckle, given["rod_length"], bank, offset)
        at_wrist = given["rod_mass"] - given["knuckle_mass"]
        centre = knuckle + at_wrist / given["rod_mass"] * (wrist - knuckle)
        points += [(along, wrist, mass - at_wrist), (along, centre, given["rod_mass"])]
        turning.append((np.unwrap(np.angle(wrist - knuckle)), given["inertia"]))
    force, couple = np.zeros((3, len(angle))), np.zeros((3, len(angle)))
    energy = np.zeros(len(angle))
    for along, place, mass in points:
        velocity, acceleration = slopes(place)
        push = -mass * acceleration
        inertia = np.stack([0.0 * angle, -push.imag, push.real])
        arm = np.stack([0.0 * angle + along, -place.imag, place.real])
        arm = arm + np.array(train["origin"])[:, None]
        force, couple = force + inertia, couple + np.cross(arm, inertia, axis=0)
        energy = energy + 0.5 * mass * np.abs(velocity) ** 2
    for tilt, inertia in turning:
        rate, change = slopes(tilt)
        couple[0] -= inertia * change.real
        energy = energy + 0.5 * inertia * rate.real**2
    if table["excitation"]["driven_machine"] != "cancels_torque":
        couple[0] += slopes(energy)[0].real
    return SPEED**2 * force, SPEED**2 * couple


@pytest.mark.parametrize("where", ["separate", "cancels_torque"])
def test_forces_and_couples_are_those_of_all_points(where: str) -> None:
    table = engine(where)
    angle = TURN * np.arange(512) / 512
    record = run_case(validate(table))
    expected = by_points(table, angle)
    for kind, wanted in zip(("force", "couple"), expected, strict=True):
        found = over_turn(record, angle, kind)
        wanted = wanted - wanted.mean(axis=-1, keepdims=True)
        scale = np.abs(wanted).max()
        assert found == pytest.approx(wanted, abs=1e-9 * scale), kind
    force = record["excitation/force"].values
    along, ahead = force[:, 2], -force[:, 1]
    for name, sense in (("with_crank", 1j), ("against_crank", -1j)):
        turning = record[f"excitation/turning/{name}"].values
        assert turning == pytest.approx(0.5 * np.abs(along + sense * ahead), abs=1e-9)


def test_strokes_and_dead_centres() -> None:
    record = run_case(validate(engine("separate")))
    train = engine("separate")["machine"]["crank_train"]
    angle = TURN * np.arange(20_000) / 20_000
    cylinder = train["cylinders"][1]
    rods = SlaveRods(0.06, 0.2, 0.004, *(np.array([[one]]) for one in (
        0.3, -0.4, cylinder["bank_angle"], 0.05, 0.95, 0.15,
    )))  # fmt: skip
    place = slave_motion(rods, angle).position[0]
    path = "kinematics/cylinder"
    stroke = record[f"{path}/stroke"].values
    assert stroke[1] == pytest.approx(np.ptp(place), abs=1e-8)
    assert stroke[0] == pytest.approx(
        np.sqrt(0.26**2 - 0.004**2) - np.sqrt(0.14**2 - 0.004**2), rel=1e-13
    )
    top = record[f"{path}/top_dead_centre"].values[1]
    assert top == pytest.approx(angle[np.argmax(place)], abs=4e-4)
    waves = np.exp(1j * np.multiply.outer(np.arange(41), angle[:50]))
    series = record[f"{path}/position_harmonics"].values[1]
    assert np.real(series @ waves) == pytest.approx(place[:50], abs=1e-13)
