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
    key,
)
from vibecalc.core.case.rules import needs, one_of, refuse, same_length

SampleRate = Annotated[float, Field(gt=0), Unit("rad/s", "a sampling rate", "'2 kHz'")]
Numbers = Annotated[tuple[Number, ...], Field(max_length=400_000)]


class Channel(Table):
    """One channel of a record: the accelerometer at a position, positive upwards (z)."""

    column: Name = key("CSV column, WAV channel number or UFF data set 58")
    at: Name = key("name of its position")
    scale: Acceleration | None = key(
        "acceleration of 1 in a CSV file without a unit, of full scale in a WAV; negative if "
        "mounted upside down",
        None,
    )
    use: Literal["solve", "compare"] = key("fit the motion to it, or compare only", "solve")


class RecordFile(Table):
    """A file of samples over time, and its order analysis."""

    file: Name = key("CSV, WAV or universal file (58) next to the case")
    channels: tuple[Channel, ...] = key("accelerometers in the file", min_length=1, max_length=200)
    time: str = key("CSV column with the time of each sample", "time")
    sample_rate: SampleRate | None = key("in Hz, for a CSV file without a time column", None)
    pulses: str = key("tachometer column or channel", "")
    pulses_per_turn: int = key("per revolution of the crankshaft", 1, strict=True, ge=1, le=10_000)
    disc: Literal["even", "uneven"] | None = key(
        "of several pulses per revolution: a pattern that repeats every revolution is motion "
        "of the shaft (even), or error of the disc (uneven); default: of the disc, with both "
        "in +-",
        None,
    )
    torsion: Angle = key(
        "r.m.s. torsional vibration of the shaft that tachometer or speed do not show; part of +-",
        0.0,
        ge=0,
        le=0.5,
    )
    threshold: Number | None = key(
        "trigger level of a pulse, in units of its column, of full scale in a WAV; default: "
        "half way between minimum and maximum",
        None,
    )
    hysteresis: Number | None = key(
        "fall below the threshold before the next pulse; default: a fifth of the range",
        None,
        gt=0,
    )
    speed: str = key("column or channel of the crank speed, instead of pulses", "")
    speed_scale: AngularSpeed | None = key(
        "speed of 1 in a file without its unit, of full scale in a WAV", None, gt=0
    )
    constant_speed: AngularSpeed | None = key("of the crankshaft, instead of pulses", None, gt=0)
    turns: int = key(
        "revolutions per block; the scatter of the blocks gives the uncertainty",
        4,
        strict=True,
        ge=1,
        le=1000,
    )
    window: Literal["none", "hann"] = key("of each block", "none")
    interpolation: Literal[1, 3, 5] = key("degree of the splines for resampling at equal angles", 5)


class FoundOrders(Table):
    """What a record holds, block by block: put here when the file is read."""

    made_with: RecordFile = key("keys of the record at that time")
    orders: tuple[Annotated[int, Field(ge=1)], ...] = key("harmonics of the plate")
    speeds: Numbers = key("of the blocks, rad/s")
    real: Numbers = key("of amplitudes in m/s^2, by channel, block, harmonic")
    imaginary: Numbers = key("of the same")
    error: Numbers = key("what interpolation makes of each, by channel and harmonic")
    by_angle: Numbers = key(
        "standard uncertainty by an angle that is off, m/s^2, by channel and harmonic"
    )
    zero: Number = key("the same of where the angle is zero, rad", ge=0)
    pulse_scatter: Number = key("by which a pulse is off, rad", ge=0)
    disc_pattern: Numbers = key("by which pulses of the disc come late, rad")
    speed_correction: Number = key("of the speed as given, relative")
    unsteady: str = key("how phases move against the shaft", "")
    lines: Numbers = key("root mean square amplitudes, by channel and line of order")


class Record(RecordFile):
    """A file of samples over time; with a tachometer, a speed, or at one known speed."""

    found: FoundOrders | None = key("put here when the file is read", None)
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

    file: Name = key("that it was read from")
    orders: tuple[Annotated[int, Field(ge=1)], ...] = key("harmonics of the plate")
    base_frequency: Frequency | None = key("of order 1, where the file has frequencies", None, gt=0)
    amplitude: tuple[Annotated[Acceleration, Field(ge=0)], ...] = key(
        "of each harmonic", max_length=64
    )
    phase: tuple[Annotated[float, Field(ge=-1e3 * math.pi, le=1e3 * math.pi), Unit("rad")], ...] = (
        key("of each harmonic, leading positive", max_length=64)
    )
    RULES = (same_length("orders", "amplitude", "phase"),)


class Spectrum(Table):
    """A complex spectrum of one accelerometer from an analyser: a reading with phases."""

    file: Name = key(
        "CSV with columns order or frequency, and amplitude and phase or real and imaginary"
    )
    at: Name = key("name of the position")
    use: Literal["solve", "compare"] = key("fit the motion to it, or compare only", "solve")
    found: FoundLines | None = key("put here when the file is read", None)
