"""Are the numbers of a measurement within reason, and does it say what they count in?"""

from collections.abc import Iterator
from typing import Any

from vibecalc.case.measurement_tables import Measurement
from vibecalc.errors import KeyPath, Problem

TABLE: KeyPath = ("measurement",)
#: dB, m and rad; what lies beyond is no reading of a machine
LOUDEST, FARTHEST, TURNED = 400.0, 1e6, 1e6
SMALLEST, LARGEST = 1e-20, 1e20
_MOST = {
    "x": FARTHEST,
    "y": FARTHEST,
    "level": LOUDEST,
    "amplitude": LARGEST,
    "angular_amplitude": LARGEST,
    "phase": TURNED,
}
_KEYS = {
    "positions": ("x", "y"),
    "readings": ("level", "amplitude", "angular_amplitude", "phase"),
    "scan": ("x", "y", "level", "amplitude", "phase"),
    "plate": ("x", "y"),
}
_SINGLE = (
    *("reference_level", "angular_reference_level", "level_step", "amplitude_step"),
    *("angular_step", "phase_step", "base_frequency"),
    *("amplitude_uncertainty", "angular_uncertainty"),
)


def range_problems(table: Measurement) -> Iterator[Problem]:
    """Yield the numbers that are too large or too small to compute with."""
    columns: list[tuple[KeyPath, Any]] = []
    for name, entries in (("positions", table.positions), ("readings", table.readings)):
        for place, entry in enumerate(entries):
            for key in _KEYS[name]:
                columns.append(((*TABLE, name, place, key), getattr(entry, key)))
    for name, one in (("scan", table.scan), ("plate", table.plate)):
        if one is not None:
            columns += [((*TABLE, name, key), getattr(one, key)) for key in _KEYS[name]]
    for path, values in columns:
        several = isinstance(values, tuple)
        for place, value in enumerate(values if several else (values,)):
            if abs(value) > _MOST[str(path[-1])] or 0.0 < abs(value) < SMALLEST:
                yield _out((*path, place) if several else path, value)
    for key in _SINGLE:
        value = getattr(table, key)
        if value and not SMALLEST <= value <= LARGEST:
            yield _out((*TABLE, key), value)


def scale_problems(table: Measurement) -> list[Problem]:
    """Levels without a reference, and readings without their last digit."""
    return [*_references(table), *_steps(table)]


def _out(path: KeyPath, value: float) -> Problem:
    return Problem(
        path=path,
        message="the number is out of the range of any measurement",
        found=f"{value:.6g} in SI units",
    )


def _references(table: Measurement) -> Iterator[Problem]:
    scanned = table.scan is not None and bool(table.scan.level)
    linear = [n for n, one in enumerate(table.readings) if one.level and not one.about]
    if table.reference_level is None and (linear or scanned):
        path: KeyPath = (*TABLE, "readings", linear[0], "level") if linear else (*TABLE, "scan")
        yield Problem(
            path=path,
            message="levels without a reference: a level says nothing without what 0 dB is",
            allowed='reference_level = "1e-5 m/s^2", or what the instrument refers to',
            hint="1e-5 m/s^2 in older and naval work, 1e-6 m/s^2 in ISO 1683",
        )
    angular = [n for n, one in enumerate(table.readings) if one.level and one.about]
    if table.angular_reference_level is None and angular:
        yield Problem(
            path=(*TABLE, "readings", angular[0], "level"),
            message="levels of rotation without a reference: what is 0 dB?",
            allowed='angular_reference_level = "1 rad/s^2", or what the instrument refers to',
        )


def _steps(table: Measurement) -> Iterator[Problem]:
    scan = table.scan
    needs = {
        "amplitude_step": [n for n, one in enumerate(table.readings) if one.amplitude],
        "angular_step": [n for n, one in enumerate(table.readings) if one.angular_amplitude],
        "phase_step": [n for n, one in enumerate(table.readings) if one.phase],
    }
    scanned = {
        "amplitude_step": scan is not None and bool(scan.amplitude),
        "phase_step": scan is not None and bool(scan.phase),
    }
    example = {"amplitude_step": "0.001 m/s^2", "angular_step": "0.01 rad/s^2"}
    for key, readings in needs.items():
        if getattr(table, key) is None and (readings or scanned.get(key)):
            yield Problem(
                path=(*TABLE, "readings", readings[0]) if readings else (*TABLE, "scan"),
                message=f"[measurement] does not say the {key.replace('_', ' ')}: how far is a "
                "reading off?",
                allowed=f'{key} = "{example.get(key, "1 deg")}", the last digit that was read',
            )
