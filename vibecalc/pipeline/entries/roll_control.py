"""Results of the control of a motor: the reduced model, its margins, and what the full one says."""

from vibecalc.pipeline.entries.entry import PEAK, Entry, entry

ROOT = "response/control"

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


def _loop(below: str, axes: str, of: str) -> tuple[Entry, ...]:
    return tuple(
        entry(f"{ROOT}/{below}{name}", axes, unit, f"{words}{of}") for name, unit, words in LOOP
    )


ENTRIES = (
    entry(f"{ROOT}/motor_gain", "", "N*m*s/rad", "torque of the motor for each unit of slip"),
    entry(f"{ROOT}/motor_offset", "", "N*m", "torque of the straight motor curve at no slip"),
    entry(f"{ROOT}/breakdown_torque", "", "N*m", "largest torque of the motor"),
    entry(f"{ROOT}/inertia", "", "kg*m^2", "inertia that the torque of the motor accelerates"),
    entry(f"{ROOT}/shell_share", "", "", "acceleration of the shell over that of the crank"),
    entry(f"{ROOT}/mean_torque", "", "N*m", "mean torque of gas and friction on the rotor"),
    entry(f"{ROOT}/disturbance", "order", "N*m", "torque of gas and pistons on the rotor at "
          "constant speed", PEAK),
    entry(f"{ROOT}/speed_without", "", "rad/s", "mean speed of the reduced model, no control"),
    entry(f"{ROOT}/target_speed", "", "rad/s", "mean speed that the speed feedback is to keep"),
    entry(f"{ROOT}/speed", "", "rad/s", "mean speed of the reduced model under control"),
    entry(f"{ROOT}/speed_feedback", "", "", "share of the speed that is fed back"),
    entry(f"{ROOT}/speed_feedback_limit", "", "", "speed feedback that keeps the target speed "
          "with a gain beyond all bounds"),
    entry(f"{ROOT}/shell_acceleration", "order", "rad/s^2", "angular acceleration of the shell "
          "under control; infinite if the loop is not stable", PEAK),
    entry(f"{ROOT}/level", "order", "dB", f"{_LEVEL}, under control"),
    entry(f"{ROOT}/level_without", "order", "dB", f"{_LEVEL}, without control"),
    entry(f"{ROOT}/attenuation", "order", "dB", "what control takes off the level"),
    entry(f"{ROOT}/pole", "pole", "1/s", "pole of the closed loop, complex"),
    *_loop("", "", ""),
    entry(f"{ROOT}/motor_gains/speed", "motor_gain", "rad/s", "mean speed with another motor"),
    entry(f"{ROOT}/motor_gains/level", "motor_gain order", "dB", f"{_LEVEL}, no control"),
    entry(f"{ROOT}/grid/speed_feedback", "gain", "",
          "speed feedback that keeps the target speed"),
    entry(f"{ROOT}/grid/level", "gain feedback order", "dB", _LEVEL),
    entry(f"{ROOT}/grid/attenuation", "gain feedback order", "dB", "what control takes off"),
    *_loop("grid/", "gain feedback", ", over gain and feedback"),
    entry(f"{ROOT}/locus/pole", "locus_gain branch", "1/s", "poles as the gain grows, complex"),
    entry(f"{ROOT}/tuned/gain", "", "", "gain found"),
    entry(f"{ROOT}/tuned/acceleration_feedback", "", "s", "feedback of the acceleration found"),
    entry(f"{ROOT}/tuned/speed_feedback", "", "", "speed feedback that goes with them"),
    entry(f"{ROOT}/tuned/objective", "", "dB", "largest level of the orders to be made small"),
    entry(f"{ROOT}/tuned/level", "order", "dB", f"{_LEVEL}, with the gains found"),
    entry(f"{ROOT}/tuned/attenuation", "order", "dB", "what they take off the level"),
    *_loop("tuned/", "", ", with the gains found"),
    entry(f"{ROOT}/tuned/active", "bound", "",
          "1 for a bound that holds the gains where they are"),
    entry(f"{ROOT}/tuned/multiplier", "bound", "dB", "what loosening the bound by one part of "
          "itself would take off, to first order"),
    entry(f"{ROOT}/tuned/residual", "", "", "part of the level's slope that no bound holds"),
    entry(f"{ROOT}/full/speed", "", "rad/s", "mean speed of the full model under control"),
    entry(f"{ROOT}/full/level", "order", "dB", f"{_LEVEL}, full model under control; infinite "
          "if its motion is unstable"),
    entry(f"{ROOT}/full/difference", "order", "dB",
          "that level less the one of the reduced model"),
    entry(f"{ROOT}/full/attenuation", "order", "dB", "what control takes off in the full model"),
    entry(f"{ROOT}/full/multiplier", "multiplier", "", "Floquet multiplier of the full model"),
    entry(f"{ROOT}/full/stable", "", "", "1 if its motion is stable, else 0"),
    entry(f"{ROOT}/full/largest_slip", "", "rad/s", "largest slip of the motor under control"),
    entry(f"{ROOT}/range/level", "order", "dB", f"{_LEVEL}, full model without control"),
    entry(f"{ROOT}/range/difference", "order", "dB", "that level less the one of the reduced "
          "model: how far the reduced model holds"),
    entry(f"{ROOT}/range/linear_difference", "order", "dB", "the same, the full model with the "
          "straight motor curve of the reduced one"),
)  # fmt: skip
