"""Dampings and loads that follow the speed: closed forms, dense solves, numbers instead of laws."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.torque_reaction import line_transfer
from vibecalc.torsion.adapters.critical import critical
from vibecalc.torsion.adapters.motion import solved as solved_line
from vibecalc.torsion.adapters.search import with_narrow
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.adapters.variable_inertia import system_of
from vibecalc.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.speed_damping import SpeedLaw, archer_multiple, propeller_law

RPM = math.pi / 30.0
CASE = Path(__file__).parents[1] / "cases" / "marine_propulsion.toml"
ROOT = "response/torsion/"
RATED = 100.0
#: of the wheel and the propeller over the crank, the other way round
RATIO = -0.4
TABLE = {"speed": [60.0, 90.0, 150.0], "factor": [0.5, 1.0, 1.6]}
TORQUE = {"speed": [50.0, 100.0, 160.0], "torque": [900.0, 2500.0, 4200.0]}
INERTIA = {"a": 3.0, "b": 3.0, "pinion": 2.0, "wheel": 60.0, "propeller": 90.0}
STIFFNESS = {"crank": 2e6, "coupling": 8e4, "shaft": 3e5}


def machine(**line: Any) -> dict[str, Any]:
    return {
        "schema": 1,
        "title": "laws",
        "machine": {
            "kind": "engine", "cycle": "four_stroke", "speed": RATED,
            "crank_train": {
                "crank_radius": 0.1, "rod_length": 0.4, "reciprocating_mass": 12.0, "bore": 0.2,
                "gas_cycle": {"kind": "diesel", "compression_ratio": 14, "peak_pressure": 1.2e7,
                              "intake_pressure": 2e5, "exhaust_pressure": 1.8e5},
                "cylinders": [{"name": "1"}, {"name": "2"}], "firing_order": ["1", "2"],
            },
            "shaft_line": line,
        },
        "response": {"torsion": {
            "speeds": {"from": 65.0, "to": 140.0, "points": 6}, "orders": {"step": 0.5, "count": 8},
        }},
    }  # fmt: skip


def geared() -> dict[str, Any]:
    """Each station and shaft with a law of another kind, behind the gear by the own speed."""
    stations: list[dict[str, Any]] = [{"name": n, "inertia": i} for n, i in INERTIA.items()]
    stations[0]["cylinder"], stations[1]["cylinder"] = "1", "2"
    own = {"of": "own", "exponent": 1.5, "reference": 40.0}
    stations[3] |= {"absolute_damping": 300.0, "over_speed": own}
    shafts = [
        {"name": n, "between": ends, "stiffness": STIFFNESS[n]}
        for n, ends in (("crank", ["a", "b"]), ("coupling", ["b", "pinion"]),
                        ("shaft", ["wheel", "propeller"]))
    ]  # fmt: skip
    shafts[0] |= {"magnifier": 80, "over_speed": {"table": TABLE}}
    shafts[1] |= {"damping": 30.0, "lehr_ratio": 0.02, "over_speed": own | {"reference": 100.0}}
    steps = {"speed": [20.0, 40.0, 60.0], "factor": [2.0, 1.0, 0.7]}
    slow = {"of": "own", "table": steps}
    shafts[2] |= {"damping": 200.0, "over_speed": slow}
    return machine(
        balanced_by="pinion",
        absorbed_torques=[{"on": "propeller", "curve": TORQUE,
                "propeller_damping": {"method": "factor", "coefficient": 3.5}}],
        engine_damping={"magnifier": 50, "mode": 3, "over_speed": {"table": TABLE}},
        stations=stations,
        shafts=shafts,
        gears=[{"name": "gear", "between": ["pinion", "wheel"], "ratio": 0.4}],
    )  # fmt: skip


def table(speed: float) -> float:
    return float(np.interp(speed, TABLE["speed"], TABLE["factor"]))


def matrices() -> tuple[np.ndarray, np.ndarray]:
    """Inertia (4, 4) and the twists (3, 4) of the freedoms a, b, pinion + wheel, propeller."""
    r = RATIO**2
    values = INERTIA["a"], INERTIA["b"], INERTIA["pinion"] + r * INERTIA["wheel"]
    ends = np.array([[1.0, -1, 0, 0], [0, 1, -1, 0], [0, 0, 1, -1]])
    return np.diag([*values, r * INERTIA["propeller"]]), ends


def springs() -> np.ndarray:
    return np.array([STIFFNESS["crank"], STIFFNESS["coupling"], RATIO**2 * STIFFNESS["shaft"]])


def engine_damping(speed: float) -> float:
    inertia, ends = matrices()
    square = np.linalg.eigvals(np.linalg.solve(inertia, ends.T @ (springs()[:, None] * ends)))
    return table(speed) * INERTIA["a"] * math.sqrt(np.sort(square.real)[2]) / 50.0


def wheel_damping(speed: float) -> float:
    return 300.0 * (abs(RATIO) * speed / 40.0) ** 1.5


def propeller_damping(speed: float) -> float:
    return 3.5 * float(np.interp(speed, TORQUE["speed"], TORQUE["torque"])) / (abs(RATIO) * speed)


def complex_springs(speed: float, w: float) -> np.ndarray:
    power = (speed / 100.0) ** 1.5
    slow = float(np.interp(abs(RATIO) * speed, [20.0, 40.0, 60.0], [2.0, 1.0, 0.7]))
    loss = np.array([table(speed) / 80.0, 2.0 * 0.02 * power, 0.0])
    dashpot = np.array([0.0, 30.0 * power, RATIO**2 * 200.0 * slow])
    return springs() * (1.0 + 1j * loss) + 1j * w * dashpot


def answer(speed: float, order: float, load: np.ndarray) -> tuple[np.ndarray, complex]:
    """Referred torques of the three shafts, and that of the gear on the pinion."""
    inertia, ends = matrices()
    w, r = order * speed, RATIO**2
    absolute = np.array([
        engine_damping(speed), engine_damping(speed), r * wheel_damping(speed),
        r * propeller_damping(speed),
    ])  # fmt: skip
    k = complex_springs(speed, w)
    whole = ends.T @ (k[:, None] * ends) + 1j * w * np.diag(absolute) - w**2 * inertia
    angle = np.linalg.solve(whole, load)
    torque = k * (ends @ angle)
    wheel = (1j * w * absolute[2] - w**2 * r * INERTIA["wheel"]) * angle[2]
    return torque, wheel + torque[2]


def half(order: np.ndarray, rows: np.ndarray) -> np.ndarray:
    turn = np.arange(1 << 15) * 4.0 * np.pi / (1 << 15)
    signal = (np.exp(1j * np.multiply.outer(turn, order)) @ rows).real
    return 0.5 * (signal.max(axis=0) - signal.min(axis=0))


def record(case: dict[str, Any]) -> Record:
    return run_case(validate(case))


def values(found: Record, path: str) -> np.ndarray:
    return np.asarray(found.quantities[ROOT + path].values)


def test_every_law_against_a_dense_solve() -> None:
    found = record(geared())
    setup = build_setup(validate(geared()))
    order = setup.drive.order
    curve, gear = values(found, "speeds/torque_half_range"), values(found, "speeds/gear_torque")
    for place, speed in enumerate(np.linspace(65.0, 140.0, 6).tolist()):
        load = np.zeros((len(order), 4), dtype=complex)
        load[:, :2] = setup.drive.torque(np.array([speed])).value[0]
        solved = [answer(speed, q, one) for q, one in zip(order, load, strict=True)]
        torque = np.array([one for one, _ in solved])
        ours = solved_line(setup.model, setup.drive, np.array([speed])).torque[0]
        np.testing.assert_allclose(ours, torque, rtol=1e-10, atol=1e-10 * np.abs(torque).max())
        # samples miss the top of a smooth curve by the square of their step
        whole = half(order, np.column_stack([torque, [one for _, one in solved]]))
        actual = whole / np.abs([1.0, 1.0, RATIO, 1.0])
        np.testing.assert_allclose([*curve[:, place], gear[0, place]], actual, rtol=2e-6)


def test_dampings_that_are_reported() -> None:
    found = record(geared())
    at = found.quantities[ROOT + "speeds/station_damping"]
    assert tuple(at.axes[0].values) == ("a", "b", "wheel", "propeller")
    for place, speed in enumerate(np.asarray(at.axes[1].values, dtype=float).tolist()):
        engine = engine_damping(speed)
        wanted = [engine, engine, wheel_damping(speed), propeller_damping(speed)]
        np.testing.assert_allclose(at.values[:, place], wanted, rtol=1e-12)
        k = complex_springs(speed, 1.0)
        np.testing.assert_allclose(
            values(found, "speeds/section_loss_factor")[:, place],
            [table(speed) / 80.0, 0.04 * (speed / 100.0) ** 1.5], rtol=1e-12,
        )  # fmt: skip
        np.testing.assert_allclose(
            values(found, "speeds/section_damping")[1, place], k.imag[2] / RATIO**2, rtol=1e-12
        )
    np.testing.assert_allclose(values(found, "damping/station")[4], propeller_damping(RATED))
    mean = values(found, "torque_mean")[2]
    assert abs(mean) == pytest.approx(2500.0, rel=1e-9)  # the load's own table


def test_archer() -> None:
    """30 T / n, n in rpm, is pi T / w; on its own shaft whatever the crank does."""
    assert archer_multiple(30.0) == pytest.approx(math.pi, rel=1e-15)
    law = propeller_law(archer_multiple(25.0), SpeedLaw(8e5, 10.0, 2.0), -0.25)
    for speed in (3.0, 10.0, 12.0):
        torque, own = 8e5 * (speed / 10.0) ** 2, 0.25 * speed / RPM
        assert float(law.at(speed)) == pytest.approx(25.0 * torque / own, rel=1e-14)


def test_slope_is_the_derivative_of_the_load() -> None:
    case = geared()
    case["machine"]["shaft_line"]["absorbed_torques"] = [{
        "on": "propeller", "torque": 2500.0, "exponent": 2.4,
        "propeller_damping": {"method": "slope"},
    }]  # fmt: skip
    shaft, step = build_shaft_line(validate(case)), 1e-4
    for speed in (70.0, 100.0, 135.0):
        above, below = (2500.0 * ((speed + s) / RATED) ** 2.4 for s in (step, -step))
        slope = (above - below) / (2.0 * step * abs(RATIO))
        assert shaft.station_damping(speed)[4] / RATIO**2 == pytest.approx(slope, rel=1e-8)


def with_ring() -> dict[str, Any]:
    case = geared()
    case["machine"]["shaft_line"]["dampers"] = [
        {"name": "ring", "on": "a", "kind": "viscous", "inertia": 1.2, "damping": 400.0}
    ]
    # a ring in oil alone is a rigid mode more
    case["machine"]["shaft_line"]["engine_damping"]["mode"] = 4
    return case


@pytest.mark.long
def test_the_line_without_its_damper_has_the_same_laws() -> None:
    found, bare = record(with_ring()), record(geared())
    for path in ("speeds/torque_half_range", "torque_half_range"):
        np.testing.assert_allclose(
            values(found, f"without_dampers/{path}"), values(bare, path), rtol=1e-9
        )  # fmt: skip


def test_critical_speeds_of_a_damped_ring_follow_the_dampings() -> None:
    case = with_ring()
    for shaft in case["machine"]["shaft_line"]["shafts"]:
        shaft.pop("magnifier", None)
        shaft.pop("lehr_ratio", None)
        if "damping" not in shaft:
            shaft.pop("over_speed", None)
    setup = build_setup(validate(case))
    met = critical(setup).value
    checked = 0
    for mode, place in np.argwhere(np.isfinite(met) & (met > 60.0) & (met < 150.0)).tolist():
        speed = float(met[mode, place])
        line = setup.model.at(speed)
        n = len(line.inertia)
        below = np.linalg.solve(
            np.diag(line.inertia), -np.hstack([stiffness_matrix(line), damping_matrix(line)])
        )
        first = np.hstack([np.zeros((n, n)), np.eye(n)])
        size = np.abs(np.linalg.eigvals(np.vstack([first, below])))
        frequency = setup.drive.order[place] * speed
        assert np.min(np.abs(size / frequency - 1.0)) < 1e-9
        checked += 1
    assert checked > 2


def test_all_inertias_damped_by_a_magnifier_give_their_mode_just_that() -> None:
    case = machine(
        stations=[{"name": "a", "inertia": 3.0, "cylinder": "1"},
                  {"name": "b", "inertia": 7.0, "cylinder": "2"}],
        shafts=[{"stiffness": 2e5}],
    )  # fmt: skip
    line = case["machine"]["shaft_line"]
    for key, value, ratio in (
        ("magnifier", 40, 1.0 / 80.0),
        ("damping_ratio", 0.03, 0.03),
        ("loss_factor", 0.1, 0.05),
    ):
        line["engine_damping"] = {key: value}
        found = values(record(case), "modes/damping_ratio")
        assert found[1] == pytest.approx(ratio, rel=1e-9)


def test_without_a_mode_the_lowest_elastic_one_counts() -> None:
    found = []
    for mode in (None, 3):  # with a ring in oil the second mode is a rigid one, too
        case = with_ring()
        case["machine"]["shaft_line"]["engine_damping"] = {"magnifier": 50} | (
            {"mode": mode} if mode else {}
        )
        found.append(build_shaft_line(validate(case)).line.absolute_damping)
    np.testing.assert_array_equal(*found)
    case["machine"]["shaft_line"]["engine_damping"]["mode"] = 2
    with pytest.raises(NumericalFailure, match="mode 2 of the shaft line does not vibrate"):
        build_shaft_line(validate(case))


def test_a_damping_that_fades_leaves_no_resonance_out() -> None:
    """At low speed it is so small that the resonance stands between the points of the sweep."""
    case = machine(
        stations=[{"name": "a", "inertia": 3.0, "cylinder": "1"},
                  {"name": "b", "inertia": 7.0, "cylinder": "2", "absolute_damping": 40.0,
                   "over_speed": {"exponent": 4, "reference": 400.0}}],
        shafts=[{"stiffness": 6e4}],
    )  # fmt: skip
    case["machine"]["speed"] = 400.0
    case["response"]["torsion"] |= {
        "speeds": {"from": 20.0, "to": 420.0, "points": 41}, "orders": {"step": 1, "count": 6},
    }  # fmt: skip
    found = record(case)
    top, at = values(found, "largest/torque_half_range")[0], values(found, "largest/speed")[0]
    natural = math.sqrt(6e4 * (1 / 3.0 + 1 / 7.0))
    order = float(values(found, "largest/order")[0])
    assert at == pytest.approx(natural / order, rel=1e-4)
    case["response"]["torsion"]["speeds"] = {"from": 0.999 * at, "to": 1.001 * at, "points": 401}
    fine = values(record(case), "speeds/torque_half_range")[0].max()
    assert top == pytest.approx(fine, rel=1e-3) and top >= fine * (1.0 - 1e-9)


def test_a_variable_inertia_has_the_dampings_of_each_speed() -> None:
    setup = build_setup(validate(geared()))
    for speed in (70.0, 130.0):
        line = system_of(setup, speed).line
        assert line.absolute_damping[3] == pytest.approx(RATIO**2 * propeller_damping(speed))
        assert line.absolute_damping[0] == pytest.approx(engine_damping(speed))


def test_on_mounts_the_line_has_the_dampings_of_each_speed() -> None:
    """Leading axes of the speed are those of what follows it."""
    shaft = build_shaft_line(validate(geared()))
    speeds = np.array([70.0, 100.0, 130.0])
    spin, order = Bounded(np.ones(4), np.zeros(4)), np.array([0.5, 1.0, 2.5])
    whole = line_transfer(shaft.at(speeds[:, None]), spin, order * speeds[:, None])
    for place, speed in enumerate(speeds.tolist()):
        one = line_transfer(shaft.at(speed), spin, order * speed)
        np.testing.assert_allclose(whole.value[place], one.value, rtol=1e-12)


def test_a_speed_that_is_one_of_the_sweep_but_for_rounding_is_not_added() -> None:
    """As the corner of a class rule at 0.9 of the rated speed may be."""
    setup = build_setup(validate(geared()))
    speed = np.array([70.0, 94.5, 110.0])
    beside = np.nextafter(94.5, 0.0)
    corners = np.array([beside, 80.0, np.nextafter(80.0, 90.0), 94.6])
    found = with_narrow(setup, speed, corners).imag
    assert np.isin([*speed, 80.0, 94.6], found).all()
    assert not np.isin(corners[[0, 2]], found).any()
