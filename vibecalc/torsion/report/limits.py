"""Limits of stress and torque in a shaft line, what it bears by them, ranges that they bar."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import Column, number, pairs, paragraph, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.torsion.report.line import (
    MEGA,
    TORSION,
    Detail,
    asked,
    joined,
    short,
    turns,
    vector,
)

if TYPE_CHECKING:
    from vibecalc.torsion.stress_limits import Rule
    from vibecalc.torsion.stress_limits import Separation as SeparationRule

# ----------------------------------------------------------------------------
# Limits of stress and torque in a shaft line, where they come from, the ranges that they bar.
# ----------------------------------------------------------------------------


def torsion_limits(result: Result) -> Section | None:
    """The section, None if the case has no limit of stress or torque."""
    if not {f"{_LIMIT}largest_use", f"{_LIMIT}operating_use"} & set(result.record):
        return None
    lines = uses_by_section(result)
    crank, barred = crank_places(result), exceeded_table(result.record)
    for more in (crank, barred):
        lines += ["", *more] if lines and more else more
    return Section(
        f"Limits of the {limited_words(result.record)} and barred ranges",
        lines,
        frozenset(),
        "rules of the limits",
        Detail(result, formulas, basis, origins),
    )


class ExceededRow(NamedTuple):
    """A range in rad/s above a limit (from 1), whether its rule permits to bar it, that range."""

    low: float
    high: float
    limit: int
    permitted: bool
    peak: float
    formula: tuple[float, float]


def exceeded_rows(record: Record) -> list[ExceededRow]:
    """The ranges above the limits."""
    names = ("from", "to", "limit", "permitted", "peak_speed", "formula_from", "formula_to")
    columns = [vector(record, f"exceeded/{name}", "exceeded") for name in names]
    there = [one for one in columns if one is not None]
    return [
        ExceededRow(low, high, int(limit), bool(permitted), peak, (start, stop))
        for low, high, limit, permitted, peak, start, stop in zip(*there, strict=True)
    ] if len(there) == len(names) else []  # fmt: skip


def barred_ranges(result: Result, *, permitted: bool = True) -> list[str]:
    """Each range to be barred as words, `44.37 to 53.78 rpm`, or each that may not be."""
    low, high, may = (
        vector(result.record, f"barred/{name}", "barred") for name in ("from", "to", "permitted")
    )
    if low is None or high is None:
        return []
    may = np.ones(len(low)) if may is None else may
    inside = (low <= (at := speed_of(result) or 0.0)) & (at <= high)  # as an older file may not say
    chosen = np.flatnonzero(((may > 0.0) & ~inside) == permitted)
    return [f"{turns(low[i])} to {turns(high[i])} rpm" for i in chosen]


def acceptable(record: Record, place: int) -> str:
    """What stands behind a range in the first table that may not be barred."""
    may = vector(record, "barred/permitted", "barred")
    return "" if may is None or may[place] else "NOT ACCEPTABLE: it may not be barred"


def ranges_in_words(result: Result) -> list[str]:
    """What is barred, and where the line is not acceptable."""
    barred, not_ = (barred_ranges(result, permitted=one) for one in (True, False))
    words = []
    if barred:
        verb = "are" if len(barred) > 1 else "is"
        words.append(f"{joined(barred)} {verb} barred for lasting operation")
    if not_:
        why = "a limit for lasting operation is exceeded and no range may be barred"
        words.append(f"the line is not acceptable from {joined(not_)}, where {why}")
    return words


def exceeded_table(record: Record) -> list[str]:
    exceeded = exceeded_rows(record)
    if not exceeded:
        return []
    columns = [number("from\nrpm"), number("to\nrpm"), number("limit"),
               number("worst at\nrpm"), number("by formula\nfrom, rpm"),
               number("to\nrpm"), Column("barring it")]  # fmt: skip
    rows = [
        [turns(one.low), turns(one.high), str(one.limit) if one.limit else "",
         turns(one.peak) if one.peak else "", *(turns(end) if end else "" for end in one.formula),
         "may be done" if one.permitted else "NOT ALLOWED"]
        for one in exceeded
    ]  # fmt: skip
    words = (
        f"Speed ranges in which the {limited_words(record, 'or')} exceeds what is allowed for "
        "lasting operation:"
    )
    return [*paragraph(words), *table(columns, rows)]


def rule_of(limit: Mapping[str, Any]) -> "Rule":
    """The rule of a limit of the case, with edition and scope."""
    from vibecalc.torsion.stress_limits import ALTERNATING_SHARE, M53, M68, TORQUE_TABLE, USER_TABLE

    for key, rule in (("alternating_share", ALTERNATING_SHARE), ("torque", TORQUE_TABLE)):
        if limit.get(key):
            return rule
    return {"iacs_m68": M68, "iacs_m53": M53}.get(str(limit.get("rule")), USER_TABLE)


def separation_rule(result: Result) -> "SeparationRule | None":
    """The rule for the margins that the case names."""
    from vibecalc.torsion.stress_limits import SEPARATIONS

    return SEPARATIONS.get(str(asked(result).get("separation") or ""))


def of_torque(record: Record) -> np.ndarray:
    """Which limits are of the torque, by what they allow at the operating speed or over speeds."""
    for path, axis in (("operating/torque_allowed", "section"), ("torque_allowed", "speed")):
        found = having(record, _LIMIT + path, "limit", axis)
        if found is not None:
            values = np.asarray(found.values, dtype=float)
            there = values > 0.0 if axis == "section" else np.isfinite(values)
            return np.asarray(np.any(there, axis=1))
    every = vector(record, "limit/operating_use", "limit")
    return np.zeros(0 if every is None else every.size, bool)


def limited_words(record: Record, between: str = "and", some: Collection[int] | None = None) -> str:
    """What limits are of: `stress`, `torque` or both; of `some`, counted from 0, or all."""
    kinds = of_torque(record)
    chosen = kinds if some is None else kinds[[one for one in some if one < kinds.size]]
    if not np.any(chosen):
        return "stress"
    return "torque" if np.all(chosen) else f"stress {between} torque"


def limits_of(result: Result) -> list[Mapping[str, Any]]:
    """`response.torsion.limits` of the case."""
    limits: Any = asked(result).get("limits") or ()
    return list(limits)


def origins(result: Result) -> list[str]:
    """What each limit is: rule, edition, sections, scope."""
    blocks = [pairs(_origin(place, limit)) for place, limit in enumerate(limits_of(result))]
    return [line for block in blocks for line in ([""] * (block is not blocks[0]) + block)]


def _origin(place: int, limit: Mapping[str, Any]) -> list[tuple[str, str]]:
    rule = rule_of(limit)
    rows = [(f"limit {place + 1}", f"{rule.name}, {rule.edition} ({rule.status})")]
    named: dict[str, str] = {
        key: ", ".join(map(str, limit.get(key) or ())) for key in ("sections", "gears")
    }
    if named["sections"] or not (named["gears"] or limit.get("alternating_share")):
        every = "all with a throw" if rule.name == "IACS UR M53" else "all with a section modulus"
        rows.append(("  sections", named["sections"] or every))
    if named["gears"] or limit.get("alternating_share"):
        rows.append(("  gears", named["gears"] or "all"))
    if limit.get("alternating_share"):
        rows.append(("  alternating share", f"{float(limit['alternating_share']):g}"))
    elif not limit.get("rule"):
        return [*rows, ("  scope", "set by the case, within the speeds of its table")]
    rows += [("  scope", rule.scope), ("  not for", rule.not_for), ("  measure", rule.measure)]
    strength = limit.get("tensile_strength")
    if strength:
        rows.append(("  tensile strength", f"{show(1e-6 * float(strength), digits=4)} N/mm^2"))
    if limit.get("rule") == "iacs_m53":
        rows.append(("  crankshaft", str(limit.get("crankshaft_kind") or "free_form")))
    elif limit.get("shaft_kind"):
        rows.append(("  shaft", str(limit["shaft_kind"])))
    elif limit.get("rule"):
        rows.append(("  design factor c_K", f"{float(limit.get('design_factor') or 1.0):g}"))
    return rows


def has_limits(record: Record) -> bool:
    """Whether stress or torque of the line is held against a limit."""
    return f"{TORSION}limit/largest_use" in record


# ----------------------------------------------------------------------------
# What each section and gear of a shaft line bears, and may bear, by each limit.
# ----------------------------------------------------------------------------

_LIMIT = TORSION + "limit/"
#: what a damping of nothing lets grow without end
ENDLESS = ("each/stress", "each/torque")
_BASIS = (("diameter", "diameter\nmm", 1e3), ("tensile_strength", "sigma_B\nN/mm^2", MEGA),
          ("counted_strength", "as counted\nN/mm^2", MEGA), ("design_factor", "c_K", 1.0),
          ("size_factor", "c_D", 1.0))  # fmt: skip


def by_section(record: Record, name: str) -> np.ndarray | None:
    quantity = having(record, _LIMIT + name, "limit", "section")
    return None if quantity is None else np.asarray(quantity.values, dtype=float)


def limited_sections(record: Record) -> list[str]:
    quantity = having(record, _LIMIT + "operating/use", "limit", "section") or having(
        record, _LIMIT + "each/use", "limit", "section"
    )
    return [] if quantity is None else labels(quantity.axes[1])


def held_sections(record: Record) -> np.ndarray | None:
    """Which sections a limit is for: a diameter in its basis, or a torque that it allows."""
    parts = [by_section(record, name) for name in ("basis/diameter", "operating/torque_allowed")]
    found = [part > 0.0 for part in parts if part is not None]
    return np.any(found, axis=0) if found else None


def formulas(result: Result) -> list[str]:
    """What the rules of the case allow and bar."""
    rules = {limit.get("rule") for limit in limits_of(result)}
    lines = []
    if "iacs_m53" in rules:
        lines = paragraph(
            "Allowed stress of a crank pin by UR M53: the nominal torsional stress with which the "
            "fatigue strength sigma_DW is 1.15 of the equivalent stress sigma_v at its worst "
            "place. Fillets: sigma_v^2 = (sigma_B + sigma_add)^2 + 3 tau^2; oil bore: sigma_v = "
            "sigma_B / 3 (1 + 2 sqrt(1 + 9/4 (sigma_T / sigma_B)^2)); each stress with its "
            "concentration factor. Bending stresses are given by the case."
        )
    return lines + _formula_of_shafts() if "iacs_m68" in rules else lines


def _formula_of_shafts() -> list[str]:
    return paragraph(
        "Allowed stress by the rule: tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2), for "
        "lambda of 0.9 and more 1.38 in place of the bracket; tau_T = 1.7 tau_C / sqrt(c_K) for "
        "passing through; c_D = 0.35 + 0.93 d^-0.2; lambda: speed over the rated one, for which "
        "the operating speed is taken. Stresses in N/mm^2, d in mm. It bars the range 16 n / (18 - "
        "lambda) to (18 - lambda) n / 16 about the speed n of largest use, and what exceeds its "
        "limit beyond that; a table of the case bars what exceeds it."
    )


def basis(result: Result) -> list[str]:
    """Diameter, strength and factors behind the rule of each section."""
    record = result.record
    held, rated = held_sections(record), vector(record, "limit/basis/rated_speed", "limit")
    if held is None or rated is None:
        return []
    parts = [by_section(record, f"basis/{name}") for name, _, _ in _BASIS]
    named = limited_sections(record)
    columns = [number("limit"), Column("section")]
    columns += [number(title) for _, title, _ in _BASIS]
    columns += [number("rated speed\nrpm")]
    rows = []
    for i, j in np.argwhere(held):
        if not rated[i] or j >= len(named) or not _filled(parts[3], i, j):
            continue
        cells = [
            "" if part is None or not part[i, j] else short(factor * part[i, j])
            for part, (_, _, factor) in zip(parts, _BASIS, strict=True)
        ]
        rows.append([str(i + 1), named[j], *cells, turns(rated[i])])
    return table(columns, rows) if rows else []


def _filled(part: np.ndarray | None, i: int, j: int) -> bool:
    return part is not None and bool(part[i, j])


#: quantity -> what its results begin with, unit, factor from SI
_QUANTITIES = (("stress", "", "N/mm^2", MEGA), ("torque", "torque_", "N m", 1.0))


def uses_by_section(result: Result) -> list[str]:
    """Stress, what is allowed, and use of each section: where the use is largest, and operating.

    Then the same of torques.
    """
    record = result.record
    held, named = held_sections(record), limited_sections(record)
    if held is None or not named:
        return []
    given, torques = limits_of(result), of_torque(record)
    lines: list[str] = []
    for quantity, prefix, unit, factor in _QUANTITIES:
        columns = [number("limit"), Column("section")]
        columns += [number(title) for title, width in (
            ("worst at\nrpm", 8), (quantity, 7), ("allowed\nlasting", 7), ("use\n%", 7),
            ("allowed\npassing", 7), ("use\n%", 7), (f"operating\n{quantity}", 9),
            ("allowed\nlasting", 7), ("use\n%", 7))]  # fmt: skip
        parts = {
            name: by_section(record, name)
            for name in ("each/speed", f"each/{quantity}", f"each/{prefix}allowed", "each/use",
                         f"each/{prefix}transient", "each/transient_use", f"operating/{quantity}",
                         f"operating/{prefix}allowed", "operating/use")
        }  # fmt: skip
        rows, some = [], []
        for i, j in np.argwhere(held):
            if j < len(named) and torques[i] == (quantity == "torque"):
                cells = [_use(name, part, i, j, factor) for name, part in parts.items()]
                rows.append([str(i + 1), named[j], *cells])
                some.append(i)
        if not rows:
            continue
        listed = "; ".join(
            f"{i + 1}: {rule_of(limit).name}" for i, limit in enumerate(given) if i in some
        )
        words = f"Half ranges of the {quantity} in {unit}. Limit {listed}."
        if any(given[i].get("rule") for i in some if i < len(given)):
            words += " A rule is informative here: the society's current text counts."
        lines += [*([""] if lines else []), *table(columns, rows), *paragraph(words)]
    return lines


def crank_places(result: Result) -> list[str]:
    """Acceptability of each place of the throws that the rule for crankshafts is held against."""
    record = result.record

    def part(name: str) -> np.ndarray | None:
        found = having(record, f"{_LIMIT}crank/{name}", "limit", "section", "crank_place")
        return None if found is None else np.asarray(found.values, dtype=float)

    strength, named = part("fatigue_strength"), limited_sections(record)
    if strength is None:
        return []
    places = labels(record[f"{_LIMIT}crank/fatigue_strength"].axes[2])
    columns = [number("limit"), Column("section"), Column("place")]
    columns += [number(title) for title, width in (
        ("factor in\nbending", 9), ("factor in\ntorsion", 9), ("bending\nN/mm^2", 8),
        ("sigma_DW\nN/mm^2", 8), ("worst\nQ", 7), ("operating\nQ", 9))]  # fmt: skip
    parts = [(part("bending_factor"), 1.0), (part("torsion_factor"), 1.0),
             (part("bending_stress"), MEGA), (strength, MEGA), (part("acceptability"), 1.0),
             (part("operating_acceptability"), 1.0)]  # fmt: skip
    rows = []
    for i, j, k in np.argwhere(strength > 0.0):
        cells = ["-" if one is None or not one[i, j, k] else short(factor * one[i, j, k])
                 for one, factor in parts]  # fmt: skip
        rows.append([str(i + 1), named[j], places[k], *cells])
    words = "Crankshafts by IACS UR M53: Q = sigma_DW / sigma_v is to be 1.15 at least."
    return [*paragraph(words), *table(columns, rows)]


def _use(name: str, part: np.ndarray | None, i: int, j: int, factor: float) -> str:
    """A cell of the table of uses; `-` where the limit does not apply."""
    if part is None:
        return ""
    value = float(part[i, j])
    if name == "each/speed":
        return turns(value) if value else "-"
    if name.endswith("use"):
        return _percent(value) if value else "-"
    return _load(factor * part, i, j, "no bound" if name in ENDLESS else "-")


def _percent(use: float) -> str:
    return show(100.0 * use, digits=4) if np.isfinite(use) else "above"


def _load(values: np.ndarray, i: int, j: int, endless: str) -> str:
    value = float(values[i, j])
    if not np.isfinite(value):
        return endless
    return show(value, digits=4) if value else "-"
