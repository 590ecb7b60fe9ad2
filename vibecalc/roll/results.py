"""Results of a machine whose motor finds the speed: roll, motor, start-up, control."""

from vibecalc.core.results.record import (
    CANCELS,
    CHECK,
    DIFFERENCE,
    EXAMINED,
    MARCH,
    MARCHED,
    PEAK,
    PLACE,
    SEARCHED,
    SPECTRUM,
    TURN,
    Entry,
    Headline,
    entry,
    under,
)

# ----------------------------------------------------------------------------
# Results of rotor, pistons and shell in their periodic motion under a real motor.
# ----------------------------------------------------------------------------

ROLL = "response/roll"
SHAKING = f"{ROLL}/shaking"

#: variables with harmonics, levels and a course over the turn: unit, long name
VARIABLES: dict[str, tuple[str, str]] = {
    "shell_acceleration": ("rad/s^2", "angular acceleration of the shell"),
    "rotor_acceleration": ("rad/s^2", "angular acceleration of the rotor against the ground"),
    "crank_speed": ("rad/s", "speed of the crank against the shell"),
    "slip": ("rad/s", "slip speed of the motor"),
    "motor_torque": ("N*m", "torque of the motor"),
    "gas_torque": ("N*m", "torque of the gas on the crankshaft"),
    "mount_torque": ("N*m", "torque of the mounts on the shell"),
}
#: the same, one for each cylinder
FORCES: dict[str, tuple[str, str]] = {
    "rod_force": ("N", "force along the connecting rod, positive in compression"),
    "wall_force": ("N", "force of a piston on its wall"),
}
_SHELL = Headline("roll acceleration of the shell, dominant order", "dB")
_PEAKS = {
    "rod_force": Headline("rod force, peak", "kN"),
    "wall_force": Headline("force on the cylinder wall, peak", "kN"),
}
#: works of one turn, of which that of the motor feeds the others
_WORK = f"{ROLL}/energy/motor"
WORKS = {
    "motor": "of the motor",
    "gas": "absorbed by the gas",
    "friction": "dissipated by friction",
    "mounts": "dissipated by the mounts",
}
_BY_ORDER = "order"
_BY_CYLINDER = "cylinder order"

ROLL_ENTRIES = under(
    ROLL,
    entry("speed", "", "rad/s", "mean speed of the crank against the shell",
          headline=Headline("mean speed", "rpm")),
    entry("speed_variation", "", "", "(max - min) / mean of the crank speed over a turn",
          headline=Headline("cyclic irregularity of the crank speed")),
    entry("mean_slip", "", "rad/s", "mean slip speed of the motor"),
    entry("largest_slip", "", "rad/s", "largest slip speed in a turn"),
    entry("mean_torque", "", "N*m", "mean torque of the motor over the crank angle",
          headline=Headline("motor torque, mean", "N*m")),
    entry("largest_torque", "", "N*m", "largest torque of the motor in a turn",
          headline=Headline("motor torque, peak", "N*m")),
    entry("breakdown_margin", "", "", "breakdown torque of the motor / mean torque - 1",
          headline=Headline("breakdown torque margin, T_max / T_mean - 1")),
    entry("shell_drift", "", "rad/s", "mean angular speed of the shell"),
    entry("angular_momentum", "", "N*m*s", "mean angular momentum about the crank axis"),
    *(
        entry(name, _BY_ORDER, unit, words, PEAK, name=words)
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(name, _BY_CYLINDER, unit, words, PEAK)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"level/{name}", axes, "dB", f"{words}, dB re 1 {unit} zero-to-peak",
              headline=_SHELL if name == "shell_acceleration" else None, exempt=SPECTRUM,
              name=f"level of the {words}")
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (unit, words) in kinds.items()
    ),
    *(
        entry(f"phase_lag/{name}", axes, "rad",
              f"{words}: angle by which it lags, x = C cos(n W t - lag), t = 0 at crank angle 0",
              exempt=SPECTRUM, circle=TURN, name=f"phase lag of the {words}")
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (_, words) in kinds.items()
    ),
    *(
        entry(f"cycle/{name}", "crank_angle", unit, f"{words} over a turn")
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(f"cycle/{name}", "cylinder crank_angle", unit, f"{words} over a turn",
              curve="piston_forces")
        for name, (unit, words) in FORCES.items()
    ),
    entry("cycle/gas_force", "cylinder crank_angle", "N", "force of the gas on the piston",
          curve="piston_forces"),
    entry("cycle/time", "crank_angle", "s", "time since crank angle 0"),
    entry("multiplier", "multiplier", "", "Floquet multiplier of the motion, complex"),
    entry("largest_multiplier", "", "", "magnitude of the largest of them"),
    entry("trivial_multipliers", "", "",
          "multipliers that equal 1 by symmetry: phase, and for a free shell its angle and "
          "momentum"),
    *(
        entry(f"energy/{name}", "", "J", f"work {words} in a turn", part_of=_WORK)
        for name, words in WORKS.items()
    ),
    entry("energy/residual", "", "J", "energy balance error; zero for the exact motion",
          exempt=CHECK, diagnostic=True),
    entry("momentum_residual", "", "N*m*s", "error of the angular momentum balance", exempt=CHECK,
          diagnostic=True, name="error of the angular momentum balance"),
    entry("interpolation/level", "interpolant order", "dB",
          "level of the shell acceleration with each interpolation of the gas forces"),
    entry("interpolation/spread", "order", "dB", "range of these levels: ambiguity of the table",
          exempt=DIFFERENCE),
    entry("method/level", "method order", "dB", "level of the shell acceleration",
          exempt=DIFFERENCE),
    entry("method/difference", "method order", "dB",
          "difference of that level from the method of the case", exempt=DIFFERENCE),
    entry("method/work", "method", "", "evaluations of the right-hand side, in points",
          exempt=DIFFERENCE, diagnostic=True),
    entry("sensitivity/level", "parameter order", "dB",
          "change of the level of the shell acceleration for one percent more of the parameter",
          exempt=DIFFERENCE),
    *(
        entry(f"sensitivity/ten_percent_{word}", "parameter order", "dB",
              f"change of that level with ten percent {word} of the parameter, each solved anew",
              exempt=DIFFERENCE)
        for word in ("more", "less")
    ),
    *(
        entry(f"classical/{name}_peak", "cylinder", unit, f"largest {words}, constant speed",
              exempt=DIFFERENCE)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"{name}_peak", "cylinder", unit, f"largest magnitude of the {words}",
              headline=_PEAKS[name])
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"classical/{name}_error", "cylinder", "",
              f"largest error over a turn of the {words} at constant speed, over its peak",
              exempt=DIFFERENCE)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"classical/{name}_error_by_order", "cylinder order", unit,
              f"error of the harmonics of the {words} at constant speed", exempt=DIFFERENCE)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        one
        for name, unit in (("force", "N"), ("couple", "N*m"))
        for one in (
            entry(f"shaking/{name}", "order direction", unit,
                  f"{name} of the masses on the body at constant speed, shell fixed", PEAK),
            entry(f"shaking/{name}_peak", "direction", unit,
                  f"shaking {name}, peak over a turn, all orders",
                  headline=Headline(f"shaking {name}, peak", unit)),
        )
    ),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of a motor whose fluxes are states: its fit to the slip table, what its transients do.
# ----------------------------------------------------------------------------

MOTOR = "response/roll/motor"

#: where the electrical energy of a turn goes
ENERGIES: dict[str, str] = {
    "electrical": "energy from the line in a turn",
    "stator_copper": "heat in the windings of the stator in a turn",
    "rotor_copper": "heat in the cages of the rotor in a turn",
    "mechanical": "work on the crankshaft in a turn",
    "residual": "energy balance error; zero for the exact motion",
}

MOTOR_ENTRIES = under(
    MOTOR,
    entry("stator_leakage", "", "H", "leakage inductance of the stator"),
    entry("magnetising_inductance", "", "H", "magnetising inductance"),
    entry("rotor_resistance", "cage", "ohm", "resistance of a cage, as seen by the stator"),
    entry("rotor_leakage", "cage", "H", "leakage of a cage, as seen by the stator"),
    entry("parameter_spread", "motor_parameter", "",
          "relative standard error of a parameter for 1 % error in every row of the table, "
          "assumed values fixed"),
    entry("parameter_free_spread", "motor_parameter", "",
          "the same without assumed values; infinite: not identifiable"),
    entry("singular_value", "combination", "",
          "sensitivity of the logarithms of the torques to a product of powers of the parameters"),
    entry("combination", "combination motor_parameter", "", "exponents of that product"),
    entry("combination_spread", "combination", "",
          "relative standard error of that product for 1 % error in every row of the table"),
    entry("table/torque", "slip", "N*m", "torque of the slip table", exempt=DIFFERENCE),
    entry("table/fitted", "slip", "N*m", "steady torque of the fitted motor", exempt=DIFFERENCE),
    entry("table/difference", "slip", "N*m", "steady torque - torque of the table",
          exempt=DIFFERENCE),
    entry("table/relative_difference", "slip", "", "the same / torque of the table",
          exempt=DIFFERENCE),
    entry("table/used", "slip", "", "1: row used in the fit, 0: not used", exempt=DIFFERENCE),
    entry("worst_difference", "", "", "largest relative difference from a fitted row",
          exempt=DIFFERENCE),
    entry("rms_difference", "", "", "root of the mean square of these differences",
          exempt=DIFFERENCE),
    entry("curve", "slip", "N*m", "steady torque of the fitted motor"),
    entry("breakdown_slip", "", "rad/s", "slip at the largest steady torque"),
    entry("breakdown_torque", "", "N*m", "largest steady torque"),
    entry("locked_rotor_torque", "", "N*m", "torque at standstill"),
    entry("gain", "", "N*m*s/rad", "slope of the steady torque at synchronous speed"),
    entry("stator_time", "", "s", "time constant of the stator, fluxes of the rotor held"),
    entry("rotor_open_time", "cage", "s", "time constant of the rotor, stator open"),
    entry("rotor_short_time", "cage", "s", "time constant of the rotor, stator shorted"),
    entry("transient_decay_time", "transient", "s",
          "time constant of a transient at the mean slip, constant speed"),
    entry("transient_frequency", "transient", "rad/s",
          "frequency of the torque pulsation by the transient"),
    entry("torque_answer", "order", "N*m*s/rad",
          "torque response to a small harmonic of the crank speed about the mean slip, complex"),
    entry("static_answer", "", "N*m*s/rad",
          "quasi-static torque response: minus the slope of the steady curve"),
    *(
        entry(f"energy/{name}", "", "J", words, exempt=CHECK * (name == "residual"),
              diagnostic=name == "residual")
        for name, words in ENERGIES.items()
    ),
    entry("static_speed", "", "rad/s", "mean crank speed with the steady torque"),
    entry("table_speed", "", "rad/s", "mean crank speed with the slip table"),
    entry("static_level", "order", "dB",
          "level of the shell acceleration with the steady torque of the same motor at every slip, "
          "dB re 1 rad/s^2 zero-to-peak"),
    entry("table_level", "order", "dB",
          "level of the shell acceleration with the slip table as the torque at every slip, "
          "dB re 1 rad/s^2 zero-to-peak"),
    entry("dynamics_change", "order", "dB",
          "change of the level of the shell acceleration by the motor transients",
          exempt=DIFFERENCE),
    entry("fit_change", "order", "dB",
          "change of that level by the fitted curve instead of the table, without transients",
          exempt=DIFFERENCE),
    entry("cycle/static_slip", "crank_angle", "rad/s", "slip with its steady torque"),
    entry("cycle/static_torque", "crank_angle", "N*m", "its steady torque over a turn"),
)  # fmt: skip

#: what has to be solved for next to the motion that the case asks for
COMPARED = (
    *(f"{MOTOR}/{name}_{of}" for of in ("speed", "level") for name in ("static", "table")),
    *(f"{MOTOR}/{name}_change" for name in ("dynamics", "fit")),
    *(f"{MOTOR}/cycle/static_{name}" for name in ("slip", "torque")),
)

# ----------------------------------------------------------------------------
# Results of a start-up or a change of load in time, of a machine whose motor finds its speed.
# ----------------------------------------------------------------------------

START = "response/start_up"

#: quantities with a peak on the way: unit, long name
PEAKS: dict[str, tuple[str, str]] = {
    "shell_angle": ("rad", "angle of the shell"),
    "shell_acceleration": ("rad/s^2", "angular acceleration of the shell"),
    "rotor_acceleration": ("rad/s^2", "angular acceleration of the rotor against the ground"),
    "crank_speed": ("rad/s", "speed of the crank against the shell"),
    "motor_torque": ("N*m", "torque of the motor"),
    "mount_torque": ("N*m", "torque of the mounts on the shell"),
}
_LEADING = {
    "shell_angle": Headline("roll of the shell during start, peak", "mrad"),
    "motor_torque": Headline("motor torque during start, peak", "N*m"),
    "mount_torque": Headline("mount torque during start, peak", "N*m"),
}
#: those with a history
HISTORIES = ("shell_angle", "shell_acceleration", "crank_speed", "motor_torque", "mount_torque")
#: those with a peak after each change of the load
STEPPED = ("shell_angle", "shell_acceleration", "motor_torque", "mount_torque")

START_UP_ENTRIES = under(
    START,
    entry("started", "", "", "1: running at the end, above the breakdown speed; 0: not"),
    entry("settled", "", "", "1: vibration settled too; 0: not"),
    entry("running_speed", "", "rad/s", "mean crank speed of the last whole turn; 0 without one",
          headline=Headline("mean speed after the start", "rpm")),
    entry("time_to_speed", "", "s",
          "time at which the crank reaches that speed; infinite if it does not start"),
    entry("time_to_steady", "", "s",
          "start of the first turn with settled vibration; infinite if not settled",
          headline=Headline("time to steady running", "s")),
    entry("turns_to_steady", "", "",
          "turns to that time from the start or the last change of load"),
    *(
        item
        for name, (unit, words) in PEAKS.items()
        for item in (
            entry(f"{name}_peak", "", unit, f"largest magnitude of the {words}",
                  headline=_LEADING.get(name), exempt=MARCHED),
            entry(f"{name}_peak_time", "", "s", f"time of the largest {words}", exempt=PLACE),
        )
    ),
    entry("energy/motor", "", "J", "work of the motor over the whole time"),
    entry("energy/gas", "", "J", "work absorbed by the gas"),
    entry("energy/friction", "", "J", "work dissipated by friction"),
    entry("energy/mounts", "", "J", "work dissipated by the mount damping"),
    entry("energy/stored", "", "J", "increase of kinetic and mount energy"),
    entry("energy/residual", "", "J", "energy balance error; zero for the exact motion",
          exempt=CHECK, diagnostic=True),
    *(
        entry(f"history/{name}_{end}", "start_time", PEAKS[name][0],
              f"{words} of the {PEAKS[name][1]} in each interval of time", exempt=MARCHED)
        for name in HISTORIES
        for end, words in (("low", "smallest sample"), ("high", "largest sample"))
    ),
    entry("turn/begin", "turn", "s", "start time of each whole turn, at crank angle 0"),
    entry("turn/speed", "turn", "rad/s", "mean crank speed of each whole turn"),
    entry("turn/shell_acceleration", "turn", "rad/s^2",
          "half range of the shell acceleration in each whole turn", exempt=MARCHED),
    entry("load/factor", "load_step", "", "factor on the gas forces from that time"),
    entry("load/speed", "load_step", "rad/s",
          "mean crank speed of the last whole turn under that load; 0 without one"),
    *(
        entry(f"load/{name}_peak", "load_step", PEAKS[name][0],
              f"largest magnitude of the {PEAKS[name][1]} under that load", exempt=MARCHED)
        for name in STEPPED
    ),
    entry("start_angles/starts", "start_angle", "", "1: starts from that angle", exempt=MARCHED),
    entry("start_angles/lower", "start_interval", "rad",
          "first crank angle of a range of starts from rest under full load", exempt=MARCHED,
          circle=TURN),
    entry("start_angles/upper", "start_interval", "rad",
          "last crank angle of that range; above one turn where it includes 0", exempt=MARCHED,
          circle=TURN),
    entry("start_angles/fraction", "", "", "share of all crank angles with a start",
          exempt=MARCHED),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of the control of a motor: the reduced model, its margins, and what the full one says.
# ----------------------------------------------------------------------------

CONTROL = "response/control"

_LEVEL = "level of the shell's acceleration, dB re 1 rad/s^2 zero-to-peak"
_STATUS = (
    "0 stable, 1 stable for zero delay only, 2 marginally stable, 3 unstable, 4 unstable for any "
    "lag"
)
#: name, unit, long name of what every loop has
LOOP: tuple[tuple[str, str, str], ...] = (
    ("status", "", f"stability of the loop: {_STATUS}"),
    ("gain_margin", "dB", "gain margin, upward"),
    ("gain_reduction", "dB", "gain margin, downward"),
    ("phase_margin", "rad", "phase margin, lag or lead"),
    ("delay_margin", "s", "delay margin"),
    ("bandwidth", "rad/s", "highest gain crossover frequency"),
    ("feedthrough", "", "gain of the loop at high frequency"),
    ("command_rate", "rad/s^2", "maximum rate of change of the synchronous speed"),
    ("torque_peak", "N*m", "peak motor torque in a turn"),
)

_MARGINS = {
    "gain_margin": Headline("tuned controller, gain margin", "dB"),
    "phase_margin": Headline("tuned controller, phase margin", "deg"),
}


def _loop(below: str, axes: str, of: str) -> tuple[Entry, ...]:
    return tuple(
        entry(f"{below}{name}", axes, unit, f"{words}{of}",
              headline=_MARGINS.get(name) if below == "tuned/" else None)
        for name, unit, words in LOOP
    )  # fmt: skip


CONTROL_ENTRIES = under(
    CONTROL,
    entry("motor_gain", "", "N*m*s/rad", "slope of the motor torque over slip"),
    entry("motor_offset", "", "N*m", "motor torque at zero slip, linear curve"),
    entry("breakdown_torque", "", "N*m", "largest torque of the motor"),
    entry("inertia", "", "kg*m^2", "inertia accelerated by the motor"),
    entry("shell_share", "", "", "acceleration ratio, shell / crank"),
    entry("mean_torque", "", "N*m", "mean torque of gas and friction on the rotor",
          name="mean torque of gas and friction"),
    entry("disturbance", "order", "N*m",
          "torque of gas and pistons on the rotor at "
          "constant speed", PEAK, name="torque of gas and pistons at constant speed"),
    entry("speed_without", "", "rad/s", "mean speed of the reduced model, no control"),
    entry("target_speed", "", "rad/s", "target mean speed of the speed feedback"),
    entry("speed", "", "rad/s", "mean speed of the reduced model under control",
          headline=Headline("speed under control", "rpm")),
    entry("speed_feedback", "", "", "feedback factor of the speed"),
    entry("speed_feedback_limit", "", "",
          "speed feedback for the target speed, "
          "infinite gain"),
    entry("shell_acceleration", "order", "rad/s^2",
          "angular acceleration of the shell "
          "under control; infinite if the loop is not stable", PEAK),
    entry("level", "order", "dB", f"{_LEVEL}, under control"),
    entry("level_without", "order", "dB", f"{_LEVEL}, without control"),
    entry("attenuation", "order", "dB", "reduction of the level by control"),
    entry("pole", "pole", "1/s", "pole of the closed loop, complex"),
    *_loop("", "", ""),
    entry("motor_gains/speed", "motor_gain", "rad/s", "mean speed with another motor"),
    entry("motor_gains/level", "motor_gain order", "dB", f"{_LEVEL}, no control",
          name="level of the shell's acceleration with another motor"),
    entry("grid/speed_feedback", "gain", "", "speed feedback for the target speed"),
    entry("grid/level", "gain feedback order", "dB", _LEVEL),
    entry("grid/attenuation", "gain feedback order", "dB", "reduction by control"),
    *_loop("grid/", "gain feedback", ", over gain and feedback"),
    entry("locus/pole", "locus_gain branch", "1/s", "poles as the gain grows, complex"),
    entry("tuned/gain", "", "", "tuned gain", exempt=SEARCHED),
    entry("tuned/acceleration_feedback", "", "s", "tuned acceleration feedback", exempt=SEARCHED),
    entry("tuned/speed_feedback", "", "", "speed feedback with the tuned gains", exempt=SEARCHED),
    entry("tuned/objective", "", "dB",
          "largest level of the orders to be reduced, dB re 1 rad/s^2 zero-to-peak",
          headline=Headline("tuned controller, minimised level", "dB")),
    entry("tuned/level", "order", "dB", f"{_LEVEL}, tuned gains"),
    entry("tuned/attenuation", "order", "dB", "reduction by the tuned gains"),
    *_loop("tuned/", "", ", tuned gains"),
    entry("tuned/active", "bound", "", "1: active bound"),
    entry("tuned/multiplier", "bound", "dB",
          "reduction of the level per relative "
          "relaxation of the bound, first order", exempt=SEARCHED),
    entry("tuned/residual", "", "", "residual of the optimality condition", exempt=SEARCHED,
          diagnostic=True),
    entry("full/speed", "", "rad/s", "mean speed of the full model under control"),
    entry("full/level", "order", "dB",
          f"{_LEVEL}, full model under control; infinite "
          "if its motion is unstable"),
    entry("full/difference", "order", "dB", "difference of that level from the reduced model"),
    entry("full/attenuation", "order", "dB", "reduction by control in the full model"),
    entry("full/multiplier", "multiplier", "", "Floquet multiplier of the full model"),
    entry("full/stable", "", "", "1 if its motion is stable, else 0"),
    entry("full/largest_slip", "", "rad/s", "largest slip of the motor under control",
          exempt=EXAMINED),
    entry("range/level", "order", "dB", f"{_LEVEL}, full model without control"),
    entry("range/difference", "order", "dB",
          "difference of that level from the "
          "reduced model"),
    entry("range/linear_difference", "order", "dB",
          "the same, full model with the "
          "linear motor curve of the reduced one"),
)  # fmt: skip

#: axis name -> (unit, long name)
AXES = {
    "multiplier": ("", "Floquet multiplier, largest first"),
    "interpolant": ("", "interpolation of the gas tables"),
    "parameter": ("", "parameter of the machine"),
    "start_time": ("s", "end of an interval of time"),
    "turn": ("", "whole turn of the crank, the first is 1"),
    "load_step": ("s", "start time of a constant load"),
    "start_angle": ("rad", "crank angle of a start from rest"),
    "start_interval": ("", "interval of crank angles, ascending"),
    "slip": ("rad/s", "slip speed"),
    "cage": ("", "cage of the rotor"),
    "motor_parameter": ("", "parameter of the motor"),
    "combination": ("", "product of powers of the motor's parameters, best determined first"),
    "transient": ("", "electrical transient, least damped first"),
    "motor_gain": ("N*m*s/rad", "slope of the motor torque over slip"),
    "gain": ("", "gain of the controller"),
    "feedback": ("s", "feedback of the shell's acceleration"),
    "locus_gain": ("", "gain of the controller"),
    "branch": ("", "branch of the root locus"),
    "bound": ("", "bound of the gains"),
}
ENTRIES = (
    *ROLL_ENTRIES,
    *START_UP_ENTRIES,
    *MOTOR_ENTRIES,
    *CONTROL_ENTRIES,
)
HELPS = {f"{ROLL}/": (CANCELS,), f"{CONTROL}/": (CANCELS,), f"{START}/": (MARCH,)}
