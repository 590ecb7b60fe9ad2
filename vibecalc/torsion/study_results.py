"""Results of studies of a shaft line: modal route, variable inertia, changes in time, damper."""

from vibecalc.core.results.record import CHECK, PEAK, Entry, Headline, entry

#: changes in time from one speed of the crank to another
PASSAGES = ("run_up", "run_down", "start", "stop")
ROOT = "response/torsion"

# ----------------------------------------------------------------------------
# Results of a shaft line next to the steady ones: transients, variable inertia, the modal route.
#
# Torques are actual ones, of the shaft they belong to.
# ----------------------------------------------------------------------------

PUBLISHED, VARIABLE, TRANSIENT = (
    f"{ROOT}/{part}/" for part in ("as_published", "variable_inertia", "transient")
)
_BY_ELASTIC_MODE = "elastic_mode half_order"

AS_PUBLISHED = (
    entry(f"{PUBLISHED}natural_frequency", "elastic_mode", "rad/s", "undamped"),
    entry(f"{PUBLISHED}rayleigh_inertia", "", "1/s", "factor of the inertia in Rayleigh damping"),
    entry(f"{PUBLISHED}rayleigh_stiffness", "", "s", "factor of the stiffness in Rayleigh damping"),
    entry(f"{PUBLISHED}rayleigh_damping_ratio", "elastic_mode", "",
          "that it gives; the twists have the damping ratio of the case"),
    entry(f"{PUBLISHED}intensity", _BY_ELASTIC_MODE, "N*m",
          "sum of shape times torque; the shape is 1 at the first freedom", PEAK),
    entry(f"{PUBLISHED}largest_intensity_order", "elastic_mode", "", "order of the largest"),
    entry(f"{PUBLISHED}static_twist", _BY_ELASTIC_MODE, "rad",
          "intensity over modal stiffness; modal, it follows the scale of the shape", PEAK),
    entry(f"{PUBLISHED}twist", "elastic_mode speed", "rad",
          "modal twist at crank angle zero, all orders, torque of the operating speed"),
    entry(f"{PUBLISHED}twist_magnitude", "elastic_mode speed", "rad",
          "magnitude of the complex sum whose real part that is"),
    entry(f"{PUBLISHED}twist_at_critical", _BY_ELASTIC_MODE, "rad",
          "modal twist at crank angle zero, all orders, on each critical speed"),
    entry(f"{PUBLISHED}largest_twist", "elastic_mode", "rad", "largest magnitude of those"),
    entry(f"{PUBLISHED}largest_twist_order", "elastic_mode", "", "order of that critical speed"),
)  # fmt: skip

_BY_SECTION = "section"
_SPEEDS = "section variable_speed"
VARIABLE_INERTIA = (
    entry(f"{VARIABLE}relative_variation", "station", "",
          "half the range of the inertia over the turn, over its mean"),
    entry(f"{VARIABLE}highest_order", "", "", "of the motion that was kept"),
    entry(f"{VARIABLE}torque", "section half_order", "N*m",
          "exact motion at the operating speed, stiffness and damping part", PEAK),
    entry(f"{VARIABLE}torque_half_range", _BY_SECTION, "N*m", "of the exact motion, all orders"),
    entry(f"{VARIABLE}constant_half_range", _BY_SECTION, "N*m", "with mean inertias, all orders"),
    entry(f"{VARIABLE}change", _BY_SECTION, "", "of the half range, over that with mean inertias"),
    entry(f"{VARIABLE}secondary/twist", "half_order", "rad",
          "what the other orders add in the section that changes most (linear)", PEAK),
    entry(f"{VARIABLE}secondary/source", "half_order", "", "order that adds most; 0: the mean"),
    entry(f"{VARIABLE}secondary/share", "half_order", "", "of that order in the sum of all sizes"),
    entry(f"{VARIABLE}growth", "", "1/s", "of the fastest vibration about it; negative: dies out"),
    entry(f"{VARIABLE}wedge/speed", "wedge", "rad/s",
          "an order of the inertia meets the sum of two natural frequencies"),
    entry(f"{VARIABLE}wedge/half_width", "wedge", "rad/s", "unstable so near to it, undamped"),
    entry(f"{VARIABLE}wedge/order", "wedge", "", "of the inertia"),
    entry(f"{VARIABLE}wedge/first_mode", "wedge", "", "number of the mode, the rigid one is 1"),
    entry(f"{VARIABLE}wedge/second_mode", "wedge", "", "number of the other, or the same"),
    entry(f"{VARIABLE}wedge/growth", "wedge", "1/s", "at its centre, undamped"),
    entry(f"{VARIABLE}wedge/damping_ratio", "wedge", "", "of both modes that removes it"),
    entry(f"{VARIABLE}unstable/from", "unstable", "rad/s", "vibration grows from here, as damped"),
    entry(f"{VARIABLE}unstable/to", "unstable", "rad/s", "to here"),
    entry(f"{VARIABLE}unstable/growth", "unstable", "1/s", "the fastest seen between"),
    entry(f"{VARIABLE}speeds/torque_half_range", _SPEEDS, "N*m", "linear motion, all orders"),
    entry(f"{VARIABLE}speeds/change", _SPEEDS, "",
          "of the half range, over that with mean inertias"),
    entry(f"{VARIABLE}largest_change", _BY_SECTION, "", "of those, in magnitude"),
    entry(f"{VARIABLE}largest_change_speed", _BY_SECTION, "rad/s", "where that is"),
)  # fmt: skip

_WINDOWS = "section transient_time"
_COUNTED = "section range_bin"
_EQUIVALENT = (
    entry(f"{TRANSIENT}equivalent/frequency", _BY_SECTION, "rad/s",
          "at which the dashpot for a loss factor keeps its magnitude"),
    entry(f"{TRANSIENT}equivalent/damping", _BY_SECTION, "N*m*s/rad",
          "of that dashpot, stiffness times loss factor over the frequency"),
)  # fmt: skip
_CLUTCH = (
    entry(f"{TRANSIENT}clutch/slip_time", "", "s", "of all slipping, from its engaging on",
          headline=Headline("clutch slips for", "s")),
    entry(f"{TRANSIENT}clutch/heat", "", "J", "friction torque times slip, of all slipping",
          headline=Headline("heat of the clutch", "kJ")),
    entry(f"{TRANSIENT}clutch/held", "", "s", "time from engaging until it holds, first"),
    entry(f"{TRANSIENT}clutch/common_speed", "", "rad/s",
          "mean speed of the crank then, by the momentum of both parts"),
    entry(f"{TRANSIENT}clutch/engagements", "", "", "how often it begins to hold"),
    entry(f"{TRANSIENT}clutch/use", "", "",
          "largest torque while it holds over its friction torque; 1: where it slips"),
    entry(f"{TRANSIENT}clutch/slip_speed", "clutch_time", "rad/s",
          "of its plates, first end less second, own shaft", curve="clutch_slip"),
)  # fmt: skip
_CYCLES = (
    entry(f"{TRANSIENT}counted/range", _COUNTED, "N*m",
          "largest of the bin, crest less trough of a cycle"),
    entry(f"{TRANSIENT}counted/number", _COUNTED, "", "of cycles in the bin",
          curve="counted_cycles"),
    entry(f"{TRANSIENT}counted/mean", _COUNTED, "N*m", "mean of the cycles in the bin"),
    entry(f"{TRANSIENT}counted/largest_range", _BY_SECTION, "N*m", "of any cycle"),
    entry(f"{TRANSIENT}counted/largest_stress_range", _BY_SECTION, "Pa", "of any cycle, shear"),
    entry(f"{TRANSIENT}counted/equivalent_number", _BY_SECTION, "",
          "of cycles of the largest range that use up as much as all"),
    entry(f"{TRANSIENT}counted/damage", _BY_SECTION, "", "sum of n / N of one change (Miner)"),
    entry(f"{TRANSIENT}counted/damage_of_all", _BY_SECTION, "",
          "of all changes that the case says; 1: the life is used up",
          headline=Headline("fatigue of the changes, sum of Miner", "")),
)  # fmt: skip
_STEPS = (
    entry(f"{TRANSIENT}steady_before", _BY_SECTION, "N*m",
          "largest magnitude of the steady vibration before, mean in it"),
    entry(f"{TRANSIENT}steady_after", _BY_SECTION, "N*m", "and of that which is reached at last"),
    entry(f"{TRANSIENT}dynamic_factor", _BY_SECTION, "", "peak over the larger of those two"),
)  # fmt: skip
_PASSAGES = (
    entry(f"{TRANSIENT}half_range", _WINDOWS, "N*m", "half of high less low"),
    entry(f"{TRANSIENT}quasi_steady", _WINDOWS, "N*m",
          "largest steady half range at the speeds of that cycle"),
    entry(f"{TRANSIENT}peak_half_range", _BY_SECTION, "N*m",
          "largest half range of any cycle, begin it where it may"),
    entry(f"{TRANSIENT}peak_half_range_speed", _BY_SECTION, "rad/s",
          "crank speed midway between its crest and its trough"),
    entry(f"{TRANSIENT}steady_half_range", _BY_SECTION, "N*m",
          "largest steady half range between the same speeds"),
    entry(f"{TRANSIENT}steady_half_range_speed", _BY_SECTION, "rad/s", "crank speed there"),
    entry(f"{TRANSIENT}overshoot", _BY_SECTION, "",
          "largest half range over the steady one, less 1; negative: it has no time to build up"),
    entry(f"{TRANSIENT}lag", _BY_SECTION, "rad/s",
          "by which it comes later than the steady one, in the sense of the run"),
    entry(f"{TRANSIENT}acceleration", "", "rad/s^2",
          "largest one of the crank; it grows and fades evenly"),
    entry(f"{TRANSIENT}acceleration_torque", "", "N*m",
          "that gives it to the whole line, at the speed of the crankshaft"),
    entry(f"{TRANSIENT}acceleration_supplied", "", "N*m",
          "of it by the load station: what mean gas torque and loads leave over, own shaft"),
    entry(f"{TRANSIENT}acceleration_supplied_at", "", "", "that station, counted from 1"),
    entry(f"{TRANSIENT}acceleration_part", _BY_SECTION, "N*m",
          "torque that carries the acceleration to what lies behind the section"),
    entry(f"{TRANSIENT}peak_without_acceleration", _BY_SECTION, "N*m",
          "largest magnitude on the way without that part, mean in it"),
)  # fmt: skip
TRANSIENTS = (
    entry(f"{TRANSIENT}speed", "transient_time", "rad/s", "crank speed at that time"),
    entry(f"{TRANSIENT}torque_low", _WINDOWS, "N*m", "lowest in a cycle about it, mean in it"),
    entry(f"{TRANSIENT}torque_high", _WINDOWS, "N*m", "highest in a cycle about it, mean in it"),
    entry(f"{TRANSIENT}peak", _BY_SECTION, "N*m", "largest magnitude on the way, mean in it",
          headline=Headline("torque in the transient, peak", "N*m")),
    entry(f"{TRANSIENT}peak_stress", _BY_SECTION, "Pa", "that over the section modulus, shear"),
    entry(f"{TRANSIENT}peak_time", _BY_SECTION, "s", "when that is"),
    entry(f"{TRANSIENT}peak_speed", _BY_SECTION, "rad/s", "crank speed then"),
    entry(f"{TRANSIENT}worst_section", "", "", "section of the largest peak, counted from 1"),
    entry(f"{TRANSIENT}history/torque", "history_time", "N*m",
          "in that section about its peak, mean in it"),
    entry(f"{TRANSIENT}waterfall/speed", "waterfall_time", "rad/s", "crank speed"),
    entry(f"{TRANSIENT}waterfall/order", "waterfall_time half_order", "N*m",
          "amplitude of the order in that section, in a window of some turns", PEAK),
    entry(f"{TRANSIENT}waterfall/frequency", "waterfall_time waterfall_frequency", "N*m",
          "amplitude at the frequency in that section, in a window of time", PEAK),
    *_PASSAGES,
    *_STEPS,
    *_EQUIVALENT,
    *_CLUTCH,
    *_CYCLES,
)  # fmt: skip
OF_PASSAGES = tuple(one.path for one in _PASSAGES)
OF_STEPS = tuple(one.path for one in _STEPS)


# ----------------------------------------------------------------------------
# Results of the search for the damper of a shaft line.
#
# The damper's values are actual ones, of the shaft that carries it. What is made small is the
# largest half range over the cycle of all sections that count at all speeds of the range.
# ----------------------------------------------------------------------------

DESIGN = "damper_design/"
#: objective -> unit
OBJECTIVES = {"torque": "N*m", "twist": "rad", "stress": "Pa"}
_LEADING = {
    "torque": Headline("largest torque with it, half range", "N*m"),
    "stress": Headline("largest stress with it, half range", "N/mm^2"),
}


def _seen(stem: str, whose: str) -> tuple[Entry, ...]:
    """What one damper does over the range of speeds."""
    each = tuple(
        entry(f"{DESIGN}{stem}worst_{name}", "", unit, f"largest half range, {whose}",
              headline=None if stem else _LEADING.get(name))
        for name, unit in OBJECTIVES.items()
    )  # fmt: skip
    return (
        *each,
        entry(f"{DESIGN}{stem}worst_section", "", "", "where that is, counted from 1"),
        entry(f"{DESIGN}{stem}worst_speed", "", "rad/s", "where that is"),
        entry(f"{DESIGN}{stem}heat", "", "W", f"mean power at its own worst speed, {whose}",
              name="" if stem else "heat in the optimal damper, largest"),
        entry(f"{DESIGN}{stem}heat_speed", "", "rad/s", "where that is"),
        entry(f"{DESIGN}{stem}travel", "", "rad",
              f"of the ring against its station, at its own worst speed, {whose}"),
        entry(f"{DESIGN}{stem}travel_speed", "", "rad/s", "where that is"),
    )  # fmt: skip


def _by_objective(stem: str, axes: str, words: str) -> tuple[Entry, ...]:
    return tuple(
        entry(f"{DESIGN}{stem}{name}", axes, unit, words) for name, unit in OBJECTIVES.items()
    )


_MAP = "chart_stiffness chart_damping"
DAMPER_DESIGN_ENTRIES = (
    entry(f"{DESIGN}inertia", "", "kg*m^2", "of the ring", name="inertia of the ring"),
    entry(f"{DESIGN}stiffness", "", "N*m/rad", "of its springs; 0: none",
          headline=Headline("stiffness of the optimal damper", "kN*m/rad")),
    entry(f"{DESIGN}damping", "", "N*m*s/rad", "viscous",
          headline=Headline("damping of the optimal damper", "N*m*s/rad")),
    entry(f"{DESIGN}natural_frequency", "", "rad/s", "of the ring on its springs, station held"),
    entry(f"{DESIGN}damping_ratio", "", "",
          "damping over twice the root of stiffness times inertia"),
    *_seen("", "with the damper found"),
    *_seen("table/", "with the table value"),
    entry(f"{DESIGN}table/gain", "", "", "worst of the table value over that of the damper found",
          name="largest load, compared over optimal damper"),
    entry(f"{DESIGN}active/kind", "active", "", "0: a section, 1: heat, 2: travel"),
    entry(f"{DESIGN}active/section", "active", "", "the section, counted from 1; 0: none"),
    entry(f"{DESIGN}active/speed", "active", "rad/s", "of the peak"),
    entry(f"{DESIGN}active/level", "active", "", "over the worst half range, or over the limit"),
    entry(f"{DESIGN}active/weight", "active", "",
          "of the peak in the proof; of a limit: its price, relative fall for relative rise"),
    entry(f"{DESIGN}bound_sensitivity", "design_value", "",
          "slope of the optimum by the logarithm of a bound that holds it; 0: none does"),
    entry(f"{DESIGN}certificate", "", "", "what is left of the weighted slopes, over the worst",
          exempt=CHECK, diagnostic=True),
    entry(f"{DESIGN}curvature", "", "",
          "least one along what the peaks leave free; above 0: a minimum"),
    entry(f"{DESIGN}basin/stiffness", "basin", "N*m/rad", "end of a descent"),
    entry(f"{DESIGN}basin/damping", "basin", "N*m*s/rad", "end of a descent"),
    entry(f"{DESIGN}basin/worst", "basin", "", "there, over that of the damper found"),
    entry(f"{DESIGN}sensitivity", "stiffness_factor damping_factor", "",
          "worst with so many times stiffness and damping, over the best"),
    *_by_objective("chart/", _MAP, "largest half range, read on a grid of speeds"),
    entry(f"{DESIGN}chart/heat", _MAP, "W", "mean power at its worst speed"),
    entry(f"{DESIGN}chart/travel", _MAP, "rad", "at its worst speed"),
    *_by_objective("ring/", "ring_inertia", "largest half range with the best damper of that ring"),
    entry(f"{DESIGN}ring/stiffness", "ring_inertia", "N*m/rad", "of that damper"),
    entry(f"{DESIGN}ring/damping", "ring_inertia", "N*m*s/rad", "of that damper"),
    *_by_objective("curve/", "damper_curve speed",
                   "half range of the section that is largest at this speed"),
)  # fmt: skip

#: why results of studies are not held to the tolerance
STUDY = "marches in time, differences, maps and ends of searches of a shaft line"
#: those of studies that are
_HELD = {
    *(f"{VARIABLE}{name}" for name in (
        "highest_order", "torque", "torque_half_range", "constant_half_range",
        "speeds/torque_half_range",
    )),
    *(f"{TRANSIENT}{name}" for name in (
        "speed", "worst_section", "history/torque", "waterfall/speed", "waterfall/order",
        "waterfall/frequency", "acceleration", "acceleration_torque", "acceleration_supplied",
        "acceleration_supplied_at", "acceleration_part",
    )),
    *(f"{DESIGN}{stem}{name}" for stem in ("", "table/") for name in (
        *(f"worst_{one}" for one in (*OBJECTIVES, "section")), "heat", "travel",
    )),
    *(f"{DESIGN}curve/{name}" for name in OBJECTIVES),
    *(f"{DESIGN}{name}" for name in ("inertia", "table/gain", "curvature")),
}  # fmt: skip
ENTRIES = (
    *AS_PUBLISHED,
    *(
        one if one.exempt or one.path in _HELD else one._replace(exempt=STUDY)
        for one in (*VARIABLE_INERTIA, *TRANSIENTS, *DAMPER_DESIGN_ENTRIES)
    ),
)
