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
    key,
)
from vibecalc.core.case.rules import Row, ascending, by_kind, once, refers, same_length
from vibecalc.core.results.named import named
from vibecalc.parts.tables import NEEDED_BY_KIND

# ----------------------------------------------------------------------------
# Joints with play: what a case says of clearances and of the contact in them.
# ----------------------------------------------------------------------------


class Play(Table):
    """A clearance between two contacts."""

    clearance: Length = key("total free travel between the contacts", gt=0)
    stiffness: Stiffness = key("of a contact", gt=0)
    contact_damping: Damping = key("viscous, while in contact", 0.0)
    film_damping: Damping = key("viscous, in the clearance: a linearised squeeze film", 0.0)


class Joint(Play):
    """A bearing with clearance along the cylinder axis."""

    spring: Literal["continuous", "full_deflection"] = key(
        "contact force: stiffness times penetration, or times the full deflection, which "
        "jumps at contact",
        "continuous",
    )


class Joints(Table):
    """Bearings with clearance in the running gear of one cylinder."""

    cylinder: Name | None = key("its name; default: the first working one", None)
    wrist_pin: Joint = key("between rod and piston")
    crank_pin: Joint | None = key(
        "between crank and rod; the rod is then a mass between two clearances", None
    )
    bore: Play | None = key("between piston and cylinder wall: piston slap", None)
    RULES = (refers("cylinder", "machine.crank_train.cylinders", "cylinder"),)


# ----------------------------------------------------------------------------
# The motor on the crankshaft: torque that is given by order, or torque over the slip.
# ----------------------------------------------------------------------------


class TorqueHarmonics(Table):
    """Torque on the rotor: the sum of cosine cos(n a) + sine sin(n a) over the orders."""

    order: tuple[WholeNumber, ...] = key(
        "multiples of the crank speed, 0 is the mean", min_length=1, max_length=401
    )
    cosine: tuple[Moment, ...] = key(
        "amplitude of the cosine, one per order", min_length=1, max_length=401
    )
    sine: tuple[Moment, ...] = key(
        "amplitude of the sine, one per order", min_length=1, max_length=401
    )
    RULES = (same_length("order", "cosine", "sine", what="torque"), once("order", "order"))


SlipTorque = Annotated[Moment, Field(ge=0)]


class SlipTable(Table):
    """Torque over slip of an induction motor; odd in the slip."""

    slip: tuple[AngularSpeed, ...] = key(
        "synchronous speed minus speed, ascending from 0", min_length=1, max_length=2000
    )
    torque: tuple[SlipTorque, ...] = key(
        "on the rotor, from 0, one per slip; below synchronous speed a motor does not brake",
        min_length=1,
        max_length=2000,
    )
    RULES = (same_length("slip", "torque"), ascending("slip"))


def _motor_kind(row: Row) -> Any:
    return named("vibecalc.kinds:motor_kind")(row.machine)


class Motor(Table):
    """Motor on the crankshaft; `kind` decides which of these keys apply."""

    kind: Literal["torque_harmonics", "slip_table", "linear", "dynamic"] | None = key(
        "torque by order at a given speed (default), or over slip, with the speed as a result",
        None,
    )
    rotor_diameter: Length = key(
        "diameter of the circle of the rotor conductors (torque_harmonics)", NEEDED_BY_KIND, gt=0
    )
    skew_angle: Angle = key(
        "of the conductors to the rotor axis (torque_harmonics)",
        NEEDED_BY_KIND,
        gt=-1.5,
        lt=1.5,
    )
    torque: TorqueHarmonics = key(
        "torque on the rotor, by order (torque_harmonics)", NEEDED_BY_KIND
    )
    synchronous_speed: AngularSpeed = key(
        "of the stator field (slip_table, linear, dynamic)", NEEDED_BY_KIND, gt=0
    )
    slip_table: SlipTable = key(
        "torque over slip, steady state (slip_table, dynamic)", NEEDED_BY_KIND
    )
    interpolation: Literal["linear", "parabola", "monotone"] | None = key(
        "between the rows of the slip table; default: monotone", None
    )
    beyond: Literal["refuse", "hold"] | None = key(
        "slip beyond the table: hold the last torque, or refuse (default)",
        None,
        alias="extrapolation",
    )
    gain: AngularDamping = key("torque per unit of slip (linear)", NEEDED_BY_KIND, gt=0)
    poles: int = key("number of poles, even (dynamic)", NEEDED_BY_KIND, strict=True, ge=2, le=200)
    voltage: Voltage = key("line to line, r.m.s. (dynamic)", NEEDED_BY_KIND, gt=0)
    stator_resistance: Resistance = key(
        "per phase, star connection (dynamic)", NEEDED_BY_KIND, gt=0
    )
    cages: Literal["single", "double", "triple"] | None = key(
        "of the rotor, fitted to the slip table (dynamic); default: double", None
    )
    RULES = (
        by_kind(
            "motor",
            _motor_kind,
            torque_harmonics="rotor_diameter skew_angle torque",
            slip_table="synchronous_speed slip_table | interpolation extrapolation",
            linear="synchronous_speed gain",
            dynamic="synchronous_speed slip_table poles voltage stator_resistance "
            "| cages interpolation extrapolation",
        ),
    )
