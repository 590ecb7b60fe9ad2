"""Results of a base that moves: what the machine does, and what its mounts have to bear."""

from collections.abc import Iterator

from vibecalc.core.results.record import PEAK, RMS, Entry, Headline, entry
from vibecalc.points.results import UNITS

ROOT = "base_motion"
HARMONIC, SPECTRUM = f"{ROOT}/harmonic", f"{ROOT}/spectrum"
AXES = {
    "base_harmonic": ("", "harmonic of the motion of the base"),
    "base_frequency": ("Hz", "frequency"),
}


#: where motions are told
_POINT = "reference point"


#: unit, words, axes of what moves by a harmonic; by spectra all but the foundation, on which the
#: mounts may stand, has an r.m.s. value
RESPONSES = {
    "translation": ("m", f"displacement of the {_POINT}", "direction"),
    "rotation": ("rad", "rotation", "direction"),
    "relative_translation": ("m", f"displacement of the {_POINT} relative to base", "direction"),
    "relative_rotation": ("rad", "rotation relative to the base", "direction"),
    "velocity": ("m/s", f"velocity of the {_POINT}", "direction"),
    "angular_velocity": ("rad/s", "angular velocity", "direction"),
    "acceleration": ("m/s^2", f"acceleration of the {_POINT}", "direction"),
    "angular_acceleration": ("rad/s^2", "angular acceleration", "direction"),
    "foundation_translation": ("m", f"displacement of the foundation at its {_POINT}", "direction"),
    "foundation_rotation": ("rad", "rotation of the foundation", "direction"),
    "deflection": ("m", "deflection of a mount", "mount direction"),
    "mount_force": ("N", "mount force on the base", "mount direction"),
    "point_displacement": ("m", "displacement at a point", "sensor"),
    "point_velocity": ("m/s", "velocity at a point", "sensor"),
    "point_acceleration": ("m/s^2", "acceleration at a point", "sensor"),
}
#: those that have a peak under all harmonics, over the first of their axes
PEAKS = ("deflection", "mount_force", "acceleration", *(f"point_{name}" for name in UNITS))
_HEADLINES = {
    f"{HARMONIC}/deflection_peak": Headline("mount deflection by base motion, peak", "mm"),
    f"{HARMONIC}/mount_force_peak": Headline("mount force by base motion, peak", "N"),
    f"{HARMONIC}/acceleration_peak": Headline("acceleration by base motion, peak", "m/s^2"),
    f"{SPECTRUM}/acceleration_rms": Headline("acceleration by random base motion, r.m.s.", "m/s^2"),
    f"{SPECTRUM}/deflection_peak": Headline("mount deflection by random base motion, peak", "mm"),
    f"{SPECTRUM}/mount_force_peak": Headline("mount force by random base motion, peak", "N"),
    f"{SPECTRUM}/point_velocity_rms": Headline("velocity at a point, random, r.m.s.", "mm/s"),
}


def _entries() -> Iterator[Entry]:
    def of(path: str, axes: str, unit: str, words: str, amplitude: str) -> Entry:
        return entry(path, axes, unit, words, amplitude, headline=_HEADLINES.get(path))

    axes = "coordinate base_frequency"
    words = "motion of the body / motion of the base, same axis"
    yield entry(f"{ROOT}/transmissibility", axes, "", words)
    words = f"motion of the body relative to the base / motion of the base, at the {_POINT}"
    yield entry(f"{ROOT}/relative_transmissibility", axes, "", words)
    yield entry(f"{HARMONIC}/frequency", "base_harmonic", "rad/s", "frequency of each harmonic")
    for name, (unit, words, axes) in RESPONSES.items():
        each = f"base_harmonic {axes}" if axes == "direction" else f"{axes} base_harmonic"
        yield of(f"{HARMONIC}/{name}", each, unit, f"{words} by a harmonic of the base", PEAK)
    for name in PEAKS:
        unit, words, axes = RESPONSES[name]
        words = f"{words}, all harmonics in phase"
        yield of(f"{HARMONIC}/{name}_peak", axes.split()[0], unit, words, PEAK)
    words = f"acceleration of the base at the {_POINT}"
    yield entry(f"{SPECTRUM}/base_acceleration_rms", "direction", "m/s^2", words, RMS)
    for name, (unit, words, axes) in RESPONSES.items():
        if not name.startswith("foundation"):
            path = f"{SPECTRUM}/{name}"
            yield of(f"{path}_rms", axes, unit, f"{words} by the spectra of the base", RMS)
            yield of(f"{path}_peak", axes, unit, f"{words}, with the peak factor", PEAK)
    for name, words in (
        ("base_density", f"the same of the base at the {_POINT}"),
        ("density", f"one-sided power spectral density of the acceleration of the {_POINT}"),
    ):
        yield entry(f"{SPECTRUM}/{name}", "direction base_frequency", "m^2/s^3", words)


ENTRIES = tuple(_entries())
