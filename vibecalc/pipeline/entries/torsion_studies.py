"""Results of a shaft line beside the steady ones: transients, variable inertia, the modal route.

Torques are own ones, of the shaft they belong to.
"""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "response/torsion"
PUBLISHED, VARIABLE, TRANSIENT = (
    f"{ROOT}/{part}/" for part in ("as_published", "variable_inertia", "transient")
)
_BY_MODE = "elastic_mode half_order"

AS_PUBLISHED = (
    entry(f"{PUBLISHED}natural_frequency", "elastic_mode", "rad/s", "undamped"),
    entry(f"{PUBLISHED}rayleigh_inertia", "", "1/s", "factor of the inertia in Rayleigh damping"),
    entry(f"{PUBLISHED}rayleigh_stiffness", "", "s", "factor of the stiffness in Rayleigh damping"),
    entry(f"{PUBLISHED}rayleigh_damping_ratio", "elastic_mode", "",
          "that it gives; the twists have the damping ratio of the case"),
    entry(f"{PUBLISHED}intensity", _BY_MODE, "N*m",
          "sum of shape times torque; the shape is 1 at the first freedom", PEAK),
    entry(f"{PUBLISHED}largest_intensity_order", "elastic_mode", "", "order of the largest"),
    entry(f"{PUBLISHED}static_twist", _BY_MODE, "rad",
          "intensity over modal stiffness; modal, it follows the scale of the shape", PEAK),
    entry(f"{PUBLISHED}twist", "elastic_mode speed", "rad",
          "modal twist at crank angle zero, all orders, torque of the operating speed"),
    entry(f"{PUBLISHED}twist_magnitude", "elastic_mode speed", "rad",
          "magnitude of the complex sum whose real part that is"),
    entry(f"{PUBLISHED}twist_at_critical", _BY_MODE, "rad",
          "modal twist at crank angle zero, all orders, on each critical speed"),
    entry(f"{PUBLISHED}largest_twist", "elastic_mode", "rad", "largest magnitude of those"),
    entry(f"{PUBLISHED}largest_twist_order", "elastic_mode", "", "order of that critical speed"),
)  # fmt: skip

_SECTION = "section"
_SPEEDS = "section variable_speed"
VARIABLE_INERTIA = (
    entry(f"{VARIABLE}relative_variation", "station", "",
          "half the range of the inertia over the turn, over its mean"),
    entry(f"{VARIABLE}highest_order", "", "", "of the motion that was kept"),
    entry(f"{VARIABLE}torque", "section half_order", "N*m",
          "exact motion at the operating speed, stiffness and damping part", PEAK),
    entry(f"{VARIABLE}torque_half_range", _SECTION, "N*m", "of the exact motion, all orders"),
    entry(f"{VARIABLE}constant_half_range", _SECTION, "N*m", "with mean inertias, all orders"),
    entry(f"{VARIABLE}change", _SECTION, "", "of the half range, over that with mean inertias"),
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
    entry(f"{VARIABLE}largest_change", _SECTION, "", "of those, in magnitude"),
    entry(f"{VARIABLE}largest_change_speed", _SECTION, "rad/s", "where that is"),
)  # fmt: skip

_WINDOWS = "section transient_time"
_STEPS = (
    entry(f"{TRANSIENT}steady_before", _SECTION, "N*m",
          "largest magnitude of the steady vibration before, mean in it"),
    entry(f"{TRANSIENT}steady_after", _SECTION, "N*m", "and of that which is reached at last"),
    entry(f"{TRANSIENT}dynamic_factor", _SECTION, "", "peak over the larger of those two"),
)  # fmt: skip
_PASSAGES = (
    entry(f"{TRANSIENT}half_range", _WINDOWS, "N*m", "half of high less low"),
    entry(f"{TRANSIENT}quasi_steady", _WINDOWS, "N*m",
          "largest steady half range at the speeds of that cycle"),
    entry(f"{TRANSIENT}peak_half_range", _SECTION, "N*m",
          "largest half range of any cycle, begin it where it may"),
    entry(f"{TRANSIENT}peak_half_range_speed", _SECTION, "rad/s",
          "crank speed midway between its crest and its trough"),
    entry(f"{TRANSIENT}steady_half_range", _SECTION, "N*m",
          "largest steady half range between the same speeds"),
    entry(f"{TRANSIENT}steady_half_range_speed", _SECTION, "rad/s", "crank speed there"),
    entry(f"{TRANSIENT}overshoot", _SECTION, "",
          "largest half range over the steady one, less 1; negative: it has no time to build up"),
    entry(f"{TRANSIENT}lag", _SECTION, "rad/s",
          "by which it comes later than the steady one, in the sense of the run"),
    entry(f"{TRANSIENT}acceleration", "", "rad/s^2",
          "largest one of the crank; it grows and fades evenly"),
    entry(f"{TRANSIENT}acceleration_torque", "", "N*m",
          "that gives it to the whole line, at the speed of the crankshaft"),
    entry(f"{TRANSIENT}acceleration_supplied", "", "N*m",
          "of it by the load station: what mean gas torque and loads leave over, own shaft"),
    entry(f"{TRANSIENT}acceleration_supplied_at", "", "", "that station, counted from 1"),
    entry(f"{TRANSIENT}acceleration_part", _SECTION, "N*m",
          "torque that carries the acceleration to what lies behind the section"),
    entry(f"{TRANSIENT}peak_without_acceleration", _SECTION, "N*m",
          "largest magnitude on the way without that part, mean in it"),
)  # fmt: skip
TRANSIENTS = (
    entry(f"{TRANSIENT}speed", "transient_time", "rad/s", "crank speed at that time"),
    entry(f"{TRANSIENT}torque_low", _WINDOWS, "N*m", "lowest in a cycle about it, mean in it"),
    entry(f"{TRANSIENT}torque_high", _WINDOWS, "N*m", "highest in a cycle about it, mean in it"),
    entry(f"{TRANSIENT}peak", _SECTION, "N*m", "largest magnitude on the way, mean in it"),
    entry(f"{TRANSIENT}peak_time", _SECTION, "s", "when that is"),
    entry(f"{TRANSIENT}peak_speed", _SECTION, "rad/s", "crank speed then"),
    entry(f"{TRANSIENT}worst_section", "", "", "section of the largest peak, counted from 1"),
    entry(f"{TRANSIENT}course/torque", "course_time", "N*m",
          "in that section about its peak, mean in it"),
    entry(f"{TRANSIENT}waterfall/speed", "waterfall_time", "rad/s", "crank speed"),
    entry(f"{TRANSIENT}waterfall/order", "waterfall_time half_order", "N*m",
          "amplitude of the order in that section, in a window of some turns", PEAK),
    entry(f"{TRANSIENT}waterfall/frequency", "waterfall_time waterfall_frequency", "N*m",
          "amplitude at the frequency in that section, in a window of time", PEAK),
    *_PASSAGES,
    *_STEPS,
)  # fmt: skip
OF_PASSAGES = tuple(one.path for one in _PASSAGES)
OF_STEPS = tuple(one.path for one in _STEPS)

ENTRIES = (*AS_PUBLISHED, *VARIABLE_INERTIA, *TRANSIENTS)
