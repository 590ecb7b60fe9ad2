"""Results of pendulums in the centrifugal field of a rotor."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "pendulum"

ENTRIES = (
    entry(f"{ROOT}/order", "", "", "order that small swings follow"),
    entry(f"{ROOT}/path_radius", "", "m", "radius of curvature of the path at its vertex"),
    entry(f"{ROOT}/path_exponent", "", "", "0: a circle, 1: a cycloid"),
    entry(f"{ROOT}/detuning", "", "1/rad^2", "relative change of the order by the swing squared"),
    entry(f"{ROOT}/largest_swing", "", "rad", "where the path ends"),
    entry(f"{ROOT}/mass_ratio", "", "", "inertia of the equivalent absorber over the rotor's"),
    entry(f"{ROOT}/inertia", "", "kg*m^2", "inertia of the equivalent absorber"),
    entry(f"{ROOT}/stiffness", "", "N*m/rad", "stiffness of the equivalent absorber at this speed"),
    entry(f"{ROOT}/order_of_swing", "swing", "", "order that the pendulum keeps at this swing"),
    entry(f"{ROOT}/small/rotor", "", "rad", "motion of the rotor, small swings, complex", PEAK),
    entry(f"{ROOT}/small/swing", "", "rad", "swing, small swings, complex", PEAK),
    entry(f"{ROOT}/small/rotor_without", "", "rad", "the same with the pendulums locked", PEAK),
    entry(f"{ROOT}/response/rotor", "order_ratio", "rad", "motion of the rotor, complex", PEAK),
    entry(f"{ROOT}/response/without", "order_ratio", "rad", "the same, pendulums locked", PEAK),
    entry(
        f"{ROOT}/steady/torque", "steady_swing", "N*m", "torque that holds a steady swing, undamped"
    ),
    entry(
        f"{ROOT}/steady/largest_swing",
        "steady_swing",
        "rad",
        "largest angle of swing over the cycle",
    ),
    entry(f"{ROOT}/jump/torque", "", "N*m", "torque beyond which the pendulum jumps; infinite"),
    entry(f"{ROOT}/jump/swing", "", "rad", "largest angle of swing, from which it jumps"),
)
