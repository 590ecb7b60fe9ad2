"""Records over time and complex spectra of accelerometers on a plate."""

import math
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Angle,
    AngularSpeed,
    Frequency,
    Name,
    Number,
    Table,
    Unit,
)
from vibecalc.core.case.rules import needs, one_of, refuse, same_length

SampleRate = Annotated[float, Field(gt=0), Unit("rad/s", "a sampling rate", "'2 kHz'")]
Numbers = Annotated[tuple[Number, ...], Field(max_length=400_000)]


class Channel(Table):
    """One column or channel of a record: the accelerometer at a position, positive upwards (z)."""

    column: Name = Field(description="of a CSV file; number of a WAV channel or data set 58")
    at: Name = Field(description="name of the position that it stands at")
    scale: Acceleration | None = Field(
        None, description="acceleration of 1 in a CSV file without a unit, of full scale in a WAV; "
        "negative for one mounted upside down",
    )  # fmt: skip
    use: Literal["solve", "compare"] = Field(
        "solve", description="find the motion from it, or compare only"
    )


class RecordFile(Table):
    """A file of samples over time, and how orders are made of it."""

    file: Name = Field(description="CSV, WAV or universal file (58) next to the case")
    channels: Annotated[tuple[Channel, ...], Field(min_length=1, max_length=200)] = Field(
        description="the accelerometers in it"
    )
    time: str = Field("time", description="column of a CSV file with the time of each sample")
    sample_rate: SampleRate | None = Field(
        None, description="samples per second in Hz, of a CSV file without such a column"
    )
    pulses: str = Field("", description="column or channel of a tachometer")
    pulses_per_turn: Annotated[int, Field(strict=True, ge=1, le=10_000)] = Field(
        1, description="of the crankshaft"
    )
    disc: Literal["even", "uneven"] | None = Field(
        None, description="of several pulses per turn: a pattern that repeats each turn is motion "
        "of the shaft (even), or of the disc (uneven); default: of the disc, and +- has both",
    )  # fmt: skip
    torsion: Angle = Field(
        0.0, ge=0, le=0.5, description="torsional vibration of the shaft that pulses or speed do "
        "not show, root mean square; it enters +-",
    )  # fmt: skip
    threshold: Number | None = Field(
        None, description="that a pulse rises through, in its column's numbers, of full scale in a "
        "WAV; default: half way between the lowest and the highest sample",
    )  # fmt: skip
    hysteresis: Number | None = Field(
        None, gt=0, description="how far it has to fall below before the next pulse; "
        "default: a fifth of the way between the lowest and the highest sample",
    )  # fmt: skip
    speed: str = Field("", description="column or channel of a crank speed, instead of pulses")
    speed_scale: AngularSpeed | None = Field(
        None, gt=0, description="speed of 1 in a file without its unit, of full scale in a WAV"
    )
    constant_speed: AngularSpeed | None = Field(
        None, gt=0, description="of the crankshaft, instead of pulses"
    )
    turns: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        4, description="whole turns of a block; the scatter of blocks tells the uncertainty"
    )
    window: Literal["none", "hann"] = Field("none", description="over each block")
    interpolation: Literal[1, 3, 5] = Field(
        5, description="degree of the splines that give signals at equal angles"
    )


class FoundOrders(Table):
    """What a record holds, block by block: put here when the file is read."""

    made_with: RecordFile = Field(description="keys of the record at that time")
    orders: tuple[Annotated[int, Field(ge=1)], ...] = Field(description="harmonics of the plate")
    speeds: Numbers = Field(description="of the blocks, rad/s")
    real: Numbers = Field(description="of amplitudes in m/s^2, by channel, block, harmonic")
    imaginary: Numbers = Field(description="of the same")
    error: Numbers = Field(description="what interpolation makes of each, by channel and harmonic")
    by_angle: Numbers = Field(
        description="standard uncertainty by an angle that is off, m/s^2, by channel and harmonic"
    )
    zero: Number = Field(ge=0, description="the same of where the angle is zero, rad")
    pulse_scatter: Number = Field(ge=0, description="by which a pulse is off, rad")
    disc_pattern: Numbers = Field(description="by which pulses of the disc come late, rad")
    speed_correction: Number = Field(description="of the speed as given, relative")
    unsteady: str = Field("", description="how phases move against the shaft")
    lines: Numbers = Field(description="root mean square amplitudes, by channel and line of order")


class Record(RecordFile):
    """A file of samples over time; with a tachometer, a speed, or at one known speed."""

    found: FoundOrders | None = Field(None, description="put here when the file is read")
    RULES = (
        one_of("pulses", "speed", "constant_speed", hint="phases refer to the shaft"),
        needs("threshold", "pulses"),
        refuse(
            "disc",
            "one pulse per turn has no pattern",
            lambda t: "disc" in t and t["pulses_per_turn"] == 1,
            "pulses_per_turn = 2 or more, or no disc",
        ),
        needs("hysteresis", "pulses"),
        needs("speed_scale", "speed"),
        refuse(
            "channels",
            "a position has two channels of one record",
            lambda t: len({*map(_at, t.entries("channels"))}) < len(t.entries("channels")),
            "each position once",
        ),
        refuse(
            "turns",
            "a window of Hann smears each line over its neighbours: whole orders need blocks of "
            "two turns at least",
            lambda t: t["window"] == "hann" and t["turns"] == 1,
            "turns = 2 or more",
            also="window",
        ),
    )


def _at(channel: object) -> str:
    return str(channel.get("at")) if isinstance(channel, dict) else repr(channel)


class FoundLines(Table):
    """What a spectrum holds at the harmonics: put here when the file is read."""

    file: Name = Field(description="that it was read from")
    orders: tuple[Annotated[int, Field(ge=1)], ...] = Field(description="harmonics of the plate")
    base_frequency: Frequency | None = Field(
        None, gt=0, description="of order 1, where the file has frequencies"
    )
    amplitude: Annotated[tuple[Annotated[Acceleration, Field(ge=0)], ...], Field(max_length=64)] = (
        Field(description="of each harmonic")
    )
    phase: Annotated[
        tuple[Annotated[float, Field(ge=-1e3 * math.pi, le=1e3 * math.pi), Unit("rad")], ...],
        Field(max_length=64),
    ] = Field(description="of each harmonic, leading positive")
    RULES = (same_length("orders", "amplitude", "phase"),)


class Spectrum(Table):
    """A complex spectrum of one accelerometer, as an analyser writes it: a reading with phases."""

    file: Name = Field(
        description="CSV with columns order or frequency, and amplitude and phase or real and "
        "imaginary"
    )
    at: Name = Field(description="name of the position")
    use: Literal["solve", "compare"] = Field("solve", description="find the motion, or compare")
    found: FoundLines | None = Field(None, description="put here when the file is read")
