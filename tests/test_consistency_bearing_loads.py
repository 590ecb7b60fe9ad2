"""Claim: bearings bear what Newton, Euler and the balance of the whole crankshaft say."""

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from crank_trains import over_turn, slopes
from shipped_cases import table_of

from vibecalc.bearings.crank_loads import cycle_means, cycle_peaks
from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.core.run.run import run_case

ROOT = "bearing_loads"
TURN = 2.0 * np.pi
CARD = {
    "crank_angle": [0.0, 0.3, 0.9, 2.5, 4.0, 5.5, 6.0, TURN],
    "pressure": [4e6, 5e6, 2e6, 3e5, 1e4, 2e5, 1e6, 4e6],
}
BEARINGS = [{"name": "front", "position": -0.11}, {"name": "rear", "position": 0.14}]


def machine(**train: Any) -> dict[str, Any]:
    """One cylinder with offset, tilted, between two bearings, with a flywheel beyond."""
    return {
        "schema": 1,
        "title": "one cylinder",
        "machine": {
            "kind": "engine",
            "cycle": "two_stroke",
            "speed": 310.0,
            "crank_train": {
                "crank_radius": 0.05,
                "rod_length": 0.17,
                "wrist_pin_offset": 0.006,
                "piston_mass": 0.8,
                "pin_mass": 0.2,
                "rod": {"mass": 0.9, "crank_pin_to_mass_centre": 0.06, "inertia": 0.0061},
                "rotating_mass": 1.1,
                "bore": 0.09,
                "gas_pressure": CARD,
                "cylinders": [
                    {"name": "1", "position": 0.02, "crank_phase": 0.7, "bank_angle": 0.35}
                ],
                "counterweights": [
                    {"name": "web", "unbalance": 0.06, "phase": 3.6, "position": 0.05}
                ],
                **train,
            },
        },
        "excitation": {"orders": 40},
        "bearing_loads": {
            "main_bearings": BEARINGS,
            "shaft_loads": [
                {"name": "wheel", "position": 0.2, "mass": 30.0},
                {"name": "belt", "position": -0.16, "force": [0.0, 500.0, -200.0]},
            ],
            "crank_angles": 361,
        },
    }


def run(table: dict[str, Any]) -> Record:
    return run_case(validate(table))


def by_newton_and_euler(
    table: dict[str, Any], angle: np.ndarray, pressure: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Crank pin, wrist pin (complex, stroke + i ahead) and wall at crank angles of a turn.

    Five equations for five unknown forces at each angle: of the piston along and across its
    cylinder, of the rod along both and about its mass centre.
    """
    train = table["machine"]["crank_train"]
    (cylinder,), rod, speed = train["cylinders"], train["rod"], table["machine"]["speed"]
    radius, length, offset = train["crank_radius"], train["rod_length"], train["wrist_pin_offset"]
    local = angle + cylinder["crank_phase"] - cylinder["bank_angle"]
    pin = radius * np.exp(1j * local)
    wrist = pin.real + np.sqrt(length**2 - (pin.imag - offset) ** 2) + 1j * offset
    along = (wrist - pin) / length
    centre = pin + rod["crank_pin_to_mass_centre"] * along
    piston_acceleration = slopes(wrist)[1].real * speed**2
    acceleration = slopes(centre)[1] * speed**2
    tilt = np.unwrap(np.angle(along))
    bent = slopes(tilt)[1].real * speed**2
    gas = pressure * 0.25 * np.pi * train["bore"] ** 2
    mass = train["piston_mass"] + train["pin_mass"]
    found = []
    for k in range(len(angle)):
        # unknown: wrist pin on the rod (2), crank on the rod (2), wall on the piston
        to_wrist, to_crank = wrist[k] - centre[k], pin[k] - centre[k]
        matrix = np.array([
            [-1.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, -1.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 1.0, 0.0],
            [-to_wrist.imag, to_wrist.real, -to_crank.imag, to_crank.real, 0.0],
        ])  # fmt: skip
        right = [
            mass * piston_acceleration[k] + gas[k], 0.0,
            rod["mass"] * acceleration[k].real, rod["mass"] * acceleration[k].imag,
            rod["inertia"] * bent[k],
        ]  # fmt: skip
        found.append(np.linalg.solve(matrix, right))
    wx, wy, cx, cy, wall = np.array(found).T
    turned = np.exp(1j * cylinder["bank_angle"])
    return -(cx + 1j * cy) * turned, (wx + 1j * wy) * turned, -wall


def force_of(record: Record, path: str) -> np.ndarray:
    """Forces (bearing, angle) along z, the stroke, + i along -y, ahead of it."""
    across, up = np.moveaxis(record[path].values, -2, 0)
    return up - 1j * across


def test_rod_and_bearings_by_newton_and_euler() -> None:
    table = machine()
    record, train = run(table), table["machine"]["crank_train"]
    angle = record[f"{ROOT}/main/force"].axes[-1].values[:-1]
    own = np.mod(angle + 0.7 - 0.35, TURN)
    pressure = np.interp(own, CARD["crank_angle"], CARD["pressure"])
    pin, wrist, wall = by_newton_and_euler(table, angle, pressure)
    scale = np.abs(wrist).max()
    for path, expected in (("crank_pin/force", pin), ("wrist_pin/force", wrist)):
        assert force_of(record, f"{ROOT}/{path}")[0, :-1] == pytest.approx(
            expected, abs=1e-10 * scale
        )
    assert record[f"{ROOT}/side_thrust/force"].values[0, :-1] == pytest.approx(
        wall, abs=1e-10 * scale
    )
    outward, ahead = record[f"{ROOT}/crank_pin/force_of_throw"].values[0]
    turning = (outward + 1j * ahead)[:-1] * np.exp(1j * (angle + 0.7))
    assert turning == pytest.approx(pin, abs=1e-10 * scale)
    # two bearings: force and moment of all that loads the shaft
    square = table["machine"]["speed"] ** 2
    loads = [
        (0.02, pin + 1.1 * 0.05 * square * np.exp(1j * (angle + 0.7))),
        (0.05, 0.06 * square * np.exp(1j * (angle + 3.6))),
        (0.2, np.full(len(angle), -30.0 * 9.80665 + 0j)),
        (-0.16, np.full(len(angle), -200.0 - 500.0j)),
    ]
    total = sum(force for _, force in loads)
    moment = sum((place + 0.11) * force for place, force in loads)
    rear = moment / 0.25
    main = force_of(record, f"{ROOT}/main/force")[:, :-1]
    assert main[1] == pytest.approx(rear, abs=1e-10 * scale)
    assert main[0] == pytest.approx(total - rear, abs=1e-10 * scale)
    assert train["rod"]["mass"] == 0.9


def test_all_bearings_and_walls_make_the_shaking_of_the_engine() -> None:
    table = deepcopy(table_of("engine_bearing_loads"))
    train, asked = table["machine"]["crank_train"], table["bearing_loads"]
    del train["gas_cycle"], train["bore"], asked["speeds"], asked["shaft_loads"]
    train["cylinders"][1]["bank_angle"] = 0.9
    for cylinder, phase in zip(train["cylinders"], (0.2, 1.3, 4.0, 5.0), strict=True):
        cylinder["crank_phase"] = phase
    del train["firing_order"]
    table["excitation"]["orders"] = 40
    record = run(table)
    angle = record[f"{ROOT}/main/force"].axes[-1].values
    main = force_of(record, f"{ROOT}/main/force")
    bank = np.array([0.0, 0.9, 0.0, 0.0])
    wall = record[f"{ROOT}/side_thrust/force"].values * 1j * np.exp(1j * bank)[:, None]
    force = main.sum(0) + wall.sum(0)
    _, y, z = over_turn(record, angle, "force")
    scale = np.abs(main).max()
    assert force == pytest.approx(z - 1j * y, abs=1e-9 * scale)
    # moments about the transverse axes: x cross force
    places = np.array([-0.18, -0.09, 0.0, 0.09, 0.18])
    cylinders = np.array([-0.135, -0.045, 0.045, 0.135])
    moment = places @ main + cylinders @ wall
    _, about_y, about_z = over_turn(record, angle, "couple")
    assert -moment.real == pytest.approx(about_y, abs=1e-9 * scale)
    assert -moment.imag == pytest.approx(about_z, abs=1e-9 * scale)


def test_highest_and_mean_loads() -> None:
    """An ellipse that stands aside, and a path with corners, against a fine grid."""
    places = np.array([0.4, 2.0, 5.0])

    def every(angle: np.ndarray) -> np.ndarray:
        ellipse = 3.0 * np.cos(angle) + 1j * np.sin(angle) + 0.5 + 0.2j
        corners = np.interp(angle % TURN, [0.0, *places, TURN], [1.0, 4.0, -2.0, 3.9, 1.0])
        return np.stack([ellipse, corners + 0.3j], axis=-1)

    height, place = cycle_peaks(every, places, TURN)
    mean, vector = cycle_means(every, places, TURN)
    fine = np.linspace(0.0, TURN, 400_001)
    size = np.abs(every(fine)).T
    assert height.value == pytest.approx([size[0].max(), np.hypot(4.0, 0.3)], rel=1e-9)
    assert place.value[1] == pytest.approx(0.4, abs=1e-9)
    sampled = 0.5 * (size[:, 1:] + size[:, :-1]).mean(-1)
    assert mean.value == pytest.approx(sampled, rel=1e-9)
    assert np.all(height.error < 1e-9) and np.all(mean.error < 1e-9)
    assert vector.value[0] == pytest.approx(0.5 + 0.2j)


def test_gas_of_cards_between_their_speeds_and_of_a_weak_cylinder() -> None:
    table = machine()
    train = table["machine"]["crank_train"]
    del train["gas_pressure"]
    low = {**CARD, "pressure": [0.5 * one for one in CARD["pressure"]]}
    train["gas_cards"] = [
        {"speed": 200.0, "gas_pressure": low},
        {"speed": 400.0, "gas_pressure": CARD},
    ]
    train["cylinders"][0]["pressure_scale"] = 0.9
    record = run(table)
    angle = record[f"{ROOT}/main/force"].axes[-1].values[:-1]
    pressure = np.interp(np.mod(angle + 0.35, TURN), CARD["crank_angle"], CARD["pressure"])
    share = 0.9 * (0.5 * 0.45 + 0.55)
    pin, wrist, _ = by_newton_and_euler(table, angle, share * pressure)
    scale = np.abs(wrist).max()
    assert force_of(record, f"{ROOT}/crank_pin/force")[0, :-1] == pytest.approx(
        pin, abs=1e-10 * scale
    )


#: a body on four mounts, for what says where gravity acts
MOUNTED = {
    "body": {"mass": 90.0, "inertia": [4.0, 5.0, 6.0]},
    "mounts": {
        "each": {"stiffness": 1e6},
        "positions": [[0.3, 0.2, 0.0], [-0.3, 0.2, 0.0], [0.0, -0.2, 0.0], [0.0, 0.0, 0.1]],
    },
}


@pytest.mark.parametrize(("gravity", "up"), [(1.62, "y"), (0.0, "z")])
def test_weights_act_as_those_of_the_body_on_its_mounts(gravity: float, up: str) -> None:
    table = machine()
    angle = run(table)[f"{ROOT}/main/force"]
    table["machine"] |= MOUNTED
    table["isolation"] = {"model": "rigid_body", "up": up, "gravity": gravity}
    changed = run(table)[f"{ROOT}/main/force"].values - angle.values
    # the wheel at 0.2 m: 0.31 / 0.25 of it on the rear bearing, the rest on the front one
    here, usual = np.zeros(2), np.array([0.0, -30.0 * 9.80665])
    here["yz".index(up)] = -30.0 * gravity
    for bearing, share in ((0, -0.06 / 0.25), (1, 0.31 / 0.25)):
        expected = share * (here - usual)[:, None] + np.zeros(len(angle.axes[-1].values))
        assert changed[bearing] == pytest.approx(expected, abs=1e-8)


def test_what_loads_leave_out_is_said() -> None:
    table = machine()
    table["machine"] |= {"kind": "compressor", **MOUNTED}
    del table["machine"]["cycle"]
    assert not any("[bearing_loads]" in one for one in machine_warnings(validate(table)))
    table["machine"]["joints"] = {"wrist_pin": {"clearance": 1e-4, "stiffness": 1e8}}
    table["response"] = {"operations": [{"name": "on", "working": ["1"]}]}
    said = " ".join(machine_warnings(validate(table)))
    assert "impacts of [machine.joints] are not in them" in said
    assert "other operations and the changes between them are not in them" in said
