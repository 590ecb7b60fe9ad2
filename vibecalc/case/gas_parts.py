"""Tables that a machine is driven with: gas pressure, motor torque. Each may stand in a CSV."""

from pydantic import Field

from vibecalc.case.fields import Angle, Length, Moment, Pressure, Table, WholeNumber


class GasPressure(Table):
    """Pressure on the piston over one turn, straight lines between the entries."""

    crank_angle: tuple[Angle, ...] = Field(
        min_length=3, max_length=2000, description="ascending, the last one turn after the first"
    )
    pressure: tuple[Pressure, ...] = Field(
        min_length=3, max_length=2000, description="above that of the crankcase, one per angle"
    )


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


class Motor(Table):
    """The motor that drives the crankshaft."""

    rotor_diameter: Length = Field(gt=0, description="of the circle of the rotor's conductors")
    skew_angle: Angle = Field(
        gt=-1.5, lt=1.5, description="of the conductors against the axis of the rotor"
    )
    torque: TorqueHarmonics = Field(description="torque on the rotor, by order")
