"""Results of readings on a rigid plate: its motion, levels anywhere, and how sure they are."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, named, q
from vibecalc.core.results.record import (
    CHECK,
    DIFFERENCE,
    EXAMINED,
    PEAK,
    TURN,
    UNCERTAINTY,
    Headline,
)

_RE = "dB re reference_level of the case"
_RE_ANGULAR = "dB re angular_reference_level of the case"
_UNSURE = {"exempt": UNCERTAINTY}
_OF = "standard uncertainty of"
_PHASE = "relative to the reference position"
_OF_RECORD = {"exempt": EXAMINED}
_CIRCLE = {"circle": TURN}

#: axis name -> (unit, long name)
AXES = {
    "position": ("", "point of the plate"),
    "reading": ("", "harmonic and instrument"),
    "signal": ("", "harmonic and instrument"),
    "candidate": ("", "harmonic, and signs of the phases of roll and pitch"),
    "channel": ("", "position of an accelerometer, with the number of its record of several"),
    "block": ("", "block of whole turns of a record"),
    "order_line": ("", "multiple of crank speed, in steps of one over the turns of a block"),
    "further": ("", "harmonic, and a reading that would distinguish motions"),
    "plate_x": ("m", "place on the plate along the crankshaft"),
    "plate_y": ("m", "place on the plate across the crankshaft"),
}


def _each(name: str) -> dict[str, Any]:
    words, kind = f"{name} level", "" if name == "translation" else "angular_"
    reference = f"vibecalc.measurement.report:{kind}level_words"
    return {"headline": Headline(words, "dB", pick="each", reference=reference), "name": words}


class Whole(Group):
    """The motion of the plate."""

    ROOT: ClassVar[str] = "measurement"
    frequency: Any = q("order", "rad/s", "frequency of the harmonics")
    translation: Any = q("order", "m/s^2", "acceleration of the origin along z", PEAK)
    roll: Any = q("order", "rad/s^2", "angular acceleration about x", PEAK)
    pitch: Any = q("order", "rad/s^2", "angular acceleration about y", PEAK)
    translation_level: Any = q("order", "dB", f"level of the origin, {_RE}", **_each("translation"))
    roll_level: Any = q("order", "dB", f"level of the roll, {_RE_ANGULAR}", **_each("roll"))
    pitch_level: Any = q("order", "dB", f"level of the pitch, {_RE_ANGULAR}", **_each("pitch"))
    acceleration: Any = q("position order", "m/s^2", "acceleration along z", PEAK)


class Phase(Group):
    """Of the motion."""

    ROOT: ClassVar[str] = "measurement/phase"
    translation: Any = named("order", "rad", f"phase of the origin {_PHASE}", **_CIRCLE)
    roll: Any = named("order", "rad", f"phase of the roll {_PHASE}", **_CIRCLE)
    pitch: Any = named("order", "rad", f"phase of the pitch {_PHASE}", **_CIRCLE)
    roll_to_translation: Any = named(
        "order", "rad", "phase of the roll against the origin", **_CIRCLE
    )
    pitch_to_translation: Any = named(
        "order", "rad", "phase of the pitch against the origin", **_CIRCLE
    )


class Levels(Group):
    """At named positions, of the motion and its parts."""

    ROOT: ClassVar[str] = "measurement/level"
    standard: Any = q("position order", "dB", f"level of the total motion, {_RE}",
        name="level of the total motion")  # fmt: skip
    no_roll: Any = q("position order", "dB", f"level without the roll, {_RE}")
    no_pitch: Any = q("position order", "dB", f"level without the pitch, {_RE}")
    only_roll: Any = q("position order", "dB", f"level of the roll alone, {_RE}")
    only_pitch: Any = q("position order", "dB", f"level of the pitch alone, {_RE}")
    only_translation: Any = q("position order", "dB", f"level of the translation alone, {_RE}")
    all_orders: Any = q("position", "dB", f"level of all harmonics, {_RE}")


class Uncertainty(Group):
    """Of levels and phases."""

    ROOT: ClassVar[str] = "measurement/uncertainty"
    level: Any = q("position order", "dB", f"{_OF} the level at a position", **_UNSURE)
    translation_level: Any = q("order", "dB", f"{_OF} the level of the origin", **_UNSURE)
    roll_level: Any = q("order", "dB", f"{_OF} the level of the roll", **_UNSURE)
    pitch_level: Any = q("order", "dB", f"{_OF} the level of the pitch", **_UNSURE)
    translation_phase: Any = q("order", "rad", f"{_OF} the phase of the origin", **_UNSURE)
    roll_phase: Any = q("order", "rad", f"{_OF} the phase of the roll", **_UNSURE)
    pitch_phase: Any = q("order", "rad", f"{_OF} the phase of the pitch", **_UNSURE)
    level_bound: Any = q(
        "position order", "dB",
        "maximum error of the level of the selected motion, readings within their rounding",
        **_UNSURE)  # fmt: skip


class Fit(Group):
    """How well readings determine the motion."""

    ROOT: ClassVar[str] = "measurement/fit"
    motions: Any = q("order", "", "motions compatible with the readings")
    decided: Any = q("order", "", "1: motion uniquely determined")
    misfit: Any = q(
        "order", "",
        "minimum misfit of the readings / their stated uncertainty; with phases, "
        "root mean square / stated standard uncertainty", exempt=CHECK)  # fmt: skip


class Readings(Group):
    """What instruments read next to the motion."""

    ROOT: ClassVar[str] = "measurement/reading"
    order: Any = q("reading", "", "harmonic of the reading")
    read: Any = q("reading", "dB", "level read, dB re the reference of its kind",
        name="level read")  # fmt: skip
    computed: Any = q("reading", "dB", "level of the motion, re the same",
        name="level of the motion at a reading")  # fmt: skip
    residual: Any = q("reading", "dB", "level computed - level read", exempt=CHECK)


class Signals(Group):
    """Readings with phases next to the motion."""

    ROOT: ClassVar[str] = "measurement/signal"
    order: Any = q("signal", "", "harmonic of a reading with a phase")
    residual: Any = q(
        "signal", "",
        "computed - read in amplitude and phase / stated uncertainties, combined",
        exempt=CHECK)  # fmt: skip


class Candidates(Group):
    """All motions that levels leave."""

    ROOT: ClassVar[str] = "measurement/candidate"
    order: Any = q("candidate", "", "harmonic of a motion compatible with the levels")
    chosen: Any = q("candidate", "", "1: selected motion")
    worst_residual: Any = q(
        "candidate", "dB",
        "largest residual of the selecting readings, or of those solved for",
        exempt=CHECK)  # fmt: skip
    translation_level: Any = q("candidate", "dB", f"level of the origin, {_RE}")
    roll_level: Any = q("candidate", "dB", f"level of the roll, {_RE_ANGULAR}")
    pitch_level: Any = q("candidate", "dB", f"level of the pitch, {_RE_ANGULAR}")
    translation_phase: Any = q("candidate", "rad", f"phase of the origin {_PHASE}", **_CIRCLE)
    roll_phase: Any = q("candidate", "rad", f"phase of the roll {_PHASE}", **_CIRCLE)
    pitch_phase: Any = q("candidate", "rad", f"phase of the pitch {_PHASE}", **_CIRCLE)
    level: Any = q("candidate position", "dB", f"level at a position, {_RE}",
        name="level of a compatible motion")  # fmt: skip
    level_bound: Any = q(
        "candidate position", "dB",
        "its maximum error for this motion, readings within their rounding",
        **_UNSURE)  # fmt: skip


class Further(Group):
    """Readings not yet made."""

    ROOT: ClassVar[str] = "measurement/further"
    order: Any = q(
        "further", "",
        "harmonic with two motions, and the reading at named positions that separates them best",
    )  # fmt: skip
    difference: Any = q("further", "dB", "level difference there, selected motion - next one")


class Records(Group):
    """Orders of records over time."""

    ROOT: ClassVar[str] = "measurement/record"
    acceleration: Any = q(
        "channel order", "m/s^2", "acceleration of a channel, mean over the blocks", PEAK,
        **_OF_RECORD)  # fmt: skip
    phase: Any = q(
        "channel order", "rad", "its phase relative to the first pulse, lead positive",
        **_OF_RECORD, **_CIRCLE)  # fmt: skip
    uncertainty: Any = q(
        "channel order", "m/s^2",
        "its standard uncertainty by scatter of the blocks and of the angle",
        **_UNSURE)  # fmt: skip
    phase_uncertainty: Any = q(
        "channel order", "rad", "standard uncertainty of the phase by both", **_UNSURE
    )
    pulse_scatter: Any = q(
        "channel", "rad", "standard deviation of a pulse from a smooth motion of the shaft",
        **_UNSURE)  # fmt: skip
    speed_correction: Any = q(
        "channel", "", "relative correction of the given speed for constant phases", **_OF_RECORD
    )
    block_speed: Any = q("channel block", "rad/s", "mean crank speed of a block")
    block_acceleration: Any = q(
        "channel block order", "m/s^2", "acceleration of a channel in a block", PEAK, **_OF_RECORD
    )
    spectrum: Any = q(
        "channel order_line", "m/s^2",
        "root mean square over the blocks of the amplitudes of all lines", PEAK,
        **_OF_RECORD)  # fmt: skip


class Map(Group):
    """Over the plate."""

    ROOT: ClassVar[str] = "measurement/map"
    amplitude: Any = q("order plate_y plate_x", "m/s^2", "acceleration along z", PEAK)
    all_orders: Any = q(
        "plate_y plate_x", "m/s^2", "root of the sum of the squared amplitudes of all harmonics",
        PEAK)  # fmt: skip


class Quiet(Group):
    """Places of the plate that move least."""

    ROOT: ClassVar[str] = "measurement/quiet"
    x: Any = q("order", "m", "point of least motion")
    y: Any = q("order", "m", "point of least motion")
    amplitude: Any = q("order", "m/s^2", "acceleration of that point", PEAK, exempt=DIFFERENCE)
    all_orders_x: Any = q("", "m", "point of least motion, all harmonics")
    all_orders_y: Any = q("", "m", "point of least motion, all harmonics")
    all_orders_amplitude: Any = q(
        "", "m/s^2", "root of the sum of the squared amplitudes at that point", PEAK,
        exempt=DIFFERENCE)  # fmt: skip


ENTRIES = tuple(
    entries_of(
        Whole, Phase, Levels, Uncertainty, Fit, Readings, Signals, Candidates, Further, Records,
        Map, Quiet,
    )
)  # fmt: skip
