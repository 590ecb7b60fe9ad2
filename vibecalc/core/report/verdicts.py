"""Published and measured numbers of a case, held against its result; what is missed, in words."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from vibecalc.core.report.sections import read_as
from vibecalc.core.report.writing import DIGITS, show
from vibecalc.core.results.printed import read_printed, tolerance_of
from vibecalc.core.results.record import KEPT, TURN, UNDECIDED, Estimate, Result, Verdict
from vibecalc.core.results.select import scalar, select
from vibecalc.core.results.tolerance import UNRESOLVED, circle_of
from vibecalc.core.results.verdicts import asked, entries, name_of, naming, not_found, verdicts_of
from vibecalc.numerics.rounding import EPSILON
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Published and measured numbers of a case, held against its result.
# ----------------------------------------------------------------------------

WITHIN = "within"
OUTSIDE = "outside"
KNOWN = "known difference"
MEASURED = "measured"

#: Comparing at the very edge of a tolerance must not hang on the last bit of a subtraction.
_ROUND_OFF = 4.0 * EPSILON


class ReferenceRow(NamedTuple):
    """A published or measured number next to ours; all numbers in `unit`, the one printed.

    `difference` is computed less printed, of a phase the shortest way round (`cyclic`); the
    relative one is that over the printed number.
    `agrees` is the bare comparison, `within` the counted one: None for a row that is shown only.
    `printed` is the value as the case writes it. A computed value that its error exceeds is not
    `resolved`, and agrees only if that error is within the tolerance.
    """

    quantity: str
    where: Mapping[str, int | float | str]
    source: str
    value: float
    printed: str
    computed: float
    unit: str
    error_estimate: float
    resolved: bool
    tolerance: float
    difference: float
    relative_difference: float | None
    agrees: bool
    within: bool | None
    verdict: str
    kind: str
    known_difference: str = ""
    shown_by: str = ""
    at: str = "optimum"
    cyclic: bool = False


def judge_references(result: Result) -> list[ReferenceRow]:
    """Judge every `[[reference]]` of the case, in its order.

    A complex quantity counts by its magnitude. The tolerance is `atol`, else `rtol` times the
    printed value, else half a unit of the last printed digit, a whole one where the source cut
    its digits off. What a [[find]] was to find and did not is undefined, outside every tolerance.
    Phases agree whatever whole turns they differ by. At a speed between two samples of a curve the
    computed number lies on the straight line between these, and its error says what that is off.

    Raises
    ------
    ResultError
        A row names a quantity or an entry that the result does not have.
    """
    return [_judge_reference(result, entry) for entry in entries(result, "reference")]


def counted_misses(result: Result) -> int:
    """How many counted references and limits the result misses; `verify` exits 1 on any."""
    return len(misses(judge_references(result), verdicts_of(result)))


def misses(references: Sequence[ReferenceRow], limits: Sequence[Verdict]) -> list[str]:
    """One line of words for each counted reference outside its tolerance and each missed limit."""
    problems = [
        f"{name_of(row.quantity, row.where)}: published {row.value:.10g} {row.unit}".rstrip()
        + f", {_computed(row.computed, 10)}"
        + ("" if row.resolved else f" +-{row.error_estimate:.3g}, unresolved")
        + f", tolerance {row.tolerance:.2g} ({row.source})"
        for row in references
        if row.within is False
    ]
    for limit in (as_read(row) for row in limits if not row.satisfied):
        where = f" at {label_of(limit)}" * bool(limit.label)
        where = f" ({limit.borne})" if limit.borne else where
        expected = f"was expected to be {limit.expect}, " * (limit.expect != KEPT)
        left = f"margin {limit.margin:.3g}"
        left += f" +-{limit.error_estimate:.3g}" * (limit.state == UNDECIDED)
        value = f"{_computed(limit.computed, 6, '')} {limit.unit}".rstrip()
        name = name_of(limit.quantity, limit.where)
        problems.append(f"limit on {name} {expected}is {limit.state}{where}: {value}, {left}")
    return problems


_CIRCULAR = re.compile(r"\b(\w+)=(\S+) rad/s")
_SPEED = re.compile(r"\b\w*speed=(\S+ rpm)")


def label_of(row: Verdict) -> str:
    """The worst entry by its axes: `mount=1, speed=300 rpm`; other frequencies in Hz."""
    return _CIRCULAR.sub(_turning, row.label)


def place_of(row: Verdict) -> str:
    """The worst entry in words, a speed in rpm."""
    words = re.sub(r"(\w+)=([^,]*)", _named_entry, _SPEED.sub(r"at \1", label_of(row)))
    return words.replace(", at ", " at ")


def _turning(found: re.Match[str]) -> str:
    axis, value = found[1], float(found[2])
    unit = "rpm" if axis.endswith("speed") else "Hz"
    return f"{axis}={show(convert(value, 'rad/s', unit))} {unit}"


def _named_entry(found: re.Match[str]) -> str:
    return entry_in_words(found[1], found[2])


def entry_in_words(axis: str, entry: str) -> str:
    """`mount 1`; an entry that says what it is of stands alone: `elastic coupling`."""
    name = axis.replace("_", " ")
    return entry if name in entry.split() else f"{name} {entry}"


def with_unit(limit: Verdict, unit: str) -> Verdict:
    """The limit with its bounds and numbers in another unit."""
    factor = convert(1.0, limit.unit, unit)
    low, high = (None if one is None else factor * one for one in (limit.min, limit.max))
    return limit._replace(
        unit=unit, computed=factor * limit.computed, margin=factor * limit.margin,
        error_estimate=limit.error_estimate * factor, min=low, max=high,
    )  # fmt: skip


def as_read(row: Verdict) -> Verdict:
    """The limit in the unit that reports have for speeds, rpm, and for frequencies, Hz."""
    if row.unit != "rad/s":
        return row
    return with_unit(row, read_as(row.quantity, row.unit)[1])


def bounds_of(row: Verdict, factor: float = 1.0) -> list[str]:
    """The bounds of a limit times a factor: `max 400`."""
    sides = {"min": row.min, "max": row.max}
    return [f"{side} {factor * bound:.6g}"
            for side, bound in sides.items() if bound is not None]  # fmt: skip


def in_percent(utilisation: float, digits: int = DIGITS) -> str:
    """The utilisation of a limit in percent, `-` of one that has none."""
    return show(100.0 * utilisation, digits=digits) if math.isfinite(utilisation) else "-"


def _computed(value: float, digits: int, lead: str = "computed ") -> str:
    return "nothing found" if math.isnan(value) else f"{lead}{value:.{digits}g}"


def _judge_reference(result: Result, entry: Mapping[str, Any]) -> ReferenceRow:
    where, unit = dict(entry.get("where") or {}), str(entry.get("unit") or "")
    if not_found(result, entry):
        printed, cyclic, resolved = read_printed(entry["value"], unit), False, True
        computed = error = math.nan
    else:
        quantity = asked(result, entry, "reference")
        printed = read_printed(entry["value"], unit, quantity.unit)
        with naming("reference", entry):
            size = abs(picked) if isinstance(picked := scalar(quantity, where), complex) else picked
        found = select(quantity, where)
        off = float(found.errors.max()) + found.curving
        computed, error = (convert(float(one), quantity.unit, printed.unit) for one in (size, off))
        resolved = not Estimate(off, quantity.estimate.terms).unresolved(abs(size))
        cyclic = circle_of(quantity) == TURN
    tolerance, difference = tolerance_of(entry, printed), computed - printed.number
    slack = _ROUND_OFF * max(abs(printed.number), abs(computed)) if math.isfinite(computed) else 0.0
    if cyclic and math.isfinite(difference):
        difference = math.remainder(difference, convert(2.0 * math.pi, "rad", printed.unit))
    # what a wide error happens to hold agrees with nothing
    agrees = bool(abs(difference) <= tolerance + slack) and (resolved or error <= tolerance)
    told = {key: str(entry.get(key) or "") for key in ("source", "known_difference", "shown_by")}
    kind = str(entry.get("kind") or "published")
    counted = kind == "published" and not told["known_difference"]
    relative = difference / abs(printed.number) if printed.number else None
    verdict = WITHIN if agrees else UNRESOLVED if not resolved else OUTSIDE
    if not counted:
        verdict = MEASURED if kind == "measured" else KNOWN
    return ReferenceRow(
        quantity=str(entry["quantity"]),
        where=where,
        value=printed.number,
        printed=printed.text,
        computed=computed,
        unit=printed.unit,
        error_estimate=error,
        resolved=resolved,
        tolerance=tolerance,
        difference=difference,
        relative_difference=relative if math.isfinite(computed) else None,
        agrees=agrees,
        within=agrees if counted else None,
        verdict=verdict,
        kind=kind,
        **told,
        at=str(entry.get("at") or "optimum"),
        cyclic=cyclic,
    )
