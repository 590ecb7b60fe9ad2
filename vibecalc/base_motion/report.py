"""A base that moves, in the report and as pictures."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibecalc.base_motion.results import HARMONIC, OF_POINTS, ROOT, SPECTRUM
from vibecalc.core.report.curves import Curve, Curves, Panel, level, sourced
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Section,
    labels,
    magnitudes,
    section,
    stacked,
    table_of,
)
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

#: result, heading, factor from SI to what is shown
_LINEAR = (
    ("translation", "motion mm", 1e3),
    ("relative_translation", "to base mm", 1e3),
    ("velocity", "velocity mm/s", 1e3),
    ("acceleration", "accel. m/s^2", 1.0),
)
_TURNS = (
    ("rotation", "motion mrad", 1e3),
    ("relative_rotation", "to base mrad", 1e3),
    ("angular_velocity", "velocity mrad/s", 1e3),
    ("angular_acceleration", "accel. rad/s^2", 1.0),
)
_SUMS = (
    (f"{HARMONIC}/deflection_peak", "deflection peak", "mm"),
    (f"{HARMONIC}/mount_force_peak", "force peak", "N"),
)


def base_motion(result: Result) -> Section | None:
    """What the harmonics and the spectra of the base do; None without any."""
    record = result.record
    if f"{ROOT}/transmissibility" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    lines = stacked(_harmonics(record), _spectra(result), _points(record))
    return section("Motion of the base", [(lines, shown)])


def _points(record: Record) -> list[str]:
    """What the base does at the points of the case, under harmonics and at random."""
    columns = [
        (f"{root}/point_{name}_{kind}", f"{name} {words}", unit)
        for root, kind, words in ((HARMONIC, "peak", "peak"), (SPECTRUM, "rms", "r.m.s."))
        for name, _, unit in OF_POINTS
    ]
    given = tuple(one for one in columns if one[0] in record)
    return by_axis(record, "sensor", "point, by the base", given) if given else []


def _harmonics(record: Record) -> list[str]:
    """A line for each harmonic: lengths along all axes; then the mounts under all of them."""
    if f"{HARMONIC}/frequency" not in record:
        return []
    frequency = record[f"{HARMONIC}/frequency"]
    found = [(record[f"{HARMONIC}/{name}"], factor) for name, _, factor in (*_LINEAR, _TURNS[0])]
    rows = [
        [
            name,
            show(hertz(float(frequency.values[place])), 0.0),
            *(
                show(factor * float(np.max(magnitudes(one)[place])), factor * one.error_estimate)
                for one, factor in found
            ),
        ]
        for place, name in enumerate(labels(frequency.axes[0]))
    ]
    heads = [number(head, 14) for _, head, _ in _LINEAR] + [number("turning mrad", 12)]
    lines = table([Column("harmonic", 16), number("Hz", 8), *heads], rows)
    words = "0 to peak, of the axis that moves most; at the reference point of the body"
    if f"{HARMONIC}/foundation_translation" in record:
        below = record[f"{HARMONIC}/foundation_translation"]
        tops = [show(1e3 * float(one), 1e3 * below.error_estimate)
                for one in np.max(magnitudes(below), axis=1)]  # fmt: skip
        words += f"; the foundation moves by {', '.join(tops)} mm"
    lines += paragraph(words)
    mounts = by_axis(record, "mount", "mount, all harmonics", _SUMS)
    words = "peaks as if all harmonics were at their largest at once: they have no common period"
    return [*lines, "", *mounts, *paragraph(words)]


def _spectra(result: Result) -> list[str]:
    record = result.record
    if f"{SPECTRUM}/acceleration_rms" not in record:
        return []
    lines: list[str] = []
    for rows_of, about in ((_LINEAR, ("x", "y", "z")), (_TURNS, ("rx", "ry", "rz"))):
        found = [(record[f"{SPECTRUM}/{name}_rms"], factor) for name, _, factor in rows_of]
        rows = [
            [name, *(show(f * float(q.values[i]), f * q.error_estimate) for q, f in found)]
            for i, name in enumerate(about)
        ]
        heads = [number(head, 17) for _, head, _ in rows_of]
        lines += [*table([Column("r.m.s.", 8), *heads], rows), ""]
    factor = float(str(table_of(result.case, "base_motion").get("peak_factor") or 3.0))
    deflection, force = (record[f"{SPECTRUM}/{one}_peak"] for one in ("deflection", "mount_force"))
    names = labels(deflection.axes[1])
    rows = [
        [
            mount,
            *(
                show(1e3 * float(one), 1e3 * deflection.error_estimate)
                for one in deflection.values[i]
            ),
            *(show(float(one), force.error_estimate) for one in force.values[i]),
        ]
        for i, mount in enumerate(labels(deflection.axes[0]))
    ]
    heads = [number(f"{name} mm", 10) for name in names] + [
        number(f"{name} N", 10) for name in names
    ]
    lines += table([Column("mount, peak", 12), *heads], rows)
    return lines + paragraph(f"peaks are {factor:g} times the r.m.s. of what moves at random")


# ----------------------------------------------------------------------------
# Transmissibility of the six freedoms; density of the acceleration.
# ----------------------------------------------------------------------------

TRANSMISSIBILITY = Curves(
    "motion of the machine over motion of its base",
    (
        Panel(
            "transmissibility",
            (Curve(f"{ROOT}/transmissibility", "{}"), level(lambda _: 1.0)),
            "motion of the body over that of the base, in the same direction",
            log="xy",
        ),
        Panel(
            "relative to the base",
            (Curve(f"{ROOT}/relative_transmissibility", "{}"), level(lambda _: 1.0)),
            "motion against the base over that of the base",
            log="xy",
        ),
    ),
    names=6,
)


def _moving(name: str) -> Callable[[Result], Quantity | None]:
    """Densities of the directions that move at all."""

    def made(result: Result) -> Quantity | None:
        found = sourced(f"{SPECTRUM}/{name}", result)
        if found is None:
            return None
        size = np.max(np.abs(found.values), axis=1)
        moving = np.flatnonzero(size > 1e-12 * np.max(size))
        axis = replace(found.axes[0], values=found.axes[0].values[moving])
        return replace(found, values=found.values[moving], axes=(axis, found.axes[1]))

    return made


DENSITY = Curves(
    "acceleration of base and body by the spectra of the base, in (m/s$^2$)$^2$/Hz",
    (
        Panel(
            "density",
            (
                Curve(_moving("density"), "body, {}"),
                Curve(_moving("base_density"), "base, {}", {"linestyle": "--"}),
            ),
            log="xy",
        ),
    ),
)
