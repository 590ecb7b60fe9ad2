"""Every result of a shaft line: path, unit, axes, long name."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, lead, named, q
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
)
from vibecalc.torsion import curve_results, study_results
from vibecalc.torsion.coupling_results import COUPLING, COUPLING_AXES, COUPLING_ENTRIES, LARGEST

# ----------------------------------------------------------------------------
# Results of a shaft line: modes, what the cylinders do to it, and its vibration at one speed.
#
# Angles and torques are actual ones, of the shaft they belong to. An amplitude of an order is
# 0-to-peak; a half range is (highest - lowest) / 2 over the cycle of all orders together, without
# the mean.
# ----------------------------------------------------------------------------

ROOT = "response/torsion"
_BY_MODE = "mode half_order"

_OF_MODES = (
    ("frequency_error", "mode", "rad/s", "error estimate of each natural frequency"),
    ("damping_ratio", "mode", "", "of the damped pole, or as given by mode; 1: overdamped"),
    ("undamped_frequency", "mode", "rad/s",
     "of the line without any damping, the rings of its dampers free, by their own numbers"),
    ("transfer_matrix_frequency", "mode", "rad/s",
     "undamped, by transfer matrix and mode count, in branched lines no second way; without "
     "closed loops of shafts only"),
    ("shape", "mode station", "",
     "own angle; the largest freedom is 1, with a damper the largest that is no ring"),
    ("ring_shape", "mode damper", "", "the same, of the rings of dampers"),
    ("modal_inertia", "mode", "kg*m^2",
     "sum of inertia times squared magnitude of that shape, referred to the crankshaft"),
    ("strain_energy_share", "mode section", "", "of the section in the energy of the mode"),
    ("holzer_angle", "mode freedom", "",
     "Holzer table, undamped: referred angle, 1 in its first row"),
    ("holzer_inertia_torque", "mode freedom", "N*m", "Holzer table: J w^2 times the angle"),
    ("holzer_torque", "mode freedom", "N*m", "Holzer table: running sum of the torques"),
)  # fmt: skip
MODES = (
    entry(f"{ROOT}/modes/natural_frequency", "mode", "rad/s",
          "with a damper the magnitude of the pole, else undamped; 0: it does not vibrate",
          headline=Headline("natural frequency, elastic mode", "Hz", pick="elastic")),
    *(
        entry(f"{ROOT}/modes/{name}", *rest, diagnostic=name == "frequency_error")
        for name, *rest in _OF_MODES
    ),
    entry(f"{ROOT}/modes/holzer_residual", "mode", "N*m",
          "Holzer table: sum of the last row; a mode closes at 0", exempt=CHECK, diagnostic=True),
)  # fmt: skip

EXCITATION = (
    entry(f"{ROOT}/excitation/pressure", "crank_angle", "Pa",
          "gauge pressure in a healthy cylinder from its firing position on"),
    entry(f"{ROOT}/excitation/gas_torque", "crank_angle", "N*m", "of that cylinder's gas"),
    entry(f"{ROOT}/excitation/inertia_torque", "crank_angle", "N*m", "of its moving masses"),
    entry(f"{ROOT}/excitation/total_torque", "crank_angle", "N*m", "of both"),
    entry(f"{ROOT}/excitation/engine_torque", "crank_angle", "N*m",
          "of all cylinders, from the first firing on, referred to the crankshaft"),
    entry(f"{ROOT}/excitation/gas", "half_order", "N*m", "gas torque of one cylinder", PEAK),
    entry(f"{ROOT}/excitation/inertia", "half_order", "N*m", "inertia torque of one", PEAK),
    entry(f"{ROOT}/excitation/total", "half_order", "N*m", "torque of one cylinder", PEAK),
    entry(f"{ROOT}/excitation/tangential_pressure", "half_order", "Pa",
          "total torque of one cylinder over piston area and crank radius", PEAK),
    entry(f"{ROOT}/excitation/power", "", "W", "indicated, of all cylinders",
          headline=Headline("power, indicated", "kW")),
    entry(f"{ROOT}/excitation/mean_torque", "", "N*m", "of all cylinders",
          headline=Headline("torque of the engine, mean", "N*m")),
    entry(f"{ROOT}/excitation/mean_indicated_pressure", "", "Pa", "of a healthy cylinder"),
    entry(f"{ROOT}/excitation/firing_angle", "cylinder", "rad", "crank angle at which it fires",
          circle=CYCLE),
    entry(f"{ROOT}/excitation/station_torque", "station half_order", "N*m",
          "of all cylinders of a station, phases in it", PEAK),
    entry(f"{ROOT}/excitation/vector_sum", _BY_MODE, "",
          "sum of phase vectors of a mode over that of all in line; 0: no cylinder moves"),
    entry(f"{ROOT}/excitation/intensity", _BY_MODE, "N*m",
          "torque on the mode, sum of shape times torque; the shape as under modes", PEAK),
    entry(f"{ROOT}/excitation/rank", _BY_MODE, "",
          "place of the order in the mode by its vector sum, 1 for the largest; 0: they cancel"),
    entry(f"{ROOT}/excitation/major", "half_order", "",
          "1: the cylinders of each bank in phase, and the banks do not cancel; 0: not"),
    entry(f"{ROOT}/excitation/bank_factor", "half_order", "",
          "what the angle between the banks leaves of their sums; 1: all of it"),
)  # fmt: skip

_SECTION = "section half_order"
STEADY = (
    entry(f"{ROOT}/angle", "station half_order", "rad", "vibration of the station", PEAK),
    entry(f"{ROOT}/twist", _SECTION, "rad", "of the section, first end less second", PEAK),
    entry(f"{ROOT}/torque", _SECTION, "N*m", "stiffness and damping part together", PEAK),
    entry(f"{ROOT}/stress", _SECTION, "Pa", "shear, torque over section modulus", PEAK),
    entry(f"{ROOT}/angle_half_range", "station", "rad", "half range of all orders"),
    entry(f"{ROOT}/angle_peak", "station", "rad", "largest magnitude of all orders"),
    entry(f"{ROOT}/twist_half_range", "section", "rad", "half range of all orders"),
    entry(f"{ROOT}/twist_peak", "section", "rad", "largest magnitude of all orders"),
    entry(f"{ROOT}/torque_half_range", "section", "N*m", "half range of all orders",
          headline=Headline("vibratory torque at speed, half range", "N*m")),
    entry(f"{ROOT}/torque_peak", "section", "N*m", "largest magnitude, mean torque in it"),
    entry(f"{ROOT}/torque_bound", "section", "N*m", "sum of the magnitudes of all orders"),
    entry(f"{ROOT}/torque_mean", "section", "N*m", "steady torque that the section carries"),
    entry(f"{ROOT}/stress_half_range", "section", "Pa", "half range of all orders",
          headline=Headline("vibratory stress at speed, half range", "N/mm^2")),
    entry(f"{ROOT}/section_heat", "section", "W", "dashpots and loss factors, mean power"),
    entry(f"{ROOT}/station_heat", "station", "W",
          "absolute damping, mean power; with a damping model also that of a ring it carries"),
    entry(f"{ROOT}/modal_heat", "mode", "W",
          "mean power of damping ratios given by mode, at no place in the line"),
    entry(f"{ROOT}/damper/heat", "damper", "W", "mean power",
          headline=Headline("heat in a damper at speed, mean", "W")),
    entry(f"{ROOT}/damper/travel", "damper", "rad",
          "of the ring against its station, largest magnitude of all orders"),
    entry(f"{ROOT}/gear/mean_torque", "gear", "N*m", "on the first wheel"),
    entry(f"{ROOT}/gear/alternating_torque", "gear", "N*m", "on the first wheel, half range"),
    entry(f"{ROOT}/gear/minimum_torque", "gear", "N*m", "over the cycle, mean in it",
          headline=Headline("minimum torque of a gear (below 0: hammers)", "N*m", pick="least")),
    entry(f"{ROOT}/gear/hammers", "gear", "", "1: its torque changes sign; 0: it does not",
          name="gear teeth part at speed (1: yes)"),
    entry(f"{ROOT}/margin/nearest_order", "mode", "",
          "excited order nearest to the mode at the operating speed; 0: none is near"),
    entry(f"{ROOT}/margin/distance", "mode", "",
          "of the natural frequency from that order's, over the latter; infinite without one"),
    entry(f"{ROOT}/separation/operating/margin", "mode order_class", "",
          "the same to the nearest major and the nearest other order"),
    entry(f"{ROOT}/separation/operating/half_order", "mode order_class", "",
          "that order; 0: none is near"),
    entry(f"{ROOT}/separation/operating/sufficient", "mode order_class", "",
          "1: as far from every order as the rule of the case asks; 0: not"),
)  # fmt: skip


@dataclass(frozen=True)
class PowerBalance:
    """Mean torques on their own shafts and mean powers at the operating speed."""

    ROOT: ClassVar[str] = f"{ROOT}/power_balance"
    source_torque: Any = named("station", "N*m", "mean torque of cylinders")
    source_power: Any = named("station", "W", "mean power of cylinders")
    load_torque: Any = named("station", "N*m", "mean torque that a load takes")
    load_power: Any = named("station", "W", "mean power that a load takes")
    rest_torque: Any = q(
        "", "N*m", "mean torque that the load station takes on top to balance the line; below 0 it "
        "gives", name="mean torque left for the load station",
    )  # fmt: skip
    rest_power: Any = q("", "W", "of that torque", name="mean power left for the load station")
    total_load_power: Any = lead("", "W", "power, all loads")
    load_share: Any = lead(
        "",
        "",
        "power of all loads over indicated",
        about="the mechanical efficiency if what is left is friction; infinite where the cylinders "
        "give nothing",
    )


#: where dampings follow the speed, a load or a mode
DAMPING = (
    entry(f"{ROOT}/damping/station", "station", "N*m*s/rad",
          "absolute, at the operating speed, on its own shaft"),
    entry(f"{ROOT}/damping/section", "section", "N*m*s/rad",
          "viscous, of the twist, at the operating speed, on its own shaft"),
    entry(f"{ROOT}/damping/loss_factor", "section", "", "of its stiffness, at the operating speed"),
)  # fmt: skip

TORSION_ENTRIES = (*EXCITATION, *entries_of(PowerBalance), *MODES, *DAMPING, *STEADY)

# ----------------------------------------------------------------------------
# Results of a shaft line over a range of crank speeds: curves, criticals, limits, barred ranges.
#
# A value is infinite at a speed where an order meets a natural frequency that nothing damps.
# ----------------------------------------------------------------------------

_CURVE = "section speed"
_MAY_BE_BARRED = (
    "1: it may be barred; 0: it holds the operating speed, or the rule lets none be barred there, "
    "from lambda = 0.8 on"
)
#: curve over the speeds -> axis of what it is of: the largest, or least, of each at any speed
FOLLOWED = {
    "angle_half_range": "station",
    "twist_peak": "section",
    "torque_peak": "section",
    "travel": "damper",
    "heat": "damper",
    "gear_torque": "gear",
    "gear_minimum_torque": "gear",
}


def _extremes(name: str, axis: str, unit: str, words: str, headline: str = "") -> tuple[Entry, ...]:
    path, read = f"{ROOT}/largest/{name}", {"W": "W"}.get(unit, "N*m")
    pick = "least" if "minimum" in name else "largest"
    leads = Headline(headline, read, pick, at=f"{path}_speed") if headline else None
    return (
        entry(path, axis, unit, f"{words}, at any speed of the range", headline=leads),
        entry(f"{path}_speed", axis, "rad/s", "where that is", exempt=PLACE),
    )


TORSION_SPEEDS_ENTRIES = (
    entry(f"{ROOT}/critical/speed", "mode half_order", "rad/s",
          "speed at which the order meets the natural frequency, also outside of the range; "
          "0: the mode does not vibrate; infinite: no response peaks"),
    entry(f"{ROOT}/speeds/angle_half_range", "station speed", "rad", "half range of all orders",
          curve="station_angles"),
    entry(f"{ROOT}/speeds/twist_half_range", _CURVE, "rad", "half range of all orders"),
    entry(f"{ROOT}/speeds/twist_peak", _CURVE, "rad", "largest magnitude of all orders"),
    entry(f"{ROOT}/speeds/torque_half_range", _CURVE, "N*m", "half range of all orders"),
    entry(f"{ROOT}/speeds/torque_peak", _CURVE, "N*m", "largest magnitude, mean torque in it"),
    entry(f"{ROOT}/speeds/stress_half_range", _CURVE, "Pa", "half range of all orders",
          curve="section_stress"),
    entry(f"{ROOT}/speeds/station_damping", "station speed", "N*m*s/rad",
          "absolute, on its own shaft, where it follows the speed", curve="damping_over_speed"),
    entry(f"{ROOT}/speeds/section_damping", _CURVE, "N*m*s/rad",
          "viscous, of the twist, where it follows the speed", curve="damping_over_speed"),
    entry(f"{ROOT}/speeds/section_loss_factor", _CURVE, "", "where it follows the speed",
          curve="damping_over_speed"),
    entry(f"{ROOT}/speeds/mean_torque", "speed", "N*m", "of all cylinders"),
    entry(f"{ROOT}/speeds/gear_mean_torque", "gear speed", "N*m", "on the first wheel",
          curve="gear_torque"),
    entry(f"{ROOT}/speeds/gear_torque", "gear speed", "N*m", "on the first wheel, half range",
          curve="gear_torque"),
    entry(f"{ROOT}/speeds/gear_minimum_torque", "gear speed", "N*m",
          "over the cycle, in the sense of its mean; below 0 the teeth leave each other",
          curve="gear_torque"),
    entry(f"{ROOT}/speeds/gear_hammers", "gear speed", "",
          "1: its torque changes sign; 0: it does not",
          name="gear teeth part over the speeds (1: yes)"),
    entry(f"{ROOT}/hammering/from", "hammering", "rad/s", "a gear hammers from here"),
    entry(f"{ROOT}/hammering/to", "hammering", "rad/s", "to here"),
    entry(f"{ROOT}/hammering/gear", "hammering", "", "this gear, counted from 1"),
    entry(f"{ROOT}/campbell/natural_frequency", "mode speed", "rad/s",
          "as under modes, where pendulums let it follow the speed"),
    entry(f"{ROOT}/separation/range/margin", "mode order_class", "",
          "least distance to an order within the speeds, over its nearer end; below 0: it is met"),
    entry(f"{ROOT}/separation/range/half_order", "mode order_class", "", "that order; 0: none"),
    entry(f"{ROOT}/separation/range/sufficient", "mode order_class", "",
          "1: as far from every order as the rule of the case asks; 0: not"),
    entry(f"{ROOT}/masked/from", "masked", "rad/s", "nothing damps a mode from here"),
    entry(f"{ROOT}/masked/to", "masked", "rad/s", "to here"),
    entry(f"{ROOT}/masked/mode", "masked", "", "the mode"),
    entry(f"{ROOT}/masked/half_order", "masked", "", "and the order that meets it"),
    entry(f"{ROOT}/largest/torque_half_range", "section", "N*m", "at any speed of the range",
          headline=Headline("vibratory torque over the speeds, half range", "N*m",
                   at="response/torsion/largest/speed")),
    entry(f"{ROOT}/largest/twist_half_range", "section", "rad", "there"),
    entry(f"{ROOT}/largest/stress_half_range", "section", "Pa", "there",
          headline=Headline("vibratory stress over the speeds, half range", "N/mm^2",
                   at="response/torsion/largest/speed")),
    entry(f"{ROOT}/largest/speed", "section", "rad/s", "where that is"),
    entry(f"{ROOT}/largest/mode", "section", "", "mode that resonates there; 0: none"),
    entry(f"{ROOT}/largest/half_order", "section", "", "and order; 0: none"),
    entry(f"{ROOT}/speeds/heat", "damper speed", "W", "mean power",
          headline=Headline("heat in a damper over the speeds, largest", "W",
                            unless="response/torsion/largest/heat")),
    entry(f"{ROOT}/speeds/travel", "damper speed", "rad", "ring on station, largest magnitude"),
    *_extremes("angle_half_range", "station", "rad", "half range of all orders"),
    *_extremes("twist_peak", "section", "rad", "largest magnitude"),
    *_extremes("torque_peak", "section", "N*m", "largest magnitude, mean torque in it"),
    *_extremes("heat", "damper", "W", "mean power", "heat in a damper over the speeds, largest"),
    *_extremes("travel", "damper", "rad", "ring on station, largest magnitude"),
    *_extremes("gear_torque", "gear", "N*m", "on the first wheel, half range"),
    *_extremes("gear_minimum_torque", "gear", "N*m",
               "over the cycle, in the sense of its mean; below 0 the teeth leave each other"),
    entry(f"{ROOT}/peak/speed", "peak", "rad/s", "maximum of a section's curve"),
    entry(f"{ROOT}/peak/torque_half_range", "peak", "N*m", "there, in that section"),
    entry(f"{ROOT}/peak/section", "peak", "",
          "that section, counted from 1: the one of most torque, then that of most stress"),
    entry(f"{ROOT}/peak/mode", "peak", "", "mode that resonates there; 0: none"),
    entry(f"{ROOT}/peak/half_order", "peak", "", "and order; 0: none"),
    entry(f"{ROOT}/limit/allowed", "limit speed", "Pa",
          "for lasting, in the section of largest use; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/transient", "limit speed", "Pa",
          "for passing through, there; infinite where the limit has none"),
    entry(f"{ROOT}/limit/torque_allowed", "limit speed", "N*m",
          "for lasting, of limits of the torque, in the section or gear of largest use"),
    entry(f"{ROOT}/limit/torque_transient", "limit speed", "N*m",
          "for passing through, there; infinite where the limit has none"),
    entry(f"{ROOT}/limit/largest_use", "limit", "",
          "largest stress or torque over allowed, at any speed",
          headline=Headline("use of a limit over the speeds",
                   at="response/torsion/limit/speed")),
    entry(f"{ROOT}/limit/speed", "limit", "rad/s", "where that is"),
    entry(f"{ROOT}/limit/section", "limit", "", "in this section, counted from 1; 0: in a gear"),
    entry(f"{ROOT}/limit/gear", "limit", "", "in this gear, counted from 1; 0: in a section"),
    entry(f"{ROOT}/limit/operating_use", "limit", "",
          "stress or torque over allowed at the operating speed",
          headline=Headline("use of a limit at speed")),
    entry(f"{ROOT}/limit/transient_use", "limit", "",
          "largest stress or torque over that for passing through; 0: the limit has none",
          name="use of a limit for passing through"),
    entry(f"{ROOT}/barred/from", "barred", "rad/s",
          "barred for lasting operation from here: by the formula of a rule where that is wider "
          "than the range above the limit; ranges that overlap are one",
          headline=Headline("no lasting operation from", "rpm", pick="each")),
    entry(f"{ROOT}/barred/to", "barred", "rad/s", "to here",
          headline=Headline("no lasting operation to", "rpm", pick="each",
                            words="vibecalc.torsion.report.limits:acceptable")),
    entry(f"{ROOT}/barred/permitted", "barred", "", _MAY_BE_BARRED),
    entry(f"{ROOT}/exceeded/from", "exceeded", "rad/s", "more than allowed for lasting from here"),
    entry(f"{ROOT}/exceeded/to", "exceeded", "rad/s", "to here"),
    entry(f"{ROOT}/exceeded/limit", "exceeded", "", "above this limit, counted from 1"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of a shaft line against limits, section by section, and barred ranges by formula.
#
# The section axis holds the shafts, and behind them the gears, that some limit is for; a value is 0
# where a limit is not for the section, or has no such number.
# ----------------------------------------------------------------------------

_EACH = "limit section"
_CRANK = "limit section crank_place"
_HERE = "at the operating speed"

TORSION_LIMITS_ENTRIES = (
    entry(f"{ROOT}/limit/basis/rated_speed", "limit", "rad/s", "that a rule counts from"),
    entry(f"{ROOT}/limit/basis/diameter", _EACH, "m", "outer, of the stressed section"),
    entry(f"{ROOT}/limit/basis/tensile_strength", _EACH, "Pa", "of the material, as given"),
    entry(f"{ROOT}/limit/basis/counted_strength", _EACH, "Pa", "as a rule counts it"),
    entry(f"{ROOT}/limit/basis/size_factor", _EACH, "", "c_D of a rule"),
    entry(f"{ROOT}/limit/basis/design_factor", _EACH, "", "c_K of a rule"),
    entry(f"{ROOT}/limit/operating/stress", _EACH, "Pa", f"half range of all orders, {_HERE}"),
    entry(f"{ROOT}/limit/operating/allowed", _EACH, "Pa",
          f"for lasting, {_HERE}; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/operating/transient", _EACH, "Pa",
          f"for passing through, {_HERE}; infinite where the limit has none"),
    entry(f"{ROOT}/limit/operating/torque", _EACH, "N*m", f"half range of all orders, {_HERE}"),
    entry(f"{ROOT}/limit/operating/torque_allowed", _EACH, "N*m",
          f"for lasting, {_HERE}; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/operating/torque_transient", _EACH, "N*m",
          f"for passing through, {_HERE}; infinite where the limit has none"),
    entry(f"{ROOT}/limit/operating/use", _EACH, "",
          f"stress or torque over allowed for lasting, {_HERE}"),
    entry(f"{ROOT}/limit/each/use", _EACH, "",
          "largest stress or torque over allowed, at any speed"),
    entry(f"{ROOT}/limit/each/speed", _EACH, "rad/s", "where that is"),
    entry(f"{ROOT}/limit/each/speed_ratio", _EACH, "", "lambda: that speed over the rated one"),
    entry(f"{ROOT}/limit/each/stress", _EACH, "Pa", "there"),
    entry(f"{ROOT}/limit/each/allowed", _EACH, "Pa",
          "for lasting, there; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/each/transient", _EACH, "Pa",
          "for passing through, there; infinite where the limit has none"),
    entry(f"{ROOT}/limit/each/torque", _EACH, "N*m", "there"),
    entry(f"{ROOT}/limit/each/torque_allowed", _EACH, "N*m",
          "for lasting, there; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/each/torque_transient", _EACH, "N*m",
          "for passing through, there; infinite where the limit has none"),
    entry(f"{ROOT}/limit/each/transient_use", _EACH, "",
          "largest over what is allowed for passing through, at any speed; 0: the limit has none"),
    entry(f"{ROOT}/limit/crank/bending_factor", _CRANK, "",
          "alpha_B, beta_B, gamma_B: stress concentration in bending"),
    entry(f"{ROOT}/limit/crank/torsion_factor", _CRANK, "",
          "alpha_T, beta_T, gamma_T: stress concentration in torsion"),
    entry(f"{ROOT}/limit/crank/bending_stress", _CRANK, "Pa",
          "alternating, concentrated, the additional one in fillets; 0 without a bore"),
    entry(f"{ROOT}/limit/crank/fatigue_strength", _CRANK, "Pa", "sigma_DW; 0 without a bore"),
    entry(f"{ROOT}/limit/crank/operating_acceptability", _CRANK, "",
          f"Q, fatigue strength over equivalent stress, {_HERE}; 0: no bore, or no end of stress"),
    entry(f"{ROOT}/limit/crank/acceptability", _CRANK, "",
          "the same at the speed of largest use; 1.15 at least is asked for"),
    entry(f"{ROOT}/exceeded/peak_speed", "exceeded", "rad/s",
          "of the largest use inside the range", exempt=PLACE),
    entry(f"{ROOT}/exceeded/formula_from", "exceeded", "rad/s",
          "16 n_c / (18 - lambda) of the rule, n_c the peak; 0: a limit without such a formula"),
    entry(f"{ROOT}/exceeded/formula_to", "exceeded", "rad/s", "(18 - lambda) n_c / 16 of the rule"),
    entry(f"{ROOT}/exceeded/permitted", "exceeded", "", _MAY_BE_BARRED),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of the same shaft line in another state: without its dampers, or with all gas.
#
# Names and meanings are those of the line itself.
# ----------------------------------------------------------------------------

_BARE, _HEALTHY = "the line without its dampers", "all cylinders firing"


def _half_ranges(place: str, words: str) -> tuple[Entry, ...]:
    here, top = f"{words}, at the operating speed", f"{words}, at any speed of the range"
    return (
        entry(f"{place}/torque_half_range", "section", "N*m", here),
        entry(f"{place}/twist_half_range", "section", "rad", here),
        entry(f"{place}/stress_half_range", "section", "Pa", here),
        entry(f"{place}/speeds/torque_half_range", _CURVE, "N*m", words),
        entry(f"{place}/speeds/twist_half_range", _CURVE, "rad", words),
        entry(f"{place}/speeds/stress_half_range", _CURVE, "Pa", words),
        entry(f"{place}/largest/torque_half_range", "section", "N*m", top),
        entry(f"{place}/largest/twist_half_range", "section", "rad", "there"),
        entry(f"{place}/largest/stress_half_range", "section", "Pa", "there"),
        entry(f"{place}/largest/speed", "section", "rad/s", "where that is"),
    )


def limit_uses(
    place: str, axes: str, words: str, headline: Headline | None = None
) -> tuple[Entry, ...]:
    """Uses of limits in a condition, with the load that has the largest one."""
    use = f"stress or torque over allowed{words}"
    load = "section, counted from 1, gears behind them; 0: the limit says nothing"
    return (
        entry(f"{place}/operating_use", axes, "", f"{use}, {_HERE}",
              name="use of a limit at speed, worst condition"),
        entry(f"{place}/largest_use", axes, "", f"{use}, largest at any speed", headline=headline),
        entry(f"{place}/speed", axes, "rad/s", "where that is"),
        entry(f"{place}/unbarred_use", axes, "",
              "largest at speeds that no barred range may hold: the operating one, and for a rule "
              "those from lambda = 0.8 on"),
        *(one for start, at in (("", "at the largest use"), ("operating_", _HERE)) for one in (
            entry(f"{place}/{start}element", axes, "", f"{load}, {at}"),
            entry(f"{place}/{start}allowed", axes, "Pa",
                  f"stress for lasting in it, {at}; infinite for limits of the torque"),
            entry(f"{place}/{start}torque_allowed", axes, "N*m",
                  f"torque for lasting in it, {at}; infinite for limits of the stress"),
        )),
    )  # fmt: skip


TORSION_VARIANTS_ENTRIES = (
    *_half_ranges(f"{ROOT}/bare", _BARE),
    entry(f"{ROOT}/bare/natural_frequency", "bare_mode", "rad/s", "without its dampers"),
    entry(f"{ROOT}/reduction", "section", "", "largest torque without dampers over that with them",
          headline=Headline("torque without dampers over that with them", pick="least")),
    *_half_ranges(f"{ROOT}/healthy", _HEALTHY),
    entry(f"{ROOT}/healthy/mean_torque", "", "N*m", "of all cylinders, all firing"),
    entry(f"{ROOT}/healthy/damper/heat", "damper", "W", f"mean power, {_HEALTHY}"),
    entry(f"{ROOT}/healthy/damper/travel", "damper", "rad", f"largest magnitude, {_HEALTHY}"),
    *limit_uses(f"{ROOT}/healthy/limit", "limit", f", {_HEALTHY}"),
    *limit_uses(f"{ROOT}/conditions/limit", "condition limit", "",
                headline=Headline("use of a limit, worst condition",
                                  at=f"{ROOT}/conditions/limit/speed")),
)  # fmt: skip

NAMES = {
    "order_class": ("major", "other"),
    "design_value": ("inertia", "stiffness", "damping"),
}
#: axis name -> (unit, long name)
AXES = {
    "station": ("", "station of the shaft line"),
    "section": ("", "shaft, elastic gear or damper of the line"),
    "freedom": ("", "stations that turn together, or a ring, along the line"),
    "damper": ("", "damper of the line"),
    "gear": ("", "gear of the line"),
    "hammering": ("", "range of speeds in which a gear hammers"),
    "order_class": ("", "major: the cylinders of each bank in phase; other: not"),
    "bare_mode": ("", "mode of the line without dampers, lowest first"),
    "limit": ("", "limit of the case, the first is 1"),
    "crank_place": ("", "place of a crank throw"),
    "barred": ("", "range of speeds to be passed through, ascending"),
    "exceeded": ("", "range of speeds above a limit, by limit, ascending"),
    "elastic_mode": ("", "number of the mode, the rigid one is 1"),
    "variable_speed": ("rad/s", "crank speed, criticals among the steps"),
    "wedge": ("", "sum resonance of the inertia, widest first"),
    "unstable": ("", "range of speeds in which vibration grows, ascending"),
    "transient_time": ("s", "middle of a whole cycle of the machine"),
    "history_time": ("s", "time"),
    "clutch_time": ("s", "time"),
    "range_bin": ("", "bin of the ranges of a section, the largest last"),
    "waterfall_time": ("s", "middle of a window of time"),
    "waterfall_frequency": ("rad/s", "frequency"),
    "design_value": ("", "value of the damper"),
    "basin": ("", "end of a search, the best first"),
    "stiffness_factor": ("", "stiffness over that of the damper found"),
    "damping_factor": ("", "damping over that of the damper found"),
    "chart_stiffness": ("N*m/rad", "stiffness of the damper's springs"),
    "chart_damping": ("N*m*s/rad", "damping of the damper"),
    "ring_inertia": ("kg*m^2", "inertia of the ring"),
    "damper_curve": ("", "damper that the curve is of"),
    **curve_results.CURVE_AXES,
    **COUPLING_AXES,
}
ENTRIES = (
    *TORSION_ENTRIES,
    *TORSION_SPEEDS_ENTRIES,
    *TORSION_LIMITS_ENTRIES,
    *TORSION_VARIANTS_ENTRIES,
    *study_results.ENTRIES,
    *curve_results.EVERY,
    *COUPLING_ENTRIES,
)
#: results that are found over a range of speeds
_OVER_RANGE = (
    *("/speeds/", "/masked/", "/largest", "/peak/", "/bare/", "/barred/", "/exceeded/"),
    *("/reduction", "/hammering/", "/campbell/", "/separation/range/"),
)
#: folders of stages of their own
_OWN_STAGES = tuple(
    f"{ROOT}/{name}/"
    for name in (
        *("curves", "irregularity", "conditions", "transient", "variable_inertia"),
        "as_published",
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


JUDGE = "vibecalc.torsion.report.verdicts:limit_verdicts"
HELPS = {f"{ROOT}/": (CANCELS, RESONANCE), study_results.DESIGN: (CANCELS,)}

#: curves over the speeds and the results that a bound on all of one is held against
EXTREMES = {
    **{
        (f"{ROOT}/speeds/{name}", "min" if "minimum" in name else "max"): f"{ROOT}/largest/{name}"
        for name in FOLLOWED
    },
    **{
        (f"{ROOT}/{of}speeds/{name}_half_range", "max"): f"{ROOT}/{of}largest/{name}_half_range"
        for of, names in (
            *((of, ("torque", "stress")) for of in ("", "bare/", "healthy/")),
            ("conditions/", ("torque", "stress", "angle")),
        )
        for name in names
    },
    **{
        (f"{curve_results.CURVES}/{name}/order", "max"): f"{curve_results.CURVES}/{name}/largest"
        for name in curve_results.QUANTITIES
    },
    (f"{ROOT}/irregularity/speeds/degree", "max"): f"{ROOT}/irregularity/largest/degree",
    (f"{ROOT}/coupling/speeds/use", "max"): f"{ROOT}/coupling/largest_use",
    **{(f"{COUPLING}/speeds/{name}", "max"): f"{COUPLING}/largest/{name}" for name in LARGEST},
}
