"""Results of studies of a shaft line: modal route, variable inertia, changes in time, damper.

Torques are actual ones, of the shaft they belong to.
"""

from functools import partial

from vibecalc.core.results.record import CHECK, PEAK, Entry, Headline, entry, under

#: changes in time from one speed of the crank to another
PASSAGES = ("run_up", "run_down", "start", "stop")
ROOT = "response/torsion"
PUBLISHED, VARIABLE, TRANSIENT = (
    f"{ROOT}/{part}/" for part in ("as_published", "variable_inertia", "transient")
)
#: why most results of studies are not held to the tolerance
STUDY = "marches in time, differences, maps and ends of searches of a shaft line"
_study = partial(entry, exempt=STUDY)

# ----------------------------------------------------------------------------
# The modal route as published, and inertias that change over the turn.
# ----------------------------------------------------------------------------

_BY_ELASTIC_MODE = "elastic_mode order"
AS_PUBLISHED = under(
    f"{ROOT}/as_published",
    entry("natural_frequency", "elastic_mode", "rad/s", "undamped"),
    entry("rayleigh_inertia", "", "1/s", "factor of the inertia in Rayleigh damping"),
    entry("rayleigh_stiffness", "", "s", "factor of the stiffness in Rayleigh damping"),
    entry("rayleigh_damping_ratio", "elastic_mode", "",
          "that it gives; the twists have the damping ratio of the case"),
    entry("intensity", _BY_ELASTIC_MODE, "N*m",
          "sum of shape times torque; the shape is 1 at the first freedom", PEAK),
    entry("largest_intensity_order", "elastic_mode", "", "order of the largest"),
    entry("static_twist", _BY_ELASTIC_MODE, "rad",
          "intensity over modal stiffness; modal, it follows the scale of the shape", PEAK),
    entry("twist", "elastic_mode speed", "rad",
          "modal twist at crank angle zero, all orders, torque of the operating speed"),
    entry("twist_magnitude", "elastic_mode speed", "rad",
          "magnitude of the complex sum whose real part that is"),
    entry("twist_at_critical", _BY_ELASTIC_MODE, "rad",
          "modal twist at crank angle zero, all orders, on each critical speed"),
    entry("largest_twist", "elastic_mode", "rad", "largest magnitude of those"),
    entry("largest_twist_order", "elastic_mode", "", "order of that critical speed"),
)  # fmt: skip
VARIABLE_INERTIA = under(
    f"{ROOT}/variable_inertia",
    _study("relative_variation", "station", "",
           "half the range of the inertia over the turn, over its mean"),
    entry("highest_order", "", "", "of the motion that was kept"),
    entry("torque", "section order", "N*m",
          "exact motion at the operating speed, stiffness and damping part", PEAK),
    entry("torque_half_range", "section", "N*m", "of the exact motion, all orders"),
    entry("constant_half_range", "section", "N*m", "with mean inertias, all orders"),
    _study("change", "section", "", "of the half range, over that with mean inertias"),
    _study("secondary/twist", "order", "rad",
           "what the other orders add in the section that changes most (linear)", PEAK),
    _study("secondary/source", "order", "", "order that adds most; 0: the mean"),
    _study("secondary/share", "order", "", "of that order in the sum of all sizes"),
    _study("growth", "", "1/s", "of the fastest vibration about it; negative: dies out"),
    _study("wedge/speed", "wedge", "rad/s",
           "an order of the inertia meets the sum of two natural frequencies"),
    _study("wedge/half_width", "wedge", "rad/s", "unstable so near to it, undamped"),
    _study("wedge/order", "wedge", "", "of the inertia"),
    _study("wedge/first_mode", "wedge", "", "number of the mode, the rigid one is 1"),
    _study("wedge/second_mode", "wedge", "", "number of the other, or the same"),
    _study("wedge/growth", "wedge", "1/s", "at its centre, undamped"),
    _study("wedge/damping_ratio", "wedge", "", "of both modes that removes it"),
    _study("unstable/from", "unstable", "rad/s", "vibration grows from here, as damped"),
    _study("unstable/to", "unstable", "rad/s", "to here"),
    _study("unstable/growth", "unstable", "1/s", "the fastest seen between"),
    entry("speeds/torque_half_range", "section variable_speed", "N*m", "linear motion, all orders"),
    _study("speeds/change", "section variable_speed", "",
           "of the half range, over that with mean inertias"),
    _study("largest_change", "section", "", "of those, in magnitude"),
    _study("largest_change_speed", "section", "rad/s", "where that is"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# A change in time: peaks of the sections, and what only steps or passages, clutches or counted
# cycles have.
# ----------------------------------------------------------------------------

_WINDOWS, _COUNTED = "section transient_time", "section range_bin"
_STEPS = under(
    f"{ROOT}/transient",
    _study("steady_before", "section", "N*m",
           "largest magnitude of the steady vibration before, mean in it"),
    _study("steady_after", "section", "N*m", "and of that which is reached at last"),
    _study("dynamic_factor", "section", "", "peak over the larger of those two"),
)  # fmt: skip
_PASSAGES = under(
    f"{ROOT}/transient",
    _study("half_range", _WINDOWS, "N*m", "half of high less low"),
    _study("quasi_steady", _WINDOWS, "N*m",
           "largest steady half range at the speeds of that cycle"),
    _study("peak_half_range", "section", "N*m",
           "largest half range of any cycle, begin it where it may"),
    _study("peak_half_range_speed", "section", "rad/s",
           "crank speed midway between its crest and its trough"),
    _study("steady_half_range", "section", "N*m",
           "largest steady half range between the same speeds"),
    _study("steady_half_range_speed", "section", "rad/s", "crank speed there"),
    _study("overshoot", "section", "",
           "largest half range over the steady one, less 1; negative: it has no time to build up"),
    _study("lag", "section", "rad/s",
           "by which it comes later than the steady one, in the sense of the run"),
    entry("acceleration", "", "rad/s^2", "largest one of the crank; it grows and fades evenly"),
    entry("acceleration_torque", "", "N*m",
          "that gives it to the whole line, at the speed of the crankshaft"),
    entry("acceleration_supplied", "", "N*m",
          "of it by the load station: what mean gas torque and loads leave over, own shaft"),
    entry("acceleration_supplied_at", "", "", "that station, counted from 1"),
    entry("acceleration_part", "section", "N*m",
          "torque that carries the acceleration to what lies behind the section"),
    _study("peak_without_acceleration", "section", "N*m",
           "largest magnitude on the way without that part, mean in it"),
)  # fmt: skip
OF_PASSAGES, OF_STEPS = (tuple(one.path for one in rows) for rows in (_PASSAGES, _STEPS))
TRANSIENTS = (
    *under(
        f"{ROOT}/transient",
        entry("speed", "transient_time", "rad/s", "crank speed at that time"),
        _study("torque_low", _WINDOWS, "N*m", "lowest in a cycle about it, mean in it"),
        _study("torque_high", _WINDOWS, "N*m", "highest in a cycle about it, mean in it"),
        _study("peak", "section", "N*m", "largest magnitude on the way, mean in it",
               headline=Headline("peak torque, transient", "N*m")),
        _study("peak_stress", "section", "Pa", "that over the section modulus, shear"),
        _study("peak_time", "section", "s", "when that is"),
        _study("peak_speed", "section", "rad/s", "crank speed then"),
        entry("worst_section", "", "", "section of the largest peak, counted from 1"),
        entry("history/torque", "history_time", "N*m",
              "in that section about its peak, mean in it"),
        entry("waterfall/speed", "waterfall_time", "rad/s", "crank speed"),
        entry("waterfall/order", "waterfall_time order", "N*m",
              "amplitude of the order in that section, in a window of some turns", PEAK),
        entry("waterfall/frequency", "waterfall_time waterfall_frequency", "N*m",
              "amplitude at the frequency in that section, in a window of time", PEAK),
    ),
    *_PASSAGES,
    *_STEPS,
    *under(
        f"{ROOT}/transient",
        _study("equivalent/frequency", "section", "rad/s",
               "at which the dashpot for a loss factor keeps its magnitude"),
        _study("equivalent/damping", "section", "N*m*s/rad",
               "of that dashpot, stiffness times loss factor over the frequency"),
        _study("clutch/slip_time", "", "s", "of all slipping, from its engaging on",
               headline=Headline("clutch slip time", "s")),
        _study("clutch/heat", "", "J", "friction torque times slip, of all slipping",
               headline=Headline("clutch heat", "kJ")),
        _study("clutch/held", "", "s", "time from engaging until it holds, first"),
        _study("clutch/common_speed", "", "rad/s",
               "mean speed of the crank then, by the momentum of both parts"),
        _study("clutch/engagements", "", "", "how often it begins to hold"),
        _study("clutch/use", "", "",
               "largest torque while it holds over its friction torque; 1: where it slips"),
        _study("clutch/slip_speed", "clutch_time", "rad/s",
               "of its plates, first end less second, own shaft", curve="clutch_slip"),
        _study("counted/range", _COUNTED, "N*m",
               "largest of the bin, crest less trough of a cycle"),
        _study("counted/number", _COUNTED, "", "of cycles in the bin"),
        _study("counted/mean", _COUNTED, "N*m", "mean of the cycles in the bin"),
        _study("counted/largest_range", "section", "N*m", "of any cycle"),
        _study("counted/largest_stress_range", "section", "Pa", "of any cycle, shear"),
        _study("counted/equivalent_number", "section", "",
               "of cycles of the largest range that use up as much as all"),
        _study("counted/damage", "section", "", "sum of n / N of one change (Miner)"),
        _study("counted/damage_of_all", "section", "",
               "of all changes that the case says; 1: the life is used up",
               headline=Headline("Miner damage sum of all speed changes", "")),
    ),
)  # fmt: skip

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
    "torque": Headline("largest torque, optimum damper", "N*m"),
    "stress": Headline("largest stress, optimum damper", "N/mm^2"),
}


def _seen(stem: str, whose: str) -> tuple[Entry, ...]:
    """What one damper does over the range of speeds."""
    return (
        *(entry(f"{stem}worst_{name}", "", unit, f"largest half range, {whose}",
                headline=None if stem else _LEADING.get(name))
          for name, unit in OBJECTIVES.items()),
        entry(f"{stem}worst_section", "", "", "where that is, counted from 1"),
        _study(f"{stem}worst_speed", "", "rad/s", "where that is"),
        entry(f"{stem}heat", "", "W", f"mean power at its own worst speed, {whose}",
              name="" if stem else "largest heat, optimum damper"),
        _study(f"{stem}heat_speed", "", "rad/s", "where that is"),
        entry(f"{stem}travel", "", "rad",
              f"of the ring against its station, at its own worst speed, {whose}"),
        _study(f"{stem}travel_speed", "", "rad/s", "where that is"),
    )  # fmt: skip


_MAP = "chart_stiffness chart_damping"
DAMPER_DESIGN = under(
    "damper_design",
    entry("inertia", "", "kg*m^2", "of the ring", name="ring inertia"),
    _study("stiffness", "", "N*m/rad", "of its springs; 0: none",
           headline=Headline("stiffness, optimum damper", "kN*m/rad")),
    _study("damping", "", "N*m*s/rad", "viscous",
           headline=Headline("damping, optimum damper", "N*m*s/rad")),
    _study("natural_frequency", "", "rad/s", "of the ring on its springs, station held"),
    _study("damping_ratio", "", "", "damping over twice the root of stiffness times inertia"),
    *_seen("", "with the damper found"),
    *_seen("table/", "with the table value"),
    entry("table/gain", "", "", "worst of the table value over that of the damper found",
          name="largest torque, given / optimum damper"),
    _study("active/kind", "active", "", "0: a section, 1: heat, 2: travel"),
    _study("active/section", "active", "", "the section, counted from 1; 0: none"),
    _study("active/speed", "active", "rad/s", "of the peak"),
    _study("active/level", "active", "", "over the worst half range, or over the limit"),
    _study("active/weight", "active", "",
           "of the peak in the proof; of a limit: its price, relative fall for relative rise"),
    _study("bound_sensitivity", "design_value", "",
           "slope of the optimum by the logarithm of a bound that holds it; 0: none does"),
    entry("certificate", "", "", "what is left of the weighted slopes, over the worst",
          exempt=CHECK, diagnostic=True),
    entry("curvature", "", "", "least one along what the peaks leave free; above 0: a minimum"),
    _study("basin/stiffness", "basin", "N*m/rad", "end of a descent"),
    _study("basin/damping", "basin", "N*m*s/rad", "end of a descent"),
    _study("basin/worst", "basin", "", "there, over that of the damper found"),
    _study("sensitivity", "stiffness_factor damping_factor", "",
           "worst with so many times stiffness and damping, over the best"),
    *(_study(f"chart/{name}", _MAP, unit, "largest half range, read on a grid of speeds")
      for name, unit in OBJECTIVES.items()),
    _study("chart/heat", _MAP, "W", "mean power at its worst speed"),
    _study("chart/travel", _MAP, "rad", "at its worst speed"),
    *(_study(f"ring/{name}", "ring_inertia", unit,
             "largest half range with the best damper of that ring")
      for name, unit in OBJECTIVES.items()),
    _study("ring/stiffness", "ring_inertia", "N*m/rad", "of that damper"),
    _study("ring/damping", "ring_inertia", "N*m*s/rad", "of that damper"),
    *(entry(f"curve/{name}", "damper_curve speed", unit,
            "half range of the section that is largest at this speed")
      for name, unit in OBJECTIVES.items()),
)  # fmt: skip

ENTRIES = (*AS_PUBLISHED, *VARIABLE_INERTIA, *TRANSIENTS, *DAMPER_DESIGN)
#: axis name -> (unit, long name)
AXES = {
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
}
