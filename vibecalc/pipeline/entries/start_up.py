"""Results of a start-up or a change of load in time, of a machine whose motor finds its speed."""

from vibecalc.pipeline.entries.entry import entry

ROOT = "response/start_up"

#: quantities with a peak on the way: unit, long name
PEAKS: dict[str, tuple[str, str]] = {
    "shell_angle": ("rad", "angle of the shell"),
    "shell_acceleration": ("rad/s^2", "angular acceleration of the shell"),
    "rotor_acceleration": ("rad/s^2", "angular acceleration of the rotor against the ground"),
    "crank_speed": ("rad/s", "speed of the crank against the shell"),
    "motor_torque": ("N*m", "torque of the motor"),
    "mount_torque": ("N*m", "torque of the mounts on the shell"),
}
#: those with a history
HISTORIES = ("shell_angle", "shell_acceleration", "crank_speed", "motor_torque", "mount_torque")
#: those with a peak after each change of the load
STEPPED = ("shell_angle", "shell_acceleration", "motor_torque", "mount_torque")

ENTRIES = (
    entry(f"{ROOT}/started", "", "",
          "1 if it runs at the end, above the speed of breakdown; or 0"),
    entry(f"{ROOT}/settled", "", "", "1 if its shaking has settled too; or 0"),
    entry(
        f"{ROOT}/running_speed", "", "rad/s",
        "mean crank speed of the last whole turn; 0 if it no longer turns over",
    ),
    entry(
        f"{ROOT}/time_to_speed", "", "s",
        "when the crank first has the speed of that turn; infinite if it does not start",
    ),
    entry(
        f"{ROOT}/time_to_steady", "", "s",
        "begin of the first turn from which on the shaking has settled; infinite if it has not",
    ),
    entry(
        f"{ROOT}/turns_to_steady", "", "",
        "turns begun before that, since the start or the last change of load",
    ),
    *(
        item
        for name, (unit, words) in PEAKS.items()
        for item in (
            entry(f"{ROOT}/{name}_peak", "", unit, f"largest magnitude of the {words}"),
            entry(f"{ROOT}/{name}_peak_time", "", "s", f"time of the largest {words}"),
        )
    ),
    entry(f"{ROOT}/energy/motor", "", "J", "work of the motor over the whole time"),
    entry(f"{ROOT}/energy/gas", "", "J", "work that the gas takes"),
    entry(f"{ROOT}/energy/friction", "", "J", "work that friction takes"),
    entry(f"{ROOT}/energy/mounts", "", "J", "work that the damping of the mounts takes"),
    entry(f"{ROOT}/energy/stored", "", "J", "growth of kinetic energy and of that in the mounts"),
    entry(f"{ROOT}/energy/residual", "", "J", "what is left over; zero for the exact motion"),
    *(
        entry(
            f"{ROOT}/history/{name}_{end}", "start_time", PEAKS[name][0],
            f"{words} of the {PEAKS[name][1]} in each interval of time",
        )
        for name in HISTORIES
        for end, words in (("low", "smallest sample"), ("high", "largest sample"))
    ),
    entry(f"{ROOT}/turn/begin", "turn", "s", "when each whole turn begins, at crank angle 0"),
    entry(f"{ROOT}/turn/speed", "turn", "rad/s", "mean crank speed of each whole turn"),
    entry(
        f"{ROOT}/turn/shell_acceleration", "turn", "rad/s^2",
        "half of largest less smallest acceleration of the shell in each whole turn",
    ),
    entry(f"{ROOT}/load/factor", "load_step", "", "factor on the gas forces from that time on"),
    entry(
        f"{ROOT}/load/speed", "load_step", "rad/s",
        "mean crank speed of the last whole turn under that load; 0 without one",
    ),
    *(
        entry(
            f"{ROOT}/load/{name}_peak", "load_step", PEAKS[name][0],
            f"largest magnitude of the {PEAKS[name][1]} under that load",
        )
        for name in STEPPED
    ),
    entry(f"{ROOT}/start_angles/starts", "start_angle", "", "1 where it starts from that angle"),
    entry(
        f"{ROOT}/start_angles/lower", "start_interval", "rad",
        "crank angle from which on the machine, at rest under its full load, starts",
    ),
    entry(
        f"{ROOT}/start_angles/upper", "start_interval", "rad",
        "crank angle up to which it starts; beyond a turn where the interval goes over 0",
    ),
    entry(f"{ROOT}/start_angles/fraction", "", "", "share of all crank angles it starts from"),
)  # fmt: skip
