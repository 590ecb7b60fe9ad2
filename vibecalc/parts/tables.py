"""The crank train and the gas in its cylinders, as a case writes them."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Force,
    Inertia,
    Length,
    Mass,
    Name,
    Number,
    Point,
    Pressure,
    Table,
    Unbalance,
    Unit,
    Whole,
)
from vibecalc.core.case.raw import misspelt, tables_at
from vibecalc.core.case.rules import (
    Row,
    Rule,
    by_kind,
    needs,
    once,
    one_of,
    ordered,
    refers,
    same_length,
    unique,
)
from vibecalc.parts.tangential_effort import TangentialEffort

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


class ArticulatedRod(Table):
    """A slave rod: hinged on the rod of another cylinder, not on the crank pin."""

    on: Name = Field(description="the cylinder whose rod is the master")
    knuckle_radius: Length = Field(
        ge=0, description="distance of the knuckle pin from the crank pin, on the master rod"
    )
    knuckle_angle: Angle | None = Field(
        None,
        description="of the knuckle pin from the axis of the master rod, in the sense of rotation; "
        "default: that between the two cylinders",
    )
    rod_length: Length = Field(gt=0, description="from the knuckle pin to the wrist pin")
    knuckle_mass: Mass | None = Field(
        None,
        ge=0,
        description="what moves with the knuckle pin; default: the rod's mass at a crank pin",
    )
    rod_mass: Mass | None = Field(
        None, gt=0, description="of the slave rod, the rest of it moves with the piston"
    )
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own mass centre; default: that of the two point masses"
    )
    RULES = (
        refers("on", "machine.crank_train.cylinders", "cylinder"),
        needs("inertia", "rod_mass"),
        needs("rod_mass", "inertia"),
    )


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
    articulated: ArticulatedRod | None = Field(
        None, description="its rod is a slave rod on that of another cylinder"
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
    def has_slave_rods(self) -> bool:
        """Whether some rods are hinged on others."""
        return any(cylinder.articulated is not None for cylinder in self.cylinders)

    @property
    def has_banks(self) -> bool:
        """Whether cylinders push along different lines, so that only vectors of them add."""
        first = self.cylinders[0].bank_angle
        away = [math.remainder(c.bank_angle - first, 2.0 * math.pi) for c in self.cylinders]
        return any(abs(angle) > 1e-9 for angle in away)


#: Default of a field that its kind needs: the checks of kinds refuse a case without it, so that
#: who reads the field finds what its type says, and the plain type is the honest one.
NEEDED_BY_KIND: Any = None


def cylinders_in(key: str) -> tuple[Rule, Rule]:
    """Rules of a list of names of cylinders."""
    return refers(key, "machine.crank_train.cylinders", "cylinder"), once(key, "cylinder")


Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=64)]


#: of throws that weights cancel; an empty list is no weights at all
Throws = Annotated[tuple[Name, ...], Field(max_length=64)]


Idle = Literal["stopped", "unloaded"]
