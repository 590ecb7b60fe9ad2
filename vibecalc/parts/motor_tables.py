"""The motor on the crankshaft and joints with play, as a case writes them."""

from typing import Annotated, Any, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    Damping,
    Length,
    Moment,
    Name,
    Resistance,
    Stiffness,
    Table,
    Voltage,
    WholeNumber,
)
from vibecalc.core.case.rules import (
    Row,
    ascending,
    by_kind,
    once,
    refers,
    same_length,
)
from vibecalc.core.results.named import named
from vibecalc.parts.tables import NEEDED_BY_KIND

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
# The motor on the crankshaft: torque that is given by order, or torque over the slip.
# ----------------------------------------------------------------------------


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


SlipTorque = Annotated[Moment, Field(ge=0)]


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
