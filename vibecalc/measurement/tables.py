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
    Number,
    Table,
    Unit,
    Whole,
    WholeNumber,
    key,
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

    name: Name = key("label used in readings, tables and `where`")
    x: Coordinate = key("along the crankshaft, from the centre; roll is about x")
    y: Coordinate = key("across it; pitch is about y")


class Reading(Table):
    """Reading of one instrument: a number per harmonic, with a phase if it has one."""

    at: Name | None = key("name of the accelerometer's position", None)
    between: tuple[Name, Name] | None = key(
        "two positions: acceleration of the second minus that of the first", None
    )
    about: Literal["x", "y"] | None = key("axis of a measured angular acceleration", None)
    use: Literal["solve", "choose", "compare"] = key(
        "fit the motion to it, choose between several motions that fit, or compare only", "solve"
    )
    orders: Orders = key("its harmonics; default: all", ())
    level: Levels = key("in dB, one per harmonic", ())
    amplitude: Amplitudes = key("instead of level", ())
    angular_amplitude: AngularAmplitudes = key("instead of level, of an angular acceleration", ())
    phase: Phases = key("phase lead, all relative to one signal", ())
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
    """Readings at many points, one per row, as analysers export them."""

    order: tuple[WholeNumber, ...] = key("harmonic of the row", min_length=1, max_length=2000)
    x: tuple[Coordinate, ...] = key("of the point", min_length=1, max_length=2000)
    y: tuple[Coordinate, ...] = key("of the point", min_length=1, max_length=2000)
    level: tuple[Loudness, ...] = key("in dB", (), max_length=2000)
    amplitude: tuple[Acceleration, ...] = key("instead of level", (), max_length=2000)
    phase: tuple[Angle, ...] = key("phase lead", (), max_length=2000)
    RULES = (
        one_of("level", "amplitude"),
        same_length("order", "x", "y", "level", "amplitude", "phase"),
    )


class Plate(Table):
    """Edges of the plate, for a map and for the point of least motion."""

    x: tuple[Coordinate, Coordinate] = key("minimum and maximum, along the crankshaft")
    y: tuple[Coordinate, Coordinate] = key("minimum and maximum, across it")
    points: int = key("of the map, along each edge", 61, strict=True, ge=2, le=401)
    RULES = (pair_ordered("x", equal=False), pair_ordered("y", equal=False))


class Measurement(Table):
    """Readings on a rigid plate: its translation, roll and pitch, harmonic by harmonic."""

    amplitude: Literal["zero_to_peak", "rms"] = key("amplitude convention of readings and levels")
    reference_level: Acceleration | None = key("acceleration at 0 dB, for levels", None, gt=0)
    angular_reference_level: AngularAcceleration | None = key(
        "angular acceleration at 0 dB; default: 1 rad/s^2", None, gt=0
    )
    level_step: Level = key("resolution of levels; the error is up to half of it", 0.1, gt=0, le=20)
    level_uncertainty: Level = key("further standard uncertainty of levels", 0.0, ge=0, le=20)
    amplitude_step: Acceleration | None = key("resolution of amplitudes", None, gt=0)
    amplitude_uncertainty: Acceleration = key(
        "further standard uncertainty of amplitudes", 0.0, ge=0
    )
    angular_step: AngularAcceleration | None = key("resolution of angular amplitudes", None, gt=0)
    angular_uncertainty: AngularAcceleration = key(
        "further standard uncertainty of angular amplitudes", 0.0, ge=0
    )
    phase_step: Angle | None = key("resolution of phases", None, gt=0)
    phase_uncertainty: Angle = key("further standard uncertainty of phases", 0.0, ge=0, le=math.pi)
    sensitivity_mismatch: Number = key(
        "standard uncertainty (share) of the sensitivity ratio of the two accelerometers of a "
        "difference",
        0.0,
        ge=0,
        le=1,
    )
    phase_mismatch: Angle = key(
        "standard uncertainty of the phase between these two", 0.0, ge=0, le=math.pi
    )
    orders: tuple[Order, ...] = key("measured harmonics", min_length=1, max_length=64)
    base_frequency: Frequency | None = key(
        "frequency of order 1, if the case has no machine speed", None, gt=0
    )
    reference_position: Name | None = key(
        "position of zero phase; default: that of the first reading", None
    )
    positions: tuple[Position, ...] = key(
        "named points for readings and for wanted levels", (), max_length=200
    )
    readings: tuple[Reading, ...] = key("of instruments", (), max_length=200)
    scan: Scan | None = key("readings at many points", None)
    record: tuple[Record, ...] = key(
        "files of samples over time, with a tachometer or speed", (), max_length=64
    )
    spectrum: tuple[Spectrum, ...] = key("files of complex spectra", (), max_length=200)
    plate: Plate | None = key("edges of the plate", None)
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
            "the frequency of order 1 is given twice: it is that of the crankshaft",
            lambda t: "base_frequency" in t and "speed" in t.machine,
            "machine.speed alone",
            also=("machine", "speed"),
        ),
    )

    @property
    def has_mismatch(self) -> bool:
        """Whether the two accelerometers of a difference may not be alike."""
        return self.sensitivity_mismatch > 0.0 or self.phase_mismatch > 0.0

    @property
    def channel_names(self) -> tuple[str, ...]:
        """How results name the channels of all records: by position, and by record of several."""
        several = len(self.record) > 1
        return tuple(
            f"{place}: {one.at}" if several else one.at
            for place, record in enumerate(self.record, start=1)
            for one in record.channels
        )
