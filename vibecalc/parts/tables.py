"""The parts of a machine as a case writes them: crank train, gas, joints, body, mounts, motor."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    Damping,
    DampingOrThree,
    Force,
    Inertia,
    Length,
    Mass,
    Moment,
    Name,
    Number,
    Point,
    Pressure,
    Resistance,
    Stiffness,
    StiffnessOrThree,
    Table,
    Unbalance,
    Unit,
    Voltage,
    Whole,
    WholeNumber,
)
from vibecalc.core.case.raw import misspelt, read_number, table_at, tables_at
from vibecalc.core.case.rules import (
    Row,
    Rule,
    ascending,
    at_most_one,
    by_kind,
    needs,
    once,
    one_of,
    ordered,
    refers,
    refuse,
    same_length,
    unique,
)
from vibecalc.core.results.named import named
from vibecalc.errors import Problem
from vibecalc.parts.tangential_effort import TangentialEffort

# ----------------------------------------------------------------------------
# Joints with play: what a case says of clearances and of the contact in them.
# ----------------------------------------------------------------------------


class Play(Table):
    """A dead band between two contacts."""

    clearance: Length = Field(gt=0, description="free travel from one contact to the other")
    stiffness: Stiffness = Field(gt=0, description="of a contact")
    contact_damping: Damping = Field(0.0, description="viscous, while in contact")
    film_damping: Damping = Field(
        0.0, description="viscous, while in the gap: a linearised squeeze film"
    )


class Joint(Play):
    """A bearing with play along the cylinder."""

    spring: Literal["continuous", "full_deflection"] = Field(
        "continuous",
        description="force beyond the clearance: stiffness times what goes beyond it, or times the "
        "whole deflection, which jumps at contact",
    )


class Joints(Table):
    """Bearings with play in the running gear of one cylinder."""

    cylinder: Name | None = Field(None, description="which one; default: the first that works")
    wrist_pin: Joint = Field(description="between rod and piston")
    crank_pin: Joint | None = Field(
        None, description="between crank and rod; the rod is then a mass between two gaps"
    )
    bore: Play | None = Field(None, description="between piston and cylinder wall: piston slap")
    RULES = (refers("cylinder", "machine.crank_train.cylinders", "cylinder"),)


# ----------------------------------------------------------------------------
# What the gas does to a piston over one turn, as a table. Each may stand in a CSV.
# ----------------------------------------------------------------------------

GasInterpolation = Literal["linear", "parabola", "cubic", "trigonometric"]


#: not below that of an empty cylinder
GasPressureValue = Annotated[float, Field(ge=-1e5), Unit("Pa")]


class GasPressure(Table):
    """Pressure on the piston over one turn, or over one cycle of an engine."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=3,
        max_length=2000,
        description="ascending, the last one turn (of an engine: one cycle) after the first",
    )
    pressure: tuple[GasPressureValue, ...] = Field(
        min_length=3, max_length=2000, description="above that of the crankcase, one per angle"
    )
    RULES = (same_length("crank_angle", "pressure"),)


class GasForce(Table):
    """Force on the piston over one turn of its own cylinder; positive pushes towards the crank."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=1,
        max_length=2000,
        description="of this cylinder, from its own top dead centre; the last one turn after the "
        "first",
    )
    force: tuple[Force, ...] = Field(
        min_length=1, max_length=2000, description="of the gas on the piston, one per angle"
    )
    RULES = (same_length("crank_angle", "force"),)


# ----------------------------------------------------------------------------
# What the cylinders of an engine do over a cycle: cards at several speeds, computed cycles.
# ----------------------------------------------------------------------------

Cycle = Literal["four_stroke", "two_stroke"]
#: of the crank of a cylinder, from its own firing top dead centre
CycleAngle = Annotated[float, Field(ge=-3.1416, le=3.1416), Unit("rad")]
#: of a polytropic change of state
Exponent = Annotated[float, Field(gt=1, lt=2), Unit("")]


class GasCard(Table):
    """The pressure over a cycle at one speed."""

    speed: AngularSpeed = Field(gt=0, description="of the crankshaft, at which it was taken")
    gas_pressure: GasPressure = Field(description="over one cycle: a table or a CSV")


class GasCycle(Table):
    """A cycle to be computed instead of a measured card; what is not said has usual values."""

    kind: Literal["spark", "diesel"] = Field(
        description="heat at constant volume at first, or limited by the peak pressure"
    )
    compression_ratio: Number | None = Field(
        None, gt=1, le=60, description="largest volume over the smallest"
    )
    intake_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, in the cylinder before the compression"
    )
    exhaust_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, in the cylinder as the gas goes out"
    )
    crankcase_pressure: Pressure | None = Field(
        None, gt=0, description="absolute, under the piston; default: 101325 Pa"
    )
    peak_pressure: Pressure | None = Field(
        None, gt=0, description="absolute; it or mean_indicated_pressure"
    )
    mean_indicated_pressure: Pressure | None = Field(
        None, description="work of a cycle over the swept volume; negative: it is driven"
    )
    compression_exponent: Exponent | None = Field(None, description="polytropic")
    expansion_exponent: Exponent | None = Field(None, description="polytropic")
    combustion_starts: CycleAngle | None = Field(None, description="of the own crank angle")
    combustion_ends: CycleAngle | None = Field(None, description="of the own crank angle")
    injection_ends: CycleAngle | None = Field(
        None, description="of a diesel, which holds its pressure up to there"
    )
    inlet_closes: CycleAngle | None = Field(None, description="where the compression begins")
    exhaust_opens: CycleAngle | None = Field(None, description="where the expansion ends")
    overlap: Angle | None = Field(
        None, gt=0, le=1.5, description="half width of the charge exchange, of four strokes"
    )
    RULES = (
        one_of("peak_pressure", "mean_indicated_pressure"),
        by_kind("cycle", spark="", diesel="| injection_ends"),
    )


# ----------------------------------------------------------------------------
# What the cylinders of a pump do over a turn: two pressures and a liquid that yields a little.
# ----------------------------------------------------------------------------

Volume = Annotated[float, Unit("m^3")]


class PumpCycle(Table):
    """Suction, compression, discharge and re-expansion; the pressures open and close the valves."""

    suction_pressure: Pressure = Field(gt=0, description="absolute, in the cylinder as it fills")
    discharge_pressure: Pressure = Field(
        gt=0, description="absolute, in the cylinder as it delivers"
    )
    bulk_modulus: Pressure = Field(
        gt=0, description="of the liquid with the walls around it: -V dp/dV"
    )
    dead_volume: Volume = Field(
        gt=0, description="liquid left in one cylinder at its top dead centre"
    )
    outside_pressure: Pressure = Field(
        101325.0, gt=0, description="absolute, on the other side of the plunger"
    )
    RULES = (
        ordered(
            "suction_pressure",
            "discharge_pressure",
            "a pump delivers at a higher pressure than it draws at",
        ),
    )


# ----------------------------------------------------------------------------
# Matrices of a body and of its suspension, given as a whole.
# ----------------------------------------------------------------------------

SixNumbers = tuple[Number, Number, Number, Number, Number, Number]


class BlockMatrix(Table):
    """A symmetric 6 x 6 matrix in the order x y z rx ry rz, one unit for each kind of block."""

    #: SI units of the blocks, an angle counting as a plain number
    SI: ClassVar[tuple[str, str, str]]

    values: tuple[SixNumbers, SixNumbers, SixNumbers, SixNumbers, SixNumbers, SixNumbers] = Field(
        description="six rows of six numbers, in the order x y z rx ry rz"
    )
    units: tuple[Name, Name, Name] | None = Field(
        None, description="units of the blocks: translation, coupling, rotation; default SI"
    )
    RULES = ("vibecalc.parts.rules:matrix_units",)


class MassMatrix(BlockMatrix):
    """Mass matrix of the body about its reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("kg", "kg*m", "kg*m^2")


class StiffnessMatrix(BlockMatrix):
    """Stiffness of the whole suspension at the reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("N/m", "N", "N*m")


class DampingMatrix(BlockMatrix):
    """Viscous damping of the whole suspension at the reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("N*s/m", "N*s", "N*m*s")


# ----------------------------------------------------------------------------
# The parts of a machine as a case writes them. The kinds of machine share them all.
# ----------------------------------------------------------------------------

AxisName = Literal["x", "y", "z"]


class Rod(Table):
    """A connecting rod as two point masses: one with the wrist pin, one with the crank pin."""

    mass: Mass = Field(gt=0, description="mass of one connecting rod")
    crank_pin_to_mass_centre: Length | None = Field(
        None, ge=0, description="distance from the crank pin to the mass centre of the rod"
    )
    reciprocating_fraction: Number | None = Field(
        None, ge=0, le=1, description="share of the rod mass that moves with the piston"
    )
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own mass centre; default: that of the two point masses"
    )
    RULES = (one_of("crank_pin_to_mass_centre", "reciprocating_fraction"),)


class Cylinder(Table):
    """One cylinder and its throw."""

    name: Name = Field(description="label used in tables and in `where`")
    position: Length = Field(0.0, description="along the crankshaft, from the train's origin")
    crank_phase: Angle = Field(0.0, description="angle by which this throw leads crank angle zero")
    bank_angle: Angle = Field(0.0, description="tilt of the cylinder about the crank axis")
    reciprocating_mass: Mass | None = Field(
        None, ge=0, description="overrides the train's reciprocating mass for this cylinder"
    )
    rotating_mass: Mass | None = Field(
        None, ge=0, description="overrides the train's rotating mass for this throw"
    )
    firing_angle: Angle | None = Field(
        None, ge=0, description="crank angle at which it fires, of an engine; or firing_order"
    )
    pressure_scale: Number | None = Field(
        None, ge=0, le=3, description="of the gas pressure of an engine, 0.9: weak; default: 1"
    )
    gas_force: GasForce | None = Field(
        None, description="of the gas over one turn, instead of pressure and bore: a table or a CSV"
    )


class Counterweight(Table):
    """A weight fixed to the crankshaft."""

    name: Name = Field("counterweight", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    phase: Angle = Field(0.0, description="angle by which it leads crank angle zero")
    position: Length = Field(0.0, description="along the crankshaft, from the train's origin")


class BalanceShaft(Table):
    """An extra shaft with an unbalance, geared to the crankshaft."""

    name: Name = Field("balance shaft", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = Field(
        description="shaft speed over crank speed; negative turns the other way"
    )
    phase: Angle = Field(0.0, description="angle of the unbalance from the stroke at crank angle 0")
    position: Point = Field((0.0, 0.0, 0.0), description="from the train's origin, along x, y, z")


def _parts_needed(row: Row) -> bool:
    """Whether the masses of the train count: not where each cylinder has its own."""
    key, cylinders = "reciprocating_mass", tables_at(row.data, "cylinders")
    of_cylinders = bool(cylinders) and all(key in entry for _, entry in cylinders)
    path = (*row.path, "cylinders")
    return not (
        of_cylinders or any(misspelt(entry, (*path, place), key) for place, entry in cylinders)
    )


Interval = Annotated[float, Field(ge=0), Unit("rad")]


class CrankTrain(Table):
    """Cylinders, rods and cranks, and what is put in to balance them."""

    axis: AxisName = Field("x", description="direction of the crankshaft")
    stroke: AxisName = Field("z", description="direction of a cylinder at bank angle zero")
    origin: Point = Field(
        (0.0, 0.0, 0.0), description="origin of the train, from the body's reference point"
    )
    crank_radius: Length = Field(gt=0, description="half the stroke")
    rod_length: Length = Field(gt=0, description="between the centres of the rod's bearings")
    wrist_pin_offset: Length = Field(
        0.0, description="of the cylinder axis from the crank axis, towards a crank angle of 90 deg"
    )
    reciprocating_mass: Mass | None = Field(
        None, ge=0, description="of one cylinder; or give piston_mass, pin_mass and rod"
    )
    piston_mass: Mass | None = Field(None, gt=0, description="of one piston with its rings")
    pin_mass: Mass | None = Field(None, ge=0, description="of one wrist pin")
    rod: Rod | None = Field(None, description="the connecting rod, split into two point masses")
    rotating_mass: Mass = Field(
        0.0, ge=0, description="unbalanced mass at the crank pin of each cylinder, without the rod"
    )
    bore: Length | None = Field(None, gt=0, description="diameter of the cylinders")
    gas_pressure: GasPressure | None = Field(
        None,
        description="pressure over one turn of a cylinder, from its top dead centre; of an engine "
        "over one cycle, from the firing one",
    )
    gas_cards: tuple[GasCard, ...] = Field(
        (), max_length=64, description="of an engine, at several speeds, instead of gas_pressure"
    )
    gas_cycle: GasCycle | None = Field(
        None, description="of an engine, computed, instead of gas_pressure"
    )
    tangential_effort: TangentialEffort | None = Field(
        None, description="of an engine, by its harmonics, instead of gas_pressure"
    )
    pump_cycle: PumpCycle | None = Field(
        None, description="of a pump: the pressure on its plungers over a turn"
    )
    firing_order: Annotated[tuple[Name, ...], Field(max_length=64)] = Field(
        (), description="names of the cylinders of an engine, as they fire"
    )
    firing_intervals: Annotated[tuple[Interval, ...], Field(max_length=64)] = Field(
        (), description="from each of firing_order to the next; default: even ones"
    )
    gas_interpolation: GasInterpolation | None = Field(
        None,
        description="between the rows of gas tables, for the roll of the machine, linear if not "
        "said",
    )
    cylinders: tuple[Cylinder, ...] = Field(
        min_length=1, max_length=64, description="one entry for each cylinder"
    )
    counterweights: tuple[Counterweight, ...] = Field(
        (), max_length=64, description="weights on the crankshaft"
    )
    balance_shafts: tuple[BalanceShaft, ...] = Field(
        (), max_length=64, description="shafts geared to the crankshaft"
    )
    RULES = (
        one_of("reciprocating_mass", "piston_mass pin_mass rod", when=_parts_needed),
        *(
            needs(part, "piston_mass reciprocating_mass", when=_parts_needed)
            for part in ("pin_mass", "rod")
        ),
        unique("cylinders"),
        refers("firing_order", "machine.crank_train.cylinders", "cylinder"),
        once("firing_order", "cylinder"),
        unique("gas_cards", "cards", "speed"),
    )

    @property
    def has_banks(self) -> bool:
        """Whether cylinders push along different lines, so that only vectors of them add."""
        first = self.cylinders[0].bank_angle
        away = [math.remainder(c.bank_angle - first, 2.0 * math.pi) for c in self.cylinders]
        return any(abs(angle) > 1e-9 for angle in away)


class Box(Table):
    """A uniform block, edges along x, y and z."""

    length: Length = Field(gt=0, description="edge along x")
    width: Length = Field(gt=0, description="edge along y")
    height: Length = Field(gt=0, description="edge along z")


class InertiaBlock(Table):
    """A block bolted to the body: its mass, inertia and weight count."""

    mass: Mass = Field(ge=0, description="mass of the block")
    box: Box = Field(description="its edges, for its own inertia")
    position: Point = Field(
        (0.0, 0.0, 0.0), description="of its mass centre, from the body's reference point"
    )


Moment3 = Annotated[float, Field(gt=0), Unit("kg*m^2")]


def _parts_said(row: Row) -> bool:
    """Whether the body is one of parts: not of a matrix, whose name may be misspelt."""
    complete = "mass" in row and not row.data.keys().isdisjoint({"inertia", "box"})
    return "mass_matrix" not in row and (
        complete or not misspelt(row.data, row.path, "mass_matrix")
    )


class Body(Table):
    """The rigid machine. Its reference point is its mass centre without the inertia block."""

    mass: Mass | None = Field(None, gt=0, description="of the whole machine")
    box: Box | None = Field(None, description="inertia from a uniform block; or give inertia")
    inertia: tuple[Moment3, Moment3, Moment3] | None = Field(
        None, description="moments Ixx, Iyy, Izz about the mass centre"
    )
    inertia_products: tuple[Inertia, Inertia, Inertia] = Field(
        (0.0, 0.0, 0.0), description="products Ixy, Ixz, Iyz: sums of m x y, m x z, m y z"
    )
    inertia_block: InertiaBlock | None = Field(None, description="a block added to the machine")
    mass_matrix: MassMatrix | None = Field(
        None, description="of the whole machine, instead of all of these"
    )
    RULES = (
        at_most_one("mass_matrix", "mass box inertia inertia_products inertia_block"),
        needs("", "mass mass_matrix", allowed="a mass > 0 kg, e.g. '0.4 kg' or '400 g'"),
        one_of("inertia", "box", when=_parts_said),
        refuse(
            "inertia_products",
            "inertia_products go with inertia: a box has none",
            lambda t: (
                "box" in t
                and _parts_said(t)
                and any(read_number(one, "kg*m^2") for one in t.entries("inertia_products"))
            ),
            also="box",
        ),
    )


class MountProperties(Table):
    """Stiffness and damping, one number for all directions or three along the mount's own axes."""

    stiffness: StiffnessOrThree | None = Field(
        None, description="one number, or three along the mount's own axes"
    )
    damping: DampingOrThree | None = Field(
        None, description="viscous, one number or three along the mount's own axes"
    )
    loss_factor: Number | None = Field(
        None, ge=0, le=10, description="of a complex stiffness k (1 + i loss_factor)"
    )


class Mount(MountProperties):
    """One mount; what it does not say comes from `each`."""

    name: Name = Field(description="label used in tables and in `where`")
    position: Point = Field(description="from the body's reference point")
    orientation: tuple[Angle, Angle, Angle] = Field(
        (0.0, 0.0, 0.0), description="rotations of the mount's axes about x, then y, then z"
    )


_WITH_MATRIX = ("damping_matrix", "loss_factor")
_FOR_A_MATRIX = "mounts with places have their own in [machine.mounts.each] or one by one"


def _mounts_needed(row: Row) -> bool:
    return row.data.keys().isdisjoint(_WITH_MATRIX)


def _no_stiffness(row: Row) -> Iterator[Problem]:
    """The stiffness of mounts stands in `each`, or on each of them."""
    each = table_at(row.data, "each")
    known = "stiffness" in each or "stiffness_matrix" in row
    if known or not isinstance(row.data.get("each", {}), dict):
        return
    if "positions" in row:
        yield row.problem(
            "each" if each else "",
            "mounts given by positions have no stiffness",
            allowed="each = { stiffness = ... }",
        )
    for place, mount in tables_at(row.data, "individual"):
        if "stiffness" not in mount:
            yield row.problem(
                (*row.path, "individual", place),
                f"mount {mount.get('name', place + 1)!r} has no stiffness",
                allowed="a stiffness of its own, or one in [machine.mounts.each]",
            )


class Mounts(Table):
    """What the body stands on."""

    each: MountProperties | None = Field(None, description="common to all mounts")
    positions: tuple[Point, ...] | None = Field(
        None, min_length=1, max_length=256, description="of equal mounts, named 1, 2, 3 ..."
    )
    individual: tuple[Mount, ...] | None = Field(
        None, min_length=1, max_length=256, description="mounts one by one, instead of positions"
    )
    stiffness_matrix: StiffnessMatrix | None = Field(
        None, description="of the whole suspension, instead of mounts"
    )
    damping_matrix: DampingMatrix | None = Field(
        None, description="of the whole suspension, with stiffness_matrix"
    )
    loss_factor: Number | None = Field(
        None, ge=0, le=10, description="of a complex stiffness_matrix K (1 + i loss_factor)"
    )
    modal_damping: Number | None = Field(
        None, ge=0, le=10, description="damping ratio of every mode, added to what else damps"
    )
    RULES = (
        one_of(
            "stiffness_matrix",
            "positions",
            "individual",
            when=_mounts_needed,
            allowed="positions of equal mounts, individual mounts, or one stiffness_matrix",
        ),
        at_most_one("stiffness_matrix", "each"),
        *(needs(key, "stiffness_matrix", _FOR_A_MATRIX) for key in _WITH_MATRIX),
        unique("individual"),
        _no_stiffness,
    )


# ----------------------------------------------------------------------------
# The motor on the crankshaft: torque that is given by order, or torque over the slip.
# ----------------------------------------------------------------------------

#: Default of a field that its kind needs: the checks of kinds refuse a case without it, so that
#: who reads the field finds what its type says, and the plain type is the honest one.
NEEDED_BY_KIND: Any = None


class TorqueHarmonics(Table):
    """Torque on the rotor: the sum of cosine cos(n a) + sine sin(n a) over the orders."""

    order: tuple[WholeNumber, ...] = Field(
        min_length=1, max_length=401, description="multiples of the crank speed, 0 is the mean"
    )
    cosine: tuple[Moment, ...] = Field(
        min_length=1, max_length=401, description="amplitude of the cosine, one per order"
    )
    sine: tuple[Moment, ...] = Field(
        min_length=1, max_length=401, description="amplitude of the sine, one per order"
    )
    RULES = (same_length("order", "cosine", "sine", what="torque"), once("order", "order"))


SlipTorque = Annotated[float, Field(ge=0), Unit("N*m")]


class SlipTable(Table):
    """Torque over the slip of an induction motor; at negative slip it is the negative one."""

    slip: tuple[AngularSpeed, ...] = Field(
        min_length=1, max_length=2000, description="synchronous speed less speed, ascending from 0"
    )
    torque: tuple[SlipTorque, ...] = Field(
        min_length=1,
        max_length=2000,
        description="on the rotor, from 0, one per slip; below its field a motor does not brake",
    )
    RULES = (same_length("slip", "torque"), ascending("slip"))


def _motor_kind(row: Row) -> Any:
    return named("vibecalc.kinds:motor_kind")(row.machine)


class Motor(Table):
    """The motor that drives the crankshaft; its kind says which of these keys it has."""

    kind: Literal["torque_harmonics", "slip_table", "linear", "dynamic"] | None = Field(
        None,
        description="torque given by order at a given speed, if not said, or over the slip: the "
        "motor then finds the speed",
    )
    rotor_diameter: Length = Field(
        NEEDED_BY_KIND,
        gt=0,
        description="of the circle of the rotor's conductors (torque_harmonics)",
    )
    skew_angle: Angle = Field(
        NEEDED_BY_KIND,
        gt=-1.5,
        lt=1.5,
        description="of the conductors against the axis of the rotor (torque_harmonics)",
    )
    torque: TorqueHarmonics = Field(
        NEEDED_BY_KIND, description="torque on the rotor, by order (torque_harmonics)"
    )
    synchronous_speed: AngularSpeed = Field(
        NEEDED_BY_KIND, gt=0, description="of the stator's field (slip_table, linear, dynamic)"
    )
    slip_table: SlipTable = Field(
        NEEDED_BY_KIND, description="torque over the slip, in steady running (slip_table, dynamic)"
    )
    interpolation: Literal["linear", "parabola", "monotone"] | None = Field(
        None, description="between the rows of the slip table, monotone if not said"
    )
    beyond: Literal["refuse", "hold"] | None = Field(
        None,
        description="slip beyond the table: hold the last torque, or refuse, which is the default",
    )
    gain: AngularDamping = Field(
        NEEDED_BY_KIND, gt=0, description="torque for each unit of slip (linear)"
    )
    poles: Annotated[int, Field(strict=True, ge=2, le=200)] = Field(
        NEEDED_BY_KIND, description="number of poles, an even one (dynamic)"
    )
    voltage: Voltage = Field(
        NEEDED_BY_KIND, gt=0, description="line to line, effective value (dynamic)"
    )
    stator_resistance: Resistance = Field(
        NEEDED_BY_KIND, gt=0, description="of one phase, connected as a star (dynamic)"
    )
    cages: Literal["single", "double", "triple"] | None = Field(
        None, description="of the rotor, fitted to the slip table (dynamic), double if not said"
    )
    RULES = (
        by_kind(
            "motor",
            _motor_kind,
            torque_harmonics="rotor_diameter skew_angle torque",
            slip_table="synchronous_speed slip_table | interpolation beyond",
            linear="synchronous_speed gain",
            dynamic="synchronous_speed slip_table poles voltage stator_resistance "
            "| cages interpolation beyond",
        ),
    )


def cylinders_in(key: str) -> tuple[Rule, Rule]:
    """Rules of a list of names of cylinders."""
    return refers(key, "machine.crank_train.cylinders", "cylinder"), once(key, "cylinder")


Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=64)]


#: of throws that weights cancel; an empty list is no weights at all
Throws = Annotated[tuple[Name, ...], Field(max_length=64)]


Idle = Literal["stopped", "unloaded"]
