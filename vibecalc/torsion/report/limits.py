"""Limits of the stress in a shaft line, what each section bears by them, ranges that they bar."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import Column, number, pairs, paragraph, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.torsion.report.line import MEGA, TORSION, asked, joined, short, turns, vector

if TYPE_CHECKING:
    from vibecalc.torsion.stress_limits import Rule

# ----------------------------------------------------------------------------
# Limits of the stress in a shaft line, where they come from, and the ranges that they bar.
# ----------------------------------------------------------------------------

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
    from vibecalc.torsion.stress_limits import M68, USER_TABLE

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


def remark(record: Record) -> str:
    """The sentence of the first page where a case states no limits of its own."""
    return (
        "Limits of the stress in the shaft line stand beside the results below."
        if has_limits(record)
        else ""
    )


# ----------------------------------------------------------------------------
# What each section of a shaft line bears, and may bear, by each limit of the stress.
# ----------------------------------------------------------------------------

_LIMIT = TORSION + "limit/"
_BASIS = (("diameter", "diameter\nmm", 1e3), ("tensile_strength", "sigma_B\nN/mm^2", MEGA),
          ("counted_strength", "as counted\nN/mm^2", MEGA), ("design_factor", "c_K", 1.0),
          ("size_factor", "c_D", 1.0))  # fmt: skip


def torsion_allowed(result: Result) -> list[str]:
    """Lines of both tables, none where the result does not have them."""
    lines: list[str] = []
    for block in (_basis(result.record), _uses(result)):
        lines += ["", *block] if lines and block else block
    return lines


def _matrix(record: Record, name: str) -> np.ndarray | None:
    quantity = having(record, _LIMIT + name, "limit", "section")
    return None if quantity is None else np.asarray(quantity.values, dtype=float)


def _sections(record: Record) -> list[str]:
    quantity = having(record, _LIMIT + "operating/use", "limit", "section") or having(
        record, _LIMIT + "each/use", "limit", "section"
    )
    return [] if quantity is None else labels(quantity.axes[1])


def _held(record: Record) -> np.ndarray | None:
    """Which sections a limit is for: those with a diameter in its basis."""
    wide = _matrix(record, "basis/diameter")
    return None if wide is None else wide > 0.0


def _basis(record: Record) -> list[str]:
    """Diameter, strength and factors behind the rule of each section."""
    held, rated = _held(record), vector(record, "limit/basis/rated_speed", "limit")
    if held is None or rated is None:
        return []
    parts = [_matrix(record, f"basis/{name}") for name, _, _ in _BASIS]
    named = _sections(record)
    columns = [number("limit", 5), Column("section", 20)]
    columns += [number(title, 10) for _, title, _ in _BASIS]
    columns += [number("rated speed\nrpm", 11)]
    rows = []
    for i, j in np.argwhere(held):
        if not rated[i] or j >= len(named):
            continue
        cells = [
            "" if part is None or not part[i, j] else short(factor * part[i, j])
            for part, (_, _, factor) in zip(parts, _BASIS, strict=True)
        ]
        rows.append([str(i + 1), named[j], *cells, turns(rated[i])])
    if not rows:
        return []
    words = (
        "Allowed stress by the rule: tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2), for "
        "lambda of 0.9 and more 1.38 in place of the bracket; tau_T = 1.7 tau_C / sqrt(c_K) for "
        "passing through; c_D = 0.35 + 0.93 d^-0.2; lambda: speed over the rated one, for which "
        "the operating speed is taken. Stresses in N/mm^2, d in mm."
    )
    return [*paragraph(words), *table(columns, rows)]


def _uses(result: Result) -> list[str]:
    """Stress, what is allowed, and use of each section: where the use is largest, and operating."""
    record = result.record
    held, named = _held(record), _sections(record)
    if held is None or not named:
        return []
    rated = vector(record, "limit/basis/rated_speed", "limit")
    running = speed_of(result)
    columns = [number("limit", 5), Column("section", 20), Column("", 9), number("rpm", 8),
               number("lambda", 6), number("stress", 8), number("lasting\nallowed", 8),
               number("passing\nallowed", 8), number("use\n%", 7),
               number("passing\nuse, %", 8)]  # fmt: skip
    rows = []
    for i, j in np.argwhere(held):
        if j >= len(named):
            continue
        for way, words in (("each", "any speed"), ("operating", "operating")):
            use = _matrix(record, f"{way}/use")
            if use is None:
                continue
            at = _matrix(record, "each/speed") if way == "each" else None
            speed = float(at[i, j]) if at is not None else running
            ratio = speed / rated[i] if speed and rated is not None and rated[i] else 0.0
            stress, allowed, passing = (
                _matrix(record, f"{way}/{name}") for name in ("stress", "allowed", "transient")
            )
            over = _matrix(record, "each/transient_use") if way == "each" else None
            rows.append([
                str(i + 1), named[j], words, turns(speed) if speed and use[i, j] else "",
                f"{ratio:.3f}" if ratio and use[i, j] else "", _stress(stress, i, j, "no bound"),
                _stress(allowed, i, j), _stress(passing, i, j), _percent(use[i, j]),
                _percent(over[i, j]) if over is not None and over[i, j] else "",
            ])  # fmt: skip
    words = (
        "Half range of the stress in each section, and what is allowed for lasting operation and "
        "for passing through, in N/mm^2. Use: over what is allowed for lasting, at the speed of "
        "largest use and at the operating one; passing use: the largest over what is allowed for "
        "passing, at any speed. -: the limit says nothing."
    )
    return [*paragraph(words), *table(columns, rows)] if rows else []


def _percent(use: float) -> str:
    return show(100.0 * use, digits=4) if np.isfinite(use) else "above"


def _stress(values: np.ndarray | None, i: int, j: int, endless: str = "-") -> str:
    if values is None:
        return ""
    value = float(values[i, j])
    if not np.isfinite(value):
        return endless
    return show(MEGA * value, digits=4) if value else "-"
