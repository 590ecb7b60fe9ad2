"""Results of mounts that depend on what they carry, on the frequency, or that have stops."""

from vibecalc.core.results.record import DIFFERENCE, PEAK, Headline, entry

ROOT = "isolation/mounts"
#: of mounts with static or over_load
AT_REST = tuple(
    f"{ROOT}/{name}" for name in ("load", "deflection", "static_stiffness", "stiffness")
)
LOAD_CURVE = f"{ROOT}/load_curve"
#: of mounts with stops
OF_STOPS = (f"{ROOT}/clearance_at_rest",)
MOVING = (f"{ROOT}/travel", f"{ROOT}/clearance")
OF_RUN_UP = tuple(
    f"{ROOT}/{name}" for name in ("run_up_travel", "run_up_travel_speed", "run_up_clearance")
)
#: of mounts with over_frequency
BY_ORDER = (f"{ROOT}/order_stiffness", f"{ROOT}/order_loss_factor")

MOUNT_ENTRIES = (
    entry(AT_REST[0], "mount", "N", "compression load of a mount at rest along its axis"),
    entry(AT_REST[1], "mount", "m", "compression of a mount at rest along its axis"),
    entry(AT_REST[2], "mount", "N/m", "tangent of its static load over deflection at rest"),
    entry(AT_REST[3], "mount", "N/m", "dynamic stiffness about the rest along its axis, nominal"),
    entry(LOAD_CURVE, "mount deflection", "N", "static load of a mount over its compression"),
    entry(
        OF_STOPS[0],
        "mount",
        "m",
        "distance to the nearer stop at rest; negative: stands on it, infinite: none",
        exempt=DIFFERENCE,
    ),
    entry(MOVING[0], "mount", "m", "largest motion of a mount along its axis about the rest", PEAK),
    entry(
        MOVING[1],
        "mount",
        "m",
        "least distance to a stop over the cycle; negative: it is met, infinite: none",
        exempt=DIFFERENCE,
        headline=Headline("clearance left to a stop at speed", "mm", pick="least"),
    ),
    entry(
        OF_RUN_UP[0], "mount", "m", "largest motion of a mount along its axis in the run-up", PEAK
    ),
    entry(OF_RUN_UP[1], "mount", "rad/s", "crank speed of that"),
    entry(
        OF_RUN_UP[2],
        "mount",
        "m",
        "distance to the nearer stop under weight and mean torque less that motion; infinite: none",
        exempt=DIFFERENCE,
        headline=Headline("clearance left to a stop in the run-up", "mm", pick="least"),
    ),
    entry(
        BY_ORDER[0], "mount order", "N/m", "stiffness along its axis at the frequency of an order"
    ),
    entry(BY_ORDER[1], "mount order", "", "loss factor at the frequency of an order"),
)
