"""Claim: a line is set against limits section by section, and the largest of a reading over the
speeds hangs on no grid, nor does any limit on it.

The truth: the rule by hand, the curves themselves, the same line at many more speeds.
"""

import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, ROOT, record, refusal, replaced, value
from shipped_cases import CASES

from vibecalc import run
from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Result
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.torsion.results import FOLLOWED

SPEED = 1500.0 * np.pi / 30.0
POINTS = "speeds = { from = '800 rpm', to = '2000 rpm', points = 31 }"
ENGINE = replaced(ENGINE, ('speeds = { from = "800 rpm", to = "2000 rpm" }', POINTS))
RULE = 'limits = [{ rule = "iacs_m68", tensile_strength = "700 MPa", design_factor = 0.6 }]\n'


def by_hand(speed: float) -> float:
    """tau_C in Pa of 700 N/mm2, of which 600 count, 70 mm and c_K = 0.6."""
    ratio = speed / SPEED
    course = 3.0 - 2.0 * ratio**2 if ratio < 0.9 else 1.38
    return (600.0 + 160.0) / 18.0 * 0.6 * (0.35 + 0.93 * 70.0**-0.2) * course * 1e6


def test_a_rule_is_reported_with_all_that_it_is_made_of() -> None:
    text = ENGINE + RULE
    basis = {
        "diameter": 0.07,
        "tensile_strength": 700e6,
        "counted_strength": 600e6,
        "size_factor": 0.35 + 0.93 * 70.0**-0.2,
        "design_factor": 0.6,
    }
    for name, expected in basis.items():
        assert value(text, f"limit/basis/{name}")[0] == pytest.approx([expected], rel=1e-14)
    assert value(text, "limit/basis/rated_speed")[0] == pytest.approx(SPEED)
    use, at, stress, allowed, transient, through = (
        float(value(text, f"limit/each/{name}")[0, 0])
        for name in (
            "utilisation",
            "speed",
            "stress",
            "allowed",
            "transient",
            "passage_utilisation",
        )
    )
    assert allowed == pytest.approx(by_hand(at), rel=1e-9)
    assert transient == pytest.approx(1.7 * allowed / np.sqrt(0.6), rel=1e-12)
    assert stress == pytest.approx(use * allowed, rel=1e-12)
    assert through == pytest.approx(stress / transient, rel=1e-12)
    curve = record(text)[f"{ROOT}/speeds/stress_half_range"]
    speeds = np.asarray(curve.axes[1].values)
    inside = speeds <= 1.05 * SPEED
    uses = curve.values[0, inside] / [by_hand(one) for one in speeds[inside]]
    assert uses.max() <= use * (1 + 1e-12) and use < 1.2 * uses.max()
    assert at <= 1.05 * SPEED and float(value(text, "limit/largest_utilisation")[0]) == use
    here = [
        float(value(text, f"limit/operating/{n}")[0, 0])
        for n in ("stress", "allowed", "utilisation")
    ]
    assert here[0] == pytest.approx(value(text, "stress_half_range")[0], rel=1e-12)
    assert here[1] == pytest.approx(by_hand(SPEED), rel=1e-12)
    assert here[2] == pytest.approx(here[0] / here[1], rel=1e-12)


def test_a_rule_bars_about_the_peak_and_never_near_the_rated_speed() -> None:
    # so weak a steel that speeds on both sides of 0.8 of the rated one are above the limit
    weak = (
        ENGINE + 'limits = [{ rule = "iacs_m68", tensile_strength = "1 MPa", design_factor = %s }]'
    )
    use = float(value(weak % "1.0", "limit/largest_utilisation")[0])
    text = weak % f"{min(1.0, use / 1.05)!r}"
    start, end, peak, low, high, permitted = (
        value(text, f"exceeded/{n}")
        for n in ("from", "to", "peak_speed", "formula_from", "formula_to", "permitted")
    )
    assert len(start) and np.all((start <= peak) & (peak <= end))
    ratio = peak / SPEED
    assert low == pytest.approx(16.0 * peak / (18.0 - ratio), rel=1e-12)
    assert high == pytest.approx((18.0 - ratio) * peak / 16.0, rel=1e-12)
    assert permitted.tolist() == [int(one <= 0.8 * SPEED) for one in end]
    barred = [value(text, f"barred/{n}") for n in ("from", "to")]
    assert len(barred[0]) <= len(start) and np.all(barred[0][1:] > barred[1][:-1])
    for one in zip(np.minimum(start, low), np.maximum(end, high), strict=True):
        holds = (barred[0] <= one[0]) & (one[1] <= barred[1])
        assert np.count_nonzero(holds) == 1
    assert set(barred[0]) <= {*start, *low} and set(barred[1]) <= {*end, *high}
    best = int(np.argmin(np.abs(peak - value(text, "limit/speed")[0])))
    assert peak[best] == pytest.approx(value(text, "limit/speed")[0], rel=1e-9)


def test_a_rule_bars_nothing_beyond_its_scope_though_nothing_damps_the_line() -> None:
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    text = replaced(
        ENGINE.replace(ring, "") + RULE,
        (', damping = "5 N*m*s/rad"', ""),
        ("'2000 rpm'", "'6000 rpm'"),
        ("1500 rpm", "4900 rpm"),
    )
    rated, endless = (
        value(text, "limit/basis/rated_speed")[0],
        value(text, "resonances_skipped/from"),
    )
    assert endless.max() > 1.05 * rated > endless.min()
    assert value(text, "exceeded/to").max() <= 1.05 * rated
    assert np.isinf(value(text, "limit/largest_utilisation")).all()


def test_what_a_rule_is_not_for_is_said(tmp_path: Path) -> None:

    def warnings(text: str) -> str:
        return " ".join(machine_warnings(validate(tomllib.loads(text))))

    thick = GEARED.replace(
        'N*m/rad" },', 'N*m/rad", diameter = "90 mm", tensile_strength = "6e8 Pa" },'
    )
    said = warnings(thick + 'limits = [{ rule = "iacs_m68" }]')
    for words in (
        "'a - b' (crankshaft)",
        "'b - pinion' (before a gear)",
        "'take-off - generator' (not between the engine and 'propeller')",
    ):
        assert words in said
    assert "'wheel - propeller' (" not in said
    proper = thick + 'limits = [{ rule = "iacs_m68", sections = ["wheel - propeller"] }]'
    assert "M68" not in warnings(proper)
    assert "no cylinder fires" in warnings(ENGINE + 'misfire = ["1", "2", "3"]')
    assert "no cylinder fires" not in warnings(ENGINE + 'misfire = ["1", "2"]')
    many = refusal(tmp_path, ENGINE + "as_published = { modes = 300 }")
    assert "more modes are requested than the line has" in many and "up to 3" in many
    assert not refusal(tmp_path, ENGINE + "as_published = { modes = 3 }")


@pytest.mark.long
def test_a_corner_of_a_limit_between_speeds_is_a_largest_use() -> None:
    curve = 'speed = ["800 rpm", "1301 rpm", "2000 rpm"], stress = ["99 MPa", "1 Pa", "99 MPa"]'
    text = ENGINE + f"limits = [{{ curve = {{ {curve} }} }}]"
    assert value(text, "limit/speed")[0] == pytest.approx(1301.0 * np.pi / 30.0, rel=1e-12)


# ----------------------------------------------------------------------------
# Largest values over the speeds.
# ----------------------------------------------------------------------------


@cache
def found(case: str, points: int) -> Result:
    return run(
        CASES[case],
        set={"response.torsion.speeds.points": points},
        unset=("reference", "reference_table", "limit"),
    )


@pytest.mark.parametrize(
    "case", ["engine_damped", pytest.param("engine_geared", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("name", FOLLOWED)
def test_extremes_are_those_of_a_fine_grid(case: str, name: str) -> None:
    """Fourteen points find what two thousand come near from below."""
    coarse, fine = found(case, 14).record, found(case, 2001).record
    path = f"{ROOT}/largest/{name}"
    if path not in coarse:
        pytest.skip("no such parts on this line")
    sense = -1.0 if "minimum" in name else 1.0
    value, at = coarse[path].values, coarse[f"{path}_speed"].values
    assert value == pytest.approx(fine[path].values, rel=1e-9)
    samples = sense * fine[f"{ROOT}/speeds/{name}"].values
    most = samples.max(axis=1)
    assert np.all(sense * value >= most - 1e-12 * np.abs(most))
    assert sense * value == pytest.approx(most, rel=2e-2)
    speeds = fine[f"{ROOT}/speeds/{name}"].axes[1].values
    high = samples >= (most - 1e-3 * np.abs(most))[:, None]
    nearest = [np.min(np.abs(speeds[row] - one)) for row, one in zip(high, at, strict=True)]
    assert max(nearest) <= 2.0 * np.max(np.diff(speeds))


def test_a_limit_on_a_curve_hangs_on_no_grid() -> None:
    limit = [{"quantity": f"{ROOT}/speeds/heat", "max": 1e-3}]
    rows = [
        run(
            CASES["engine_damped"],
            set={"response.torsion.speeds.points": points, "limit": limit},
            unset=("reference", "reference_table"),
        ).verdicts
        for points in (7, 101)
    ]
    (coarse, *_), (fine, *_) = (one or () for one in rows)
    assert coarse.computed == pytest.approx(fine.computed, rel=1e-9)
    assert coarse.state == fine.state == "broken"
    assert coarse.label.startswith("damper=ring, speed=")


def test_an_undamped_critical_is_skipped_with_a_station_without_inertia() -> None:
    stations = [("a", 2.0), ("m", 0.0), ("b", 3.0)]
    drive = {"on": "a", "orders": [1, 2], "torques": [100.0, 50.0]}
    line = {
        "stations": [{"name": name, "inertia": inertia} for name, inertia in stations],
        "shafts": [{"stiffness": 1e5}, {"stiffness": 2e5}],
        "excitations": [drive],
    }
    result = run({
        "schema": 1,
        "title": "light station",
        "machine": {"kind": "drive_train", "speed": 20.0, "shaft_line": line},
        "response": {"torsion": {"speeds": {"from": 50.0, "to": 300.0, "points": 31}}},
    }).record  # fmt: skip
    critical = np.sqrt(1.0 / (1.0 / 1e5 + 1.0 / 2e5) * (1.0 / 2.0 + 1.0 / 3.0))
    start, end = (result[f"{ROOT}/resonances_skipped/{name}"].values for name in ("from", "to"))
    assert np.all((start < [critical / 2.0, critical]) & (end > [critical / 2.0, critical]))
    assert np.all(np.isinf(result[f"{ROOT}/largest/torque_half_range"].values))
