"""Limits of the stress in a shaft line, where they come from, and the ranges that they bar."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.report.numbers import show
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_allowed import torsion_allowed
from vibecalc.report.sections.torsion_terms import TORSION, asked, joined, turns, vector
from vibecalc.report.tables import Column, number, pairs, paragraph, table
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from vibecalc.hardware.shaft_rules import Rule

KEPT, PASSING, BROKEN = "kept", "pass only", "BROKEN"


def torsion_limits(result: Result) -> Section | None:
    """The section, None if the case has no limit of the stress."""
    use = vector(result.record, "limit/largest_use", "limit")
    if use is None:
        use = vector(result.record, "limit/operating_use", "limit")
    if use is None:
        return None
    blocks = [torsion_allowed(result), _barred(result.record)]
    blocks += [pairs(_origin(result, place), 22) for place in range(use.size)]
    lines: list[str] = []
    for block in blocks:
        lines += ["", *block] if lines and block else block
    return Section("Limits of the stress and barred ranges", lines, frozenset())


def verdicts(record: Record) -> list[str]:
    """`kept`, `pass only` (a barred range is due) or `BROKEN`, for each limit of the stress.

    Broken is what exceeds the transient stress anywhere, or the lasting one at the operating speed,
    or where the rule lets no range of speeds be barred.
    """
    use, here, passing = (
        vector(record, f"limit/{name}_use", "limit")
        for name in ("largest", "operating", "transient")
    )
    if use is None:
        return []
    forbidden = {limit for _, _, limit, allowed, *_ in exceeded_rows(record) if not allowed}
    words = []
    for i, largest in enumerate(use):
        broken = (here is not None and here[i] > 1.0) or (passing is not None and passing[i] > 1.0)
        broken = broken or i + 1 in forbidden
        words.append(BROKEN if broken else PASSING if largest > 1.0 else KEPT)
    return words


class Exceeded(NamedTuple):
    """A range in rad/s above a limit (from 1), whether its rule permits to bar it, that range."""

    low: float
    high: float
    limit: int
    permitted: bool
    peak: float
    formula: tuple[float, float]


def exceeded_rows(record: Record) -> list[Exceeded]:
    """The ranges above the limits; what a record does not tell of them is 0, or permitted."""
    low, high, limit, allowed, peak, start, stop = (
        vector(record, f"exceeded/{name}", "exceeded")
        for name in ("from", "to", "limit", "permitted", "peak_speed", "formula_from", "formula_to")
    )
    if low is None or high is None:
        return []
    none, every = np.zeros(low.size), np.ones(low.size)
    parts = [low, high, *(none if one is None else one for one in (limit, peak, start, stop))]
    permitted = every if allowed is None else allowed
    return [
        Exceeded(a, b, int(n), bool(permitted[i]), at, (f, t))
        for i, (a, b, n, at, f, t) in enumerate(zip(*parts, strict=True))
    ]


def barred_ranges(record: Record) -> list[str]:
    """Each barred range as words: `44.37 to 53.78 rpm`."""
    low, high = (vector(record, f"barred/{name}", "barred") for name in ("from", "to"))
    if low is None or high is None:
        return []
    return [f"{turns(a)} to {turns(b)} rpm" for a, b in zip(low, high, strict=True)]


def _barred(record: Record) -> list[str]:
    found = exceeded_rows(record)
    if not found:
        what = "no stress exceeds what is allowed for lasting operation"
        return paragraph(f"No range of speeds is barred: {what}.") if _over(record) else []
    columns = [number("exceeded\nfrom, rpm", 10), number("to, rpm", 10), Column("limit", 8),
               number("largest use at\nrpm", 14), number("by the rule\'s formula\nfrom, rpm", 20),
               number("to, rpm", 10), Column("barring it", 12)]  # fmt: skip
    rows = [
        [turns(one.low), turns(one.high), str(one.limit) if one.limit else "",
         turns(one.peak) if one.peak else "", *(turns(end) if end else "-" for end in one.formula),
         "may be done" if one.permitted else "NOT ALLOWED"]
        for one in found
    ]  # fmt: skip
    ends = barred_ranges(record)
    barred = f"Barred for lasting operation, to be passed quickly: {joined(ends)}. " if ends else ""
    words = (
        f"{barred}A rule bars the range of its formula, 16 n / (18 - lambda) to (18 - lambda) n / "
        "16 about the speed n of largest use, and what exceeds its limit beyond that; a table of "
        "the case bars what exceeds it. Below: the computed ranges in which the stress exceeds "
        "what is allowed for lasting operation."
    )
    return [*paragraph(words), *table(columns, rows)]


def _over(record: Record) -> bool:
    """Whether stresses were held against the limits over a range of speeds."""
    return f"{TORSION}limit/largest_use" in record


def rule_of(limit: Mapping[str, Any]) -> "Rule":
    """The rule of a limit of the case, with edition and scope."""
    from vibecalc.hardware.shaft_rules import M68, USER_TABLE

    return M68 if limit.get("rule") == "iacs_m68" else USER_TABLE


def limits_of(result: Result) -> list[Mapping[str, Any]]:
    """`response.torsion.limits` of the case."""
    found: Any = asked(result).get("limits") or ()
    return list(found)


def _origin(result: Result, place: int) -> list[tuple[str, str]]:
    given = limits_of(result)
    if place >= len(given):
        return []
    limit = given[place]
    rule = rule_of(limit)
    rows = [(f"limit {place + 1}", f"{rule.name}, {rule.edition} ({rule.status})")]
    sections: Any = limit.get("sections") or ()
    rows.append(("  sections", ", ".join(map(str, sections)) or "all with a section modulus"))
    if limit.get("rule"):
        rows += [("  scope", rule.scope), ("  not for", rule.not_for), ("  measure", rule.measure)]
        strength = limit.get("tensile_strength")
        if strength:
            rows.append(("  tensile strength", f"{show(1e-6 * float(strength))} N/mm^2"))
        rows.append(("  design factor c_K", show(float(limit.get("design_factor") or 1.0))))
    else:
        rows.append(("  scope", "set by the case, within the speeds of its table"))
        rows.append(("  measure", "half range of the synthesis of all orders, plain section"))
    return rows


def has_limits(record: Record) -> bool:
    """Whether the stress of the line is held against a limit."""
    return f"{TORSION}limit/largest_use" in record
