"""The crank train and its cylinders, as a case writes them."""

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    Length,
    Mass,
    Name,
    Number,
    Point,
    Table,
    Unit,
    key,
    later,
)
from vibecalc.core.case.raw import misspelt, tables_at
from vibecalc.core.case.rules import Row, Rule, needs, once, one_of, refers, refuse, unique

if TYPE_CHECKING:
    from vibecalc.parts.gas_tables import GasCard, GasCycle, GasForce, GasPressure, PumpCycle
    from vibecalc.parts.tangential_effort import TangentialEffort
    from vibecalc.parts.weight_tables import ArticulatedRod, BalanceShaft, Counterweight, Rod
else:
    globals().update(
        later(
            {
                "vibecalc.parts.gas_tables": "GasCard GasCycle GasForce GasPressure PumpCycle",
                "vibecalc.parts.tangential_effort": "TangentialEffort",
                "vibecalc.parts.weight_tables": "ArticulatedRod BalanceShaft Counterweight Rod",
            }
        )
    )

# ----------------------------------------------------------------------------
# The parts of a machine as a case writes them. The kinds of machine share them all.
# ----------------------------------------------------------------------------

AxisName = Literal["x", "y", "z"]
#: what acts on a body on mounts, with what it says
Loads = tuple[Literal["shaking", "torque"], ...]
LOADS = (
    "loads on the body: shaking of the masses, torque of the cylinders; omit torque for the "
    "shaking alone"
)
#: between the rows of gas tables
GasInterpolation = Literal["linear", "parabola", "cubic", "trigonometric"]
Cycle = Literal["four_stroke", "two_stroke"]


def shaking_acts(hint: str) -> Rule:
    """No load without the shaking."""
    return refuse(
        "loads",
        "the shaking always acts",
        lambda t: "torque" in (given := t.data.get("loads") or ()) and "shaking" not in given,
        allowed='loads = ["shaking"] or ["shaking", "torque"]',
        hint=hint,
    )


class Cylinder(Table):
    """One cylinder and its throw."""

    name: Name = key("label in tables and `where`")
    position: Length = key("along the crankshaft, from the train's origin", 0.0)
    crank_phase: Angle = key("angle by which this throw leads crank angle zero", 0.0)
    bank_angle: Angle = key("tilt of the cylinder about the crank axis", 0.0)
    reciprocating_mass: Mass | None = key(
        "overrides the train's reciprocating mass for this cylinder", None, ge=0
    )
    rotating_mass: Mass | None = key(
        "overrides the train's rotating mass for this throw", None, ge=0
    )
    articulated: ArticulatedRod | None = key(
        "its rod is a slave rod on the rod of another cylinder", None
    )
    firing_angle: Angle | None = key(
        "crank angle of firing, of an engine; or firing_order", None, ge=0
    )
    pressure_scale: Number | None = key(
        "factor on the gas pressure of an engine; default: 1", None, ge=0, le=3
    )
    gas_force: GasForce | None = key(
        "of the gas over one turn, instead of pressure and bore: a table or a CSV", None
    )


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
    """Cylinders, rods, cranks and balance weights."""

    axis: AxisName = key("direction of the crankshaft", "x")
    stroke_axis: AxisName = key("direction of a cylinder at bank angle 0", "z")
    origin: Point = key("origin of the train, from the body's reference point", (0.0, 0.0, 0.0))
    crank_radius: Length = key("half the stroke", gt=0)
    rod_length: Length = key("centre to centre", gt=0)
    wrist_pin_offset: Length = key(
        "of the cylinder axis from the crank axis, towards a crank angle of 90 deg", 0.0
    )
    reciprocating_mass: Mass | None = key(
        "of one cylinder; or give piston_mass, pin_mass and rod", None, ge=0
    )
    piston_mass: Mass | None = key("of one piston with its rings", None, gt=0)
    pin_mass: Mass | None = key("of one wrist pin", None, ge=0)
    rod: Rod | None = key("the connecting rod, split into two point masses", None)
    rotating_mass: Mass = key(
        "unbalanced mass at the crank pin of each cylinder, without the rod", 0.0, ge=0
    )
    bore: Length | None = key("cylinder diameter", None, gt=0)
    gas_pressure: GasPressure | None = key(
        "over one turn from top dead centre; of an engine over one cycle, from the firing one",
        None,
    )
    gas_cards: tuple[GasCard, ...] = key(
        "of an engine, at several speeds, instead of gas_pressure", (), max_length=64
    )
    gas_cycle: GasCycle | None = key("of an engine, computed, instead of gas_pressure", None)
    tangential_effort: TangentialEffort | None = key(
        "of an engine, by its harmonics, instead of gas_pressure", None
    )
    pump_cycle: PumpCycle | None = key("of a pump: plunger pressure over one turn", None)
    firing_order: tuple[Name, ...] = key(
        "names of the cylinders of an engine, in firing order", (), max_length=64
    )
    firing_intervals: tuple[Interval, ...] = key(
        "between the cylinders of firing_order; default: even", (), max_length=64
    )
    gas_interpolation: GasInterpolation | None = key(
        "between the rows of gas tables, for roll; default: linear", None
    )
    cylinders: tuple[Cylinder, ...] = key("one entry per cylinder", min_length=1, max_length=64)
    counterweights: tuple[Counterweight, ...] = key("weights on the crankshaft", (), max_length=64)
    balance_shafts: tuple[BalanceShaft, ...] = key(
        "shafts geared to the crankshaft", (), max_length=64
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
