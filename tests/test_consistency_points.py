"""Claim: severity, zones and words of vibration at points follow from its amplitudes.

That of bodies `test_consistency_random_machines.py` holds against the equations of motion.
"""

import copy
from functools import cache
from typing import Any

import numpy as np
import pytest
import tomli_w
from engine_mounted import SEPARATE, loaded_of, mounted
from scipy.optimize import minimize_scalar
from shipped_cases import table_of

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import parse_key, set_key
from vibecalc.core.report.headline import headline_rows
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute
from vibecalc.foundation.model import foundation_cautions
from vibecalc.points.model import points_cautions
from vibecalc.points.report import points
from vibecalc.points.severity import grade, grade_number, zones
from vibecalc.points.tables import GRADES

QUANTITIES = ("displacement", "velocity", "acceleration")
STIFFNESS, LOSS = np.array([2e5, 3e5, 5e5]), 0.08
POINTS = [
    {"name": "bearing", "position": [0.3, 0.05, -0.1]},
    {"name": "turned", "position": [0.3, 0.05, -0.1],
     "axes": [[0.0, 3.0, 4.0], [0.0, -4.0, 3.0], [2.0, 0.0, 0.0]]},
    {"name": "cover", "position": [-0.2, 0.1, 0.4], "direction": [1.0, -2.0, 2.0]},
]  # fmt: skip
#: Hz; orders 2, 3 and 4 of 1800 rpm are in it
BAND = (45.0, 125.0)


def changed(**changes: Any) -> dict[str, Any]:
    """The shipped generator on four unlike mounts, with points."""
    case = copy.deepcopy(table_of("generator"))
    case = {key: case[key] for key in ("schema", "title", "machine")}
    case["machine"] |= {"speed": "1800 rpm"}
    case["machine"]["crank_train"]["rotating_mass"] = 0.2
    case["machine"]["mounts"]["each"] = {"stiffness": STIFFNESS.tolist(), "loss_factor": LOSS}
    case["isolation"] = {"model": "rigid_body"}
    case["excitation"] = {"orders": 8}
    case["point"] = POINTS
    case["vibration_severity"] = {"band": [f"{one} Hz" for one in BAND]}
    for key, value in changes.items():
        set_key(case, parse_key(key.replace("__", ".")), value)
    return case


@cache
def steady() -> Record:
    return run_case(validate(changed()))


def readings(record: Record, name: str) -> dict[str, np.ndarray]:
    found = record[f"points/{name}"]
    return dict(zip(found.axes[0].values, found.values, strict=True))


# ----------------------------------------------------------------------------
# At the operating speed: matrices, a closed form, the signal in time.
# ----------------------------------------------------------------------------


def test_response_and_pitch_move_the_points_too() -> None:
    response = run_case(validate(changed(isolation=None, response={"method": "modal"})))
    for name in QUANTITIES:
        same = steady()[f"points/{name}"].values
        away = np.abs(response[f"points/{name}"].values - same)
        assert away.max() <= 1e-10 * np.abs(same).max()
    point = {"name": "mount", "position": [-0.4, -0.2, 0.0], "direction": [0, 0, 1]}
    case = changed(isolation={"model": "pitch", "run_up": {"from": 20.0, "to": 200.0}})
    pitch = run_case(validate({**case, "point": [point]}))
    mount = pitch["isolation/support_displacement/steady_harmonics"].values[0, 0]
    found = readings(pitch, "displacement")["mount"]
    assert found == pytest.approx(mount, rel=1e-10, abs=1e-12 * np.abs(mount).max())
    assert np.all(pitch["points/run_up/displacement_peak_largest"].values > np.abs(mount).max())


# ----------------------------------------------------------------------------
# With the torque of the cylinders, and over the run-up.
# ----------------------------------------------------------------------------


def text_of_engine() -> str:
    """An engine whose torque reaches its mounts, at half orders."""
    text = SEPARATE.replace('"1500 rpm"', "157.0").replace(
        'driven_machine = "separate"\n', 'driven_machine = "separate"\norders = 4\n'
    )
    text += """[[point]]
name = "governor"
position = [0.4, 0.2, 0.1]
[[point]]
name = "base"
position = [0.5, 0.25, -0.2]
direction = [0, 0, 1]
[vibration_severity]
band = ["15 Hz", "58 Hz"]
"""
    return text


def test_the_largest_rms_of_one_mass_is_that_of_its_formula() -> None:
    case = changed(
        point=[{"name": "middle", "position": [0.0, 0.0, 0.0], "direction": [0, 0, 1]}],
        isolation={"model": "rigid_body", "run_up": {"from": 60.0, "to": 90.0}},
        vibration_severity={"band": ["15 Hz", "125 Hz"]},
    )
    # order 2 of one cylinder meets 141.4 rad/s at half of that, below the speed of order 1 at 15 Hz
    case["machine"]["crank_train"]["cylinders"] = [{"name": "1"}]
    record = run_case(validate(case))
    mass = validate(case).machine.body.mass
    force = record["excitation/force"].values[:, 2] / (60.0 * np.pi) ** 2
    order = np.arange(1, 9)

    def rms(speed: float) -> float:
        w = order * speed
        moved = speed**2 * force / (4.0 * STIFFNESS[2] * (1.0 + 1j * LOSS) - mass * w**2)
        hertz = w / 2.0 / np.pi
        counts = (hertz >= 15.0) & (hertz <= 125.0)
        return float(np.sqrt(np.sum(np.abs(w * moved)[counts] ** 2) / 2.0))

    path = "points/run_up/velocity_rms"
    top, where = (float(record[f"{path}_largest{end}"].values[0]) for end in ("", "_speed"))
    speeds = np.linspace(60.0, 90.0, 3001)
    heights = np.array([rms(one) for one in speeds])
    assert top >= heights.max() and 69.0 < where < 72.0
    best = float(speeds[np.argmax(heights)])
    near = minimize_scalar(lambda at: -rms(at), bounds=(best - 0.01, best + 0.01), method="bounded",
                           options={"xatol": 1e-12})  # fmt: skip
    assert top == pytest.approx(-near.fun, rel=1e-9)
    assert where == pytest.approx(near.x, rel=1e-6)


def test_an_undamped_resonance_has_no_bound_where_its_order_counts() -> None:
    case = changed(
        isolation={"model": "rigid_body", "run_up": {"from": 50.0, "to": 60.0}},
        machine__mounts__each={"stiffness": STIFFNESS.tolist()},
        point=POINTS[-1:],
    )
    # the orders in resonance there are below 37 Hz
    for low, bounded in (("20 Hz", False), ("45 Hz", True)):
        case["vibration_severity"] = {"band": [low, "125 Hz"]}
        record = run_case(validate(case))
        tops = [
            float(record[f"points/run_up/{name}_largest"].values[0])
            for name in ("velocity_rms", "severity", "velocity_peak")
        ]
        assert [bool(np.isfinite(one)) for one in tops] == [bounded, bounded, False]
        masked = (
            record["isolation/resonances_skipped/centre"].values
            * record["isolation/resonances_skipped/order"].values
        )
        assert np.all(masked < 2.0 * np.pi * 37.0)


# ----------------------------------------------------------------------------
# Severity.
# ----------------------------------------------------------------------------


def test_grades_are_those_printed_and_zones_count_boundaries() -> None:
    first = grade(0)
    assert f"{1e6 * first['displacement']:.1f} {first['acceleration']:.2f}" == "17.8 1.76"
    for number, name in enumerate(GRADES):
        velocity = grade(number)["velocity"]
        assert 1e3 * velocity == pytest.approx(name, rel=0.03)
        assert grade_number(velocity) == number
        assert grade_number(velocity * 1.001) == number + 1
    assert zones(np.array([1.0, 2.0, 2.1, 9.0]), np.array([2.0, 4.0, 8.0])).tolist() == [0, 0, 1, 3]


def test_the_worst_of_three_quantities_says_the_zone() -> None:
    record = run_case(validate(changed(vibration_severity={"grades": [1.1, 7.1, 71.0]})))
    boundaries = {name: record[f"points/zone_boundary/{name}"].values for name in QUANTITIES}
    assert boundaries["velocity"] == pytest.approx([1.12e-3, 7.0667e-3, 0.070667], rel=1e-4)
    values = {name: record[f"points/{name}_rms"].values for name in QUANTITIES}
    severity = record["points/severity"].values
    for i, zone in enumerate(record["points/zone"].values):
        beyond = [int((values[name][i] > boundaries[name]).sum()) for name in QUANTITIES]
        assert zone == max(beyond)
        rates = values["displacement"][i] * 20.0 * np.pi, values["acceleration"][i] / 500.0 / np.pi
        assert severity[i] == pytest.approx(max(values["velocity"][i], *rates), rel=1e-12)
        assert zone == int((severity[i] > boundaries["velocity"]).sum())


def test_the_report_says_the_zone_and_what_is_outside_the_band() -> None:
    text = text_of_engine() + 'velocity = ["5 mm/s", "10 mm/s"]\nstandard = "our own"\n'
    result = execute(loaded_of(text))
    section = points(result)
    assert section is not None
    words = " ".join(" ".join(section.lines).split())
    # 12.5 Hz to 100 Hz at 1500 rpm
    assert "r.m.s. of orders from 15 to 58 Hz" in words
    assert "Orders 0.5, 2.5, 3, 3.5, 4 outside the band" in words
    assert "Zones by our own (informative)" in words and "velocity 5.000, 10.00 mm/s" in words
    (row,) = (row for row in headline_rows(result.record) if row.path == "points/velocity_rms")
    rms = result.record["points/velocity_rms"].values
    zone = ("A/B", "C", "D")[int((rms.max() > np.array([5e-3, 10e-3])).sum())]
    assert row.value == pytest.approx(1e3 * rms.max()) and row.where.endswith(f"zone {zone}")


def test_points_that_the_torque_of_the_gas_does_not_reach_are_said() -> None:
    text = text_of_engine()
    assert points_cautions(mounted(text)) == []
    (said,) = points_cautions(mounted(text.replace('"rigid_body"', '"pitch"\nlever = 0.5')))
    assert "without the torque of the gas" in said


# ----------------------------------------------------------------------------
# On what moves: a foundation, a base.
# ----------------------------------------------------------------------------


def on_foundation(stiffness: float, **changes: Any) -> dict[str, Any]:
    """The generator on a block of 50 kg on four springs."""
    springs = {"each": {"stiffness": stiffness, "loss_factor": 0.1},
               "positions": [[x, y, 0.0] for x in (-0.3, 0.3) for y in (-0.2, 0.2)]}  # fmt: skip
    body = {"mass": 50.0, "box": {"length": 0.8, "width": 0.6, "height": 0.05}}
    place = [0.0, 0.0, -0.2]
    foundation = {"kind": "body", "position": place, "body": body, "springs": springs}
    return changed(foundation=foundation, **changes)


def test_what_the_points_do_not_follow_is_said() -> None:
    assert points_cautions(validate(on_foundation(4e5))) == []
    up = {"from": "1000 rpm", "to": "1900 rpm"}
    assert foundation_cautions(validate(on_foundation(4e5, isolation__run_up=up))) == []
    mass = changed(foundation={"mass": 90.0, "stiffness": 1e6}, isolation__run_up=up)
    assert foundation_cautions(validate(mass)) == points_cautions(validate(mass)) == []
    mass["isolation"] |= {"model": "pitch", "lever": 0.5}
    (said,) = foundation_cautions(validate(mass))
    assert "model = 'pitch' is computed on rigid ground" in said
    (said,) = points_cautions(validate(mass))
    assert "on a rigid foundation: a [foundation] of one mass" in said
    rows = {"frequency": [1.0], "real": [1e7], "imaginary": [0.0]}
    tables = [{"direction": "z", "dynamic_stiffness": rows}]
    feet = changed(foundation={"flexibilities": tables}, isolation__run_up=up)
    feet["foundation"] |= {"kind": "impedance"}
    (said,) = foundation_cautions(validate(feet))
    assert "the run-up is that of the machine on a rigid foundation" in said
    blades = {"name": "blades", "frequency": 80.0, "velocity": [0.0, 0.0, 1e-3]}
    (said,) = points_cautions(validate(changed(base_motion={"harmonics": [blades]})))
    assert "is in base_motion/" in said


def test_a_band_without_orders_has_no_severity() -> None:
    """Orders of 1800 rpm are 30 Hz apart: none lies between 35 and 55 Hz."""
    severity = {"band": ["35 Hz", "55 Hz"], "velocity": ["5 mm/s", "10 mm/s"]}
    table = changed(vibration_severity=severity)
    result = execute(loaded_of(tomli_w.dumps(table)))
    record = result.record
    assert np.all(record["points/velocity_rms"].values == 0.0)
    assert np.all(record["points/velocity_peak"].values[:3] > 0.0)
    (said,) = (one for one in record.warnings if "band of the r.m.s. values" in one)
    assert "no order of the speed lies between 35 and 55 Hz" in said
    assert "points/zone" not in record and "points/severity" not in record
    section = points(result)
    assert section is not None and "Severity" not in " ".join(section.lines)
    (row,) = (row for row in headline_rows(record) if row.path == "points/velocity_rms")
    assert "zone" not in row.where
