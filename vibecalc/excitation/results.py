"""Results of the forces and couples of the crank train, its motor, and a pump's cylinders."""

from vibecalc.core.results.record import CANCELLING, ORDERS, PEAK, RMS, TURN, Headline, entry

# ----------------------------------------------------------------------------
# Results of the forces and couples of the crank train, and of its motor.
# ----------------------------------------------------------------------------

EXCITATION_ENTRIES = (
    entry("excitation/force", "order direction", "N", "force on the body", PEAK),
    entry(
        "excitation/couple",
        "order direction",
        "N*m",
        "couple on the body about its reference point",
        PEAK,
    ),
    entry(
        "excitation/force_peak",
        "direction",
        "N",
        "largest force over a turn",
        PEAK,
        headline=Headline("shaking force, peak", "N"),
    ),
    entry(
        "excitation/couple_peak",
        "direction",
        "N*m",
        "largest couple over a turn, about the reference point",
        PEAK,
        headline=Headline("shaking couple, peak", "N*m"),
    ),
    entry(
        "excitation/turning/with_crank",
        "order",
        "N",
        "part of the force that turns with the crank, at the order times its speed",
        PEAK,
    ),
    entry(
        "excitation/turning/against_crank",
        "order",
        "N",
        "the part that turns against it",
        PEAK,
    ),
    entry("excitation/mass/knuckle", "slave_rod", "kg", "moves with the knuckle pin"),
    entry("excitation/balance/sine", "order cylinder", "", "sin(n a)", exempt=CANCELLING),
    entry("excitation/balance/cosine", "order cylinder", "", "cos(n a)", exempt=CANCELLING),
    entry(
        "excitation/balance/position_sine", "order cylinder", "m", "z sin(n a)", exempt=CANCELLING
    ),
    entry(
        "excitation/balance/position_cosine", "order cylinder", "m", "z cos(n a)", exempt=CANCELLING
    ),
    entry("excitation/balance/total_sine", "order", "", "sum of sin(n a)", exempt=CANCELLING),
    entry("excitation/balance/total_cosine", "order", "", "sum of cos(n a)", exempt=CANCELLING),
    entry(
        "excitation/balance/total_position_sine",
        "order",
        "m",
        "sum of z sin(n a)",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/total_position_cosine",
        "order",
        "m",
        "sum of z cos(n a)",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/sum",
        "order direction",
        "",
        "of several banks: sum of exp(i n a) along the axis of each cylinder",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/position_sum",
        "order direction",
        "m",
        "sum of z exp(i n a) so",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/rotating",
        "order",
        "",
        "part of that sum that turns with the crank, n times as fast",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/counter_rotating",
        "order",
        "",
        "part that turns against it",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/position_rotating",
        "order",
        "m",
        "part of the sum with z that turns with the crank",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/balance/banks/position_counter_rotating",
        "order",
        "m",
        "part that turns against it",
        exempt=CANCELLING,
    ),
    entry(
        "excitation/residual",
        "",
        "N",
        "weighted residual of forces and couples",
        PEAK,
        headline=Headline("weighted residual of the balance", "N"),
    ),
    entry("excitation/mass/reciprocating", "cylinder", "kg", "mass that moves with a piston"),
    entry("excitation/mass/rotating", "cylinder", "kg", "mass at a crank pin"),
    entry(
        "excitation/counterweight/force",
        "counterweight",
        "N",
        "centrifugal force of a counterweight",
        PEAK,
    ),
    entry(
        "excitation/counterweight/couple",
        "counterweight",
        "N*m",
        "its couple about the body's reference point",
        PEAK,
    ),
    entry(
        "excitation/rod/split_inertia",
        "",
        "kg*m^2",
        "moment of the rod's two point masses about its mass centre",
    ),
    entry(
        "excitation/rod/couple_bound",
        "",
        "N*m",
        "largest couple that the rod's true moment can add to that of its two point masses",
        PEAK,
    ),
    entry(
        "excitation/rod/couple",
        "order",
        "N*m",
        "couple of one rod about the crankshaft beyond that of its two point masses",
        PEAK,
    ),
    entry("excitation/rod/couple_peak", "", "N*m", "largest over a turn", PEAK),
    entry("excitation/motor/axial_force", "order", "N", "axial force of skewed conductors", PEAK),
    entry("excitation/motor/mean_force", "", "N", "axial force of the mean torque"),
    entry(
        "excitation/motor/sum_of_amplitudes",
        "",
        "N",
        "sum of the amplitudes of all orders, a bound of the peak",
        PEAK,
    ),
    entry(
        "excitation/motor/peak",
        "",
        "N",
        "largest axial force over a turn, mean apart",
        PEAK,
        headline=Headline("axial force of the motor, peak without mean", "N"),
    ),
    entry("excitation/motor/rms", "", "N", "axial force, mean apart", RMS),
)

# ----------------------------------------------------------------------------
# Results of the cylinders of a pump: valves, volumes, work, torque.
# ----------------------------------------------------------------------------

PUMP_ROOT = "excitation/pump"

PUMP_ENTRIES = (
    entry(
        f"{PUMP_ROOT}/suction_opens",
        "",
        "rad",
        "crank angle from top dead centre at which the suction valve opens",
        circle=TURN,
    ),
    entry(
        f"{PUMP_ROOT}/discharge_opens",
        "",
        "rad",
        "crank angle from bottom dead centre at which the discharge valve opens",
        circle=TURN,
    ),
    entry(f"{PUMP_ROOT}/swept_volume", "", "m^3", "of one cylinder"),
    entry(
        f"{PUMP_ROOT}/flow",
        "",
        "m^3/s",
        "mean flow of all cylinders, at the suction pressure",
        headline=Headline("flow of the pump, mean", "l/min"),
    ),
    entry(f"{PUMP_ROOT}/work", "", "J", "work of one cylinder on its liquid in a turn"),
    entry(
        f"{PUMP_ROOT}/power",
        "",
        "W",
        "of all cylinders on the liquid",
        headline=Headline("power of the pump, mean", "kW"),
    ),
    entry(
        f"{PUMP_ROOT}/mean_torque",
        "",
        "N*m",
        "mean torque of the liquid on the crankshaft, all cylinders, with its sign",
        headline=Headline("torque of the pump, mean", "N*m"),
    ),
    entry(
        f"{PUMP_ROOT}/volumetric_efficiency",
        "",
        "",
        "volume drawn, at the suction pressure, over the swept volume",
        headline=Headline("volumetric efficiency"),
    ),
    entry(
        f"{PUMP_ROOT}/torque",
        "order",
        "N*m",
        "torque of the liquid on the crankshaft, all cylinders, complex",
        PEAK,
    ),
    entry(
        f"{PUMP_ROOT}/pressure", "crank_angle", "Pa", "absolute, on one plunger over its own turn"
    ),
)

#: axis name -> (unit, long name)
AXES = {
    "counterweight": ("", "counterweight"),
    "slave_rod": ("", "cylinder with a slave rod"),
}
ENTRIES = (
    *EXCITATION_ENTRIES,
    *PUMP_ENTRIES,
)
HELPS = {"excitation/": (ORDERS,)}
