"""Results of the piston motion."""

from vibecalc.core.results.record import ORDERS, PEAK, PLACE, TURN, entry

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
    entry(
        "kinematics/cylinder/stroke", "cylinder", "m", "way of the piston between its dead centres",
    ),
    entry(
        "kinematics/cylinder/top_dead_centre", "cylinder", "rad", "crank angle of it", exempt=PLACE,
        circle=TURN,
    ),
    entry(
        "kinematics/cylinder/bottom_dead_centre", "cylinder", "rad", "crank angle of it",
        exempt=PLACE, circle=TURN,
    ),
    entry(
        "kinematics/cylinder/position_harmonics", "cylinder order", "m",
        "harmonics of the piston's position over the crank angle", PEAK,
    ),
    entry(
        "kinematics/cylinder/acceleration_harmonics", "cylinder order", "m/s^2",
        "harmonics of the piston's acceleration over the crank angle", PEAK,
    ),
    entry("kinematics/position", "crank_angle", "m", "piston position from the crank axis"),
    entry("kinematics/velocity", "crank_angle", "m/s", "piston velocity"),
    entry("kinematics/acceleration", "crank_angle", "m/s^2", "piston acceleration"),
)  # fmt: skip
HELPS = {"kinematics/": (ORDERS,)}
