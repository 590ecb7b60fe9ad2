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
    coordinate_words,
    in_unit,
    key_words,
    label_of,
)
from vibecalc.core.report.sections import by_size, magnitudes, read_as, scalar_of, table_of
from vibecalc.core.report.verdicts import bounds_of, entry_in_words, in_percent, place_of, with_unit
from vibecalc.core.report.writing import decibels, number, read, rpm, short, show, table
from vibecalc.core.results.catalogue import CATALOGUE, HEADLINES, OWNER, deciding
from vibecalc.core.results.named import named
from vibecalc.core.results.record import (
    KEPT,
    WORST_FIRST,
    Estimate,
    Headline,
    Quantity,
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.select import entry_text
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
#: the reference of a level, in words on it
_REFERENCE = re.compile(r"dB re [\d.e-]+ [\w^/*]+")
_SIDES = {-1: "at its lower bound", 1: "at its upper bound"}
_ELASTIC = ("1st elastic", "2nd elastic", "3rd elastic")


#: last word of the paths of results that are a load over what a limit allows, read in percent
_UTILISATION = "utilisation"


class Answer(NamedTuple):
    """A row of the first table: its cells, then path, number, entry and limits behind them.

    `entry` holds the names of the entry by axis; `limits` are in the unit of the row.
    """

    name: str
    shown: str
    unit: str
    where: str
    path: str
    value: float
    entry: Mapping[str, str] = {}
    limits: tuple[Verdict, ...] = ()

    @property
    def limit(self) -> Verdict | None:
        """The limit that decides: that of the worst verdict, then of the largest utilisation."""

        def rank(one: Verdict) -> tuple[int, float]:
            return WORST_FIRST.index(one.state), -np.nan_to_num(one.utilisation, nan=0.0)

        return min(self.limits, key=rank, default=None)


def first_table(result: Result, limits: Sequence[Verdict]) -> list[str]:
    """The first table of a result as a block; nothing if there is nothing to show."""
    rows = []
    for one in with_limits(result, limits):
        words = dict.fromkeys(map(_held, one.limits)), dict.fromkeys(map(_share, one.limits))
        held, shares = ("\n".join(each) for each in words)
        rows.append(
            [one.name, one.shown, read(_told_unit(one, result.case)), one.where, held, shares]
        )
    heads = ("result", number("value"), "unit", "where", "limit", number("util.\n%"))
    return table(heads, rows)


def _told_unit(answer: Answer, case: Mapping[str, Any]) -> str:
    """The unit; of a level with its reference, that of the case or of every case."""
    known = CATALOGUE.get(answer.path) if answer.unit == "dB" else None
    if known and known.headline and known.headline.reference:
        return str(named(known.headline.reference)(case))
    found = _REFERENCE.search(known.long_name) if known else None
    return found[0] if found else answer.unit


def with_limits(result: Result, limits: Sequence[Verdict]) -> list[Answer]:
    """The first table of a result: each `[[limit]]` by its number, or in its own row.

    Of a utilisation the limit that it is of stands in its row.
    """
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
        answers[at] = one._replace(limits=(*one.limits, with_unit(limit, one.unit)))
    return sorted((_with_rule(one, limits) for one in answers), key=_urgency)


def _with_rule(answer: Answer, limits: Sequence[Verdict]) -> Answer:
    """The row of a utilisation with the limit of a rule, table or maker that it is of.

    One below 100 % that has no verdict of its own is covered by that on a larger one.
    """
    folder, _, name = answer.path.rpartition("/")
    if answer.limits or not name.endswith(_UTILISATION) or math.isnan(answer.value):
        return answer
    own = [
        row
        for row in limits
        if row.element and row.quantity.startswith(f"{folder}/")
        if math.isclose(100.0 * row.utilisation, answer.value, rel_tol=1e-9)
    ]
    if not own and answer.value > 100.0:
        return answer
    covered = Verdict(
        quantity=answer.path, where={}, source="", min=None, max=None, unit="%", computed=0.0,
        label="", error_estimate=Estimate(0.0, 0.0), margin=0.0, state=KEPT,
    )  # fmt: skip
    row = min(own, key=lambda one: WORST_FIRST.index(one.state), default=covered)
    held = row._replace(
        max=100.0, unit="%", computed=answer.value, margin=100.0 - answer.value,
        utilisation=answer.value / 100.0,
    )  # fmt: skip
    return answer._replace(limits=(held,))


def _urgency(answer: Answer) -> int:
    """What studies found comes first, then what is limited, the broken limits before the others."""
    if answer.path.startswith(_STUDIES):
        return 0
    return 3 if answer.limit is None else 2 if answer.limit.state == KEPT else 1


def _is_about(answer: Answer, limit: Verdict) -> bool:
    """Whether the number is the one that the limit holds for."""
    picked = all(answer.entry.get(axis) == str(entry) for axis, entry in limit.where.items())
    if limit.at == "start" or not picked:
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
    where = "" if flag else place_of(limit)  # it has no worst speed
    where += " (start)" * (limit.at == "start")
    shown = show(bool(value)) if flag else decibels(value) if unit == "dB" else show(value, error)
    return Answer(name, shown, unit, where.strip(), limit.quantity, value)


def _held(limit: Verdict) -> str:
    """Bounds and verdict, `max 400 kept`; capitals where that is not as expected."""
    verdict = limit.state if limit.satisfied else limit.state.upper()
    entry = CATALOGUE.get(limit.quantity)
    if entry is not None and entry.flag and limit.max == 0.0:
        return f"must be no, {verdict}"
    return f"{', '.join(bounds_of(limit))} {verdict}"


def _share(limit: Verdict) -> str:
    """The utilisation in percent; nothing where the result itself is one, or is yes or no."""
    entry = CATALOGUE.get(limit.quantity)
    told = limit.quantity.endswith(_UTILISATION) or (entry is not None and entry.flag)
    return "" if told else in_percent(limit.utilisation, digits=3)


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
            if one.unit in ("g*mm", "W"):
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
            name = coordinate_words(name)
        elif path.startswith("find/") and path.endswith("/value"):
            name = _sought(case, path.split("/")[1])
        elif path == f"{PREFIX}objective":
            goal = str(table_of(case, "optimisation", "objective").get("quantity") or path)
            name, unit = read_as(goal, quantity.unit)
            value, error = in_unit(quantity, unit)
            over = table_of(case, "optimisation", "robust")
            sigmas = f"{float(over.get('sigmas', 2.0)):g} standard deviations"
            of = f"mean + {sigmas} of " if over else ""
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
    if one.pick == "present" and not np.any(flat):
        return
    chosen: Sequence[int] = range(min(len(flat), 1 if one.pick == "first" else _MOST_EACH))
    if one.pick == "ends" and len(flat) > _FEW:
        chosen = (0, len(flat) - 1)
    if one.pick in ("largest", "least"):
        size = -flat if one.pick == "least" else flat if quantity.unit == "dB" else np.abs(flat)
        ranking = record.quantities.get(one.by)
        size = size if ranking is None else np.ravel(magnitudes(ranking))
        top = first_of_largest(np.where(np.isnan(flat), -np.inf, size))
        chosen = range(top, top + 1)
    for at in chosen:
        place = tuple(int(one) for one in np.unravel_index(at, quantity.values.shape))
        said = named(one.words)(record, at, quantity.path) if one.words else None
        value, words = float(flat[at]), _entry(quantity, place) if said is None else [said]
        zero = quantity.unit != "dB" and quantity.estimate.is_zero(value)
        there = _same_entry(record.quantities.get(one.at), quantity, place)
        if there is not None:
            speed, unit = there
            met = {"rad/s": f"at {show(rpm(speed))} rpm", "Hz": f"at {show(speed)} Hz"}
            words.append(met.get(unit, f"at frequency ratio {show(speed)}"))
        entry = {axis.name: entry_text(axis, k)
                 for axis, k in zip(quantity.axes, place, strict=True)}  # fmt: skip
        where = ", ".join(words).replace(", at ", " at ")
        where = "" if zero and one.pick == "largest" else where
        yield _row(one, quantity, value, where)._replace(entry=entry)


def _same_entry(
    found: Quantity | None, of: Quantity, place: tuple[int, ...]
) -> tuple[float, str] | None:
    """That of another result, over the same axes though maybe with more entries, and its unit."""
    if found is None or [one.name for one in found.axes] != [one.name for one in of.axes]:
        return None
    there = []
    for axis, own, k in zip(found.axes, of.axes, place, strict=True):
        same = np.flatnonzero(axis.values == own.values[k])
        if not len(same):
            return None
        there.append(int(same[0]))
    return float(found.values[tuple(there)]), found.unit


def _entry(quantity: Quantity, place: tuple[int, ...]) -> list[str]:
    """The entry of each axis in words: `mount 1`, `at 305.8 rpm`, `clearance 0.254 mm`."""
    names = key_words([axis.name for axis in quantity.axes], {})
    words = []
    for axis, name, at in zip(quantity.axes, names, place, strict=True):
        value, unit = axis.values[at], "mm" if axis.unit == "m" else axis.unit
        shown = str(value)
        if axis.values.dtype.kind == "f":
            shown = f"{short(float(value) * convert(1.0, axis.unit, unit))} {unit}".rstrip()
        turns = axis.unit == "rad/s"
        words.append(f"at {show(rpm(float(value)))} rpm" if turns else entry_in_words(name, shown))
    return words


def _row(one: Headline, quantity: Quantity, value: float, where: str) -> Answer:
    if quantity.unit == "dB":
        return Answer(one.name, decibels(value), "dB", where, quantity.path, value)
    unit, error = (one.unit or quantity.unit) if quantity.unit else "", quantity.estimate
    unit = "%" if CATALOGUE[quantity.path].share else unit
    factor = convert(1.0, quantity.unit, unit)
    where = "  ".join(filter(None, (where, UNRESOLVED * error.unresolved(value))))
    shown = show(value * factor, error * factor)
    return Answer(one.name, shown, unit, where, quantity.path, value * factor)
