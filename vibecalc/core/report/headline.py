"""What the reader looks for first: a few results by name, in the units people read, four digits."""

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from vibecalc.core.report.sections import magnitudes
from vibecalc.core.report.studies import bound_units
from vibecalc.core.report.writing import Column, decibels, number, rpm, show
from vibecalc.core.results.catalogue import OWNER
from vibecalc.core.results.record import Headline, Quantity, Record
from vibecalc.core.results.tolerance import UNRESOLVED
from vibecalc.core.run.stage import subjects
from vibecalc.units import convert

COLUMNS = (Column("result", 48), number("value", 13), Column("unit", 9), Column("where", 25))
_DIGITS = 4
#: in N m
_LARGE = 1e4
#: rows of an array of which each entry counts
_MOST_EACH = 12
_VARIABLES, _BOUNDS = "optimisation/variable/", "optimisation/active_bound/"
_SIDES = {-1: "at its lower bound", 1: "at its upper bound"}
_ELASTIC = ("1st elastic", "2nd elastic", "3rd elastic")


def headline_rows(record: Record, case: Mapping[str, Any] | None = None) -> list[list[str]]:
    """Rows for `COLUMNS`: variables and values found, then the headlines of the subjects.

    Variables and values found are shown in the unit that `case` gives their bounds in.
    """
    rows = list(_searched(record, bound_units(case or {})))
    there = {OWNER[path] for path in record if path in OWNER}
    # those that lead come first, as their sections do
    order = sorted(subjects().items(), key=lambda item: not item[1].leads)
    for name in (name for name, _ in order if name in there):
        results = import_module(f"vibecalc.{name}.results")
        listed: Sequence[Headline] = getattr(results, "HEADLINES", ())
        large = large_torques(record, listed)
        for one in listed:
            one = one._replace(unit="kN*m") if large and one.unit == "N*m" else one
            quantity = record.quantities.get(one.path)
            if quantity is not None and quantity.values.size and one.unless not in record:
                rows += [row for row in _rows(record, quantity, one) if row not in rows]
    return rows


def large_torques(record: Record, listed: Sequence[Headline]) -> bool:
    """Whether a torque of the headlines reaches 10 kN m, so that all of them are in kN m."""
    found = (record.quantities.get(one.path) for one in listed if one.unit == "N*m")
    sizes = (np.abs(magnitudes(one)) for one in found if one is not None)
    return any(bool(np.any((size >= _LARGE) & np.isfinite(size))) for size in sizes)


def _searched(record: Record, units: Mapping[str, str]) -> Iterator[list[str]]:
    """Variables and objective of an optimisation, values of searches."""
    for path, quantity in record.items():
        key = path.removeprefix(_VARIABLES)
        found = path.startswith("find/") and path.endswith("/value")
        if quantity.axes or not (key != path or found or path == "optimisation/objective"):
            continue
        unit = units.get(path, quantity.unit)
        factor = convert(1.0, quantity.unit, unit)
        value, error = float(quantity.values) * factor, quantity.estimate * factor
        side = record.quantities.get(_BOUNDS + key)
        words = "" if side is None else _SIDES.get(int(side.values), "")
        name = key if key != path else " ".join(path.split("/")[:-1] if found else path.split("/"))
        yield [name, show(value, error, _DIGITS), unit.replace("*", " "), words]


def _rows(record: Record, quantity: Quantity, one: Headline) -> Iterator[list[str]]:
    flat = np.ravel(magnitudes(quantity))
    places = [*np.ndindex(*quantity.values.shape)]
    if one.pick == "elastic":
        moving = [float(value) for value in flat if value > 0.0]
        for value, name in zip(moving, _ELASTIC, strict=False):
            yield _row(one, quantity, value, name)
        return
    chosen = range(min(len(flat), 1 if one.pick == "first" else _MOST_EACH))
    if one.pick in ("largest", "least"):
        size = -flat if one.pick == "least" else flat if quantity.unit == "dB" else np.abs(flat)
        top = int(np.argmax(np.where(np.isnan(flat), -np.inf, size)))
        chosen = range(top, top + 1)
    for at in chosen:
        value, words = float(flat[at]), _entry(quantity, places[at])
        zero = quantity.unit != "dB" and quantity.estimate.is_zero(value)
        speed = record.quantities.get(one.at)
        if speed is not None and speed.values.shape == quantity.values.shape:
            there = float(speed.values.flat[at])
            turning = speed.unit == "rad/s"
            words.append(_rpm(there) if turning else f"at ratio {show(there, digits=_DIGITS)}")
        yield _row(one, quantity, value, "" if zero and one.pick == "largest" else " ".join(words))


def _entry(quantity: Quantity, place: tuple[int, ...]) -> list[str]:
    """The entry of each axis in words: `mount 1`, `at 305.8 rpm`."""
    words = []
    for axis, at in zip(quantity.axes, place, strict=True):
        value = axis.values[at]
        if axis.unit == "rad/s":
            words.append(_rpm(float(value)))
        elif axis.unit == "m":
            words.append(f"{axis.name} {show(1e3 * float(value), digits=_DIGITS)} mm")
        else:
            kind = axis.values.dtype.kind
            label = show(float(value), digits=_DIGITS) if kind == "f" else str(value)
            words.append(f"{axis.name.replace('_', ' ')} {label}")
    return words


def _rpm(speed: float) -> str:
    return f"at {show(rpm(speed), digits=_DIGITS)} rpm"


def _row(one: Headline, quantity: Quantity, value: float, where: str) -> list[str]:
    if quantity.unit == "dB":
        return [one.name, decibels(value), "dB", where]
    unit, error = (one.unit or quantity.unit) if quantity.unit else "", quantity.estimate
    factor = convert(1.0, quantity.unit, unit)
    words = [where, UNRESOLVED] if error.unresolved(value) else [where]
    shown = show(value * factor, error * factor, _DIGITS)
    return [one.name, shown, unit.replace("*", " "), "  ".join(filter(None, words))]
