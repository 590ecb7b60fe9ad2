"""Results of couplings and of studies: modal route, variable inertia, changes in time, damper.

Torques are actual ones, of the shaft they belong to.
"""

from collections.abc import Iterator
from functools import partial

from vibecalc.core.results.record import CHECK, PEAK, PLACE, Entry, Headline, entry, under

#: changes in time from one speed of the crank to another
PASSAGES = ("run_up", "run_down", "start", "stop")
ROOT = "response/torsion"
PUBLISHED, VARIABLE, TRANSIENT, FRICTION = (
    f"{ROOT}/{part}/"
    for part in ("as_published", "variable_inertia", "transient", "friction_damper")
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
    entry("residual", "frequency", "",
          "Holzer's table: torque of the last row over the sum of all inertia torques; 0 at a "
          "natural frequency"),
    entry("rayleigh_inertia", "", "1/s", "factor of the inertia in Rayleigh damping"),
    entry("rayleigh_stiffness", "", "s", "factor of the stiffness in Rayleigh damping"),
    entry("rayleigh_damping_ratio", "elastic_mode", "",
          "by Rayleigh damping; the twists use the damping ratio of the case"),
    entry("intensity", _BY_ELASTIC_MODE, "N*m",
          "sum of shape times torque; shape 1 at the first degree of freedom", PEAK),
    entry("largest_intensity_order", "elastic_mode", "", "order of the largest"),
    entry("static_twist", _BY_ELASTIC_MODE, "rad",
          "intensity / modal stiffness; depends on the scale of the shape", PEAK),
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
           "half range of the inertia over the revolution / its mean"),
    entry("highest_order", "", "", "of the retained motion"),
    entry("torque", "section order", "N*m",
          "exact motion at the operating speed, stiffness and damping part", PEAK),
    entry("torque_half_range", "section", "N*m", "of the exact motion, all orders"),
    entry("constant_half_range", "section", "N*m", "with mean inertias, all orders"),
    _study("change", "section", "", "of the half range, over that with mean inertias"),
    _study("secondary/twist", "order", "rad",
           "contribution of other orders in the section with the largest change (linear)", PEAK),
    _study("secondary/source", "order", "", "main contributing order; 0: the mean"),
    _study("secondary/share", "order", "", "of that order in the sum of all magnitudes"),
    _study("growth", "", "1/s", "of the fastest disturbance; negative: it decays"),
    _study("wedge/speed", "wedge", "rad/s",
           "an order of the inertia meets the sum of two natural frequencies"),
    _study("wedge/half_width", "wedge", "rad/s", "of the unstable range, undamped"),
    _study("wedge/order", "wedge", "", "of the inertia"),
    _study("wedge/first_mode", "wedge", "", "number of the mode, the rigid one is 1"),
    _study("wedge/second_mode", "wedge", "", "number of the other, or the same"),
    _study("wedge/growth", "wedge", "1/s", "at its centre, undamped"),
    _study("wedge/damping_ratio", "wedge", "", "of both modes that suppresses it"),
    _study("unstable/from", "unstable", "rad/s", "vibration grows from here, as damped"),
    _study("unstable/to", "unstable", "rad/s", "to here"),
    _study("unstable/growth", "unstable", "1/s", "fastest in the range"),
    entry("speeds/torque_half_range", "section variable_speed", "N*m", "linear motion, all orders"),
    _study("speeds/change", "section variable_speed", "",
           "of the half range, over that with mean inertias"),
    _study("largest_change", "section", "", "largest magnitude of those"),
    _study("largest_change_speed", "section", "rad/s", "where that is"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# One order with a ring that dry friction drags along; angles and torques are amplitudes.
# ----------------------------------------------------------------------------

FRICTION_DAMPED = under(
    f"{ROOT}/friction_damper",
    _study("angle", "", "rad", "of its station, by the first harmonic of the friction",
           headline=Headline("order amplitude with the friction damper", "deg")),
    _study("locked_angle", "", "rad", "the same with the ring locked on its linings"),
    _study("free_angle", "", "rad", "the same without friction"),
    _study("locked_utilisation", "", "",
           "torque of the ring, locked / friction torque; above 1 it slips"),
    _study("equivalent_inertia", "", "kg*m^2", "of the ring, as the friction drags it along"),
    _study("equivalent_damping", "", "N*m*s/rad",
           "of its slip, as a dashpot between station and frame"),
    _study("heat", "", "W", "mean power of its slip"),
    _study("best_friction_torque", "", "N*m",
           "with the most work per cycle for the amplitude that it leaves"),
    _study("best_angle", "", "rad", "of the station with that"),
    _study("torque", "section", "N*m", "of the order"),
    _study("speeds/angle", "speed", "rad", "of its station"),
    _study("speeds/locked_angle", "speed", "rad", "the same with the ring locked on its linings"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# A change in time: peaks of the sections, and what only steps or passages, clutches or counted
# cycles have.
# ----------------------------------------------------------------------------

_WINDOWS, _COUNTED = "section transient_time", "section range_bin"
_STEPS = under(
    f"{ROOT}/transient",
    _study("steady_before", "section", "N*m",
           "largest magnitude of the steady vibration before, mean included"),
    _study("steady_after", "section", "N*m", "and of the final steady vibration"),
    _study("dynamic_factor", "section", "", "peak / larger of those two"),
)  # fmt: skip
_PASSAGES = under(
    f"{ROOT}/transient",
    _study("half_range", _WINDOWS, "N*m", "(maximum - minimum) / 2"),
    _study("quasi_steady", _WINDOWS, "N*m",
           "largest steady half range at the speeds of that cycle"),
    _study("peak_half_range", "section", "N*m",
           "largest half range of any cycle"),
    _study("peak_half_range_speed", "section", "rad/s",
           "crank speed midway between its maximum and minimum"),
    _study("steady_half_range", "section", "N*m",
           "largest steady half range between the same speeds"),
    _study("steady_half_range_speed", "section", "rad/s", "crank speed there"),
    _study("overshoot", "section", "",
           "largest half range / steady one - 1; negative: no time to build up"),
    _study("lag", "section", "rad/s",
           "delay of the maximum after the steady one, in the direction of the run"),
    entry("acceleration", "", "rad/s^2", "maximum of the crank, with smooth start and end"),
    entry("acceleration_torque", "", "N*m",
          "that accelerates the whole line, referred to the crankshaft"),
    entry("acceleration_supplied", "", "N*m",
          "of it by the load station: balance of mean gas torque and loads, not referred"),
    entry("acceleration_supplied_at", "", "", "that station, counted from 1"),
    entry("acceleration_part", "section", "N*m",
          "torque that accelerates the part of the line behind the section"),
    _study("peak_without_acceleration", "section", "N*m",
           "largest magnitude without that part, mean included"),
)  # fmt: skip
OF_PASSAGES, OF_STEPS = (tuple(one.path for one in rows) for rows in (_PASSAGES, _STEPS))
TRANSIENTS = (
    *under(
        f"{ROOT}/transient",
        entry("speed", "transient_time", "rad/s", "crank speed at that time"),
        _study("torque_low", _WINDOWS, "N*m", "minimum in a cycle around it, mean included"),
        _study("torque_high", _WINDOWS, "N*m", "maximum in a cycle around it, mean included"),
        _study("peak", "section", "N*m", "largest magnitude, mean included",
               headline=Headline("peak torque, transient", "N*m")),
        _study("peak_stress", "section", "Pa", "that over the section modulus, shear"),
        _study("peak_time", "section", "s", "when that is, from the start of the simulated time"),
        _study("peak_speed", "section", "rad/s", "crank speed then"),
        entry("gear_minimum_torque", "gear", "N*m", "of the teeth, in the sense of the mean",
              headline=Headline("minimum gear torque, transient (negative: teeth part)", "N*m",
                                pick="least")),
        entry("worst_section", "", "", "section of the largest peak, counted from 1"),
        entry("history/torque", "history_time", "N*m",
              "in that section around its peak, mean included"),
        entry("waterfall/speed", "waterfall_time", "rad/s", "crank speed"),
        entry("waterfall/order", "waterfall_time order", "N*m",
              "amplitude of the order in that section, in a window of some revolutions", PEAK),
        entry("waterfall/frequency", "waterfall_time waterfall_frequency", "N*m",
              "amplitude at the frequency in that section, in a window of time", PEAK),
    ),
    *_PASSAGES,
    *_STEPS,
    *under(
        f"{ROOT}/transient",
        _study("equivalent/frequency", "section", "rad/s",
               "at which the dashpot is equivalent to the loss factor"),
        _study("equivalent/damping", "section", "N*m*s/rad",
               "of that dashpot, stiffness times loss factor over the frequency"),
        _study("clutch/slip_time", "", "s", "total slip time from engagement",
               headline=Headline("clutch slip time", "s")),
        _study("clutch/heat", "", "J", "friction torque times slip, of all slipping",
               headline=Headline("clutch heat", "kJ")),
        _study("clutch/held", "", "s", "time from engagement until it first locks"),
        _study("clutch/common_speed", "", "rad/s",
               "mean crank speed at that time, from the momentum of both parts"),
        _study("clutch/engagements", "", "", "number of times it locks"),
        _study("clutch/utilisation", "", "",
               "largest torque while locked / friction torque; 1: where it slips"),
        _study("clutch/slip_speed", "clutch_time", "rad/s",
               "of its plates, first end minus second, not referred", curve="clutch_slip"),
        _study("friction_damper/slip_time", "", "s", "total slip time of the ring",
               headline=Headline("friction damper slip time", "s")),
        _study("friction_damper/heat", "", "J", "friction torque times slip, of all slipping",
               headline=Headline("friction damper heat", "kJ")),
        _study("friction_damper/locks", "", "", "number of times that the ring locks"),
        _study("counted/range", _COUNTED, "N*m",
               "upper end of the bin, peak-to-peak of a cycle"),
        _study("counted/number", _COUNTED, "", "of cycles in the bin"),
        _study("counted/mean", _COUNTED, "N*m", "mean of the cycles in the bin"),
        _study("counted/largest_range", "section", "N*m", "of any cycle"),
        _study("counted/largest_stress_range", "section", "Pa", "of any cycle, shear"),
        _study("counted/equivalent_number", "section", "",
               "of cycles of the largest range with the same damage"),
        _study("counted/damage", "section", "", "sum of n / N of one transient (Miner)"),
        _study("counted/damage_of_all", "section", "",
               "of all transients of the case; 1: end of life",
               headline=Headline("Miner damage sum of all transients", "")),
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
        entry(f"{stem}heat", "", "W", f"mean power at its worst speed, {whose}",
              headline=None if stem else Headline("largest heat, optimum damper", "W")),
        _study(f"{stem}heat_speed", "", "rad/s", "where that is"),
        entry(f"{stem}travel", "", "rad",
              f"of the ring relative to its station, at its worst speed, {whose}"),
        _study(f"{stem}travel_speed", "", "rad/s", "where that is"),
    )  # fmt: skip


_MAP = "chart_stiffness chart_damping"
DAMPER_DESIGN = under(
    "damper_design",
    entry("inertia", "", "kg*m^2", "of the ring", name="ring inertia"),
    _study("stiffness", "", "N*m/rad", "of its springs; 0: none",
           headline=Headline("stiffness, optimum damper", "kN*m/rad", pick="present")),
    _study("damping", "", "N*m*s/rad", "viscous",
           headline=Headline("damping, optimum damper", "N*m*s/rad")),
    _study("natural_frequency", "", "rad/s", "of the ring on its springs, station held"),
    _study("damping_ratio", "", "", "damping over twice the root of stiffness times inertia"),
    *_seen("", "with the optimum damper"),
    *_seen("table/", "with the compared damper"),
    entry("table/gain", "", "", "largest value with the compared damper / with the optimum",
          name="largest torque, given / optimum damper"),
    _study("active/kind", "active", "", "0: a section, 1: heat, 2: travel"),
    _study("active/section", "active", "", "the section, counted from 1; 0: none"),
    _study("active/speed", "active", "rad/s", "of the peak"),
    _study("active/level", "active", "", "over the worst half range, or over the limit"),
    _study("active/weight", "active", "",
           "of the peak in the optimality condition; of a limit: relative fall per relative rise"),
    _study("bound_sensitivity", "design_value", "",
           "slope of the optimum by the logarithm of a bound that holds it; 0: none does"),
    entry("certificate", "", "", "residual of the weighted slopes, over the worst",
          exempt=CHECK, diagnostic=True),
    entry("curvature", "", "", "least one along what the peaks leave free; above 0: a minimum"),
    _study("basin/stiffness", "basin", "N*m/rad", "end of a local search"),
    _study("basin/damping", "basin", "N*m*s/rad", "end of a local search"),
    _study("basin/worst", "basin", "", "there, relative to the optimum"),
    _study("sensitivity", "stiffness_factor damping_factor", "",
           "largest value at these factors of stiffness and damping / optimum"),
    *(_study(f"chart/{name}", _MAP, unit, "largest half range on a grid of speeds")
      for name, unit in OBJECTIVES.items()),
    _study("chart/heat", _MAP, "W", "mean power at its worst speed"),
    _study("chart/travel", _MAP, "rad", "at its worst speed"),
    *(_study(f"ring/{name}", "ring_inertia", unit,
             "largest half range with the optimum damper of that ring")
      for name, unit in OBJECTIVES.items()),
    _study("ring/stiffness", "ring_inertia", "N*m/rad", "of that damper"),
    _study("ring/damping", "ring_inertia", "N*m*s/rad", "of that damper"),
    *(entry(f"curve/{name}", "damper_curve speed", unit,
            "half range of the section that is largest at this speed")
      for name, unit in OBJECTIVES.items()),
)  # fmt: skip

ENTRIES = (*AS_PUBLISHED, *VARIABLE_INERTIA, *FRICTION_DAMPED, *TRANSIENTS, *DAMPER_DESIGN)
#: axis name -> (unit, long name)
AXES = {
    "elastic_mode": ("", "number of the mode, the rigid one is 1"),
    "variable_speed": ("rad/s", "crank speed, with the critical speeds"),
    "wedge": ("", "sum resonance of the inertia, widest first"),
    "unstable": ("", "speed range with unstable vibration, ascending"),
    "transient_time": ("s", "middle of a whole cycle of the machine"),
    "history_time": ("s", "time"),
    "clutch_time": ("s", "time"),
    "range_bin": ("", "bin of the ranges of a section, the largest last"),
    "waterfall_time": ("s", "middle of a window of time"),
    "waterfall_frequency": ("rad/s", "frequency"),
    "design_value": ("", "value of the damper"),
    "basin": ("", "end of a search, the best first"),
    "stiffness_factor": ("", "stiffness / that of the optimum damper"),
    "damping_factor": ("", "damping / that of the optimum damper"),
    "chart_stiffness": ("N*m/rad", "stiffness of the damper's springs"),
    "chart_damping": ("N*m*s/rad", "damping of the damper"),
    "ring_inertia": ("kg*m^2", "inertia of the ring"),
    "damper_curve": ("", "damper of the curve"),
}


# ----------------------------------------------------------------------------
# What elastic couplings bear, next to what their makers permit.
# ----------------------------------------------------------------------------

COUPLING, HEALTHY = f"{ROOT}/coupling", f"{ROOT}/healthy/coupling"
_CONDITIONS = f"{ROOT}/conditions"
_HERE, _HALF = "at the operating speed", "half range of all orders"
_LIMITED = "coupling coupling_limit"
_USE = "load / permitted by the manufacturer; 0: no such limit"
_BORNE = (
    ("mean_torque", "N*m", "steady torque"),
    ("peak_torque", "N*m", "largest magnitude over the cycle, mean torque included"),
    ("vibratory_torque", "N*m", _HALF),
    ("torque_by_orders", "N*m",
     "root of the sum of squares of the orders, each times its frequency factor"),
    ("main_frequency", "rad/s", "of the order of the largest torque"),
    ("power_loss", "W", "mean, of all orders"),
    ("temperature", "K", "of the element, where it is known"),
)  # fmt: skip
#: of what a coupling bears, that of which the largest at any speed is searched
LARGEST = tuple(name for name, *_ in _BORNE if name not in ("mean_torque", "main_frequency"))


def _borne(place: str, axes: str, words: str) -> Iterator[Entry]:
    for name, unit, long_name in _BORNE:
        exempt = PLACE if name == "main_frequency" else ""
        if name in LARGEST or not place.startswith("largest"):
            yield entry(f"{place}{name}", axes, unit, f"{long_name}, {words}", exempt=exempt)


def _largest_use(axes: str, words: str, of: str = "", place: str = "") -> Iterator[Entry]:
    at = f"{place}/largest_utilisation_speed"
    headline = Headline(f"coupling utilisation{of}", at=at) if of else None
    yield entry("largest_utilisation", axes, "", words, headline=headline, share=True)
    yield entry("largest_utilisation_speed", axes, "rad/s", "where that is", exempt=PLACE)


COUPLING_ENTRIES = (
    *under(
        COUPLING,
        *_borne("", "coupling", _HERE),
        entry("stiffness", "coupling order", "N*m/rad",
              f"dynamic, at the frequency of the order, {_HERE}"),
        entry("loss_factor", "coupling order", "",
              f"relative damping over 2 pi, at the frequency of the order, {_HERE}"),
        entry("mode_stiffness", "coupling mode", "N*m/rad",
              f"dynamic, at the undamped natural frequency of the mode, {_HERE}"),
        entry("utilisation", _LIMITED, "", f"{_USE}, {_HERE}",
              share=True, headline=Headline("coupling utilisation at operating speed")),
        *_borne("speeds/", "coupling speed", "over the speeds"),
        *_borne("largest/", "coupling", "the largest at any speed"),
        *(entry(f"largest/{one}_speed", "coupling", "rad/s", "where that is", exempt=PLACE)
          for one in LARGEST),
        entry("speeds/utilisation", f"{_LIMITED} speed", "", _USE),
        *_largest_use(_LIMITED, f"{_USE}, the largest at any speed", ", speed range",
                      COUPLING),
    ),
    *under(
        HEALTHY,
        entry("utilisation", _LIMITED, "", f"{_USE}, {_HERE}, all cylinders firing"),
        *_largest_use(_LIMITED, f"{_USE}, the largest at any speed, all cylinders firing"),
    ),
    *under(
        f"{_CONDITIONS}/coupling",
        entry("utilisation", f"condition {_LIMITED}", "", f"{_USE}, {_HERE}"),
        *_largest_use(f"condition {_LIMITED}", f"{_USE}, the largest at any speed",
                      ", worst condition", f"{_CONDITIONS}/coupling"),
    ),
)  # fmt: skip
