"""Readings of accelerometers on a rigid plate, harmonic by harmonic."""

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Angle,
    Frequency,
    Level,
    Name,
    Table,
    Unit,
    Whole,
    WholeNumber,
    later,
)
from vibecalc.core.case.rules import (
    at_most_one,
    needs,
    once,
    one_of,
    pair_ordered,
    refers,
    refuse,
    same_length,
    unique,
)

if TYPE_CHECKING:
    from vibecalc.measurement.record_tables import Record, Spectrum
else:
    globals().update(later({"vibecalc.measurement.record_tables": "Record Spectrum"}))

AngularAcceleration = Annotated[float, Unit("rad/s^2")]
Order = Annotated[int, Whole, Field(ge=1, le=2000)]
Orders = Annotated[tuple[Order, ...], Field(max_length=64)]
#: what lies beyond these is no reading of a machine
Loudness = Annotated[float, Field(ge=-400, le=400), Unit("dB")]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6), Unit("m")]
Levels = Annotated[tuple[Loudness, ...], Field(max_length=64)]
Amplitudes = Annotated[tuple[Annotated[Acceleration, Field(ge=0)], ...], Field(max_length=64)]
AngularAmplitudes = Annotated[
    tuple[Annotated[AngularAcceleration, Field(ge=0)], ...], Field(max_length=64)
]
Phases = Annotated[tuple[Angle, ...], Field(max_length=64)]
Column = Field((), max_length=2000)


class Position(Table):
    """A point of the plate."""

    name: Name = Field(description="label used in readings, tables and `where`")
    x: Coordinate = Field(description="along the crankshaft, from the centre; roll is about x")
    y: Coordinate = Field(description="across it; pitch is about y")


class Reading(Table):
    """What one instrument reads: one number for each harmonic, and a phase where it has one."""

    at: Name | None = Field(None, description="name of the position of an accelerometer")
    between: tuple[Name, Name] | None = Field(
        None, description="two positions: acceleration of the second less that of the first"
    )
    about: Literal["x", "y"] | None = Field(
        None, description="axis of an angular acceleration read directly"
    )
    use: Literal["solve", "choose", "compare"] = Field(
        "solve",
        description="find the motion, choose between motions that are left, or compare only",
    )
    orders: Orders = Field((), description="harmonics that it covers; default: all of them")
    level: Levels = Field((), description="in dB, one for each harmonic")
    amplitude: Amplitudes = Field((), description="instead of levels")
    angular_amplitude: AngularAmplitudes = Field(
        (), description="instead of levels, of an angular acceleration"
    )
    phase: Phases = Field((), description="leading positive, all against one signal")
    RULES = (
        one_of("at", "between", "about"),
        one_of("level", "amplitude", "angular_amplitude"),
        refuse(
            "between",
            "a difference is between two positions",
            lambda t: len({*map(str, t.entries("between"))}) == 1,
            found="{between}",
        ),
        at_most_one("about", "amplitude"),
        at_most_one("at between", "angular_amplitude"),
        once("orders", "order"),
    )


class Scan(Table):
    """Readings at many points, one in each row; a file takes it from an analyser."""

    order: tuple[WholeNumber, ...] = Field(
        min_length=1, max_length=2000, description="harmonic of the row"
    )
    x: tuple[Coordinate, ...] = Field(min_length=1, max_length=2000, description="of the point")
    y: tuple[Coordinate, ...] = Field(min_length=1, max_length=2000, description="of the point")
    level: tuple[Loudness, ...] = Field((), max_length=2000, description="in dB")
    amplitude: tuple[Acceleration, ...] = Field(
        (), max_length=2000, description="instead of levels"
    )
    phase: tuple[Angle, ...] = Field((), max_length=2000, description="leading positive")
    RULES = (
        one_of("level", "amplitude"),
        same_length("order", "x", "y", "level", "amplitude", "phase"),
    )


class Plate(Table):
    """Edges of the plate, for a map and for the place that moves least."""

    x: tuple[Coordinate, Coordinate] = Field(description="from and to, along the crankshaft")
    y: tuple[Coordinate, Coordinate] = Field(description="from and to, across it")
    points: Annotated[int, Field(strict=True, ge=2, le=401)] = Field(
        61, description="of the map, along each edge"
    )
    RULES = (pair_ordered("x", equal=False), pair_ordered("y", equal=False))


class Measurement(Table):
    """Readings on a rigid plate: its translation, roll and pitch, harmonic by harmonic."""

    amplitude: Literal["zero_to_peak", "rms"] = Field(
        description="what readings are amplitudes of; levels are given in the same"
    )
    reference_level: Acceleration | None = Field(
        None, gt=0, description="acceleration of 0 dB; levels need it"
    )
    angular_reference_level: AngularAcceleration | None = Field(
        None, gt=0, description="angular acceleration of 0 dB; default: 1 rad/s^2"
    )
    level_step: Level = Field(
        0.1, gt=0, le=20, description="last digit of a level: it is off by up to half of it"
    )
    level_uncertainty: Level = Field(
        0.0, ge=0, le=20, description="standard uncertainty of a level besides that"
    )
    amplitude_step: Acceleration | None = Field(
        None, gt=0, description="last digit of an amplitude"
    )
    amplitude_uncertainty: Acceleration = Field(
        0.0, ge=0, description="standard uncertainty of an amplitude besides that"
    )
    angular_step: AngularAcceleration | None = Field(
        None, gt=0, description="last digit of an angular amplitude"
    )
    angular_uncertainty: AngularAcceleration = Field(
        0.0, ge=0, description="standard uncertainty of an angular amplitude besides that"
    )
    phase_step: Angle | None = Field(None, gt=0, description="last digit of a phase")
    phase_uncertainty: Angle = Field(
        0.0, ge=0, le=math.pi, description="standard uncertainty of a phase besides that"
    )
    orders: Annotated[tuple[Order, ...], Field(min_length=1, max_length=64)] = Field(
        description="harmonics that are read"
    )
    base_frequency: Frequency | None = Field(
        None, gt=0, description="frequency of order 1, where no machine speed tells it"
    )
    reference_position: Name | None = Field(
        None, description="where phases are zero; default: that of the first reading"
    )
    positions: Annotated[tuple[Position, ...], Field(max_length=200)] = Field(
        (), description="points with names: of readings, and where levels are wanted"
    )
    readings: Annotated[tuple[Reading, ...], Field(max_length=200)] = Field(
        (), description="of instruments"
    )
    scan: Scan | None = Field(None, description="readings at many points")
    record: Annotated[tuple[Record, ...], Field(max_length=64)] = Field(
        (), description="files of samples over time with a tachometer"
    )
    spectrum: Annotated[tuple[Spectrum, ...], Field(max_length=200)] = Field(
        (), description="files of complex spectra"
    )
    plate: Plate | None = Field(None, description="edges of the plate")
    RULES = (
        needs("", "readings scan record spectrum", "something has to be read"),
        unique("positions", "positions"),
        once("orders", "order"),
        *(
            refers(key, "measurement.positions", "position")
            for key in ("readings.at", "readings.between", "reference_position", "spectrum.at")
        ),
        "vibecalc.measurement.record_checks:check_records",
        refuse(
            "base_frequency",
            "the frequency of order 1 stands twice: it is that of the crankshaft",
            lambda t: "base_frequency" in t and "speed" in t.machine,
            "machine.speed alone",
            also=("machine", "speed"),
        ),
    )

    @property
    def channel_names(self) -> tuple[str, ...]:
        """How results name the channels of all records: by position, and by record of several."""
        several = len(self.record) > 1
        return tuple(
            f"{place}: {one.at}" if several else one.at
            for place, record in enumerate(self.record, start=1)
            for one in record.channels
        )
