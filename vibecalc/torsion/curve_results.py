"""Results of curves by order, cyclic irregularity and conditions: path, unit, axes, long name."""

from vibecalc.core.results.record import PEAK, Entry, Headline, entry

# ----------------------------------------------------------------------------
# Orders of named shafts and stations against the speed, their sums, and what was measured.
#
# Values are actual ones, of the own shaft. The axes hold the shafts or stations that the case asks
# the quantity of, and every order that is kept for one of them.
# ----------------------------------------------------------------------------

CURVES = "response/torsion/curves"
#: quantity -> axis, unit, what it is
QUANTITIES = {
    "torque": ("section", "N*m", "torque, stiffness and damping part"),
    "stress": ("section", "Pa", "shear stress, torque over section modulus"),
    "twist": ("section", "rad", "twist, first end less second"),
    "angle": ("station", "rad", "vibration against steady turning"),
    "angular_speed": ("station", "rad/s", "speed of that vibration"),
    "angular_acceleration": ("station", "rad/s^2", "acceleration of that vibration"),
}


def _of(name: str, axis: str, unit: str, words: str) -> tuple[Entry, ...]:
    place, over = f"{CURVES}/{name}", f"{axis} speed"
    one = "measured_point"
    return (
        entry(f"{place}/order", f"{axis} curve_order speed", unit, words, PEAK),
        entry(f"{place}/half_range", over, unit, f"{words}; half range of all orders"),
        entry(f"{place}/peak", over, unit, f"{words}; largest magnitude of all, without mean"),
        entry(f"{place}/sum", over, unit, f"{words}; sum of the magnitudes of all orders"),
        entry(f"{place}/largest", f"{axis} curve_order", unit,
              "amplitude of the order at any speed of the range"),
        entry(f"{place}/largest_speed", f"{axis} curve_order", "rad/s", "where that is"),
        entry(f"{place}/measured/{axis}", one, "", f"the {axis}, counted from 1"),
        entry(f"{place}/measured/speed", one, "rad/s", "crank speed of the point"),
        entry(f"{place}/measured/order", one, "", "its order; 0: half range of all orders"),
        entry(f"{place}/measured/value", one, unit, "as measured"),
        entry(f"{place}/measured/computed", one, unit, "computed at that speed"),
    )  # fmt: skip


CURVE_ENTRIES = (
    *(one for name, rest in QUANTITIES.items() for one in _of(name, *rest)),
    entry(f"{CURVES}/stress/allowed", "section speed", "Pa",
          "for lasting, by the strictest limit of the section; infinite without one"),
    entry(f"{CURVES}/stress/transient", "section speed", "Pa",
          "for passing through, by the strictest one; infinite without one"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# How evenly stations turn: (highest - lowest) / mean of the angular speed over the cycle.
# ----------------------------------------------------------------------------

IRREGULARITY = "response/torsion/irregularity"
_DEGREE = "(highest - lowest) / mean of the angular speed over the cycle"
_ELECTRICAL = "vibration times pole pairs of the generator there, half range"

IRREGULARITY_ENTRIES = (
    entry(f"{IRREGULARITY}/degree", "station", "", _DEGREE,
          headline=Headline("cyclic irregularity at speed")),
    entry(f"{IRREGULARITY}/electrical_angle", "station", "rad", _ELECTRICAL),
    entry(f"{IRREGULARITY}/speeds/degree", "station speed", "", _DEGREE,
          curve="cyclic_irregularity"),
    entry(f"{IRREGULARITY}/speeds/electrical_angle", "station speed", "rad", _ELECTRICAL,
          curve="cyclic_irregularity"),
    entry(f"{IRREGULARITY}/largest/degree", "station", "", "at any speed of the range",
          headline=Headline("cyclic irregularity over the speeds",
                            at=f"{IRREGULARITY}/largest/speed")),
    entry(f"{IRREGULARITY}/largest/speed", "station", "rad/s", "where that is"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# The worst of conditions of the cylinders: all fire, each misfires, pressures differ.
# ----------------------------------------------------------------------------

CONDITIONS = "response/torsion/conditions"
_WORST = "half range, in the condition where it is largest"

CONDITION_ENTRIES = (
    entry(f"{CONDITIONS}/torque_half_range", "condition section", "N*m",
          "at the operating speed, half range of all orders"),
    entry(f"{CONDITIONS}/stress_half_range", "condition section", "Pa",
          "at the operating speed, half range of all orders"),
    entry(f"{CONDITIONS}/angle_half_range", "condition station", "rad",
          "at the operating speed, half range of all orders"),
    entry(f"{CONDITIONS}/irregularity", "condition station", "",
          f"at the operating speed, {_DEGREE}"),
    entry(f"{CONDITIONS}/mean_torque", "condition", "N*m", "of all cylinders at that speed"),
    entry(f"{CONDITIONS}/speeds/torque_half_range", "section speed", "N*m", _WORST),
    entry(f"{CONDITIONS}/speeds/stress_half_range", "section speed", "Pa", _WORST,
          curve="worst_condition"),
    entry(f"{CONDITIONS}/speeds/angle_half_range", "station speed", "rad", _WORST,
          curve="worst_condition"),
    *(one for of, unit, of_what in (("torque", "N*m", "section"), ("stress", "Pa", "section"),
                                    ("angle", "rad", "station"))
      for one in (
          entry(f"{CONDITIONS}/largest/{of}_half_range", of_what, unit,
                "in any condition at any speed",
                headline=Headline("stress in the worst condition, half range",
                                  "N/mm^2") if of == "stress" else None),
      )),
    *(one for of_what in ("section", "station") for one in (
          entry(f"{CONDITIONS}/largest/{of_what}_speed", of_what, "rad/s", "where that is"),
          entry(f"{CONDITIONS}/largest/{of_what}_condition", of_what, "",
                "and in which condition, counted from 1"),
      )),
)  # fmt: skip

#: axis name -> (unit, long name)
CURVE_AXES = {
    "curve_order": ("", "order that is kept, multiple of crank speed, also halves"),
    "measured_point": ("", "measured point, in the order of the case"),
    "condition": ("", "condition of the cylinders"),
}
EVERY = (*CURVE_ENTRIES, *IRREGULARITY_ENTRIES, *CONDITION_ENTRIES)
