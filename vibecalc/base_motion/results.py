"""Results of a base that moves: what the machine does, and what its mounts have to bear."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, q
from vibecalc.core.results.record import PEAK, RMS, Entry, Headline, entry

ROOT = "base_motion"
HARMONIC, SPECTRUM = f"{ROOT}/harmonic", f"{ROOT}/spectrum"
AXES = {
    "base_harmonic": ("", "harmonic of the motion of the base"),
    "base_frequency": ("Hz", "frequency"),
}


@dataclass(frozen=True)
class OverFrequency:
    """Of motions of the base in one direction at a time."""

    ROOT: ClassVar[str] = ROOT
    transmissibility: Any = q(
        "coordinate base_frequency", "",
        "motion of the body over that of the base, along and about the same axis",
    )  # fmt: skip
    relative_transmissibility: Any = q(
        "coordinate base_frequency", "",
        "motion of the body against the base over that of the base",
    )  # fmt: skip


#: name, unit, words: motions along, then about the axes
MOTIONS = (
    ("translation", "m", "displacement of the reference point"),
    ("rotation", "rad", "rotation"),
    ("relative_translation", "m", "displacement of the reference point against the base"),
    ("relative_rotation", "rad", "rotation against the base"),
    ("velocity", "m/s", "velocity of the reference point"),
    ("angular_velocity", "rad/s", "angular velocity"),
    ("acceleration", "m/s^2", "acceleration of the reference point"),
    ("angular_acceleration", "rad/s^2", "angular acceleration"),
)
#: where the mounts stand on a second body
FOUNDATION = (
    ("foundation_translation", "m", "displacement of the foundation at its reference point"),
    ("foundation_rotation", "rad", "rotation of the foundation"),
)
#: at the points of the case
OF_POINTS = (
    ("displacement", "m", "mm"),
    ("velocity", "m/s", "mm/s"),
    ("acceleration", "m/s^2", "m/s^2"),
)
OF_MOUNTS = (
    ("deflection", "m", "deflection of a mount", "mm"),
    ("mount_force", "N", "force of a mount below it", "N"),
)


def _harmonics() -> Iterator[Entry]:
    yield entry(f"{HARMONIC}/frequency", "base_harmonic", "rad/s", "of each harmonic")
    for name, unit, words in MOTIONS:
        axes = "base_harmonic direction"
        yield entry(f"{HARMONIC}/{name}", axes, unit, f"{words} by a harmonic of the base", PEAK)
    for name, unit, words in FOUNDATION:
        axes = "base_harmonic direction"
        yield entry(f"{HARMONIC}/{name}", axes, unit, f"{words} by a harmonic of the base", PEAK)
    for name, unit, words, read in OF_MOUNTS:
        axes = "mount direction base_harmonic"
        yield entry(f"{HARMONIC}/{name}", axes, unit, f"{words} by a harmonic of the base", PEAK)
        yield entry(
            f"{HARMONIC}/{name}_peak",
            "mount",
            unit,
            f"{words}, harmonics at their largest at once",
            PEAK,
            headline=Headline(f"{words} by the base, peak", read),
        )
    yield entry(
        f"{HARMONIC}/acceleration_peak",
        "direction",
        "m/s^2",
        "acceleration of the reference point, harmonics at their largest at once",
        PEAK,
        headline=Headline("acceleration by the base, peak", "m/s^2"),
    )
    for name, unit, _ in OF_POINTS:
        words = f"{name} at a point by"
        axes = "sensor base_harmonic"
        path = f"{HARMONIC}/point_{name}"
        yield entry(path, axes, unit, f"{words} a harmonic of the base", PEAK)
        words = f"{words} the base, harmonics at their largest at once"
        yield entry(f"{path}_peak", "sensor", unit, words, PEAK)


def _spectra() -> Iterator[Entry]:
    yield entry(f"{SPECTRUM}/base_acceleration_rms", "direction", "m/s^2", "of the base", RMS)
    for name, unit, words in MOTIONS:
        lead = name == "acceleration"
        yield entry(
            f"{SPECTRUM}/{name}_rms",
            "direction",
            unit,
            f"{words} by the spectra of the base",
            RMS,
            headline=Headline("acceleration by the base, r.m.s.", unit) if lead else None,
        )
        yield entry(
            f"{SPECTRUM}/{name}_peak", "direction", unit, f"{words}, peak factor in it", PEAK
        )
    for name, unit, words, read in OF_MOUNTS:
        axes = "mount direction"
        yield entry(f"{SPECTRUM}/{name}_rms", axes, unit, f"{words} by the spectra", RMS)
        yield entry(
            f"{SPECTRUM}/{name}_peak",
            axes,
            unit,
            f"{words}, peak factor in it",
            PEAK,
            headline=Headline(f"{words} at random, peak", read),
        )
    for name, unit, read in OF_POINTS:
        words, path = f"{name} at a point by the spectra of the base", f"{SPECTRUM}/point_{name}"
        head = Headline("velocity at a point by the base, r.m.s.", read)
        head_of = head if name == "velocity" else None
        yield entry(f"{path}_rms", "sensor", unit, words, RMS, headline=head_of)
        yield entry(f"{path}_peak", "sensor", unit, f"{words}, peak factor in it", PEAK)
    yield entry(
        f"{SPECTRUM}/base_density",
        "direction base_frequency",
        "m^2/s^3",
        "the same of the base where the reference point is",
    )
    yield entry(
        f"{SPECTRUM}/density",
        "direction base_frequency",
        "m^2/s^3",
        "one-sided density of the acceleration of the reference point, for each hertz",
    )


ENTRIES = (*entries_of(OverFrequency), *_harmonics(), *_spectra())
