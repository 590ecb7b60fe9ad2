"""Claim: torques given at stations act on a line as full matrices in its own angles say.

The truth: `dense_line.py` (nothing referred, gears as constraints), sums of records by fine
quadrature, phases of two cycles tried one by one.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from dense_line import DenseLine, half_range
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.numerics.synthesis import Cycles, synthesis
from vibecalc.torsion.station_torques import record_harmonics

ROOT = "response/torsion"
RATIO = 23.0 / 41.0
SPEED = 1480.0 * math.pi / 30.0


def table(name: str, **line: Any) -> dict[str, Any]:
    """A shipped case in SI, with other keys in its shaft line and no references."""
    case = resolve(load_case(CASES[name]).case)
    case["machine"]["shaft_line"].update(line)
    return {key: one for key, one in case.items() if not key.startswith(("reference", "limit"))}


def torques(line: DenseLine, w: float, station: str, amplitude: complex) -> np.ndarray:
    return line.alone(w, station, amplitude).torque[: len(line.line["shafts"]), 0]


@cache
def pump() -> tuple[DenseLine, Record]:
    case = validate(table("pump_drive"))
    return DenseLine(resolve(case)), run_case(case)


def test_what_cannot_follow_the_speed_has_no_critical_speed() -> None:
    _, record = pump()
    quantity = record[f"{ROOT}/critical/speed"]
    orders = np.asarray(quantity.axes[1].values)
    ripple = int(np.argmin(np.abs(orders * SPEED - 200.0 * math.pi)))
    values = np.asarray(quantity.values)[1:]
    assert np.all(np.isinf(values[:, ripple]))
    assert np.all(np.isfinite(np.delete(values, ripple, axis=1)))


BLADES = [
    {"on": "propeller", "blades": 4, "torques": ["900 N*m", "150 N*m"], "phases": [0.4, 1.1]},
    {"on": "generator", "orders": [3], "orders_of": "crankshaft", "torques": ["70 N*m"]},
]


def test_blades_meet_the_cycle_of_an_engine_in_every_phase() -> None:
    data = [table("engine_geared"), table("engine_geared", excitations=BLADES)]
    for one in data:
        one["response"]["torsion"] = {"orders": {"step": 0.5, "count": 24}}
    alone, case = run_case(validate(data[0])), validate(data[1])
    both, line = run_case(case), DenseLine(resolve(case))
    speed, blades = case.machine.speed, 4.0 * 40.0 / 118.0
    rows = np.asarray(alone[f"{ROOT}/torque"].values)[: len(line.line["shafts"])].copy()
    order = np.asarray(alone[f"{ROOT}/torque"].axes[1].values)
    # the third order of the generator turns with the engine
    rows[:, order == 3.0] += torques(line, 3.0 * speed, "generator", 70.0)[:, None]
    given = {1.0: 900.0 * np.exp(0.4j), 2.0: 150.0 * np.exp(1.1j)}
    pushed = [torques(line, q * blades * speed, "propeller", one) for q, one in given.items()]
    wanted = half_range(order, rows) + half_range(np.array([*given]), np.transpose(pushed))
    found = np.asarray(both[f"{ROOT}/torque_half_range"].values)[: len(rows)]
    assert found == pytest.approx(wanted, rel=1e-9)


def test_a_record_is_its_orders() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 73)
    torque = 300.0 + 40.0 * np.cos(3.0 * angle - 0.3) + 11.0 * np.sin(7.0 * angle)
    torque[-1] = torque[0]
    orders = np.arange(1, 13)
    x = record_harmonics(angle, torque, orders)
    fine = np.linspace(0.0, 2.0 * math.pi, 72 * 4001)[:-1]
    wave = np.interp(fine, angle, torque)
    for order, one in zip(orders, x, strict=True):
        assert one == pytest.approx(2.0 * np.mean(wave * np.exp(-1j * order * fine)), abs=2e-6)
    record = {"angle": angle.tolist(), "torque": torque.tolist()}
    by_record = {"on": "pump", "record": record, "harmonics": 12}
    by_order = {
        "on": "pump",
        "orders": orders.tolist(),
        "torques": np.abs(x).tolist(),
        "phases": np.angle(x).tolist(),
    }
    cases = [table("pump_drive", excitations=[one]) for one in (by_record, by_order)]
    for one in cases:
        one["response"]["torsion"]["speeds"]["points"] = 5
    first, second = (run_case(validate(one)) for one in cases)
    path = f"{ROOT}/speeds/torque_half_range"
    assert np.asarray(first[path].values) == pytest.approx(
        np.asarray(second[path].values), rel=1e-12
    )


def test_a_record_over_two_turns_has_half_orders() -> None:
    angle = np.linspace(0.0, 4.0 * math.pi, 145)
    record = {"angle": angle.tolist(), "torque": (10.0 * np.cos(0.5 * angle)).tolist()}
    given = {"on": "pump", "record": record, "harmonics": 3}
    made = run_case(validate(table("pump_drive", excitations=[given])))
    orders = np.asarray(made[f"{ROOT}/torque"].axes[1].values)
    assert orders == pytest.approx([0.5 * RATIO, RATIO, 1.5 * RATIO], rel=1e-12)


@pytest.mark.parametrize(
    ("law", "factor"),
    [
        ({"exponent": 1.5}, lambda share: share**1.5),
        (
            {"over_speed": {"speed": [50.0, 120.0, 200.0], "factor": [0.2, 0.9, 1.0]}},
            lambda share: np.interp(share * SPEED, [50.0, 120.0, 200.0], [0.2, 0.9, 1.0]),
        ),
    ],
)
def test_given_torques_follow_their_law(law: dict[str, Any], factor: Any) -> None:
    given = {"on": "pump", "blades": 5, "torques": ["30 N*m"], **law}
    case = validate(table("pump_drive", excitations=[given]))
    line, quantity = DenseLine(resolve(case)), run_case(case)[f"{ROOT}/speeds/torque_half_range"]
    for place in (3, 100):
        speed = float(np.asarray(quantity.axes[1].values)[place])
        amplitude = 30.0 * factor(speed / SPEED)
        wanted = np.abs(torques(line, 5.0 * RATIO * speed, "pump", amplitude))
        assert np.asarray(quantity.values)[:, place] == pytest.approx(wanted, rel=1e-9)


def test_the_station_that_balances_has_shares_of_what_is_left() -> None:
    given = {"on": "motor", "orders": [1], "shares": [0.1]}
    case = validate(table("pump_drive", excitations=[given]))
    line, quantity = DenseLine(resolve(case)), run_case(case)[f"{ROOT}/speeds/torque_half_range"]
    speed = float(np.asarray(quantity.axes[1].values)[40])
    amplitude = 0.1 * RATIO * 620.0 * (speed / SPEED) ** 2
    wanted = np.abs(torques(line, speed, "motor", amplitude))
    assert np.asarray(quantity.values)[:, 40] == pytest.approx(wanted, rel=1e-9)


def test_two_cycles_meet_in_every_phase() -> None:
    rng = np.random.default_rng(7)
    first, second = (rng.normal(size=n) + 1j * rng.normal(size=n) for n in (3, 2))
    cycles = Cycles(np.array([0.5, 1.0, 3.0, 4.0, 8.0]), np.array([0, 0, 0, 1, 1]))
    found = synthesis(cycles, np.concatenate([first, second]))
    angle = np.linspace(0.0, 4.0 * math.pi, 4001)
    one = (np.exp(1j * np.outer(angle, [0.5, 1.0, 3.0])) @ first).real
    other = (np.exp(1j * np.outer(angle, [4.0, 8.0])) @ second).real
    every = one[:, None] + other[None, :]
    assert found.highest == pytest.approx(every.max(), rel=1e-4)
    assert found.highest >= every.max() and found.lowest <= every.min()
    assert found.half_range == pytest.approx(0.5 * (found.highest - found.lowest), rel=1e-14)
    assert found.upper_bound == pytest.approx(np.abs(first).sum() + np.abs(second).sum())


# ----------------------------------------------------------------------------
# Changes in time.
# ----------------------------------------------------------------------------


def test_a_load_step_needs_no_excitation() -> None:
    step = {"kind": "load_step", "on": "pump", "torque": 40.0, "time_after": 0.2}
    nothing = [{"on": "motor", "orders": [1.0], "torques": [0.0]}]
    made = []
    for given in ((), nothing):
        case = table("pump_drive", excitations=given)
        case["response"]["torsion"] = {"transient": step}
        made.append(run_case(validate(case)))
    alone, same = made
    assert set(alone) == set(same)
    for name in ("transient/peak", "transient/steady_after", "modes/natural_frequency"):
        assert np.array_equal(alone[f"{ROOT}/{name}"].values, same[f"{ROOT}/{name}"].values)
    assert not np.any(alone[f"{ROOT}/torque_half_range"].values)
    # no order is near a mode where none acts
    assert not np.any(alone[f"{ROOT}/margin/nearest_order"].values)
    case["machine"]["shaft_line"]["excitations"] = ()
    case["response"]["torsion"]["speeds"] = {"from": 100.0, "to": 160.0, "points": 5}
    (problem,) = check_machine(validate(case))
    assert "nothing excites this line" in problem.message


def test_a_cylinder_that_stops_firing_takes_its_own_orders_along_and_no_others() -> None:
    stops = {"kind": "misfire_onset", "cylinder": "3", "time_before": 0.05, "time_after": 0.1}
    asked = {"misfire_kind": "motored", "orders": {"step": 0.5, "count": 8}, "transient": stops}
    still = [{**one, "torques": [0.0] * len(one["torques"])} for one in BLADES]
    found = []
    for given in ([], still):
        case = table("engine_geared", excitations=given)
        case["response"]["torsion"] = asked
        made = run_case(validate(case))
        found.append(np.asarray(made[f"{ROOT}/transient/steady_after"].values))
    assert found[1] == pytest.approx(found[0], rel=1e-9)
