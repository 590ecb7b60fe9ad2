"""Limits of a case, judged against its result."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from vibecalc.errors import ResultError
from vibecalc.pipeline.tolerance import remedy
from vibecalc.report.lookup import asked, entries, naming, not_found
from vibecalc.report.printed import read_printed
from vibecalc.results.record import Estimate, Quantity, Result
from vibecalc.results.select import curving, held, uncertainty, worst
from vibecalc.units import convert

KEPT, BROKEN, UNDECIDED = "kept", "broken", "undecided"
_STATES = {1: KEPT, -1: BROKEN, 0: UNDECIDED}


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """A bound and the worst entry it is held against; all numbers in `unit`.

    `state` is KEPT where the whole interval of the value and its error lies inside, BROKEN where it
    lies outside, else UNDECIDED; `decided_by` then says what would decide. The error is the same
    for all entries of a quantity, so that the worst entry is also the one whose interval reaches
    furthest. `label` names it.
    """

    quantity: str
    where: Mapping[str, int | float | str] = field(default_factory=dict)
    source: str
    min: float | None
    max: float | None
    unit: str
    computed: float
    label: str
    error_estimate: float
    margin: float
    state: str
    decided_by: str = ""
    expect: str = "kept"
    at: str = "optimum"

    @property
    def kept(self) -> bool | None:
        """None where that is undecided."""
        return None if self.state == UNDECIDED else self.state == KEPT

    @property
    def satisfied(self) -> bool:
        """Whether the limit does what the case expects of it."""
        return self.state == self.expect


def judge_limits(result: Result) -> list[LimitRow]:
    """Judge every `[[limit]]` of the case, in its order; of an array the worst entry counts.

    An infinite value breaks a `max` with a margin of minus infinity; what a [[find]] was to find
    and did not is undecided. Numbers are in the unit of
    the bound as written (of `max`, if the row has both).

    Raises
    ------
    ResultError
        A row names a quantity or an entry that the result does not have.
    """
    return [_judge(result, entry) for entry in entries(result, "limit")]


def _nothing(entry: Mapping[str, Any]) -> LimitRow:
    """A limit on what a [[find]] did not find: missed, whatever the case expects of it."""
    both = {side: entry.get(side) for side in ("max", "min")}
    bounds = {side: read_printed(bound) for side, bound in both.items() if bound is not None}
    unit = next((bound.unit for bound in bounds.values()), "")
    limits = {side: convert(bound.number, bound.unit, unit) for side, bound in bounds.items()}
    expect = str(entry.get("expect") or "kept")
    return LimitRow(
        quantity=str(entry["quantity"]),
        where=dict(entry.get("where") or {}),
        source=str(entry.get("source") or ""),
        min=limits.get("min"),
        max=limits.get("max"),
        unit=unit,
        computed=math.nan,
        label="",
        error_estimate=math.nan,
        margin=-math.inf,
        state=UNDECIDED,
        decided_by="a [[find]] that finds it",
        expect=expect,
        at=str(entry.get("at") or "optimum"),
    )


def _judge(result: Result, entry: Mapping[str, Any]) -> LimitRow:
    if not_found(result, entry):
        return _nothing(entry)
    quantity = asked(result, entry, "limit")
    where = dict(entry.get("where") or {})
    sides: tuple[Literal["max"], Literal["min"]] = ("max", "min")
    bounds = {
        side: read_printed(entry[side], default_unit=quantity.unit)
        for side in sides
        if entry.get(side) is not None
    }
    if not bounds:
        raise ResultError(f"a [[limit]] on {quantity.path} has neither max nor min")
    unit = next(iter(bounds.values())).unit
    limits = {side: convert(bound.number, bound.unit, unit) for side, bound in bounds.items()}
    judged = []
    for side, limit in limits.items():
        with naming("limit", entry):
            value, label = worst(quantity, where, side)
        zero = quantity.estimate.is_zero(value)
        computed = 0.0 if zero else convert(value, quantity.unit, unit)
        margin = limit - computed if side == "max" else computed - limit
        # A value that is not a number keeps no limit, whatever the side.
        judged.append((-math.inf if math.isnan(margin) else margin, computed, label, limit, zero))
    margin, computed, label, limit, zero = min(judged, key=lambda item: item[0])
    error = 0.0 if zero else convert(uncertainty(quantity, where), quantity.unit, unit)
    error = Estimate(error, 0.0)  # what is a zero has become one
    state = _STATES[int(held(margin, error, limit))]
    return LimitRow(
        quantity=str(entry["quantity"]),
        where=where,
        source=str(entry.get("source") or ""),
        min=limits.get("min"),
        max=limits.get("max"),
        unit=unit,
        computed=computed,
        label=label,
        error_estimate=error,
        margin=margin,
        state=state,
        decided_by=_decided_by(result, quantity, where) if state == UNDECIDED else "",
        expect=str(entry.get("expect") or "kept"),
        at=str(entry.get("at") or "optimum"),
    )


def _decided_by(result: Result, quantity: Quantity, where: Mapping[str, Any]) -> str:
    if curving(quantity, where) > quantity.error_estimate:
        return "more points of the curve, whose samples lie too far apart here"
    return remedy(quantity, result.case)
