"""Claim: a limit is judged once, and all that speak of it say the same.

In conditions of the cylinders a limit is what it is in a case that is in that condition alone.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from dense_curve_line import text, values
from engine_cases import ran
from long_but import long_but
from report_samples import golden
from shipped_cases import ROOT, result_of

from vibecalc.core.report.calculation import limit_table
from vibecalc.core.report.headline import first_table
from vibecalc.core.report.pages import conclusion
from vibecalc.core.report.text import as_json, render_report, render_verdicts
from vibecalc.core.report.verdicts import counted_misses, judge_references
from vibecalc.core.results.compare import compare
from vibecalc.core.results.compare_rules import Rule, Rules
from vibecalc.core.results.record import BARRED, BROKEN, KEPT, UNDECIDED, Result
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.results.verdicts import held, judge, judged, verdicts_of
from vibecalc.core.study.execute import execute, load_checked

GOLDEN = ROOT / "tests" / "golden"
NAMES = [path.stem for path in sorted(GOLDEN.glob("*.h5"))]
LIMITS = """
[[response.torsion.limits]]
alternating_share = 0.5
gears = ["pinion - wheel"]
[[response.torsion.limits]]
torque = { speed = ["500 rpm", "1300 rpm"], torque = ["900 N*m", "900 N*m"] }
sections = ["rubber"]
"""
COUPLING = (
    'coupling = { stiffness = "24 kN*m/rad", relative_damping = 1.068, nominal_torque = "2 kN*m", '
    'maximum_torque = "4 kN*m", vibratory_torque = "300 N*m", power_loss = "80 W" } }'
)


@cache
def line(asked: str) -> Result:
    """The geared line of the dense solves with an elastic coupling in place of the rubber."""
    plain = "stiffness = 2.4e4, loss_factor = 0.17 }"
    case = text(asked + LIMITS)
    assert plain in case
    return ran(case.replace(plain, COUPLING))


def without_limits(name: str) -> Result:
    """A result whose case has no `[[limit]]`, its limits not judged yet."""
    result = result_of(name)
    return replace(result, case={**result.case, "limit": ()}, verdicts=None)


# ----------------------------------------------------------------------------
# Everybody says the same.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", long_but(NAMES, *NAMES[::7], "genset_coupling", "genset_skid"))
def test_text_verify_and_json_count_the_same_limits(name: str) -> None:
    result = result_of(name)
    rows = verdicts_of(result)
    said = conclusion([], rows).split(";")[0].split(",")[0].rstrip(".")
    kept = sum(row.state == KEPT for row in rows)
    assert said.startswith(f"{kept} of {len(rows)} limit" if rows else "")
    for words in (render_report(result), render_verdicts(result)):
        assert said in " ".join(words.split())
    told = as_json(result)["limits"]
    assert [row["verdict"] for row in told] == [row.state for row in rows]
    assert [row["satisfied"] for row in told] == [row.satisfied for row in rows]
    missed = sum(row.within is False for row in judge_references(result))
    assert counted_misses(result) == missed + sum(not row.satisfied for row in rows)


def test_a_barred_limit_is_called_so_everywhere_and_kept_nowhere() -> None:
    result = golden("marine_propulsion")
    rows = {state: [row for row in verdicts_of(result) if row.state == state]
            for state in (KEPT, BARRED, BROKEN)}  # fmt: skip
    words = as_json(result)
    for state, told in rows.items():
        shown = [row for row in words["limits"] if row["verdict"] == state]
        assert told and [row["kept"] for row in shown] == len(told) * [state == KEPT]
        assert state == BROKEN or all(row["satisfied"] for row in shown)
    table = limit_table(rows[BARRED])[0].splitlines()
    assert sum(line.endswith("  barred") for line in table) == len(rows[BARRED])
    assert "max 100 barred\n" in render_report(result)


def test_what_is_broken_in_a_condition_is_broken_for_verify() -> None:
    result = without_limits("marine_propulsion")
    rows = [row for row in verdicts_of(result) if row.state == BROKEN]
    assert {row.condition for row in rows} == {"misfire of cylinder 5 (worst of 7 conditions)"}
    assert counted_misses(result) == len(rows) == 4
    assert "4 of 10 limits are kept; 2 are exceeded in barred" in render_verdicts(result)


def test_a_limit_of_the_case_says_what_is_expected_of_the_others_on_that_result() -> None:
    result = result_of("genset_coupling")
    rows = [row for row in verdicts_of(replace(result, verdicts=None)) if row.state == BROKEN]
    assert len(rows) == 2 and all(row.satisfied for row in rows)
    alone = [row for row in verdicts_of(without_limits("genset_coupling")) if row.state == BROKEN]
    assert len(alone) == 1 and not alone[0].satisfied


# ----------------------------------------------------------------------------
# Each entry with an error of its own.
# ----------------------------------------------------------------------------

FORCE = "isolation/support_force/steady_peak"


@pytest.mark.parametrize(
    ("bounds", "state", "label", "off"),
    [
        ({"max": 5.0}, KEPT, "2", 1e-3),
        ({"max": 4.15}, UNDECIDED, "1", 0.2),
        ({"max": 3.99}, BROKEN, "2", 1e-3),
        ({"max": 4.15, "where": {"mount": "2"}}, KEPT, "2", 1e-3),
        ({"max": 4.15, "where": {"mount": "1"}}, UNDECIDED, "1", 0.2),
        ({"min": 0.5}, KEPT, "3", 0.0),
        ({"min": 1.5}, BROKEN, "3", 0.0),
    ],
)
def test_a_limit_counts_the_error_of_each_entry(
    bounds: dict[str, object], state: str, label: str, off: float
) -> None:
    result = result_of("generator")
    quantity = replace(
        result[FORCE],
        values=np.array([3.99, 4.0, 1.0, 2.0]),
        error_estimate=0.2,
        errors=np.array([0.2, 1e-3, 0.0, 0.0]),
    )
    record = replace(result.record, quantities={FORCE: quantity})
    row = {"quantity": FORCE, "source": "none", **bounds}
    (verdict,) = judged(replace(result, record=record, case={"limit": [row]}))
    assert (verdict.state, verdict.error_estimate) == (state, off)
    assert verdict.label == f"mount={label}"


def test_errors_of_entries_are_kept_in_the_file(tmp_path: Path) -> None:
    result = execute(load_checked([ROOT / "cases" / "generator.toml"])[0])
    own = {path: one.errors for path, one in result.items() if one.errors is not None}
    assert len(own) > 10
    again = read_result(write_result(result, tmp_path / "one.h5"))
    for path, errors in own.items():
        assert np.array_equal(again[path].errors, errors)
        assert np.max(errors) == again[path].error_estimate
        assert again[path].errors.shape == again[path].values.shape


# ----------------------------------------------------------------------------
# In conditions.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("row", long_but(range(3), 2))
def test_a_condition_uses_gears_and_couplings_as_a_case_with_that_misfire(row: int) -> None:
    found = line('conditions = { misfire = "each" }')
    alone = line(f'misfire = ["{row}"]' if row else "")
    for name in ("largest_utilisation", "operating_utilisation"):
        use = values(found, f"conditions/limit/{name}")[row]
        assert use == pytest.approx(values(alone, f"limit/{name}"), rel=1e-8)
        assert use[0] > 0.0
    of = values(found, "conditions/exceeded/condition")
    assert set(of) <= {1.0, 2.0, 3.0, 4.0} and np.any(of == row + 1)
    for variant, there in (("", row + 1), *([("healthy/", 1)] if row else [])):
        for name in ("from", "to", "limit", "permitted", "peak_speed"):
            own = values(found, f"conditions/exceeded/{name}")[of == there]
            assert own == pytest.approx(values(alone, f"{variant}exceeded/{name}"), rel=1e-6), name
    for name in ("utilisation", "largest_utilisation", "largest_utilisation_speed"):
        use = values(found, f"conditions/coupling/{name}")[row]
        # a use that no speed changes much is met where rounding says
        assert use == pytest.approx(values(alone, f"coupling/{name}"), rel=1e-5)


def test_the_worst_condition_is_the_row_of_a_coupling() -> None:
    result = line('conditions = { misfire = "each" }')
    uses = values(result, "conditions/coupling/largest_utilisation")
    path = "response/torsion/conditions/coupling/largest_utilisation"
    rows = {row.where["coupling_limit"]: row for row in verdicts_of(result) if row.quantity == path}
    for k, name in enumerate(result.record[path].axes[2].values):
        assert rows[name].utilisation == uses[:, 0, k].max()
        assert rows[name].state == (BROKEN if uses[:, 0, k].max() > 1.0 else KEPT)
    assert rows["T_KW"].state == BROKEN and "(worst of 4 conditions)" in rows["T_KW"].condition


def test_a_range_with_the_operating_speed_in_it_may_not_be_barred() -> None:
    limit = '[[response.torsion.limits]]\ngears = ["pinion - wheel"]\ntorque = '
    result = line(f'{limit}{{ speed = ["500 rpm", "1300 rpm"], torque = ["5 N*m", "5 N*m"] }}\n')
    low, high = (values(result, f"exceeded/{end}") for end in ("from", "to"))
    inside = (low <= 1200.0 * np.pi / 30.0) & (1200.0 * np.pi / 30.0 <= high)
    assert inside.any()
    assert list(values(result, "exceeded/permitted")) == [int(not one) for one in inside]
    row = next(row for row in verdicts_of(result) if row.where.get("limit") == 1)
    assert row.state == BROKEN


# ----------------------------------------------------------------------------
# Stops of mounts.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize(("rest", "state"), [(1e-3, BROKEN), (-1e-4, KEPT)])
def test_a_mount_that_meets_its_stop_breaks_a_limit_unless_it_stands_on_it(
    rest: float, state: str
) -> None:
    result = without_limits("genset_skid")
    quantities = dict(result.record.quantities)
    for name, value in (("clearance_at_rest", rest), ("clearance", -2e-4)):
        one = quantities[f"isolation/mounts/{name}"]
        values_ = np.array(one.values)
        values_[2] = value
        quantities[one.path] = replace(one, values=values_)
    changed = replace(result, record=replace(result.record, quantities=quantities))
    row = next(row for row in verdicts_of(changed) if row.limit.endswith("at speed"))
    assert row.state == state
    assert (row.element == "mount 3") == (state == BROKEN)


# ----------------------------------------------------------------------------
# In the file, and in the comparison of two.
# ----------------------------------------------------------------------------


def test_rows_come_back_from_a_file_as_they_were(tmp_path: Path) -> None:
    result = replace(result_of("engine_geared"), verdicts=None)
    rows = judged(result)
    odd = rows[0]._replace(
        computed=np.inf, margin=-np.inf, source="a, b; \u00e9", utilisation=np.nan
    )
    path = write_result(replace(result, verdicts=(odd, *rows)), tmp_path / "rows.h5")
    again = read_result(path).verdicts
    assert again is not None
    assert list(map(str, again)) == list(map(str, (odd, *rows)))
    assert again[0].error_estimate.terms == 0.0  # type: ignore[attr-defined]
    # a file without rows has them judged when it is read
    old = read_result(write_result(result, tmp_path / "old.h5"))
    assert old.verdicts is None
    assert list(map(str, verdicts_of(old))) == list(map(str, rows))


def test_a_verdict_that_has_changed_is_a_difference() -> None:
    result = result_of("genset_coupling")
    rows = verdicts_of(result)
    for state, same in ((KEPT, True), (UNDECIDED, True), (BROKEN, False)):
        changed = replace(result, verdicts=(rows[0]._replace(state=state), *rows[1:]))
        assert compare(result, changed).same == same == compare(changed, result).same
    row = next(one for one in compare(result, changed).rows if not one.same)
    assert row.problems == ("limit: kept became broken",)
    assert compare(
        result, changed, Rules(rules=(Rule(quantity="verdicts", compare="ignore"),))
    ).same


# ----------------------------------------------------------------------------
# On the bound.
# ----------------------------------------------------------------------------


def test_an_interval_that_ends_on_the_bound_to_the_last_bits_keeps_it() -> None:
    """As at the optimum of a search, which keeps the whole interval inside."""
    error = 2.8529858213372044e-07
    assert held(error - 7e-14, error, 150.0) == 1
    assert held(error - 1e-12, error, 150.0) == 0


def test_a_bound_may_be_a_temperature() -> None:
    result, path = result_of("genset_coupling"), "response/torsion/coupling/temperature"
    found = float(result.record[path].values[0])
    for bound, state in ((found - 273.15 + 1.0, KEPT), (found - 273.15 - 1.0, BROKEN)):
        limit = {"quantity": path, "max": f"{bound} degC"}
        row = judged(replace(result, case={**result.case, "limit": [limit]}))[0]
        assert (row.state, row.unit) == (state, "K")
        assert row.max == pytest.approx(bound + 273.15)
        assert row.margin == pytest.approx(1.0 if state == KEPT else -1.0)


@pytest.mark.parametrize(
    ("bounds", "share"),
    [
        ({"max": 8.0}, 0.5), ({"max": 2.0}, 2.0), ({"min": 3.0}, 0.75), ({"min": 8.0}, 2.0),
        ({"min": 1.0, "max": 5.0}, 0.8), ({"min": 3.5, "max": 80.0}, 0.875),
        ({"min": 1.0, "max": 80.0}, 0.25), ({"min": -1.0, "max": 5.0}, 0.8),
        ({"min": 3.0, "max": 100.0}, 0.75), ({"min": 0.0}, None), ({"max": 0.0}, None),
        ({"min": -4.5, "max": 80.0}, None), ({"max": "800 %"}, 0.5), ({"max": "200 %"}, 2.0),
        ({"min": "300 %"}, 0.75), ({"min": "800 %"}, 2.0),
    ],
)  # fmt: skip
def test_the_share_of_a_limit_is_that_of_its_nearer_side(
    bounds: dict[str, float], share: float | None
) -> None:
    """Of a number 4 without a unit; a limit at or through zero on that side has no share."""
    result, path = golden("engine_damped"), "response/torsion/reduction"
    four = replace(result.record[path], values=np.array(4.0), axes=(), errors=None)
    record = replace(result.record, quantities=result.record.quantities | {path: four})
    row = judge(replace(result, record=record), {"quantity": path, **bounds})
    assert (row.utilisation == pytest.approx(share)) if share else np.isnan(row.utilisation)
    if share:
        assert row.state == (KEPT if share <= 1.0 else BROKEN)
    shown = limit_table([row])[0].splitlines()[-1].split()[-2]
    assert (float(shown) == pytest.approx(100.0 * share)) if share else shown == "-"


@pytest.mark.parametrize(("name", "linear"), [("roll_records", "1e-5"), ("roll_measured", "1")])
def test_a_level_in_the_first_table_has_its_reference(name: str, linear: str) -> None:
    result = golden(name)
    measured = {**result.case["measurement"], "reference_level": float(linear)}
    result = replace(result, case={**result.case, "measurement": measured}, verdicts=())
    rows = [line for line in first_table(result, ())[0].splitlines() if " level " in line]
    assert len(rows) == 9
    for row in rows:
        linearly = row.strip().startswith("translation")
        assert f"dB re {linear} m/s^2" in row if linearly else "dB re 1 rad/s^2" in row
