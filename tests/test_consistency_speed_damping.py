"""Dampings and loads that follow the speed: closed forms, dense solves, numbers instead of laws."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from dense_line import DenseLine, cylinder_of, half_range

from vibecalc.core.case.load import resolve, validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.torque_reaction import line_transfer
from vibecalc.torsion.adapters.critical import critical
from vibecalc.torsion.adapters.search import with_narrow
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.adapters.variable_inertia import system_of
from vibecalc.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.torsion.model import build_shaft_line

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


def record(case: dict[str, Any]) -> Record:
    return run_case(validate(case))


def values(found: Record, path: str) -> np.ndarray:
    return np.asarray(found.quantities[ROOT + path].values)


@cache
def laws() -> tuple[Record, DenseLine]:
    """A run with every law, and its full matrices under the torque of its cylinders."""
    case = validate(geared())
    found, tables = run_case(case), resolve(case)
    cylinder = cylinder_of(found, tables)
    return found, DenseLine(tables, lambda speed: cylinder)


def test_every_law_against_a_dense_solve() -> None:
    found, line = laws()
    order = cylinder_of(found, geared()).order
    curve, gear = values(found, "speeds/torque_half_range"), values(found, "speeds/gear_torque")
    for place, speed in enumerate(np.linspace(65.0, 140.0, 6).tolist()):
        now = line.at(speed)
        np.testing.assert_allclose(curve[:, place], half_range(order, now.torque), rtol=1e-9)
        np.testing.assert_allclose(gear[:, place], half_range(order, now.gear), rtol=1e-9)


def test_dampings_that_are_reported() -> None:
    found, line = laws()
    at = found.quantities[ROOT + "speeds/station_damping"]
    assert tuple(at.axes[0].values) == ("a", "b", "wheel", "propeller")
    for place, speed in enumerate(np.asarray(at.axes[1].values, dtype=float).tolist()):
        np.testing.assert_allclose(
            at.values[:, place], line.absolute(speed)[[0, 1, 3, 4]], rtol=1e-12
        )
        springs, dashpots = line.section_laws(speed, np.ones(1), np.zeros(3))
        loss = springs[:, 0].imag / springs[:, 0].real
        for path, wanted in (("section_loss_factor", loss[:2]), ("section_damping", dashpots[1:])):
            seen = values(found, f"speeds/{path}")[:, place]
            np.testing.assert_allclose(seen, wanted, rtol=1e-12)
    np.testing.assert_allclose(values(found, "damping/station"), line.absolute(RATED), rtol=1e-12)
    mean = values(found, "torque_mean")[2]
    assert abs(mean) == pytest.approx(2500.0, rel=1e-9)  # the load's own table


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
        engine, *_, propeller = laws()[1].absolute(speed)
        assert line.absolute_damping[3] == pytest.approx(RATIO**2 * propeller)
        assert line.absolute_damping[0] == pytest.approx(engine)


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
