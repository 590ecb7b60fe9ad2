"""Results of a shaft line: modes, what the cylinders do to it, and its vibration at one speed.

Angles and torques are own ones, of the shaft they belong to. An amplitude of an order is 0-to-peak;
a half range is (highest - lowest) / 2 over the cycle of all orders together, without the mean.
"""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "response/torsion"
_BY_MODE = "mode half_order"

_OF_MODES = (
    ("natural_frequency", "mode", "rad/s",
     "with a damper the magnitude of the pole, else undamped; 0: it does not vibrate"),
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
    ("holzer_residual", "mode", "N*m", "Holzer table: sum of the last row; a mode closes at 0"),
)  # fmt: skip
MODES = tuple(entry(f"{ROOT}/modes/{name}", *rest) for name, *rest in _OF_MODES)

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
    entry(f"{ROOT}/excitation/mean_torque", "", "N*m", "of all cylinders"),
    entry(f"{ROOT}/excitation/mean_indicated_pressure", "", "Pa", "of a healthy cylinder"),
    entry(f"{ROOT}/excitation/power", "", "W", "indicated, of all cylinders"),
    entry(f"{ROOT}/excitation/firing_angle", "cylinder", "rad", "crank angle at which it fires"),
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
    entry(f"{ROOT}/torque_half_range", "section", "N*m", "half range of all orders"),
    entry(f"{ROOT}/torque_peak", "section", "N*m", "largest magnitude, mean torque in it"),
    entry(f"{ROOT}/torque_bound", "section", "N*m", "sum of the magnitudes of all orders"),
    entry(f"{ROOT}/torque_mean", "section", "N*m", "steady torque that the section carries"),
    entry(f"{ROOT}/stress_half_range", "section", "Pa", "half range of all orders"),
    entry(f"{ROOT}/section_heat", "section", "W", "dashpots and loss factors, mean power"),
    entry(f"{ROOT}/station_heat", "station", "W",
          "absolute damping, mean power; with a damping model also that of a ring it carries"),
    entry(f"{ROOT}/modal_heat", "mode", "W",
          "mean power of damping ratios given by mode, at no place in the line"),
    entry(f"{ROOT}/damper/heat", "damper", "W", "mean power"),
    entry(f"{ROOT}/damper/travel", "damper", "rad",
          "of the ring against its station, largest magnitude of all orders"),
    entry(f"{ROOT}/gear/mean_torque", "gear", "N*m", "on the first wheel"),
    entry(f"{ROOT}/gear/alternating_torque", "gear", "N*m", "on the first wheel, half range"),
    entry(f"{ROOT}/gear/least_torque", "gear", "N*m", "over the cycle, mean in it"),
    entry(f"{ROOT}/gear/hammers", "gear", "", "1: its torque changes sign; 0: it does not"),
    entry(f"{ROOT}/margin/nearest_order", "mode", "",
          "excited order nearest to the mode at the operating speed; 0: none is near"),
    entry(f"{ROOT}/margin/distance", "mode", "",
          "of the natural frequency from that order's, over the latter; infinite without one"),
    entry(f"{ROOT}/separation/operating/margin", "mode order_class", "",
          "the same to the nearest major and the nearest other order"),
    entry(f"{ROOT}/separation/operating/half_order", "mode order_class", "",
          "that order; 0: none is near"),
    entry(f"{ROOT}/separation/operating/kept", "mode order_class", "",
          "1: as far from every order as the rule of the case asks; 0: not"),
)  # fmt: skip

ENTRIES = (*MODES, *EXCITATION, *STEADY)
