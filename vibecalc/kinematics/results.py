"""Results of the piston motion."""

from vibecalc.core.results.record import ORDERS, PEAK, entry

ENTRIES = (
    entry("kinematics/position_harmonics", "order", "m", "harmonics of piston position", PEAK),
    entry(
        "kinematics/acceleration_harmonics", "order", "m/s^2",
        "harmonics of piston acceleration at operating speed", PEAK,
    ),
    entry(
        "kinematics/dropped_acceleration", "", "m/s^2",
        "sum of the acceleration that the chosen series or order leaves out", PEAK,
    ),
    entry("kinematics/position", "crank_angle", "m", "piston position from the crank axis"),
    entry("kinematics/velocity", "crank_angle", "m/s", "piston velocity"),
    entry("kinematics/acceleration", "crank_angle", "m/s^2", "piston acceleration"),
)  # fmt: skip
HELPS = {"kinematics/": (ORDERS,)}
