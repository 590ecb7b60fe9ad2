"""What the reader looks for first: a few results by name, in the units people read, four digits."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.goals import (
    FITTED,
    PICKED,
    PREFIX,
    VARIABLE,
    bound_units,
    in_unit,
    key_words,
    label_of,
)
from vibecalc.core.report.sections import by_size, magnitudes, read_as, scalar_of, table_of
from vibecalc.core.report.verdicts import bounds_of, place_of
from vibecalc.core.report.writing import decibels, number, read, rpm, short, show, table
from vibecalc.core.results.catalogue import CATALOGUE, HEADLINES, OWNER, deciding
from vibecalc.core.results.named import named
from vibecalc.core.results.record import (
    KEPT,
    Headline,
    Quantity,
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import UNRESOLVED
from vibecalc.core.run.stage import subjects
from vibecalc.numerics.rounding import first_of_largest
from vibecalc.units import convert

#: rows of an array of which each entry counts
_MOST_EACH = 12
#: entries that all have a row where else the lowest and the highest stand for them
_FEW = 3
#: groups of what studies found
_STUDIES = (PREFIX, "find/", FITTED)
#: head of the column of limits, and of one with utilisations
LIMIT_HEADS = ("limit", "limit (util.)")
#: the reference of a level, in words on it
_REFERENCE = re.compile(r"dB re [\d.e-]+ [\w^/*]+")
_SIDES = {-1: "at its lower bound", 1: "at its upper bound"}
_ELASTIC = ("1st elastic", "2nd elastic", "3rd elastic")


class Answer(NamedTuple):
    """A row of the first table: its cells, then path, number and unit behind them."""

    name: str
    shown: str
    unit: str
    where: str
    path: str
    value: float
    limit: str = ""
    missed: bool = False


def first_table(result: Result, limits: Sequence[Verdict]) -> list[str]:
    """The first table of a result as a block; nothing if there is nothing to show."""
    rows = [[one.name, one.shown, read(_told_unit(one)), one.where, one.limit]
            for one in with_limits(result, limits)]  # fmt: skip
    limit = LIMIT_HEADS["%)" in "".join(row[-1] for row in rows)]
    return table(("result", number("value"), "unit", "where", limit), rows)


def _told_unit(answer: Answer) -> str:
    """The unit; of a level with its reference, where that is the same in every case."""
    known = CATALOGUE.get(answer.path) if answer.unit == "dB" else None
    found = _REFERENCE.search(known.long_name) if known else None
    return found[0] if found else answer.unit


def with_limits(result: Result, limits: Sequence[Verdict]) -> list[Answer]:
    """The first table of a result: each `[[limit]]` by its number, or in its own row."""
    answers = headline_rows(result.record, result.case)
    for limit in (row for row in limits if not row.element):
        paths = {deciding(limit.quantity, limit.where, side) for side in ("max", "min")}
        paths.add(limit.quantity)
        same = [i for i, one in enumerate(answers) if one.path in paths]
        at = next((i for i in same if _is_about(answers[i], limit)), None)
        if at is None:
            at = same[-1] + 1 if same else len(answers)
            answers.insert(at, _own_row(limit))
        one = answers[at]
        words, missed = _held(limit, one.unit), one.missed or not limit.satisfied
        words = one.limit if words in one.limit else f"{one.limit}\n{words}".lstrip()
        answers[at] = one._replace(limit=words, missed=missed)
    return sorted(answers, key=_urgency)


def _urgency(answer: Answer) -> int:
    """What studies found comes first, then what is limited, the broken limits before the others."""
    if answer.path.startswith(_STUDIES):
        return 0
    if not answer.limit:
        return 3
    bounds = [line for line in answer.limit.splitlines() if not line.startswith("(")]
    return 2 if bounds[-1].endswith(KEPT) else 1


def _is_about(answer: Answer, limit: Verdict) -> bool:
    """Whether the number is the one that the limit holds for."""
    if limit.at == "start" or (limit.where and not answer.where.startswith(place_of(limit))):
        return False
    value = convert(limit.computed, limit.unit, answer.unit)
    return (value == 0.0 and answer.shown == "0") or math.isclose(value, answer.value, rel_tol=1e-9)


def _own_row(limit: Verdict) -> Answer:
    name, unit = read_as(limit.quantity, limit.unit)
    known = CATALOGUE.get(limit.quantity)
    flag = known is not None and known.flag
    if math.isnan(limit.computed):
        return Answer(name, "not found", unit, "", limit.quantity, math.nan)
    factor = convert(1.0, limit.unit, unit)
    value, error = limit.computed * factor, limit.error_estimate * factor
    where = place_of(limit) + " (start)" * (limit.at == "start")
    shown = show(bool(value)) if flag else decibels(value) if unit == "dB" else show(value, error)
    return Answer(name, shown, unit, where.strip(), limit.quantity, value)


def _held(limit: Verdict, unit: str) -> str:
    """Bounds with the verdict, `max 400 kept`, capitals where that is not as expected; below them
    the utilisation, where that is not the number itself."""
    verdict = limit.state if limit.satisfied else limit.state.upper()
    bounds = ", ".join(bounds_of(limit, convert(1.0, limit.unit, unit)))
    known = math.isfinite(limit.utilisation) and unit != "%"
    use = f"\n({show(100.0 * limit.utilisation, digits=3)} %)" if known else ""
    return f"{bounds} {verdict}{use}"


def headline_rows(record: Record, case: Mapping[str, Any] | None = None) -> list[Answer]:
    """Variables and values found, then the headlines of the subjects, without limits.

    Variables and values found are shown in the unit that `case` gives their bounds in.
    """
    rows = list(_searched(record, case or {}))
    # those that lead come first, as their sections do
    order = [name for name, _ in sorted(subjects().items(), key=lambda item: not item[1].leads)]
    large = large_torques(record)
    for path in sorted(HEADLINES, key=lambda path: order.index(OWNER[path])):
        one = HEADLINES[path]
        one = one._replace(unit="kN*m") if large and one.unit == "N*m" else one
        quantity = record.quantities.get(path)
        if quantity is not None and quantity.values.size and one.unless not in record:
            if one.unit == "g*mm":
                one = one._replace(unit=by_size(one.unit, quantity.values))
            rows += [row for row in _rows(record, quantity, one) if row not in rows]
    return rows


def large_torques(record: Record, subject: str = "") -> bool:
    """Whether a torque of the headlines reaches 10 kN m, so that all of them are in kN m."""
    listed = [path for path, one in HEADLINES.items() if one.unit == "N*m"]
    found = (record.quantities.get(path) for path in listed if subject in ("", OWNER[path]))
    sizes = (magnitudes(one) for one in found if one is not None)
    return any(by_size("N*m", size) != "N*m" for size in sizes)


def _searched(record: Record, case: Mapping[str, Any]) -> Iterator[Answer]:
    """Variables and objective of an optimisation, values of searches, fitted keys."""
    units = bound_units(case)
    for path, quantity in record.items():
        if quantity.axes or not path.startswith(_STUDIES):
            continue
        unit, words = units.get(path, quantity.unit), ""
        value, error = in_unit(quantity, unit)
        name, text = path.split("/", 2)[-1], show(value, error)
        if path.startswith(PICKED):
            text, unit = label_of(case, path, value), ""
        elif path.startswith(FITTED):
            off, _ = in_unit(record[f"fit/standard_error/{name}"], unit)
            words = f"+- {show(off, digits=2)}" if math.isfinite(off) else "not identifiable"
            text = show(value)
        elif path.startswith(VARIABLE):
            words = _SIDES.get(int(scalar_of(record, f"{PREFIX}active_bound/{name}") or 0), "")
        elif path.startswith("find/") and path.endswith("/value"):
            name = _sought(case, path.split("/")[1])
        elif path == f"{PREFIX}objective":
            goal = str(table_of(case, "optimisation", "objective").get("quantity") or path)
            name, unit = read_as(goal, quantity.unit)
            value, error = in_unit(quantity, unit)
            over = table_of(case, "optimisation", "robust")
            of = f"mean and {float(over.get('sigmas', 2.0)):g} deviations of " if over else ""
            name, text = f"objective: {of}{name}", show(value, error)
        else:
            continue
        yield Answer(name, text, unit, words, path, value)


def _sought(case: Mapping[str, Any], search: str) -> str:
    """What a [[find]] changes and its name: `rod length (rod_10_db)`."""
    rows: Any = case.get("find") or ()
    keys = [str(one["key"]) for one in rows if one.get("name") == search]
    return f"{key_words(keys, case)[0]} ({search})" if keys else search


def _rows(record: Record, quantity: Quantity, one: Headline) -> Iterator[Answer]:
    flat = np.ravel(magnitudes(quantity))
    if one.pick == "elastic":
        moving = [float(value) for value in flat if value > 0.0]
        for value, name in zip(moving, _ELASTIC, strict=False):
            yield _row(one, quantity, value, name)
        return
    chosen: Sequence[int] = range(min(len(flat), 1 if one.pick == "first" else _MOST_EACH))
    if one.pick == "ends" and len(flat) > _FEW:
        chosen = (0, len(flat) - 1)
    if one.pick in ("largest", "least"):
        size = -flat if one.pick == "least" else flat if quantity.unit == "dB" else np.abs(flat)
        top = first_of_largest(np.where(np.isnan(flat), -np.inf, size))
        chosen = range(top, top + 1)
    for at in chosen:
        place = tuple(int(one) for one in np.unravel_index(at, quantity.values.shape))
        said = named(one.words)(record, at) if one.words else ""
        value, words = float(flat[at]), [said] if said else _entry(quantity, place)
        zero = quantity.unit != "dB" and quantity.estimate.is_zero(value)
        speed = record.quantities.get(one.at)
        if speed is not None and speed.values.shape == quantity.values.shape:
            there = float(speed.values.flat[at])
            said = {"rad/s": _rpm(there), "Hz": f"at {show(there)} Hz"}
            words.append(said.get(speed.unit, f"at frequency ratio {show(there)}"))
        where = ", ".join(words).replace(", at ", " at ")
        yield _row(one, quantity, value, "" if zero and one.pick == "largest" else where)


def _entry(quantity: Quantity, place: tuple[int, ...]) -> list[str]:
    """The entry of each axis in words: `mount 1`, `at 305.8 rpm`, `clearance 0.254 mm`."""
    names = key_words([axis.name for axis in quantity.axes], {})
    words = []
    for axis, name, at in zip(quantity.axes, names, place, strict=True):
        value, unit = axis.values[at], "mm" if axis.unit == "m" else axis.unit
        shown = str(value)
        if axis.values.dtype.kind == "f":
            shown = f"{short(float(value) * convert(1.0, axis.unit, unit))} {unit}".rstrip()
        words.append(_rpm(float(value)) if axis.unit == "rad/s" else f"{name} {shown}")
    return words


def _rpm(speed: float) -> str:
    return f"at {show(rpm(speed))} rpm"


def _row(one: Headline, quantity: Quantity, value: float, where: str) -> Answer:
    if quantity.unit == "dB":
        return Answer(one.name, decibels(value), "dB", where, quantity.path, value)
    unit, error = (one.unit or quantity.unit) if quantity.unit else "", quantity.estimate
    unit = "%" if CATALOGUE[quantity.path].share else unit
    factor = convert(1.0, quantity.unit, unit)
    where = "  ".join(filter(None, (where, UNRESOLVED * error.unresolved(value))))
    shown = show(value * factor, error * factor)
    return Answer(one.name, shown, unit, where, quantity.path, value * factor)
