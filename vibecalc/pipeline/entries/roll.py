"""Results of rotor, pistons and shell in their periodic motion under a real motor."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "response/roll"
SHAKING = f"{ROOT}/shaking"

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
_BY_ORDER = "order"
_BY_CYLINDER = "cylinder order"

ENTRIES = (
    entry(f"{ROOT}/speed", "", "rad/s", "mean speed of the crank against the shell"),
    entry(f"{ROOT}/speed_variation", "", "", "largest less smallest crank speed, over the mean"),
    entry(f"{ROOT}/mean_slip", "", "rad/s", "mean slip speed of the motor"),
    entry(f"{ROOT}/largest_slip", "", "rad/s", "largest slip speed in a turn"),
    entry(f"{ROOT}/mean_torque", "", "N*m", "mean torque of the motor over the crank angle"),
    entry(f"{ROOT}/breakdown_margin", "", "", "largest torque of the motor over that mean, less 1"),
    entry(f"{ROOT}/shell_drift", "", "rad/s", "mean angular speed of the shell"),
    entry(f"{ROOT}/angular_momentum", "", "N*m*s", "mean angular momentum about the crank axis"),
    *(
        entry(f"{ROOT}/{name}", _BY_ORDER, unit, words, PEAK)
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(f"{ROOT}/{name}", _BY_CYLINDER, unit, words, PEAK)
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"{ROOT}/level/{name}", axes, "dB", f"{words}, dB re 1 {unit} zero-to-peak")
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (unit, words) in kinds.items()
    ),
    *(
        entry(
            f"{ROOT}/phase_lag/{name}", axes, "rad",
            f"{words}: angle by which it lags, x = C cos(n W t - lag), t = 0 at crank angle 0",
        )
        for kinds, axes in ((VARIABLES, _BY_ORDER), (FORCES, _BY_CYLINDER))
        for name, (_, words) in kinds.items()
    ),
    *(
        entry(f"{ROOT}/cycle/{name}", "crank_angle", unit, f"{words} over a turn")
        for name, (unit, words) in VARIABLES.items()
    ),
    *(
        entry(f"{ROOT}/cycle/{name}", "cylinder crank_angle", unit, f"{words} over a turn")
        for name, (unit, words) in FORCES.items()
    ),
    entry(f"{ROOT}/cycle/gas_force", "cylinder crank_angle", "N", "force of the gas on the piston"),
    entry(f"{ROOT}/cycle/time", "crank_angle", "s", "time since crank angle 0"),
    entry(f"{ROOT}/multiplier", "multiplier", "", "Floquet multiplier of the motion, complex"),
    entry(f"{ROOT}/largest_multiplier", "", "", "magnitude of the largest of them"),
    entry(
        f"{ROOT}/trivial_multipliers", "", "",
        "multipliers that are 1 whatever the machine: phase, and for a free shell its angle and "
        "its momentum",
    ),
    entry(f"{ROOT}/energy/motor", "", "J", "work of the motor in a turn"),
    entry(f"{ROOT}/energy/gas", "", "J", "work that the gas takes in a turn"),
    entry(f"{ROOT}/energy/friction", "", "J", "work that friction takes in a turn"),
    entry(f"{ROOT}/energy/mounts", "", "J", "work that the mounts take in a turn"),
    entry(f"{ROOT}/energy/residual", "", "J", "what is left over; zero for the exact motion"),
    entry(
        f"{ROOT}/momentum_residual", "", "N*m*s",
        "how far the angular momentum strays from what the mounts explain",
    ),
    entry(
        f"{ROOT}/interpolation/level", "interpolant order", "dB",
        "level of the shell acceleration with each interpolation of the gas forces",
    ),
    entry(
        f"{ROOT}/interpolation/spread", "order", "dB",
        "largest less smallest of these: what the table leaves open",
    ),
    entry(f"{ROOT}/method/level", "method order", "dB", "level of the shell acceleration"),
    entry(
        f"{ROOT}/method/difference", "method order", "dB",
        "that level less the one of the method of the case",
    ),
    entry(f"{ROOT}/method/work", "method", "", "evaluations of the right-hand side, in points"),
    entry(
        f"{ROOT}/sensitivity/level", "parameter order", "dB",
        "change of the level of the shell acceleration for one percent more of the parameter",
    ),
    *(
        entry(
            f"{ROOT}/sensitivity/ten_percent_{word}", "parameter order", "dB",
            f"change of that level with ten percent {word} of the parameter, each solved for",
        )
        for word in ("more", "less")
    ),
    *(
        entry(f"{ROOT}/classical/{name}_peak", "cylinder", unit, f"largest {words}, constant speed")
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(f"{ROOT}/{name}_peak", "cylinder", unit, f"largest magnitude of the {words}")
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(
            f"{ROOT}/classical/{name}_error", "cylinder", "",
            f"largest error over a turn of the {words} at constant speed, over its peak",
        )
        for name, (unit, words) in FORCES.items()
    ),
    *(
        entry(
            f"{ROOT}/classical/{name}_error_by_order", "cylinder order", unit,
            f"error of the harmonics of the {words} at constant speed",
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
            ),
        )
    ),
)  # fmt: skip
