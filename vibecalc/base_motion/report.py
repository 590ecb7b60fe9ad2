"""A base that moves, in the report and as pictures."""

from collections.abc import Sequence

import numpy as np

from vibecalc.base_motion.results import HARMONIC, ROOT, SPECTRUM
from vibecalc.core.report.curves import Curve, Curves, Panel, level
from vibecalc.core.report.rows import Cells, Rows, reduced, rows_of
from vibecalc.core.report.sections import Section, magnitudes, section, stacked, table_of
from vibecalc.core.report.sources import Source, entry_of, of_freedoms
from vibecalc.core.report.writing import paragraph, show
from vibecalc.core.results.record import Record, Result

#: result, heading, unit
_LINEAR = (
    ("translation", "motion mm", "mm"),
    ("relative_translation", "to base mm", "mm"),
    ("velocity", "velocity mm/s", "mm/s"),
    ("acceleration", "accel. m/s^2", "m/s^2"),
)
_TURNS = (
    ("rotation", "motion mrad", "mrad"),
    ("relative_rotation", "to base mrad", "mrad"),
    ("angular_velocity", "velocity mrad/s", "mrad/s"),
    ("angular_acceleration", "accel. rad/s^2", "rad/s^2"),
)
#: a line for each harmonic: lengths along all axes
_LARGEST = [Cells(reduced(f"{HARMONIC}/{name}", np.max), head, unit)
            for name, head, unit in (*_LINEAR, ("rotation", "rotation mrad", "mrad"))]  # fmt: skip
_FREQUENCY = Cells("frequency", "Hz", "Hz")
_BY_HARMONIC = Rows("base_harmonic", "harmonic", (_FREQUENCY, *_LARGEST), HARMONIC)


def _at_random(motions: Sequence[tuple[str, str, str]], label: str) -> Rows:
    columns = [Cells(f"{name}_rms", head, unit) for name, head, unit in motions]
    return Rows("direction", "r.m.s.", columns, SPECTRUM, label)


_PEAKS = Cells("deflection_peak", "{} mm", "mm"), Cells("mount_force_peak", "{} N")
_RANDOM = (_at_random(_LINEAR, "{}"), _at_random(_TURNS, "r{}"),
           Rows("mount", "mount, peak", _PEAKS, SPECTRUM))  # fmt: skip
_AT_ONCE = "peaks: all harmonics in phase (they have no common period)"
_OF_ALL = (Cells("deflection_peak", "deflection peak mm", "mm"),
           Cells("mount_force_peak", "force peak N", note=_AT_ONCE))  # fmt: skip
_SUMS = Rows("mount", "mount, all harmonics", _OF_ALL, HARMONIC, merge=True)
#: what the base does at the points of the case, under harmonics and at random
_POINTS = Rows(
    "sensor",
    "point, by base motion",
    [
        Cells(f"{root}/point_{name}_{kind}", f"{name} {words} {unit}", unit)
        for root, kind, words in ((HARMONIC, "peak", "peak"), (SPECTRUM, "rms", "r.m.s."))
        for name, unit in (("displacement", "mm"), ("velocity", "mm/s"), ("acceleration", "m/s^2"))
    ],
    merge=True,
)


def base_motion(result: Result) -> Section | None:
    """What the harmonics and the spectra of the base do; None without any."""
    record = result.record
    if f"{ROOT}/transmissibility" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    lines = stacked(_harmonics(record), _spectra(result), rows_of(record, _POINTS)[0])
    return section("Motion of the base", [(lines, shown)])


def _harmonics(record: Record) -> list[str]:
    """Motion by each harmonic, then the mounts under all of them."""
    lines, _ = rows_of(record, _BY_HARMONIC)
    if not lines:
        return []
    words = "0-to-peak, axis of largest motion, at the reference point of the body"
    below = record.quantities.get(f"{HARMONIC}/foundation_translation")
    if below is not None:
        tops = np.max(magnitudes(below), axis=1)
        moves = (show(1e3 * float(one), 1e3 * below.error_estimate) for one in tops)
        words += f"; motion of the foundation {', '.join(moves)} mm"
    return [*lines, *paragraph(words), "", *rows_of(record, _SUMS)[0]]


def _spectra(result: Result) -> list[str]:
    record = result.record
    if f"{SPECTRUM}/acceleration_rms" not in record:
        return []
    factor = float(str(table_of(result.case, "base_motion").get("peak_factor") or 3.0))
    lines = stacked(*(rows_of(record, one)[0] for one in _RANDOM))
    return lines + paragraph(f"random peaks: {factor:g} times the r.m.s. value")


# ----------------------------------------------------------------------------
# Transmissibility of the six freedoms; density of the acceleration.
# ----------------------------------------------------------------------------


_RATIOS = {
    "transmissibility": "body / base, same direction",
    "relative_transmissibility": "(body - base) / base",
}
TRANSMISSIBILITY = Curves(
    "transmissibility from the base to the machine",
    tuple(
        Panel(
            name.replace("_", " "),
            (Curve(of_freedoms(f"{ROOT}/{name}", turning), "{}"), level(lambda _: 1.0)),
            f"{title}, {'about' if turning else 'along'} axes",
            log="xy",
        )
        for name, title in _RATIOS.items()
        for turning in (False, True)
    ),
    columns=2,
    names=6,
    level="row",
)


def _moving(name: str) -> Source:
    """Densities of the directions that move at all."""
    path = f"{SPECTRUM}/{name}"

    def places(result: Result) -> np.ndarray:
        size = np.max(np.abs(result.record[path].values), axis=1)
        return np.flatnonzero(size > 1e-12 * np.max(size))

    return entry_of(path, places)


_BODY = Curve(_moving("density"), "body, {}")
_BASE = Curve(_moving("base_density"), "base, {}", {"linestyle": "--"})
DENSITY = Curves(
    "power spectral density of the acceleration, base and body, in (m/s$^2$)$^2$/Hz",
    (Panel("density", (_BODY, _BASE), log="xy"),),
)
