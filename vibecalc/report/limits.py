"""Limits of a case, judged against its result."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from vibecalc.errors import ResultError
from vibecalc.report.lookup import asked, entries, naming, not_found
from vibecalc.report.printed import read_printed
from vibecalc.results.record import Result
from vibecalc.results.select import worst
from vibecalc.units import convert


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """A bound and the worst entry it is held against; all numbers in `unit`.

    `kept` means a margin of at least minus the error estimate; `satisfied` turns that round for
    a limit that is expected to be broken. `label` names the worst entry of an array.
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
    kept: bool
    expect: str = "kept"
    at: str = "optimum"

    @property
    def satisfied(self) -> bool:
        """Whether the limit does what the case expects of it."""
        return self.kept == (self.expect == "kept")


def judge_limits(result: Result) -> list[LimitRow]:
    """Judge every `[[limit]]` of the case, in its order; of an array the worst entry counts.

    An infinite value breaks a `max` with a margin of minus infinity, and so does what a [[find]]
    was to find and did not. Numbers are in the unit of
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
        kept=expect != "kept",
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
    held = []
    for side, limit in limits.items():
        with naming("limit", entry):
            value, label = worst(quantity, where, side)
        magnitude = abs(value) if isinstance(value, complex) else value
        computed = convert(float(magnitude), quantity.unit, unit)
        margin = limit - computed if side == "max" else computed - limit
        # A value that is not a number keeps no limit, whatever the side.
        held.append((-math.inf if math.isnan(margin) else margin, computed, label))
    margin, computed, label = min(held, key=lambda item: item[0])
    error = convert(quantity.error_estimate, quantity.unit, unit)
    slack = error if math.isfinite(error) else 0.0
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
        kept=bool(margin >= -slack),
        expect=str(entry.get("expect") or "kept"),
        at=str(entry.get("at") or "optimum"),
    )
