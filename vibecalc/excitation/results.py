"""Results of the forces and couples of the crank train, its motor, and a pump's cylinders."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, named, q
from vibecalc.core.results.record import CANCELLING, ORDERS, PEAK, RMS, TURN

# ----------------------------------------------------------------------------
# Forces and couples of the crank train, and what makes them.
# ----------------------------------------------------------------------------


ABOUT = "about the body's reference point"


class OnBody(Group):
    """All forces and couples of the crank train on the body."""

    ROOT: ClassVar[str] = "excitation"
    force: Any = q("order direction", "N", "force on the body", PEAK)
    couple: Any = q("order direction", "N*m", f"couple on the body {ABOUT}", PEAK)
    force_peak: Any = lead("direction", "N", "shaking force, peak", PEAK,
        unless="balance/before/force_peak")  # fmt: skip
    couple_peak: Any = lead("direction", "N*m", "shaking couple of inertia forces, peak", PEAK,
        about=ABOUT, unless="balance/before/couple_peak")  # fmt: skip
    residual: Any = lead("", "N", "residual unbalance", PEAK, about=ABOUT)


class Turning(Group):
    """Parts of the force of a train with slave rods."""

    ROOT: ClassVar[str] = "excitation/turning"
    with_crank: Any = named("order", "N", "force with the crank", PEAK)
    against_crank: Any = named("order", "N", "force against it", PEAK)


class Masses(Group):
    """Masses that make the forces."""

    ROOT: ClassVar[str] = "excitation/mass"
    knuckle: Any = named("slave_rod", "kg", "with its pin")
    reciprocating: Any = named("cylinder", "kg", "moves with the piston")
    rotating: Any = named("cylinder", "kg", "turns with the pin")


class Counterweights(Group):
    """Of each counterweight at the operating speed."""

    ROOT: ClassVar[str] = "excitation/counterweight"
    force: Any = named("counterweight", "N", "centrifugal force of a counterweight", PEAK)
    couple: Any = q("counterweight", "N*m", f"its couple {ABOUT}", PEAK,
        name="couple of a counterweight")  # fmt: skip


class OfRod(Group):
    """What the two point masses that stand for a rod leave out."""

    ROOT: ClassVar[str] = "excitation/rod"
    split_inertia: Any = q(
        "", "kg*m^2", "moment of the rod's two point masses about its mass centre"
    )
    couple_bound: Any = q(
        "", "N*m",
        "largest couple that the rod's true moment can add to that of its two point masses", PEAK,
    )  # fmt: skip
    couple: Any = q(
        "order", "N*m",
        "couple of one rod about the crankshaft beyond that of its two point masses", PEAK,
    )  # fmt: skip
    couple_peak: Any = q("", "N*m", "largest over a turn", PEAK)


# ----------------------------------------------------------------------------
# The balance table: sines and cosines of each cylinder, and their sums.
# ----------------------------------------------------------------------------


class BalanceColumns(Group):
    """Of cylinders in one bank, at angles a and places z along the shaft."""

    ROOT: ClassVar[str] = "excitation/balance"
    sine: Any = q("order cylinder", "", "sin(n a)", exempt=CANCELLING)
    cosine: Any = q("order cylinder", "", "cos(n a)", exempt=CANCELLING)
    position_sine: Any = q("order cylinder", "m", "z sin(n a)", exempt=CANCELLING)
    position_cosine: Any = q("order cylinder", "m", "z cos(n a)", exempt=CANCELLING)
    total_sine: Any = q("order", "", "sum of sin(n a)", exempt=CANCELLING)
    total_cosine: Any = q("order", "", "sum of cos(n a)", exempt=CANCELLING)
    total_position_sine: Any = q("order", "m", "sum of z sin(n a)", exempt=CANCELLING)
    total_position_cosine: Any = q("order", "m", "sum of z cos(n a)", exempt=CANCELLING)


class BankColumns(Group):
    """Of cylinders in several banks."""

    ROOT: ClassVar[str] = "excitation/balance/banks"
    sum: Any = q(
        "order direction", "",
        "of several banks: sum of exp(i n a) along the axis of each cylinder", exempt=CANCELLING,
    )  # fmt: skip
    position_sum: Any = q("order direction", "m", "sum of z exp(i n a) so", exempt=CANCELLING)
    rotating: Any = q(
        "order", "", "part of that sum that turns with the crank, n times as fast",
        exempt=CANCELLING,
    )  # fmt: skip
    counter_rotating: Any = q("order", "", "part that turns against it", exempt=CANCELLING)
    position_rotating: Any = q(
        "order", "m", "part of the sum with z that turns with the crank", exempt=CANCELLING
    )
    position_counter_rotating: Any = q(
        "order", "m", "part that turns against it", exempt=CANCELLING
    )


# ----------------------------------------------------------------------------
# The axial force of a motor; the cylinders of a pump: valves, volumes, work, torque.
# ----------------------------------------------------------------------------


class OfMotor(Group):
    """Axial force of skewed conductors."""

    ROOT: ClassVar[str] = "excitation/motor"
    axial_force: Any = q("order", "N", "axial force of skewed conductors", PEAK)
    mean_force: Any = q("", "N", "axial force of the mean torque", name="mean axial force")
    sum_of_amplitudes: Any = q(
        "",
        "N",
        "sum of the amplitudes of all orders, a bound of the peak",
        PEAK,
        name="sum of the amplitudes of the axial force",
    )
    peak: Any = lead("", "N", "axial force of the motor, peak without mean", PEAK)
    rms: Any = q("", "N", "axial force, mean apart", RMS, name="axial force without mean")


class OfPump(Group):
    """One cylinder over a turn, and the torque of all."""

    ROOT: ClassVar[str] = "excitation/pump"
    suction_opens: Any = q(
        "", "rad", "crank angle from top dead centre at which the suction valve opens", circle=TURN
    )
    discharge_opens: Any = q(
        "", "rad", "crank angle from bottom dead centre at which the discharge valve opens",
        circle=TURN,
    )  # fmt: skip
    swept_volume: Any = q("", "m^3", "of one cylinder")
    flow: Any = lead(
        "", "m^3/s", "flow of the pump, mean", read="l/min", about="at the suction pressure"
    )
    work: Any = q("", "J", "work of one cylinder on its liquid in a turn")
    power: Any = lead("", "W", "power of the pump, mean", about="on the liquid")
    mean_torque: Any = lead(
        "", "N*m", "torque of the pump, mean", about="of the liquid on the crankshaft"
    )
    volumetric_efficiency: Any = lead(
        "", "", "volumetric efficiency", about="volume drawn over the swept volume"
    )
    torque: Any = q(
        "order", "N*m", "torque of the liquid on the crankshaft, all cylinders, complex", PEAK
    )
    pressure: Any = q("crank_angle", "Pa", "absolute, on one plunger over its own turn")


#: axis name -> (unit, long name)
AXES = {
    "counterweight": ("", "counterweight"),
    "slave_rod": ("", "cylinder with a slave rod"),
}
ENTRIES = tuple(
    entries_of(
        OnBody, Turning, Masses, Counterweights, OfRod, BalanceColumns, BankColumns, OfMotor, OfPump
    )
)
HELPS = {"excitation/": (ORDERS,)}
