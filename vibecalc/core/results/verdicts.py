"""Limits of a result, each judged once: rows that every report, exit code, sweep and search reads.

`run` judges them after the last stage and stores them with the result (`judged`); a file without
them, as older ones, is judged by the same function when it is read (`verdicts_of`).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import JUDGES, OWNER, deciding, speed_path
from vibecalc.core.results.named import named
from vibecalc.core.results.printed import read_printed
from vibecalc.core.results.record import (
    AT_START,
    BROKEN,
    KEPT,
    ROUNDING,
    UNDECIDED,
    Estimate,
    Quantity,
    Result,
    Verdict,
)
from vibecalc.core.results.renamed import VERDICT_FIELDS, current_path, current_where
from vibecalc.core.results.select import Side, beside_error, numbers, select
from vibecalc.core.results.tolerance import remedy
from vibecalc.errors import ResultError
from vibecalc.numerics.rounding import first_of_largest
from vibecalc.units import SHIFTED, convert, parse_quantity

# ----------------------------------------------------------------------------
# The rows of a result.
# ----------------------------------------------------------------------------

_STATES = {1: KEPT, -1: BROKEN, 0: UNDECIDED}


def verdicts_of(result: Result) -> Sequence[Verdict]:
    """The rows of a result: as stored with it, else judged now."""
    return judged(result) if result.verdicts is None else result.verdicts


def judged(result: Result) -> tuple[Verdict, ...]:
    """Every limit of a run: each `[[limit]]` in the order of the case, then those of the subjects.

    A `[[limit]]` that expects a result to be broken says so of the other limits on it, too. The
    file of a sweep has no rows: `core/report/sweep/limits.py` judges its points.

    Raises
    ------
    ResultError
        A row names a quantity or an entry that the result does not have.
    """
    if result.swept is not None:
        return ()
    asked_for = entries(result, "limit")
    there = {OWNER[path] for path in result.record if path in OWNER}
    judges = [where for subject, where in JUDGES.items() if subject in there]
    others = [_expected(row, asked_for) for judge in judges for row in named(judge)(result)]
    return (*(judge(result, entry) for entry in asked_for), *others)


def _expected(row: Verdict, asked_for: Sequence[Mapping[str, Any]]) -> Verdict:
    """The row with plain numbers; broken as a `[[limit]]` on the same result and entries expects,
    where one does."""
    given = {name: getattr(row, name) for name in _NUMBERS - {"error_estimate"}}
    numbers: dict[str, Any] = {name: float(one) for name, one in given.items() if one is not None}
    row = row._replace(**numbers)
    if row.state != BROKEN:
        return row
    picked = {(axis, str(entry)) for axis, entry in row.where.items()}
    for one in asked_for:
        where = {(axis, str(entry)) for axis, entry in (one.get("where") or {}).items()}
        if one["quantity"] == row.quantity and one.get("expect") == BROKEN and where <= picked:
            return row._replace(expect=BROKEN)
    return row


# ----------------------------------------------------------------------------
# A bound, and whether values keep it: for one result, for all points of a sweep, for a search.
# ----------------------------------------------------------------------------


class Bound(NamedTuple):
    """One side of a limit: its `value` in the unit of the quantity, `written` as in the case."""

    side: Side
    value: float
    written: float | str

    def left(self, values: Any) -> Any:
        """What is left from values (...) to the bound: positive inside."""
        return self.value - values if self.side == "max" else values - self.value

    def utilisation(self, value: float, unit: str) -> float:
        """The share of the bound that a value takes up, above 1 outside: value over `max`, `min`
        over value; NaN where that is no share, of a bound or a level at or through zero.

        A level in dB is a logarithm: its zero is its reference, not nothing.
        """
        above, below = (value, self.value) if self.side == "max" else (self.value, value)
        if unit == "dB" or not self.value > 0.0 or not below > 0.0:
            return math.nan
        return above / below

    def scaled(self, margin: Any) -> Any:
        """Margins (...) as shares of the bound."""
        return margin / (abs(self.value) or 1.0)


def bounds_of(entry: Mapping[str, Any], unit: str) -> list[Bound]:
    """Both sides of a `[[limit]]` on a quantity of that unit, those it has."""
    sides: tuple[Side, Side] = ("max", "min")
    written = [(side, entry[side]) for side in sides if entry.get(side) is not None]
    return [Bound(side, parse_quantity(str(said), unit), said) for side, said in written]


def held(margin: np.ndarray | float, error: np.ndarray | float, bound: float) -> np.ndarray:
    """Whether values keep a limit: 1 kept, -1 broken, 0 undecided, of the shape of `margin`.

    The whole interval of a value and its error counts. `margin` is positive inside, in the unit of
    `error` and of the `bound`. A value on the bound, to the last bits, is inside; so is one that
    its error does not tell from the bound, as far as that is `ROUNDING` of the bound. A finite
    value with an unknown error decides nothing, one that is not a number keeps nothing.
    """
    margin, error = np.asarray(margin, dtype=float), np.asarray(error, dtype=float)
    reach = np.where(np.isinf(margin), 0.0, np.where(np.isnan(error), np.inf, error))
    last_bits = 4.0 * np.finfo(float).eps * abs(bound)
    on = margin >= -np.maximum(last_bits, reach)
    inside = on & ((margin - reach >= -last_bits) | (reach <= ROUNDING * abs(bound)))
    outside = np.isnan(margin) | (margin + reach < -last_bits)
    return np.asarray(np.where(inside, 1, np.where(outside, -1, 0)))


def state_of(margin: float, error: float, bound: float) -> str:
    """The same of one value, as the word of a row."""
    return _STATES[int(held(margin, error, bound))]


def judge(result: Result, entry: Mapping[str, Any]) -> Verdict:
    """A row of the limits of a case, or one like it; of an array the worst entry counts.

    A bound on all of a curve holds between its samples, too: it is held against what the run found
    to be the largest, or least, at any speed, where there is such a result.
    An infinite value breaks a `max` with a margin of minus infinity; what a [[find]] was to find
    and did not is undecided. Numbers are in the unit of the bound as written (of `max`, if the row
    has both).
    """
    missing, where = not_found(result, entry), dict(entry.get("where") or {})
    quantity = None if missing else asked(result, entry, "limit")
    own = "" if quantity is None else quantity.unit
    said = next((entry[side] for side in ("max", "min") if entry.get(side) is not None), None)
    if said is None:
        raise ResultError(f"a [[limit]] on {entry['quantity']} has neither max nor min")
    unit = read_printed(said, default_unit=own).unit
    unit = own if unit in SHIFTED else unit
    known = unit if quantity is None else own
    bounds = bounds_of(entry, known)
    limits = {bound.side: convert(bound.value, known, unit) for bound in bounds}
    computed, off, label, margin, share = math.nan, math.nan, "", -math.inf, math.nan
    state, decided_by = UNDECIDED, _what_finds(result, entry)
    if quantity is not None:
        sides = []
        for bound in bounds:
            with naming("limit", entry):
                sides.append((*_nearest(result, entry, bound), bound))
        held_worst, left, value, off, label, bound = min(sides, key=lambda one: one[:2])
        state = _STATES[held_worst]
        computed, limit = convert(value, own, unit), limits[bound.side]
        share = bound._replace(value=limit).utilisation(computed, unit)
        if math.isfinite(share):  # of a range, the side of which more is taken up
            share = max(share, *(one[-1].utilisation(one[2], own) for one in sides))
        off = convert(off, own, unit)
        margin = left
        if math.isfinite(left):
            margin = limit - computed if bound.side == "max" else computed - limit
        decided_by = _decided_by(result, quantity, where) if state == UNDECIDED else ""
    return Verdict(
        quantity=str(entry["quantity"]),
        where=where,
        source=str(entry.get("source") or ""),
        min=limits.get("min"),
        max=limits.get("max"),
        unit=unit,
        computed=computed,
        label=label,
        error_estimate=Estimate(off, 0.0),  # what is a zero has become one
        margin=margin,
        state=state,
        decided_by=decided_by,
        expect=str(entry.get("expect") or KEPT),
        at=str(entry.get("at") or "optimum"),
        utilisation=share,
    )


def _nearest(
    result: Result, entry: Mapping[str, Any], bound: Bound
) -> tuple[int, float, float, float, str]:
    """State of a bound as of `held`, its margin; value, error and label of the deciding entry."""
    path, where = str(entry["quantity"]), dict(entry.get("where") or {})
    start = AT_START * (entry.get("at") == "start")
    extreme = deciding(path, where, bound.side)
    if start + extreme not in result.record:  # of an older file
        extreme = path
    quantity = result.record[start + extreme]
    picked = numbers(quantity, where)
    values, errors = picked.values, picked.errors
    zero = quantity.zeros(values, errors)
    values = np.where(zero, 0.0, values)
    errors = np.where(zero, 0.0, errors + beside_error(quantity, where))
    left = bound.left(values)
    # A value that is not a number keeps no limit, whatever the side.
    left = np.where(np.isnan(left), -np.inf, left)
    states = held(left, errors, bound.value)
    state = int(np.min(states))
    worst = (values if bound.side == "max" else -values) + (errors if state == 0 else 0.0)
    worst = np.where(np.isnan(values), np.inf, worst)
    worst = np.where(states == state, worst, -np.inf)
    place = int(np.argmax(worst))
    label = picked.label(first_of_largest(worst))
    if extreme != path and (at := result.record.quantities.get(start + speed_path(extreme))):
        speed = numbers(at, where).values[first_of_largest(worst)]
        label = ", ".join(filter(None, (label, f"speed={speed:.9g} {at.unit}")))
    return state, float(left[place]), float(values[place]), float(errors[place]), label


def _decided_by(result: Result, quantity: Quantity, where: Mapping[str, Any]) -> str:
    if select(quantity, where).curving > quantity.error_estimate:
        return "more points of the curve, whose samples lie too far apart here"
    return remedy(quantity, result.case)


# ----------------------------------------------------------------------------
# The rows in a file: objects of JSON, which has no word for what is infinite or undefined.
# ----------------------------------------------------------------------------

VERDICTS = "verdicts"
_NUMBERS = {"min", "max", "computed", "error_estimate", "margin", "utilisation", "speed"}


def as_objects(rows: Sequence[Verdict]) -> list[dict[str, Any]]:
    """The rows as plain objects; "inf", "-inf" and "nan" stand for such numbers."""
    return [
        {
            name: str(value) if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row._asdict().items()
        }
        for row in rows
    ]


def from_objects(content: Sequence[Mapping[str, Any]]) -> tuple[Verdict, ...]:
    """The rows of such objects; what a later version has more is left out."""
    rows = []
    for one in content:
        now = {VERDICT_FIELDS.get(name, name): value for name, value in one.items()}
        known = {name: now[name] for name in Verdict._fields if name in now}
        for name in _NUMBERS & known.keys():
            known[name] = None if known[name] is None else float(known[name])
        known |= {"quantity": current_path(one["quantity"]), "where": current_where(one["where"])}
        row = Verdict(**known)
        rows.append(row._replace(error_estimate=Estimate(row.error_estimate, 0.0)))
    return tuple(rows)


# ----------------------------------------------------------------------------
# Rows of the case that name a quantity of its result.
# ----------------------------------------------------------------------------


def entries(result: Result, table: str) -> tuple[Mapping[str, Any], ...]:
    """The rows of a list of tables of the case (`reference`, `limit`), none if it is absent."""
    rows: Any = result.case.get(table) or ()
    return tuple(rows)


def asked(result: Result, entry: Mapping[str, Any], table: str) -> Quantity:
    """The quantity that a row of the case names; `at = "start"` looks under `AT_START`.

    Raises
    ------
    ResultError
        The result does not have it; the nearest path is named.
    """
    path = str(entry["quantity"])
    if entry.get("at") == "start":
        path = AT_START + path
    if path not in result.record:
        from difflib import get_close_matches

        near = get_close_matches(path, list(result.record), n=1, cutoff=0.5)
        hint = f"; the nearest one is {near[0]}" if near else ""
        raise ResultError(f"a [[{table}]] asks for {path}, which this result does not have{hint}")
    return result.record[path]


def not_found(result: Result, entry: Mapping[str, Any]) -> bool:
    """Whether a row of the case names something of a [[find]] that found nothing, or a result that
    the run left out with a warning, as of an efficiency where nothing acts."""
    path = str(entry["quantity"])
    if path in result.record:
        return False
    planned = {one for stage in result.plan for one in stage.get("quantities", "").split(", ")}
    return path in planned or _is_sought(result, path)


def _is_sought(result: Result, path: str) -> bool:
    return path.rsplit("/", 1)[0] in {f"find/{one['name']}" for one in entries(result, "find")}


def _what_finds(result: Result, entry: Mapping[str, Any]) -> str:
    """What would decide a limit on something that the result does not have."""
    if _is_sought(result, str(entry["quantity"])):
        return "a [[find]] that finds it"
    return "a run that does not leave it out"


@contextmanager
def naming(table: str, entry: Mapping[str, Any]) -> Iterator[None]:
    """Say in a ResultError which row of a list of tables asked for what is not there."""
    try:
        yield
    except ResultError as error:
        row = name_of(str(entry["quantity"]), dict(entry.get("where") or {}))
        source = f" ({entry['source']})" if entry.get("source") else ""
        raise ResultError(f"the [[{table}]] on {row}{source}: {error}") from error


def name_of(quantity: str, where: Mapping[str, Any]) -> str:
    """`path [axis=entry, ...]`, as messages and tables name an entry."""
    picks = ", ".join(f"{axis}={entry}" for axis, entry in where.items())
    return f"{quantity} [{picks}]" if picks else quantity
