"""Claim: limits say the same whatever way they are given, without damping, for passing through."""

import numpy as np
import pytest
from engine_cases import CRANK, ENGINE, GEARED, ran

from vibecalc.torsion.report.limits import flags


def test_a_shaft_kind_is_its_factor() -> None:
    rule = 'rule = "iacs_m68", sections = ["a - b"], tensile_strength = "600 MPa"'
    text = f"{ENGINE}limits = [{{ {rule}, KEY }}, {{ {rule} }}]\n"
    named = ran(text.replace("KEY", 'shaft_kind = "keyway_cylinder"')).record
    given = ran(text.replace("KEY", "design_factor = 0.45")).record
    for name in ("allowed", "transient", "operating_utilisation", "basis/design_factor"):
        path = f"response/torsion/limit/{name}"
        assert np.array_equal(named[path].values, given[path].values)
    assert named["response/torsion/limit/basis/design_factor"].values[:, 0].tolist() == [0.45, 1.0]


def test_a_throw_of_the_line_is_the_same_as_one_of_the_limit() -> None:
    sizes = CRANK.removeprefix("crank = { ").removesuffix(" }")
    throw = (
        f'throw = {{ {sizes}, oil_bore = "7 mm", pin_length = "40 mm", journal_length = "4 cm" }}'
    )
    line = GEARED.replace('stiffness = "1e6 N*m/rad"', throw)
    rule = 'rule = "iacs_m53", tensile_strength = "600 MPa"'
    bending = 'bending = { web = "9 MPa", compressive = "1 MPa", oil_bore = "5 MPa" }'
    other = f'sections = ["a - b"], {CRANK[:-2]}, oil_bore = "7 mm" }}'
    text = f"{line}limits = [{{ {rule}, {bending} }}, {{ {rule}, {bending}, {other} }}]\n"
    record = ran(text).record
    for name in ("bending_factor", "torsion_factor", "fatigue_strength", "operating_acceptability"):
        found = record[f"response/torsion/limit/crank/{name}"].values
        assert np.array_equal(found[0], found[1]) and np.all(found[0] > 0.0)


def passing(curve: str, low: float, high: float) -> str:
    """A limit with what is allowed for passing through, in N/mm2."""
    column = f'transient = ["{low} MPa", "{high} MPa"]'
    return f"limits = [{{ curve = {{ {curve}, {column} }} }}]\n"


def test_a_table_for_passing_through_is_held_by_itself() -> None:
    # 9 N/mm2 for lasting; for passing through from 20 at 700 rpm to 30 at 2100 rpm
    curve = 'speed = ["700 rpm", "2100 rpm"], stress = ["9 MPa", "9 MPa"]'
    result = ran(ENGINE + passing(curve, 20, 30))
    record = result.record
    stress = record["response/torsion/speeds/stress_half_range"]
    turns = np.asarray(stress.axes[1].values) * 30.0 / np.pi
    sweep = np.max(stress.values[0] / (20e6 + 10e6 * (turns - 700.0) / 1400.0))
    use = float(record["response/torsion/limit/passage_utilisation"].values[0])
    assert sweep <= use * (1.0 + 1e-12) and use == pytest.approx(sweep, rel=1e-3)
    assert flags(result) == ["BROKEN"]
    high = ran(ENGINE + passing(curve, 80, 80))
    here = float(high.record["response/torsion/limit/operating_utilisation"].values[0])
    assert flags(high) == ["barred range" if here <= 1.0 else "BROKEN"]


def test_a_gear_that_nothing_damps_has_no_upper_end() -> None:
    text = f"""{GEARED}speeds = {{ from = "400 rpm", to = "620 rpm", points = 23 }}
limits = [{{ alternating_share = 1, gears = ["pinion - wheel"] }}]
"""
    record = ran(text).record
    assert record["response/torsion/resonances_skipped/from"].values.size
    assert np.isinf(record["response/torsion/limit/largest_utilisation"].values[0])
    low, high = (record[f"response/torsion/exceeded/{name}"].values for name in ("from", "to"))
    at = record["response/torsion/limit/speed"].values[0]
    assert np.any((low <= at) & (at <= high))


def test_the_rule_for_crankshafts_on_another_shaft_is_cautioned() -> None:
    rule = 'rule = "iacs_m53", tensile_strength = "600 MPa"'
    bending = "bending = { web = 0, compressive = 0 }"
    shafts = 'sections = ["a - b", "b - pinion", "wheel - propeller"]'
    text = f"{GEARED}limits = [{{ {rule}, {bending}, {CRANK}, {shafts} }}]\n"
    said = [one for one in ran(text).record.warnings if "UR M53" in one]
    (words,) = said
    assert "for crankshafts, but is applied to other shafts" in words
    assert words.endswith("'wheel - propeller' (no cylinder at its ends)")
