"""Every result of a shaft line but those of studies: path, unit, axes, long name.

Angles and torques are actual ones, of the shaft they belong to. An amplitude of an order is
0-to-peak; a half range is (highest - lowest) / 2 over the cycle of all orders together, without
the mean. A value is infinite at a speed where an order meets a natural frequency that nothing
damps.
"""

from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, named, q
from vibecalc.core.results.record import (
    CANCELS,
    CHECK,
    CYCLE,
    PEAK,
    PLACE,
    RESONANCE,
    Entry,
    Headline,
    entry,
    under,
)
from vibecalc.torsion import study_results
from vibecalc.torsion.study_results import COUPLING, COUPLING_ENTRIES, LARGEST

ROOT = "response/torsion"
_REPORT = "vibecalc.torsion.report.limits"
_LASTS, _PASSES = "infinite outside the limit", "infinite where the limit has none"
_HERE, _TOP = "at the operating speed", "at any speed of the range"
_HALF, _WITH_MEAN = "half range of all orders", "largest magnitude, mean torque included"

# ----------------------------------------------------------------------------
# Modes, what the cylinders do to the line, and its vibration at one speed.
# ----------------------------------------------------------------------------

MODES = under(
    f"{ROOT}/modes",
    entry("natural_frequency", "mode", "rad/s",
          "with a damper the magnitude of the pole, else undamped; 0: rigid or overdamped",
          headline=Headline("torsional natural frequency", "Hz", pick="elastic")),
    entry("frequency_error", "mode", "rad/s", "error estimate of each natural frequency",
          diagnostic=True),
    entry("damping_ratio", "mode", "", "of the damped pole, or as given by mode; 1: overdamped"),
    entry("undamped_frequency", "mode", "rad/s",
          "of the line without any damping, damper rings free, with numbers of their own"),
    entry("transfer_matrix_frequency", "mode", "rad/s",
          "undamped, by transfer matrix and mode count (no independent check in branched lines); "
          "only without closed loops of shafts"),
    entry("shape", "mode station", "",
          "actual angle; largest degree of freedom 1, damper rings excepted"),
    entry("ring_shape", "mode damper", "", "the same, of the rings of dampers"),
    entry("modal_inertia", "mode", "kg*m^2",
          "sum of inertia times squared magnitude of that shape, referred to the crankshaft"),
    entry("strain_energy_share", "mode section", "", "of the section in the energy of the mode"),
    entry("holzer_angle", "mode freedom", "",
          "Holzer table, undamped: referred angle, 1 in its first row"),
    entry("holzer_inertia_torque", "mode freedom", "N*m", "Holzer table: J w^2 times the angle"),
    entry("holzer_torque", "mode freedom", "N*m", "Holzer table: running sum of the torques"),
    entry("holzer_residual", "mode", "N*m", "Holzer table: sum of the last row; a mode closes at 0",
          exempt=CHECK, diagnostic=True),
)  # fmt: skip

_BY_MODE = "mode order"
EXCITATION = under(
    f"{ROOT}/excitation",
    entry("pressure", "crank_angle", "Pa",
          "gauge pressure in a firing cylinder from its firing position on"),
    entry("gas_torque", "crank_angle", "N*m", "of that cylinder's gas"),
    entry("inertia_torque", "crank_angle", "N*m", "of its moving masses"),
    entry("total_torque", "crank_angle", "N*m", "of both"),
    entry("engine_torque", "crank_angle", "N*m",
          "of all cylinders, from the first firing on, referred to the crankshaft"),
    entry("gas", "order", "N*m", "gas torque of one cylinder", PEAK),
    entry("inertia", "order", "N*m", "inertia torque of one", PEAK),
    entry("total", "order", "N*m", "torque of one cylinder", PEAK),
    entry("tangential_pressure", "order", "Pa",
          "total torque of one cylinder over piston area and crank radius", PEAK),
    entry("power", "", "W", "indicated, of all cylinders",
          headline=Headline("indicated power", "kW")),
    entry("mean_torque", "", "N*m", "of all cylinders",
          headline=Headline("mean indicated torque", "N*m")),
    entry("mean_indicated_pressure", "", "Pa", "of a firing cylinder"),
    entry("firing_angle", "cylinder", "rad", "crank angle at which it fires", circle=CYCLE),
    entry("station_torque", "station order", "N*m",
          "of all cylinders of a station, with their phases", PEAK),
    entry("vector_sum", _BY_MODE, "",
          "vector sum of a mode / sum of all in phase; 0: no cylinder moves"),
    entry("intensity", _BY_MODE, "N*m",
          "modal torque: sum of shape times torque, shape as under modes", PEAK),
    entry("rank", _BY_MODE, "",
          "place of the order in the mode by its vector sum, 1 for the largest; 0: they cancel"),
    entry("major", "order", "",
          "1: the cylinders of each bank in phase, and the banks do not cancel; 0: not"),
    entry("bank_factor", "order", "",
          "factor on the sums due to the bank angle; 1: no reduction"),
)  # fmt: skip

_SUFFICIENT = "1: margin to every order as the rule requires; 0: not"
STEADY = under(
    ROOT,
    entry("angle", "station order", "rad", "vibration of the station", PEAK),
    entry("twist", "section order", "rad", "of the section, first end less second", PEAK),
    entry("torque", "section order", "N*m", "stiffness and damping part together", PEAK),
    entry("stress", "section order", "Pa", "shear, torque over section modulus", PEAK),
    entry("angle_half_range", "station", "rad", _HALF),
    entry("angle_peak", "station", "rad", "largest magnitude of all orders"),
    entry("twist_half_range", "section", "rad", _HALF),
    entry("twist_peak", "section", "rad", "largest magnitude of all orders"),
    entry("torque_half_range", "section", "N*m", _HALF,
          headline=Headline("vibratory torque at operating speed", "N*m")),
    entry("torque_peak", "section", "N*m", _WITH_MEAN),
    entry("torque_bound", "section", "N*m", "sum of the magnitudes of all orders"),
    entry("torque_mean", "section", "N*m", "steady torque that the section carries"),
    entry("stress_half_range", "section", "Pa", _HALF,
          headline=Headline("vibratory stress at operating speed", "N/mm^2")),
    entry("section_heat", "section", "W", "dashpots and loss factors, mean power"),
    entry("station_heat", "station", "W",
          "absolute damping, mean power; with a damping model also that of a ring it carries"),
    entry("modal_heat", "mode", "W",
          "mean power of modal damping ratios, not assigned to a place"),
    entry("damper/heat", "damper", "W", "mean power",
          headline=Headline("mean damper heat at operating speed", "W")),
    entry("damper/travel", "damper", "rad",
          "of the ring relative to its station, or swing of a pendulum, largest magnitude"),
    entry("gear/mean_torque", "gear", "N*m", "on the first wheel"),
    entry("gear/alternating_torque", "gear", "N*m", "on the first wheel, half range"),
    entry("gear/minimum_torque", "gear", "N*m", "over the cycle, mean included",
          headline=Headline("minimum gear torque (negative: gear hammer)", "N*m", pick="least")),
    entry("gear/hammers", "gear", "", "1: its torque changes sign; 0: it does not", flag=True,
          name="gear hammer at operating speed"),
    entry("margin/nearest_order", "mode", "",
          "excited order nearest to the mode at the operating speed; 0: none is near"),
    entry("margin/distance", "mode", "",
          "|natural frequency / frequency of that order - 1|; infinite without one"),
    entry("separation/operating/margin", "mode order_class", "",
          "the same to the nearest major and the nearest other order"),
    entry("separation/operating/order", "mode order_class", "",
          "that order; 0: none is near"),
    entry("separation/operating/sufficient", "mode order_class", "", _SUFFICIENT),
)  # fmt: skip


class PowerBalance(Group):
    """Mean torques on their own shafts and mean powers at the operating speed."""

    ROOT: ClassVar[str] = f"{ROOT}/power_balance"
    source_torque: Any = named("station", "N*m", "mean torque of cylinders")
    source_power: Any = named("station", "W", "mean power of cylinders")
    load_torque: Any = named("station", "N*m", "mean torque that a load takes")
    load_power: Any = named("station", "W", "mean power that a load takes")
    rest_torque: Any = q(
        "", "N*m", "mean torque that the load station absorbs to balance the line; negative: it "
        "supplies", name="balancing torque of the load station",
    )  # fmt: skip
    rest_power: Any = q("", "W", "of that torque", name="balancing power of the load station")
    total_load_power: Any = lead("", "W", "power absorbed by all loads")
    load_share: Any = lead(
        "", "", "load power / indicated power",
        about="mechanical efficiency if the rest is friction; infinite if the cylinders deliver "
        "nothing",
    )  # fmt: skip


#: where dampings follow the speed, a load or a mode
DAMPING = under(
    f"{ROOT}/damping",
    entry("station", "station", "N*m*s/rad", f"absolute, {_HERE}, not referred"),
    entry("section", "section", "N*m*s/rad", f"viscous, of the twist, {_HERE}, not referred"),
    entry("loss_factor", "section", "", f"of its stiffness, {_HERE}"),
)

# ----------------------------------------------------------------------------
# Over a range of crank speeds: curves, their extremes, criticals, barred ranges.
# ----------------------------------------------------------------------------

_MAY_BE_BARRED = (
    "1: may be barred; 0: it includes the operating speed, or the rule permits no barred range "
    "there (from lambda = 0.8)"
)
_LEAST_OF_GEAR = "minimum over the cycle, in the direction of the mean; negative: gear hammer"
_HOT = "largest damper heat, speed range"
_FOLLOWED = (
    ("angle_half_range", "station", "rad", _HALF),
    ("twist_peak", "section", "rad", "largest magnitude"),
    ("torque_peak", "section", "N*m", _WITH_MEAN),
    ("heat", "damper", "W", "mean power"),
    ("travel", "damper", "rad", "ring to station, swing of pendulums, largest"),
    ("gear_torque", "gear", "N*m", "on the first wheel, half range"),
    ("gear_minimum_torque", "gear", "N*m", _LEAST_OF_GEAR),
)
#: curve over the speeds -> axis of what it is of: the largest, or least, of each at any speed
FOLLOWED = {name: axis for name, axis, *_ in _FOLLOWED}


def _extremes(name: str, axis: str, unit: str, words: str) -> Iterator[Entry]:
    at = f"{ROOT}/largest/{name}_speed"
    headline = Headline(_HOT, unit, at=at) if name == "heat" else None
    yield entry(f"largest/{name}", axis, unit, f"{words}, {_TOP}", headline=headline)
    yield entry(f"largest/{name}_speed", axis, "rad/s", "where that is", exempt=PLACE)


def _largest(of: str) -> Headline:
    unit = "N/mm^2" if of == "stress" else "N*m"
    return Headline(f"largest vibratory {of}", unit, at=f"{ROOT}/largest/speed")


_DAMPS, _GEAR = "damping_over_speed", "gear_torque"
SPEEDS = under(
    ROOT,
    entry("critical/speed", _BY_MODE, "rad/s",
          "speed at which the order meets the natural frequency, also outside of the range; "
          "0: the mode does not vibrate; infinite: no response peaks"),
    entry("speeds/angle_half_range", "station speed", "rad", _HALF, curve="station_angles"),
    entry("speeds/twist_half_range", "section speed", "rad", _HALF),
    entry("speeds/twist_peak", "section speed", "rad", "largest magnitude of all orders"),
    entry("speeds/torque_half_range", "section speed", "N*m", _HALF),
    entry("speeds/torque_peak", "section speed", "N*m", _WITH_MEAN),
    entry("speeds/stress_half_range", "section speed", "Pa", _HALF, curve="section_stress"),
    entry("speeds/station_damping", "station speed", "N*m*s/rad",
          "absolute, not referred, where it depends on speed", curve=_DAMPS),
    entry("speeds/section_damping", "section speed", "N*m*s/rad",
          "viscous, of the twist, where it depends on speed", curve=_DAMPS),
    entry("speeds/section_loss_factor", "section speed", "", "where it depends on speed",
          curve=_DAMPS),
    entry("speeds/mean_torque", "speed", "N*m", "of all cylinders"),
    entry("speeds/gear_mean_torque", "gear speed", "N*m", "on the first wheel", curve=_GEAR),
    entry("speeds/gear_torque", "gear speed", "N*m", "on the first wheel, half range", curve=_GEAR),
    entry("speeds/gear_minimum_torque", "gear speed", "N*m", _LEAST_OF_GEAR, curve=_GEAR),
    entry("speeds/gear_hammers", "gear speed", "", "1: its torque changes sign; 0: it does not",
          name="gear hammer, speed range", flag=True),
    entry("hammering/from", "hammering", "rad/s", "a gear hammers from here"),
    entry("hammering/to", "hammering", "rad/s", "to here"),
    entry("hammering/gear", "hammering", "", "this gear, counted from 1"),
    entry("campbell/natural_frequency", "mode speed", "rad/s",
          "as under modes, where pendulums make it depend on speed"),
    entry("separation/range/margin", "mode order_class", "",
          "least margin to an order over the speed range; negative: critical within it"),
    entry("separation/range/order", "mode order_class", "", "that order; 0: none"),
    entry("separation/range/sufficient", "mode order_class", "", _SUFFICIENT),
    entry("resonances_skipped/from", "resonance_skipped", "rad/s", "a mode is undamped from here"),
    entry("resonances_skipped/to", "resonance_skipped", "rad/s", "to here"),
    entry("resonances_skipped/mode", "resonance_skipped", "", "the mode"),
    entry("resonances_skipped/order", "resonance_skipped", "", "and the order that meets it"),
    entry("largest/torque_half_range", "section", "N*m", _TOP, headline=_largest("torque")),
    entry("largest/twist_half_range", "section", "rad", "there"),
    entry("largest/stress_half_range", "section", "Pa", "there", headline=_largest("stress")),
    entry("largest/speed", "section", "rad/s", "where that is"),
    entry("largest/mode", "section", "", "mode that resonates there; 0: none"),
    entry("largest/order", "section", "", "and order; 0: none"),
    entry("speeds/heat", "damper speed", "W", "mean power",
          headline=Headline(_HOT, "W", unless=f"{ROOT}/largest/heat")),
    entry("speeds/travel", "damper speed", "rad", "ring to station, swing of pendulums, largest"),
    *(one for row in _FOLLOWED for one in _extremes(*row)),
    entry("peak/speed", "peak", "rad/s", "maximum of a section's curve"),
    entry("peak/torque_half_range", "peak", "N*m", "there, in that section"),
    entry("peak/section", "peak", "",
          "that section, counted from 1: the one of most torque, then that of most stress"),
    entry("peak/mode", "peak", "", "mode that resonates there; 0: none"),
    entry("peak/order", "peak", "", "and order; 0: none"),
)  # fmt: skip


def _barred(place: str, of: str = "") -> tuple[Entry, ...]:
    """Ranges of speeds above the limits, and what is barred for all of them; `of` what is said."""
    words = f", {of}" * bool(of)

    def lead(end: str, told: str) -> Headline | None:
        """Of the line as it is; those of its variants stand in words."""
        words = f"vibecalc.torsion.report.vibration:{told}"
        return None if of else Headline(f"barred range {end}", "rpm", pick="each", words=words)

    return under(
        place,
        entry("barred/from", "barred", "rad/s",
              "barred for continuous operation from here: by the formula of a rule where that is "
              f"wider than the range above the limit; overlapping ranges are merged{words}",
              headline=lead("from", "barred_by")),
        entry("barred/to", "barred", "rad/s", f"to here{words}",
              headline=lead("to", "acceptable")),
        entry("barred/permitted", "barred", "", _MAY_BE_BARRED),
        entry("exceeded/from", "exceeded", "rad/s",
              f"more than allowed in continuous operation from here{words}"),
        entry("exceeded/to", "exceeded", "rad/s", "to here"),
        entry("exceeded/limit", "exceeded", "", "above this limit, counted from 1"),
    )  # fmt: skip


BARRED = _barred(ROOT)
# ----------------------------------------------------------------------------
# Against limits, over the speeds and section by section.
#
# The section axis holds the shafts, and behind them the gears, that some limit is for; a value is 0
# where a limit is not for the section, or has no such number.
# ----------------------------------------------------------------------------

_EACH, _CRANK = "limit section", "limit section crank_place"


def _held(place: str, here: str, stress: str) -> Iterator[Entry]:
    """Stress and torque of each section, and what is allowed of both."""
    for of, prefix, unit in (("stress", "", "Pa"), ("torque", "torque_", "N*m")):
        yield entry(f"{place}/{of}", _EACH, unit, stress)
        yield entry(
            f"{place}/{prefix}allowed", _EACH, unit, f"for continuous operation, {here}; {_LASTS}"
        )
        words = f"for passing through, {here}; {_PASSES}"
        yield entry(f"{place}/{prefix}transient", _EACH, unit, words)


LIMITS = under(
    f"{ROOT}/limit",
    entry("allowed", "limit speed", "Pa",
          f"for continuous operation, in the section of highest utilisation; {_LASTS}"),
    entry("transient", "limit speed", "Pa", f"for passing through, there; {_PASSES}"),
    entry("torque_allowed", "limit speed", "N*m",
          "for continuous operation, of limits of the torque, in the section or gear of highest "
          "utilisation"),
    entry("torque_transient", "limit speed", "N*m", f"for passing through, there; {_PASSES}"),
    entry("largest_utilisation", "limit", "", "largest stress or torque over allowed, at any speed",
          share=True,
          headline=Headline("highest utilisation", at=f"{ROOT}/limit/speed",
                            words=f"{_REPORT}:most_used")),
    entry("speed", "limit", "rad/s", "where that is"),
    entry("section", "limit", "", "in this section, counted from 1; 0: in a gear"),
    entry("gear", "limit", "", "in this gear, counted from 1; 0: in a section"),
    entry("operating_utilisation", "limit", "",
          "stress or torque over allowed at the operating speed",
          share=True,
          headline=Headline("utilisation at operating speed",
                            words=f"{_REPORT}:most_used_at_speed")),
    entry("passage_utilisation", "limit", "",
          "largest stress or torque over that for passing through; 0: the limit has none",
          name="utilisation, passage", share=True),
)  # fmt: skip
BY_SECTION = under(
    f"{ROOT}/limit",
    entry("basis/rated_speed", "limit", "rad/s", "to which a rule refers"),
    entry("basis/diameter", _EACH, "m", "outer, of the stressed section"),
    entry("basis/tensile_strength", _EACH, "Pa", "of the material, as given"),
    entry("basis/counted_strength", _EACH, "Pa", "as used by a rule"),
    entry("basis/size_factor", _EACH, "", "c_D of a rule"),
    entry("basis/design_factor", _EACH, "", "c_K of a rule"),
    *_held("operating", _HERE, f"{_HALF}, {_HERE}"),
    entry("operating/utilisation", _EACH, "",
          f"stress or torque over allowed in continuous operation, {_HERE}"),
    entry("each/utilisation", _EACH, "", "largest stress or torque over allowed, at any speed"),
    entry("each/speed", _EACH, "rad/s", "where that is"),
    entry("each/speed_ratio", _EACH, "", "lambda: that speed over the rated one"),
    *_held("each", "there", "there"),
    entry("each/passage_utilisation", _EACH, "",
          "largest over what is allowed for passing through, at any speed; 0: the limit has none"),
    entry("crank/bending_factor", _CRANK, "",
          "alpha_B, beta_B, gamma_B: stress concentration in bending"),
    entry("crank/torsion_factor", _CRANK, "",
          "alpha_T, beta_T, gamma_T: stress concentration in torsion"),
    entry("crank/bending_stress", _CRANK, "Pa",
          "alternating, concentrated, the additional one in fillets; 0 without a bore"),
    entry("crank/fatigue_strength", _CRANK, "Pa", "sigma_DW; 0 without a bore"),
    entry("crank/operating_acceptability", _CRANK, "",
          f"Q, fatigue strength / equivalent stress, {_HERE}; 0: no bore or unbounded stress"),
    entry("crank/acceptability", _CRANK, "",
          "the same at the speed of highest utilisation; required: 1.15"),
)  # fmt: skip


def _exceeded(place: str) -> tuple[Entry, ...]:
    """What is known of ranges above the limits besides their ends."""
    return under(
        place,
        entry("exceeded/peak_speed", "exceeded", "rad/s",
              "of the highest utilisation inside the range", exempt=PLACE),
        entry("exceeded/formula_from", "exceeded", "rad/s",
              "16 n_c / (18 - lambda) of the rule, n_c the peak; 0: a limit without a formula"),
        entry("exceeded/formula_to", "exceeded", "rad/s", "(18 - lambda) n_c / 16 of the rule"),
        entry("exceeded/permitted", "exceeded", "", _MAY_BE_BARRED),
    )  # fmt: skip


EXCEEDED = _exceeded(ROOT)

# ----------------------------------------------------------------------------
# The same shaft line in another state: without its dampers, or with all gas.
#
# Names and meanings are those of the line itself.
# ----------------------------------------------------------------------------

_BARE, _HEALTHY = "the line without its dampers", "all cylinders firing"
_LOADS = (("torque", "section", "N*m"), ("twist", "section", "rad"), ("stress", "section", "Pa"))


def _half_ranges(place: str, words: str) -> tuple[Entry, ...]:
    scopes = (("", "", f"{words}, {_HERE}"), ("speeds/", " speed", words), ("largest/", "", ""))
    top = {"torque": f"{words}, {_TOP}"}
    return under(
        f"{ROOT}/{place}",
        *(
            entry(f"{scope}{of}_half_range", axis + over, unit, told or top.get(of, "there"))
            for scope, over, told in scopes
            for of, axis, unit in _LOADS
        ),
        entry("largest/speed", "section", "rad/s", "where that is"),
    )


def _limit_uses(
    place: str, axes: str, words: str, lead: Callable[[str, str], Headline] | None = None
) -> Any:
    """Uses of limits in a condition, with the load that has the largest one.

    `lead` makes headlines of their names and the speeds that they stand at.
    """
    top, here = "highest utilisation, worst condition", "utilisation at operating speed"
    here = f"{here}{words or ', worst condition'}"
    use = f"stress or torque over allowed{words}"
    load = "section, counted from 1, then gears; 0: outside the limit"
    return under(
        f"{ROOT}/{place}/limit",
        entry("operating_utilisation", axes, "", f"{use}, {_HERE}", share=True, name=here,
              headline=lead(here, "") if lead else None),
        entry("largest_utilisation", axes, "", f"{use}, largest at any speed", share=True,
              headline=lead(top, f"{ROOT}/{place}/limit/speed") if lead else None),
        entry("speed", axes, "rad/s", "where that is"),
        entry("unbarred_utilisation", axes, "",
              "largest at speeds that may not be barred: the operating speed, and for a rule those "
              "from lambda = 0.8"),
        *(one for start, at in (("", "at the largest use"), ("operating_", _HERE)) for one in (
            entry(f"{start}element", axes, "", f"{load}, {at}"),
            entry(f"{start}allowed", axes, "Pa",
                  f"stress for continuous operation, {at}; infinite for limits of the torque"),
            entry(f"{start}torque_allowed", axes, "N*m",
                  f"torque for continuous operation, {at}; infinite for limits of the stress"),
        )),
    )  # fmt: skip


def _in_conditions(name: str, at: str) -> Headline:
    return Headline(name, at=at, words=f"{_REPORT}:most_used_in_condition")


VARIANTS = (
    *_half_ranges("without_dampers", _BARE),
    *under(ROOT,
        entry("without_dampers/natural_frequency", "mode_without_dampers", "rad/s",
              "without its dampers"),
        entry("reduction", "section", "", "largest torque without dampers over that with them",
              headline=Headline("torque reduction by the dampers, factor", pick="least",
                                by=f"{ROOT}/without_dampers/largest/torque_half_range"))),
    *_half_ranges("healthy", _HEALTHY),
    *under(f"{ROOT}/healthy",
        entry("mean_torque", "", "N*m", "of all cylinders, all firing"),
        entry("damper/heat", "damper", "W", f"mean power, {_HEALTHY}"),
        entry("damper/travel", "damper", "rad", f"largest magnitude, {_HEALTHY}")),
    *_limit_uses("healthy", "limit", f", {_HEALTHY}"),
    *_barred(f"{ROOT}/healthy", _HEALTHY),
    *_exceeded(f"{ROOT}/healthy"),
    *_limit_uses("conditions", "condition limit", "", _in_conditions),
    *_barred(f"{ROOT}/conditions", "worst condition"),
    entry(f"{ROOT}/conditions/exceeded/condition", "exceeded", "",
          "in this condition, counted from 1"),
    *_exceeded(f"{ROOT}/conditions"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Orders of named shafts and stations against the speed, their sums, and what was measured.
#
# The axes hold the shafts or stations that the case asks the quantity of, and every order that is
# kept for one of them.
# ----------------------------------------------------------------------------

CURVES = f"{ROOT}/curves"
#: quantity -> axis, unit, what it is
QUANTITIES = {
    "torque": ("section", "N*m", "torque, stiffness and damping part"),
    "stress": ("section", "Pa", "shear stress, torque over section modulus"),
    "twist": ("section", "rad", "twist, first end less second"),
    "angle": ("station", "rad", "vibration relative to uniform rotation"),
    "angular_speed": ("station", "rad/s", "speed of that vibration"),
    "angular_acceleration": ("station", "rad/s^2", "acceleration of that vibration"),
}


def _of_curves(name: str, axis: str, unit: str, words: str) -> tuple[Entry, ...]:
    over, by_order, point = f"{axis} speed", f"{axis} curve_order", "measured_point"
    return under(
        f"{CURVES}/{name}",
        entry("order", f"{by_order} speed", unit, words, PEAK),
        entry("half_range", over, unit, f"{words}; half range of all orders"),
        entry("peak", over, unit, f"{words}; largest magnitude of all, without mean"),
        entry("sum", over, unit, f"{words}; sum of the magnitudes of all orders"),
        entry("largest", by_order, unit, "amplitude of the order at any speed of the range"),
        entry("largest_speed", by_order, "rad/s", "where that is"),
        entry(f"measured/{axis}", point, "", f"the {axis}, counted from 1"),
        entry("measured/speed", point, "rad/s", "crank speed of the point"),
        entry("measured/order", point, "", "its order; 0: half range of all orders"),
        entry("measured/value", point, unit, "as measured"),
        entry("measured/computed", point, unit, "computed at that speed"),
    )


CURVE_ENTRIES = (
    *(one for name, rest in QUANTITIES.items() for one in _of_curves(name, *rest)),
    entry(f"{CURVES}/stress/allowed", "section speed", "Pa",
          "for continuous operation, by the strictest limit of the section; infinite without one"),
    entry(f"{CURVES}/stress/transient", "section speed", "Pa",
          "for passing through, by the strictest one; infinite without one"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# How evenly stations turn, and the worst of conditions of the cylinders: all fire, each misfires,
# pressures differ.
# ----------------------------------------------------------------------------

IRREGULARITY, CONDITIONS = f"{ROOT}/irregularity", f"{ROOT}/conditions"
_DEGREE = "(highest - lowest) / mean of the angular speed over the cycle"
_ELECTRICAL = "vibration times pole pairs of the generator, half range"
_WORST = "half range, in the condition where it is largest"

IRREGULARITY_ENTRIES = under(
    IRREGULARITY,
    entry("degree", "station", "", _DEGREE,
          headline=Headline("cyclic irregularity at operating speed")),
    entry("electrical_angle", "station", "rad", _ELECTRICAL),
    entry("speeds/degree", "station speed", "", _DEGREE, curve="cyclic_irregularity",
          name="cyclic irregularity"),
    entry("speeds/electrical_angle", "station speed", "rad", _ELECTRICAL,
          curve="cyclic_irregularity"),
    entry("largest/degree", "station", "", _TOP,
          headline=Headline("largest cyclic irregularity",
                            at=f"{IRREGULARITY}/largest/speed")),
    entry("largest/speed", "station", "rad/s", "where that is"),
)  # fmt: skip
_WORST_STRESS = Headline(
    "largest stress, worst condition",
    "N/mm^2",
    at=f"{CONDITIONS}/largest/section_speed",
    words=f"{_REPORT}:most_stressed_in_condition",
)
_OF_CONDITIONS = (
    ("torque", "section", "N*m"),
    ("stress", "section", "Pa"),
    ("angle", "station", "rad"),
)
CONDITION_ENTRIES = under(
    CONDITIONS,
    *(entry(f"{of}_half_range", f"condition {axis}", unit, f"{_HERE}, {_HALF}")
      for of, axis, unit in _OF_CONDITIONS),
    entry("irregularity", "condition station", "", f"{_HERE}, {_DEGREE}"),
    entry("gear_minimum_torque", "condition gear", "N*m", f"{_HERE}, {_LEAST_OF_GEAR}"),
    entry("mean_torque", "condition", "N*m", "of all cylinders at that speed"),
    *(entry(f"speeds/{of}_half_range", f"{axis} speed", unit, _WORST,
            curve="worst_condition" * (of != "torque"))
      for of, axis, unit in _OF_CONDITIONS),
    *(entry(f"largest/{of}_half_range", axis, unit, "in any condition at any speed",
            headline=_WORST_STRESS if of == "stress" else None)
      for of, axis, unit in _OF_CONDITIONS),
    *(one for axis in ("section", "station") for one in (
        entry(f"largest/{axis}_speed", axis, "rad/s", "where that is"),
        entry(f"largest/{axis}_condition", axis, "", "and in which condition, counted from 1"),
    )),
)  # fmt: skip

# ----------------------------------------------------------------------------
# All of them, their axes, and what other folders read of them.
# ----------------------------------------------------------------------------

NAMES = {
    "order_class": ("major", "other"),
    "design_value": ("inertia", "stiffness", "damping"),
}
#: axis name -> (unit, long name)
AXES = {
    "station": ("", "station of the shaft line"),
    "section": ("", "shaft, elastic gear or damper of the line"),
    "freedom": ("", "group of stations that turn together, or a ring, along the line"),
    "damper": ("", "damper of the line"),
    "gear": ("", "gear of the line"),
    "hammering": ("", "range of speeds in which a gear hammers"),
    "order_class": ("", "major: the cylinders of each bank in phase; other: not"),
    "mode_without_dampers": ("", "mode of the line without dampers, lowest first"),
    "limit": ("", "limit of the case, the first is 1"),
    "crank_place": ("", "place of a crank throw"),
    "barred": ("", "range of speeds to be passed through, ascending"),
    "exceeded": ("", "range of speeds above a limit, by limit, ascending"),
    **study_results.AXES,
    "curve_order": ("", "order that is kept, multiple of crank speed, also halves"),
    "measured_point": ("", "measured point, in the order of the case"),
    "condition": ("", "condition of the cylinders"),
    "coupling": ("", "elastic coupling of the line"),
    "coupling_limit": ("", "limit of a coupling by DIN 740-2"),
}
ENTRIES = (
    *(*EXCITATION, *entries_of(PowerBalance), *MODES, *DAMPING, *STEADY),
    *(*SPEEDS, *LIMITS, *BARRED, *BY_SECTION, *EXCEEDED, *VARIANTS, *study_results.ENTRIES),
    *(*CURVE_ENTRIES, *IRREGULARITY_ENTRIES, *CONDITION_ENTRIES, *COUPLING_ENTRIES),
)
#: results that are found over a range of speeds
_OVER_RANGE = (
    *("/speeds/", "/resonances_skipped/", "/largest", "/peak/", "/without_dampers/"),
    *("/barred/", "/exceeded/"),
    *("/reduction", "/hammering/", "/campbell/", "/separation/range/"),
)
#: folders of stages of their own
_OWN_STAGES = tuple(
    f"{ROOT}/{name}/"
    for name in (
        *("curves", "irregularity", "conditions", "transient", "variable_inertia"),
        *("as_published", "friction_damper"),
    )
)


def over_range(path: str) -> bool:
    """Whether a result is found over a range of speeds, not at the operating one."""
    _, _, of_limit = path.partition("/limit/")
    if of_limit:
        here = of_limit.startswith(("operating", "basis/", "crank/"))
        return not here or of_limit == "crank/acceptability"
    return any(word in path for word in _OVER_RANGE)


def of_line(ranged: bool) -> Iterator[str]:
    """Paths of the line itself, over the range or at the operating speed."""
    own = (one.path for one in ENTRIES if one.path.startswith(f"{ROOT}/"))
    every = (path for path in own if not path.startswith(_OWN_STAGES))
    return (path for path in every if over_range(path) == ranged)


JUDGE = "vibecalc.torsion.report.limits:limit_verdicts"
HELPS = {f"{ROOT}/": (CANCELS, RESONANCE), study_results.DESIGN: (CANCELS,)}
#: curves over the speeds below a folder and the results that a bound on all of one is held against
_EXTREMES = (
    *((ROOT, name) for name in FOLLOWED),
    *((f"{ROOT}{of}", f"{load}_half_range")
      for of in ("", "/without_dampers", "/healthy", "/conditions")
      for load in ("torque", "stress")),
    *((CONDITIONS, "angle_half_range"), (IRREGULARITY, "degree")),
    *((COUPLING, name) for name in LARGEST),
)  # fmt: skip
EXTREMES = {
    **{
        (f"{root}/speeds/{name}", "min" if "minimum" in name else "max"): f"{root}/largest/{name}"
        for root, name in _EXTREMES
    },
    **{(f"{CURVES}/{name}/order", "max"): f"{CURVES}/{name}/largest" for name in QUANTITIES},
    (f"{COUPLING}/speeds/utilisation", "max"): f"{COUPLING}/largest_utilisation",
}
