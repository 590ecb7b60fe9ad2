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
_SHELL = Headline("roll acceleration of the shell, top order", "dB")
_PEAKS = {
    "rod_force": Headline("rod force, peak", "kN"),
    "wall_force": Headline("force on the cylinder wall, peak", "kN"),
}
#: works of one turn, of which that of the motor feeds the others
_WORK = f"{ROLL}/energy/motor"
WORKS = {
    "motor": "of the motor",
    "gas": "that the gas takes",
    "friction": "that friction takes",
    "mounts": "that the mounts take",
}
_BY_ORDER = "order"
_BY_CYLINDER = "cylinder order"

ROLL_ENTRIES = (
    entry(f"{ROLL}/speed", "", "rad/s", "mean speed of the crank against the shell",
          headline=Headline("mean speed", "rpm")),
    entry(f"{ROLL}/speed_variation", "", "", "largest less smallest crank speed, over the mean",
          headline=Headline("range of the speed in a turn, over the mean")),
    entry(f"{ROLL}/mean_slip", "", "rad/s", "mean slip speed of the motor"),
    entry(f"{ROLL}/largest_slip", "", "rad/s", "largest slip speed in a turn"),
    entry(f"{ROLL}/mean_torque", "", "N*m", "mean torque of the motor over the crank angle",
          headline=Headline("motor torque, mean", "N*m")),
    entry(f"{ROLL}/largest_torque", "", "N*m", "largest torque of the motor in a turn",
          headline=Headline("motor torque, largest in a turn", "N*m")),
    entry(f"{ROLL}/breakdown_margin", "", "", "breakdown torque of the motor over it, less 1",
          headline=Headline("breakdown torque over the mean motor torque, less 1")),
    entry(f"{ROLL}/shell_drift", "", "rad/s", "mean angular speed of the shell"),
    entry(f"{ROLL}/angular_momentum", "", "N*m*s", "mean angular momentum about the crank axis"),
    *(
        entry(f"{ROLL}/{name}", _BY_ORDER, unit, words, PEAK)
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(f"{ROLL}/{name}", _BY_CYLINDER, unit, words, PEAK)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"{ROLL}/level/{name}", axes, "dB", f"{words}, dB re 1 {unit} zero-to-peak",
              headline=_SHELL if name == "shell_acceleration" else None, exempt=SPECTRUM)
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (unit, words) in kinds.items()
    ),
    *(
        entry(
            f"{ROLL}/phase_lag/{name}", axes, "rad",
            f"{words}: angle by which it lags, x = C cos(n W t - lag), t = 0 at crank angle 0",
            exempt=SPECTRUM, circle=TURN,
        )
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (_, words) in kinds.items()
    ),
    *(
        entry(f"{ROLL}/cycle/{name}", "crank_angle", unit, f"{words} over a turn")
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(f"{ROLL}/cycle/{name}", "cylinder crank_angle", unit, f"{words} over a turn",
              curve="piston_forces")
        for name, (unit, words) in FORCES.items()
    ),
    entry(f"{ROLL}/cycle/gas_force", "cylinder crank_angle", "N", "force of the gas on the piston",
          curve="piston_forces"),
    entry(f"{ROLL}/cycle/time", "crank_angle", "s", "time since crank angle 0"),
    entry(f"{ROLL}/multiplier", "multiplier", "", "Floquet multiplier of the motion, complex"),
    entry(f"{ROLL}/largest_multiplier", "", "", "magnitude of the largest of them"),
    entry(
        f"{ROLL}/trivial_multipliers", "", "",
        "multipliers that are 1 whatever the machine: phase, and for a free shell its angle and "
        "its momentum",
    ),
    *(
        entry(f"{ROLL}/energy/{name}", "", "J", f"work {words} in a turn", part_of=_WORK)
        for name, words in WORKS.items()
    ),
    entry(f"{ROLL}/energy/residual", "", "J", "what is left over; zero for the exact motion",
          exempt=CHECK, diagnostic=True),
    entry(
        f"{ROLL}/momentum_residual", "", "N*m*s",
        "how far the angular momentum strays from what the mounts explain", exempt=CHECK,
        diagnostic=True),
    entry(
        f"{ROLL}/interpolation/level", "interpolant order", "dB",
        "level of the shell acceleration with each interpolation of the gas forces",
    ),
    entry(
        f"{ROLL}/interpolation/spread", "order", "dB",
        "largest less smallest of these: what the table leaves open", exempt=DIFFERENCE),
    entry(f"{ROLL}/method/level", "method order", "dB", "level of the shell acceleration",
          exempt=DIFFERENCE),
    entry(
        f"{ROLL}/method/difference", "method order", "dB",
        "that level less the one of the method of the case", exempt=DIFFERENCE),
    entry(f"{ROLL}/method/work", "method", "", "evaluations of the right-hand side, in points",
          exempt=DIFFERENCE, diagnostic=True),
    entry(
        f"{ROLL}/sensitivity/level", "parameter order", "dB",
        "change of the level of the shell acceleration for one percent more of the parameter",
        exempt=DIFFERENCE),
    *(
        entry(
            f"{ROLL}/sensitivity/ten_percent_{word}", "parameter order", "dB",
            f"change of that level with ten percent {word} of the parameter, each solved for",
            exempt=DIFFERENCE,
        )
        for word in ("more", "less")
    ),
    *(
        entry(f"{ROLL}/classical/{name}_peak", "cylinder", unit, f"largest {words}, constant speed",
              exempt=DIFFERENCE)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"{ROLL}/{name}_peak", "cylinder", unit, f"largest magnitude of the {words}",
              headline=_PEAKS[name])
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(
            f"{ROLL}/classical/{name}_error", "cylinder", "",
            f"largest error over a turn of the {words} at constant speed, over its peak",
            exempt=DIFFERENCE,
        )
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(
            f"{ROLL}/classical/{name}_error_by_order", "cylinder order", unit,
            f"error of the harmonics of the {words} at constant speed",
            exempt=DIFFERENCE,
        )
        for name, (unit, words) in FORCES.items()
    ),
    *(
        one
        for name, unit in (("force", "N"), ("couple", "N*m"))
        for one in (
            entry(
                f"{SHAKING}/{name}", "order direction", unit,
                f"{name} of the masses on the body at constant speed, the shell held", PEAK,
            ),
            entry(
                f"{SHAKING}/{name}_peak", "direction", unit,
                f"its largest magnitude over a turn ({name}), all orders",
                headline=Headline(f"shaking {name}, peak", unit),
            ),
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
    "residual": "what is left over; zero for the exact motion",
}

MOTOR_ENTRIES = (
    entry(f"{MOTOR}/stator_leakage", "", "H", "leakage inductance of the stator"),
    entry(f"{MOTOR}/magnetising_inductance", "", "H", "magnetising inductance"),
    entry(f"{MOTOR}/rotor_resistance", "cage", "ohm",
          "resistance of a cage, as seen by the stator"),
    entry(f"{MOTOR}/rotor_leakage", "cage", "H", "leakage of a cage, as seen by the stator"),
    entry(
        f"{MOTOR}/parameter_spread", "motor_parameter", "",
        "standard error of a parameter's logarithm for 1 % of error in every row of the table, "
        "what is assumed being held",
    ),
    entry(
        f"{MOTOR}/parameter_free_spread", "motor_parameter", "",
        "the same with nothing assumed; infinite where the table does not tell the parameter",
    ),
    entry(
        f"{MOTOR}/singular_value", "combination", "",
        "answer of the logarithms of the torques to a product of powers of the parameters",
    ),
    entry(f"{MOTOR}/combination", "combination motor_parameter", "", "exponents of that product"),
    entry(
        f"{MOTOR}/combination_spread", "combination", "",
        "standard error of its logarithm for 1 % of error in every row of the table",
    ),
    entry(f"{MOTOR}/table/torque", "slip", "N*m", "torque of the slip table", exempt=DIFFERENCE),
    entry(f"{MOTOR}/table/fitted", "slip", "N*m", "steady torque of the fitted motor",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/table/difference", "slip", "N*m", "steady torque less that of the table",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/table/relative_difference", "slip", "", "the same over that of the table",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/table/used", "slip", "", "1 for a row that is fitted, 0 for one that is not",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/worst_difference", "", "", "largest relative difference from a fitted row",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/rms_difference", "", "", "root of the mean square of these differences",
          exempt=DIFFERENCE),
    entry(f"{MOTOR}/curve", "slip", "N*m", "steady torque of the fitted motor"),
    entry(f"{MOTOR}/breakdown_slip", "", "rad/s", "slip at the largest steady torque"),
    entry(f"{MOTOR}/breakdown_torque", "", "N*m", "largest steady torque"),
    entry(f"{MOTOR}/locked_rotor_torque", "", "N*m", "torque at standstill"),
    entry(f"{MOTOR}/gain", "", "N*m*s/rad", "slope of the steady torque at synchronous speed"),
    entry(f"{MOTOR}/stator_time", "", "s", "time constant of the stator, fluxes of the rotor held"),
    entry(f"{MOTOR}/rotor_open_time", "cage", "s", "time constant of the rotor, stator open"),
    entry(f"{MOTOR}/rotor_short_time", "cage", "s", "time constant of the rotor, stator shorted"),
    entry(
        f"{MOTOR}/transient_decay_time", "transient", "s",
        "time in which a transient at the mean slip falls to 1/e, the speed held",
    ),
    entry(
        f"{MOTOR}/transient_frequency", "transient", "rad/s",
        "frequency with which it makes the torque pulsate",
    ),
    entry(
        f"{MOTOR}/torque_answer", "order", "N*m*s/rad",
        "torque for a small harmonic of the crank's speed about the mean slip, complex",
    ),
    entry(
        f"{MOTOR}/static_answer", "", "N*m*s/rad",
        "the same for a slow change: minus the slope of the steady curve",
    ),
    *(
        entry(f"{MOTOR}/energy/{name}", "", "J", words, exempt=CHECK * (name == "residual"),
              diagnostic=name == "residual")
        for name, words in ENERGIES.items()
    ),
    entry(f"{MOTOR}/static_speed", "", "rad/s", "mean crank speed with its steady torque"),
    entry(f"{MOTOR}/table_speed", "", "rad/s", "mean crank speed with the slip table"),
    entry(
        f"{MOTOR}/static_level", "order", "dB",
        "level of the shell acceleration with the steady torque of the same motor at every slip, "
        "dB re 1 rad/s^2 zero-to-peak",
    ),
    entry(
        f"{MOTOR}/table_level", "order", "dB",
        "level of the shell acceleration with the slip table as the torque at every slip, "
        "dB re 1 rad/s^2 zero-to-peak",
    ),
    entry(
        f"{MOTOR}/dynamics_change", "order", "dB",
        "what the transients of the motor change in the level of the shell acceleration",
        exempt=DIFFERENCE),
    entry(
        f"{MOTOR}/fit_change", "order", "dB",
        "what the fitted curve in place of the table changes in it, without transients",
        exempt=DIFFERENCE),
    entry(f"{MOTOR}/cycle/static_slip", "crank_angle", "rad/s", "slip with its steady torque"),
    entry(f"{MOTOR}/cycle/static_torque", "crank_angle", "N*m", "its steady torque over a turn"),
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
    "shell_angle": Headline("roll of the shell in the start, peak", "mrad"),
    "motor_torque": Headline("motor torque in the start, peak", "N*m"),
    "mount_torque": Headline("torque on the mounts in the start, peak", "N*m"),
}
#: those with a history
HISTORIES = ("shell_angle", "shell_acceleration", "crank_speed", "motor_torque", "mount_torque")
#: those with a peak after each change of the load
STEPPED = ("shell_angle", "shell_acceleration", "motor_torque", "mount_torque")

START_UP_ENTRIES = (
    entry(f"{START}/started", "", "",
          "1 if it runs at the end, above the speed of breakdown; or 0"),
    entry(f"{START}/settled", "", "", "1 if its shaking has settled too; or 0"),
    entry(
        f"{START}/running_speed", "", "rad/s",
        "mean crank speed of the last whole turn; 0 if it no longer turns over",
        headline=Headline("speed after the start", "rpm")),
    entry(
        f"{START}/time_to_speed", "", "s",
        "when the crank first has the speed of that turn; infinite if it does not start",
    ),
    entry(
        f"{START}/time_to_steady", "", "s",
        "begin of the first turn from which on the shaking has settled; infinite if it has not",
        headline=Headline("time to steady running", "s")),
    entry(
        f"{START}/turns_to_steady", "", "",
        "turns begun before that, since the start or the last change of load",
    ),
    *(
        item
        for name, (unit, words) in PEAKS.items()
        for item in (
            entry(f"{START}/{name}_peak", "", unit, f"largest magnitude of the {words}",
                  headline=_LEADING.get(name), exempt=MARCHED),
            entry(f"{START}/{name}_peak_time", "", "s", f"time of the largest {words}",
                  exempt=PLACE),
        )
    ),
    entry(f"{START}/energy/motor", "", "J", "work of the motor over the whole time"),
    entry(f"{START}/energy/gas", "", "J", "work that the gas takes"),
    entry(f"{START}/energy/friction", "", "J", "work that friction takes"),
    entry(f"{START}/energy/mounts", "", "J", "work that the damping of the mounts takes"),
    entry(f"{START}/energy/stored", "", "J", "growth of kinetic energy and of that in the mounts"),
    entry(f"{START}/energy/residual", "", "J", "what is left over; zero for the exact motion",
          exempt=CHECK, diagnostic=True),
    *(
        entry(
            f"{START}/history/{name}_{end}", "start_time", PEAKS[name][0],
            f"{words} of the {PEAKS[name][1]} in each interval of time", exempt=MARCHED,
        )
        for name in HISTORIES
        for end, words in (("low", "smallest sample"), ("high", "largest sample"))
    ),
    entry(f"{START}/turn/begin", "turn", "s", "when each whole turn begins, at crank angle 0"),
    entry(f"{START}/turn/speed", "turn", "rad/s", "mean crank speed of each whole turn"),
    entry(
        f"{START}/turn/shell_acceleration", "turn", "rad/s^2",
        "half of largest less smallest acceleration of the shell in each whole turn",
        exempt=MARCHED),
    entry(f"{START}/load/factor", "load_step", "", "factor on the gas forces from that time on"),
    entry(
        f"{START}/load/speed", "load_step", "rad/s",
        "mean crank speed of the last whole turn under that load; 0 without one",
    ),
    *(
        entry(
            f"{START}/load/{name}_peak", "load_step", PEAKS[name][0],
            f"largest magnitude of the {PEAKS[name][1]} under that load", exempt=MARCHED,
        )
        for name in STEPPED
    ),
    entry(f"{START}/start_angles/starts", "start_angle", "", "1 where it starts from that angle",
          exempt=MARCHED),
    entry(
        f"{START}/start_angles/lower", "start_interval", "rad",
        "crank angle from which on the machine, at rest under its full load, starts",
        exempt=MARCHED, circle=TURN),
    entry(
        f"{START}/start_angles/upper", "start_interval", "rad",
        "crank angle up to which it starts; beyond a turn where the interval goes over 0",
        exempt=MARCHED, circle=TURN),
    entry(f"{START}/start_angles/fraction", "", "", "share of all crank angles it starts from",
          exempt=MARCHED),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of the control of a motor: the reduced model, its margins, and what the full one says.
# ----------------------------------------------------------------------------

CONTROL = "response/control"

_LEVEL = "level of the shell's acceleration, dB re 1 rad/s^2 zero-to-peak"
_STATUS = (
    "0 stable, 1 stable only without any delay, 2 on the limit, 3 unstable, 4 unstable with the "
    "least lag"
)
#: name, unit, long name of what every loop has
LOOP: tuple[tuple[str, str, str], ...] = (
    ("status", "", f"stability of the loop: {_STATUS}"),
    ("gain_margin", "dB", "how much the gain may grow"),
    ("gain_reduction", "dB", "how much the gain may fall"),
    ("phase_margin", "rad", "lag or lead, the smaller, that the loop bears"),
    ("delay_margin", "s", "further delay that the loop bears"),
    ("bandwidth", "rad/s", "highest angular frequency at which the loop has gain one"),
    ("feedthrough", "", "gain of the loop at high frequency"),
    ("command_rate", "rad/s^2", "what the actuator has to follow at most"),
    ("torque_peak", "N*m", "largest torque that is asked of the motor in a turn"),
)

_MARGINS = {
    "gain_margin": Headline("tuned controller, gain margin", "dB"),
    "phase_margin": Headline("tuned controller, phase margin", "deg"),
}


def _loop(below: str, axes: str, of: str) -> tuple[Entry, ...]:
    return tuple(
        entry(f"{CONTROL}/{below}{name}", axes, unit, f"{words}{of}",
              headline=_MARGINS.get(name) if below == "tuned/" else None)
        for name, unit, words in LOOP
    )  # fmt: skip


CONTROL_ENTRIES = (
    entry(f"{CONTROL}/motor_gain", "", "N*m*s/rad", "torque of the motor for each unit of slip"),
    entry(f"{CONTROL}/motor_offset", "", "N*m", "torque of the straight motor curve at no slip"),
    entry(f"{CONTROL}/breakdown_torque", "", "N*m", "largest torque of the motor"),
    entry(f"{CONTROL}/inertia", "", "kg*m^2", "inertia that the torque of the motor accelerates"),
    entry(f"{CONTROL}/shell_share", "", "", "acceleration of the shell over that of the crank"),
    entry(f"{CONTROL}/mean_torque", "", "N*m", "mean torque of gas and friction on the rotor"),
    entry(f"{CONTROL}/disturbance", "order", "N*m", "torque of gas and pistons on the rotor at "
          "constant speed", PEAK),
    entry(f"{CONTROL}/speed_without", "", "rad/s", "mean speed of the reduced model, no control"),
    entry(f"{CONTROL}/target_speed", "", "rad/s", "mean speed that the speed feedback is to keep"),
    entry(f"{CONTROL}/speed", "", "rad/s", "mean speed of the reduced model under control",
          headline=Headline("speed under control", "rpm")),
    entry(f"{CONTROL}/speed_feedback", "", "", "share of the speed that is fed back"),
    entry(f"{CONTROL}/speed_feedback_limit", "", "", "speed feedback that keeps the target speed "
          "with a gain beyond all bounds"),
    entry(f"{CONTROL}/shell_acceleration", "order", "rad/s^2", "angular acceleration of the shell "
          "under control; infinite if the loop is not stable", PEAK),
    entry(f"{CONTROL}/level", "order", "dB", f"{_LEVEL}, under control"),
    entry(f"{CONTROL}/level_without", "order", "dB", f"{_LEVEL}, without control"),
    entry(f"{CONTROL}/attenuation", "order", "dB", "what control takes off the level"),
    entry(f"{CONTROL}/pole", "pole", "1/s", "pole of the closed loop, complex"),
    *_loop("", "", ""),
    entry(f"{CONTROL}/motor_gains/speed", "motor_gain", "rad/s", "mean speed with another motor"),
    entry(f"{CONTROL}/motor_gains/level", "motor_gain order", "dB", f"{_LEVEL}, no control"),
    entry(f"{CONTROL}/grid/speed_feedback", "gain", "",
          "speed feedback that keeps the target speed"),
    entry(f"{CONTROL}/grid/level", "gain feedback order", "dB", _LEVEL),
    entry(f"{CONTROL}/grid/attenuation", "gain feedback order", "dB", "what control takes off"),
    *_loop("grid/", "gain feedback", ", over gain and feedback"),
    entry(f"{CONTROL}/locus/pole", "locus_gain branch", "1/s", "poles as the gain grows, complex"),
    entry(f"{CONTROL}/tuned/gain", "", "", "gain found", exempt=SEARCHED),
    entry(f"{CONTROL}/tuned/acceleration_feedback", "", "s", "feedback of the acceleration found",
          exempt=SEARCHED),
    entry(f"{CONTROL}/tuned/speed_feedback", "", "", "speed feedback that goes with them",
          exempt=SEARCHED),
    entry(f"{CONTROL}/tuned/objective", "", "dB", "largest level of the orders to be made small",
          headline=Headline("tuned controller, objective", "dB")),
    entry(f"{CONTROL}/tuned/level", "order", "dB", f"{_LEVEL}, with the gains found"),
    entry(f"{CONTROL}/tuned/attenuation", "order", "dB", "what they take off the level"),
    *_loop("tuned/", "", ", with the gains found"),
    entry(f"{CONTROL}/tuned/active", "bound", "",
          "1 for a bound that holds the gains where they are"),
    entry(f"{CONTROL}/tuned/multiplier", "bound", "dB", "what loosening the bound by one part of "
          "itself would take off, to first order", exempt=SEARCHED),
    entry(f"{CONTROL}/tuned/residual", "", "", "part of the level's slope that no bound holds",
          exempt=SEARCHED, diagnostic=True),
    entry(f"{CONTROL}/full/speed", "", "rad/s", "mean speed of the full model under control"),
    entry(f"{CONTROL}/full/level", "order", "dB", f"{_LEVEL}, full model under control; infinite "
          "if its motion is unstable"),
    entry(f"{CONTROL}/full/difference", "order", "dB",
          "that level less the one of the reduced model"),
    entry(f"{CONTROL}/full/attenuation", "order", "dB", "what control takes off in the full model"),
    entry(f"{CONTROL}/full/multiplier", "multiplier", "", "Floquet multiplier of the full model"),
    entry(f"{CONTROL}/full/stable", "", "", "1 if its motion is stable, else 0"),
    entry(f"{CONTROL}/full/largest_slip", "", "rad/s", "largest slip of the motor under control",
          exempt=EXAMINED),
    entry(f"{CONTROL}/range/level", "order", "dB", f"{_LEVEL}, full model without control"),
    entry(f"{CONTROL}/range/difference", "order", "dB", "that level less the one of the reduced "
          "model: how far the reduced model holds"),
    entry(f"{CONTROL}/range/linear_difference", "order", "dB", "the same, the full model with the "
          "straight motor curve of the reduced one"),
)  # fmt: skip

#: axis name -> (unit, long name)
AXES = {
    "multiplier": ("", "Floquet multiplier, largest first"),
    "interpolant": ("", "way to read the gas tables"),
    "parameter": ("", "parameter of the machine"),
    "start_time": ("s", "end of an interval of time"),
    "turn": ("", "whole turn of the crank, the first is 1"),
    "load_step": ("s", "time from which on the load is constant"),
    "start_angle": ("rad", "crank angle of a start from rest"),
    "start_interval": ("", "interval of crank angles, ascending"),
    "slip": ("rad/s", "slip speed"),
    "cage": ("", "cage of the rotor"),
    "motor_parameter": ("", "parameter of the motor"),
    "combination": ("", "product of powers of the motor's parameters, best determined first"),
    "transient": ("", "electrical transient, least damped first"),
    "motor_gain": ("N*m*s/rad", "torque of the motor for each unit of slip"),
    "gain": ("", "gain of the controller"),
    "feedback": ("s", "feedback of the shell's acceleration"),
    "locus_gain": ("", "gain of the controller"),
    "branch": ("", "pole that is followed"),
    "bound": ("", "what holds the gains"),
}
ENTRIES = (
    *ROLL_ENTRIES,
    *START_UP_ENTRIES,
    *MOTOR_ENTRIES,
    *CONTROL_ENTRIES,
)
HELPS = {f"{ROLL}/": (CANCELS,), f"{CONTROL}/": (CANCELS,), f"{START}/": (MARCH,)}
