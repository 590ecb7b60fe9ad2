"""Claim: IACS UR M53 and M68 are as the formulas say, worked out by hand; what M53 leaves for
torsion is the torsion with which the worst place just keeps its acceptability factor. Limit curves
are continuous and refused outside their scope; separations agree with their definitions.
"""

import numpy as np
import pytest
from engine_cases import CRANK, ENGINE, GEARED, ran

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.question_tables import CrankBending
from vibecalc.torsion.report.limits import flags
from vibecalc.torsion.stress_limits import (
    ACCEPTABILITY,
    CRANKSHAFT_KINDS,
    M68,
    SEPARATIONS,
    SHAFT_KINDS,
    CrankThrow,
    barred_range,
    bending_stresses,
    covered,
    equivalent_stress,
    fatigue_strength,
    permissible_torsion,
    proportions,
    propulsion_shaft_limits,
    separation,
    stress_concentration,
    torsion_ratio,
)


def throw(**changes: float) -> CrankThrow:
    """In mm: pin and journal of 200, bored 80 and 100, E = 150, web 100 by 300, fillets 10, 12."""
    sizes = {
        "pin_diameter": 200, "pin_bore": 80, "journal_diameter": 200, "journal_bore": 100,
        "web_thickness": 100, "web_width": 300, "crank_radius": 150, "pin_fillet": 10,
        "journal_fillet": 12, "pin_recess": 4, "journal_recess": 2, "oil_bore": 20,
    }  # fmt: skip
    return CrankThrow(**{key: np.array([1e-3 * size]) for key, size in (sizes | changes).items()})


#: a solid one of a trunk piston engine, journal thicker than pin, without recesses
SOLID = {
    "pin_diameter": 220.0, "pin_bore": 0.0, "journal_diameter": 250.0, "journal_bore": 0.0,
    "web_thickness": 80.0, "web_width": 350.0, "crank_radius": 160.0, "pin_fillet": 14.0,
    "journal_fillet": 14.0, "pin_recess": 0.0, "journal_recess": 0.0, "oil_bore": 22.0,
}  # fmt: skip


def test_proportions_by_hand() -> None:
    # S = (200 + 200) / 2 - 150 = 50: s = 50 / 200; w = 100 / 200; b = 300 / 200; r = 10 / 200,
    # 12 / 200; bores 20, 100 and 80 over 200
    found = proportions(throw())._asdict()
    by_hand = {"r_h": 0.05, "r_g": 0.06, "s": 0.25, "w": 0.5, "b": 1.5, "d_o": 0.1,
               "d_g": 0.5, "d_h": 0.4}  # fmt: skip
    for key, value in by_hand.items():
        assert found[key] == pytest.approx(value, rel=1e-14)


def test_stress_concentration_by_hand() -> None:
    found = stress_concentration(throw())
    # f(s,w): polynomials in w = 1/2 are 0.00435, 1.463025, -0.526825;
    #   0.00435 + 0.75 * 1.463025 - 0.5625 * 0.526825 = 0.8052796875
    # f(w) = 2.1790 * 0.5^0.7171 = 1.325527128; f(b) = 0.6840 - 0.01155 + 0.331425 = 1.003875
    # f(r) = 0.2081 * 0.05^-0.5231 = 0.9973345653
    # f(d_G) = 0.9993 + 0.135 - 0.255275 + 0.066325 = 0.94535
    # f(d_H) = 0.9978 + 0.1258 - 0.243856 + 0.1545408 = 1.0342848
    # f(recess) = 1 + 0.03 (1.8 + 0.8) = 1.078; alpha_B is 2.6914 times all of these
    assert found.bending[0, 0] == pytest.approx(3.0316960260478, rel=1e-12)
    # f_B(s,w): -0.65335, 2.997225, -1.31565: -0.65335 + 2.24791875 - 0.740053125 = 0.854515625
    # f_B(w) = 2.2422 * 0.5^0.7548 = 1.328791702; f_B(b) = 0.5616 + 0.17955 + 0.2646 = 1.00575
    # f_B(r) = 0.1908 * 0.06^-0.5568 = 0.9139106834
    # f_B(d_G) = 1.0012 - 0.32205 + 0.306625 = 0.985775
    # f_B(d_H) = 1.0022 - 0.07612 + 0.001168 = 0.927248; beta_B = 2.7146 times these, 1.078
    assert found.bending[0, 1] == pytest.approx(2.7917017704906, rel=1e-12)
    # f_Q(s) = 0.4368 + 1.62225 - 0.855675 = 1.203375; f_Q(w) = 0.5 / 0.53215 = 0.9395847036
    # f_Q(b) = 1; f_Q(r) = 0.5331 * 0.06^-0.2038 = 0.9458482348
    # f_Q(d_H) = 0.9937 - 0.47796 + 0.277968 = 0.793708; beta_Q = 3.0128 times these, 1.078
    assert found.compression[0] == pytest.approx(2.7568186719479, rel=1e-12)
    # gamma_B = 3 - 0.588 + 0.346, gamma_T = 4 - 0.6 + 0.3
    assert found.bending[0, 2] == pytest.approx(2.758, rel=1e-14)
    assert found.torsion[0, 2] == pytest.approx(3.7, rel=1e-14)
    # exponent -0.322 + 0.1015 * 0.75 = -0.245875: 0.05 to it 2.0887706199, 0.06 1.9972023174
    # f(b) = 7.8955 - 15.981 + 12.03345 - 2.892375 = 1.055575; f(w) = 0.5^-0.145 = 1.1057306533
    assert found.torsion[0, 0] == pytest.approx(1.9503797647741, rel=1e-12)
    assert found.torsion[0, 1] == pytest.approx(1.8648782920345, rel=1e-12)


def test_a_journal_thicker_than_the_pin_by_hand() -> None:
    # s = (235 - 160) / 220 = 0.3409090909, w = 0.3636363636, b = 1.5909090909, r = 0.0636363636
    # alpha_B: f(s,w) = 0.7190188316, f(w) 1.0549011250, f(b) 1.0445650826, f(r) 0.8791314345,
    #   0.9993, 0.9978
    # beta_B: 0.7305085210, 1.0448790725, 1.0496764463, 0.8844539560, 1.0012, 1.0022
    # beta_Q: 1.2016030992, 0.8992199267, 1.0909090909, 0.9345736481, 0.9937
    # alpha_T: 0.0636363636^-0.2551022727 = 2.0191913766, f(b) 1.0314274042, f(w) 1.1579858181
    # beta_T: of r = 14 / 250 = 0.056, 2.0861238071
    found = stress_concentration(throw(**SOLID))
    assert found.bending[0] == pytest.approx([1.8692137581996, 1.9302034258917, 2.758], rel=1e-12)
    assert found.compression[0] == pytest.approx(3.2980303406798, rel=1e-12)
    assert found.torsion[0] == pytest.approx([1.9293427015204, 1.9932968159161, 3.7], rel=1e-12)


def test_a_recess_never_lowers_a_factor() -> None:
    # 1.8 + 3.2 s is below 0 for an overlap of less than -0.5625; at s = -0.5 it is 0.2
    plain = stress_concentration(throw(crank_radius=300.0, pin_recess=0.0, journal_recess=0.0))
    recessed = stress_concentration(throw(crank_radius=300.0))
    assert recessed.bending[0, 0] == pytest.approx(1.006 * plain.bending[0, 0], rel=1e-12)


def test_fatigue_strength_by_hand() -> None:
    # sigma_B = 700: 0.42 * 700 + 39.3 = 333.3; 0.264 + 1.073 * 200^-0.2 = 0.6358722084;
    # (785 - 700) / 4900 = 0.0173469388; 196 / 700 = 0.28, times 10^-0.5 and 12^-0.5
    # pin 1.05 * 333.3 * 0.7417630104, journal 1.05 * 333.3 * 0.7340483..., bore K = 1, R = 10 mm
    kind = CRANKSHAFT_KINDS["continuous_grain_flow"]
    found = fatigue_strength(throw(), np.array([700e6]), kind)[0] / 1e6
    assert found == pytest.approx([259.59106086228, 256.89117299871, 247.22958177360], rel=1e-12)
    # 375.3 * (0.264 + 1.073 * 220^-0.2 - 15 / 4900 + 0.245 / sqrt(14)), free form; of 250; of 11
    solid = fatigue_strength(throw(**SOLID), np.array([800e6]), 1.0)[0] / 1e6
    assert solid == pytest.approx([259.43306108450, 255.97662854850, 262.58230664943], rel=1e-12)
    # a radius below 2 mm counts as 2 mm, and so does a cast shaft below 1 at the bore
    least = fatigue_strength(throw(oil_bore=3.0), np.array([700e6]), 0.93)[0, 2] / 1e6
    by_hand = 0.93 * 333.3 * (0.6358722083527361 + 85 / 4900 + 0.28 / np.sqrt(2.0))
    assert least == pytest.approx(by_hand, rel=1e-12)


def test_acceptability_by_hand() -> None:
    # bending 25, radial force 4, at the bore 12, additional 10 N/mm2; torsion of the pin 20 N/mm2
    one = throw()
    factors = stress_concentration(one)
    given = CrankBending(web=25e6, compressive=4e6, oil_bore=12e6, additional=10e6)
    bending = bending_stresses(factors, given)
    # pin 3.0316960260 * 25 + 10, journal 2.7917017705 * 25 + 2.7568186719 * 4 + 10, bore 2.758 * 12
    assert bending[0] / 1e6 == pytest.approx([85.792400651196, 90.819818950057, 33.096], rel=1e-12)
    # W_pin / W_journal = (200^4 - 80^4) / (200^4 - 100^4) = 1.55904 / 1.5
    assert torsion_ratio(one)[0] == pytest.approx([1.0, 1.03936, 1.0], rel=1e-14)
    torsion = factors.torsion * torsion_ratio(one) * 20e6
    assert torsion[0] / 1e6 == pytest.approx([39.007595295482, 38.765598032180, 74.0], rel=1e-12)
    # sqrt(85.7924^2 + 3 * 39.0076^2); the same of the journal; 33.096 / 3 (1 + 2 sqrt(1 + 9/4
    # (74 / 33.096)^2))
    found = equivalent_stress(bending, torsion)[0] / 1e6
    assert found == pytest.approx([109.20216793500, 112.94491704587, 88.251298727714], rel=1e-12)
    strength = fatigue_strength(one, np.array([700e6]), 1.05)
    # 259.59106 / 109.20217, 256.89117 / 112.94492, 247.22958 / 88.25130
    assert strength[0] / 1e6 / found == pytest.approx(
        [2.3771603235643, 2.2744819308192, 2.8014271216154], rel=1e-12
    )


def test_what_is_left_for_torsion_is_where_the_factor_is_met() -> None:
    random = np.random.default_rng(53)
    bending = random.uniform(0.0, 190e6, (50, 3))
    strength = random.uniform(220e6, 300e6, (50, 3))
    torsion = permissible_torsion(bending, strength)
    kept = bending < strength / ACCEPTABILITY
    factor = strength / equivalent_stress(bending, torsion)
    assert factor[kept] == pytest.approx(ACCEPTABILITY, rel=1e-12)
    assert np.all(torsion[~kept] == 0.0)
    # by hand, bore without bending: all of sigma_DW / 1.15 is torsion
    assert permissible_torsion(np.zeros(3), np.full(3, 230e6))[2] == pytest.approx(200e6)
    # fillet: sqrt((200^2 - 120^2) / 3) = 160 / sqrt(3)
    fillet = permissible_torsion(np.full(3, 120e6), np.full(3, 230e6))[0]
    assert fillet == pytest.approx(160e6 / np.sqrt(3.0), rel=1e-14)
    # bore: (3 * 200 - 120) / 2 = 240; sqrt(240^2 - 120^2) / 1.5 = 138.5640646
    bore = permissible_torsion(np.full(3, 120e6), np.full(3, 230e6))[2]
    assert bore == pytest.approx(138.56406460551e6, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "factor", "lasting", "passing"),
    [
        # 600 N/mm2, d = 32 mm: d^-0.2 = 1/2, c_D = 0.815; 760 / 18 * 0.815 * (3 - 2 / 4) = 86.0278
        # N/mm2 at half the rated speed for c_K = 1; tau_C goes with c_K, tau_T = 1.7 tau_C /
        # sqrt(c_K) = 146.2472 sqrt(c_K)
        ("flange", 1.0, 86.027777777778, 146.2472222222222),
        ("shrink_fit", 1.0, 86.027777777778, 146.2472222222222),
        ("keyway_taper", 0.60, 51.616666666667, 113.2826112191524),
        ("keyway_cylinder", 0.45, 38.7125, 98.10561912282203),
        ("radial_hole", 0.50, 43.013888888889, 103.4124025630293),
        ("longitudinal_slot", 0.30, 25.808333333333, 80.10290258358192),
        ("thrust_collar", 0.85, 73.123611111111, 134.8332767033370),
        ("thrust_roller_bearing", 0.85, 73.123611111111, 134.8332767033370),
        ("propeller_flange", 0.55, 47.315277777778, 108.4598428186388),
        ("propeller_keyless", 0.55, 47.315277777778, 108.4598428186388),
        ("propeller_keyed", 0.55, 47.315277777778, 108.4598428186388),
        ("propeller_forward", 0.80, 68.822222222222, 130.8074921637627),
    ],
)
def test_shaft_kinds_of_m68_by_hand(
    kind: str, factor: float, lasting: float, passing: float
) -> None:
    assert SHAFT_KINDS[kind] == factor
    found = propulsion_shaft_limits(0.5, 600e6, 0.032, SHAFT_KINDS[kind])
    assert found.continuous / 1e6 == pytest.approx(lasting, rel=1e-12)
    assert found.transient / 1e6 == pytest.approx(passing, rel=1e-12)


def test_m68_curve_is_continuous_and_never_rises() -> None:
    ratio = np.linspace(0.0, 1.05, 2101)
    limit = propulsion_shaft_limits(ratio, 500e6, 0.3).continuous
    assert np.all(np.diff(limit) <= 1e-9 * limit[0])
    near = propulsion_shaft_limits([np.nextafter(0.9, 0.0), 0.9], 500e6, 0.3)
    assert np.ptp(near.continuous) <= 1e-14 * near.continuous[0]
    # steel above the cap counts no more
    capped = propulsion_shaft_limits(0.5, 900e6, 0.3).continuous
    assert capped == propulsion_shaft_limits(0.5, 600e6, 0.3).continuous


def test_m68_says_what_it_is_not_for() -> None:
    assert "crankshafts" in M68.not_for and M68.status == "informative"
    assert covered([0.0, 1.05, 1.0501, -0.1]).tolist() == [True, True, False, False]
    with pytest.raises(NumericalFailure, match=r"no limit at 1.2 of the rated speed"):
        propulsion_shaft_limits([0.3, 1.2], 600e6, 0.2)


def test_barred_range() -> None:
    found = barred_range([50.0, 80.0], 100.0)
    assert found.lower == pytest.approx([16 * 50 / 17.5, 16 * 80 / 17.2])
    assert found.upper == pytest.approx([17.5 * 50 / 16, 17.2 * 80 / 16])
    # geometric about the critical speed
    assert found.lower * found.upper == pytest.approx([2500.0, 6400.0])
    assert found.permitted.tolist() == [True, False]
    with pytest.raises(NumericalFailure, match=r"above 1\.05"):
        barred_range(106.0, 100.0)


def test_separation_margins() -> None:
    # orders 1, 2 and 2.5 of 90 to 100 rad/s
    found = separation([80.0, 95.0, 112.0, 165.0, 209.0], [1.0, 2.0, 2.5], 90.0, 100.0)
    assert found.margin[:, 0] == pytest.approx([1 / 9, -0.05, 0.12, 0.65, 1.09])
    assert found.kept[:, 0].tolist() == [True, False, True, True, True]
    assert found.margin[3:, 1] == pytest.approx([15 / 180, 9 / 200])
    assert found.kept[3:, 1].tolist() == [True, False]
    assert found.kept[:, 2].all()
    # a range from rest has no side below
    from_rest = separation([50.0], [1.0], 0.0, 100.0, "api_684")
    assert from_rest.margin[0, 0] == pytest.approx(-0.5) and not from_rest.kept[0, 0]
    assert SEPARATIONS["api_618"].margin[10.0] == 0.05 and 11.0 not in SEPARATIONS["api_618"].margin


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
    assert flags(high) == ["barred" if here <= 1.0 else "BROKEN"]


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
