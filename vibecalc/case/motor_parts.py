"""The motor on the crankshaft: torque that is given by order, or torque over the slip."""

from typing import Annotated, Any, Literal

from pydantic import Field

from vibecalc.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    Length,
    Moment,
    Resistance,
    Table,
    Voltage,
    WholeNumber,
)

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


class SlipTable(Table):
    """Torque over the slip of an induction motor; at negative slip it is the negative one."""

    slip: tuple[AngularSpeed, ...] = Field(
        min_length=1, max_length=2000, description="synchronous speed less speed, ascending from 0"
    )
    torque: tuple[Moment, ...] = Field(
        min_length=1, max_length=2000, description="on the rotor, from 0, one per slip"
    )


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
