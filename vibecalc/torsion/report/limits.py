"""Limits of stress and torque in a shaft line, what it bears by them, ranges that they bar."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import Section, having, labels, speed_of, stacked
from vibecalc.core.report.writing import Column, number, pairs, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    TORSION,
    Detail,
    asked,
    every,
    joined,
    short,
    turns,
    vector,
)
from vibecalc.units import convert

if TYPE_CHECKING:
    from vibecalc.torsion.stress_limits import Rule
    from vibecalc.torsion.stress_limits import Separation as SeparationRule

# ----------------------------------------------------------------------------
# Limits of stress and torque in a shaft line, where they come from, the ranges that they bar.
# ----------------------------------------------------------------------------

_LIMIT = TORSION + "limit/"


def torsion_limits(result: Result) -> Section | None:
    """The section, None if the case has no limit of stress or torque."""
    record = result.record
    if not {f"{_LIMIT}largest_use", f"{_LIMIT}operating_use"} & set(record):
        return None
    lines = stacked(uses_by_section(result), crank_places(result), exceeded_table(record))
    return Section(
        f"Limits of the {limited_words(record)} and barred ranges",
        lines,
        frozenset(),
        "rules of the limits",
        Detail(result, formulas, basis, origins),
    )


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
    """The ranges above the limits, and which of them may be barred."""
    above = (
        f"Speed ranges in which the {limited_words(record, 'or')} exceeds what is allowed for "
        "lasting operation:"
    )
    return rows_of(record, Rows("exceeded", "", _EXCEEDED, TORSION + "exceeded", above=above))[0]


def _turns(speed: float, _error: float) -> str:
    return turns(speed) if speed else ""


def _number(value: float, _error: float) -> str:
    return str(int(value)) if value else ""


_EXCEEDED = (
    Cells("from", "from\nrpm", _turns, right=True),
    Cells("to", "to\nrpm", _turns),
    Cells("limit", "limit", _number),
    Cells("peak_speed", "worst at\nrpm", _turns),
    Cells("formula_from", "by formula\nfrom, rpm", _turns),
    Cells("formula_to", "to\nrpm", _turns),
    Cells("permitted", "barring it", lambda may, _: "may be done" if may else "NOT ALLOWED"),
)


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
    count = vector(record, "limit/operating_use", "limit")
    return np.zeros(0 if count is None else count.size, bool)


def limited_words(record: Record, between: str = "and", some: Collection[int] | None = None) -> str:
    """What limits are of: `stress`, `torque` or both; of `some`, counted from 0, or all."""
    kinds = of_torque(record)
    chosen = kinds if some is None else kinds[[one for one in some if one < kinds.size]]
    if not np.any(chosen):
        return "stress"
    return "torque" if np.all(chosen) else f"stress {between} torque"


def limits_of(result: Result) -> list[Mapping[str, Any]]:
    """`response.torsion.limits` of the case."""
    return list(asked(result).get("limits") or ())


def origins(result: Result) -> list[str]:
    """What each limit is: rule, edition, sections, scope."""
    return stacked(*(pairs(_origin(i, limit)) for i, limit in enumerate(limits_of(result), 1)))


def _origin(place: int, limit: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    rule, kind, share = rule_of(limit), limit.get("rule"), limit.get("alternating_share")
    yield f"limit {place}", f"{rule.name}, {rule.edition} ({rule.status})"
    sections, gears = (", ".join(map(str, limit.get(key) or ())) for key in ("sections", "gears"))
    if sections or not (gears or share):
        of = "throw" if kind == "iacs_m53" else "section modulus"
        yield "  sections", sections or f"all with a {of}"
    if gears or share:
        yield "  gears", gears or "all"
    if share:
        yield "  alternating share", f"{float(share):g}"
    elif not kind:
        yield "  scope", "set by the case, within the speeds of its table"
        return
    yield from (("  scope", rule.scope), ("  not for", rule.not_for), ("  measure", rule.measure))
    if strength := limit.get("tensile_strength"):
        yield "  tensile strength", f"{show(1e-6 * float(strength), digits=4)} N/mm^2"
    if kind == "iacs_m53":
        yield "  crankshaft", str(limit.get("crankshaft_kind") or "free_form")
    elif limit.get("shaft_kind"):
        yield "  shaft", str(limit["shaft_kind"])
    elif kind:
        yield "  design factor c_K", f"{float(limit.get('design_factor') or 1.0):g}"


def has_limits(record: Record) -> bool:
    """Whether stress or torque of the line is held against a limit."""
    return f"{TORSION}limit/largest_use" in record


# ----------------------------------------------------------------------------
# What each section and gear of a shaft line bears, and may bear, by each limit.
# ----------------------------------------------------------------------------


def formulas(result: Result) -> list[str]:
    """What the rules of the case allow and bar."""
    rules = {limit.get("rule") for limit in limits_of(result)}
    return [line for rule, words in _FORMULAS if rule in rules for line in paragraph(words)]


_FORMULAS = (
    (
        "iacs_m53",
        "Allowed stress of a crank pin by UR M53: the nominal torsional stress with which the "
        "fatigue strength sigma_DW is 1.15 of the equivalent stress sigma_v at its worst "
        "place. Fillets: sigma_v^2 = (sigma_B + sigma_add)^2 + 3 tau^2; oil bore: sigma_v = "
        "sigma_B / 3 (1 + 2 sqrt(1 + 9/4 (sigma_T / sigma_B)^2)); each stress with its "
        "concentration factor. Bending stresses are given by the case.",
    ),
    (
        "iacs_m68",
        "Allowed stress by the rule: tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2), for "
        "lambda of 0.9 and more 1.38 in place of the bracket; tau_T = 1.7 tau_C / sqrt(c_K) for "
        "passing through; c_D = 0.35 + 0.93 d^-0.2; lambda: speed over the rated one, for which "
        "the operating speed is taken. Stresses in N/mm^2, d in mm. It bars the range 16 n / (18 - "
        "lambda) to (18 - lambda) n / 16 about the speed n of largest use, and what exceeds its "
        "limit beyond that; a table of the case bars what exceeds it.",
    ),
)

#: path below the limits, title, unit, and what writes a value in that unit, "" or "-" for none
_Column = tuple[str, str, str, Callable[[float], str]]


def _plain(value: float) -> str:
    return short(value) if value else ""


def _known(value: float) -> str:
    return short(value) if value else "-"


def _speed(value: float) -> str:
    return turns(value) if value else "-"


def _use(value: float) -> str:
    """In percent; `above` what is held against no finite number."""
    text = show(100.0 * value, digits=4) if np.isfinite(value) else "above"
    return text if value else "-"


def _load(value: float) -> str:
    return show(value, digits=4) if value and np.isfinite(value) else "-"


def _endless(value: float) -> str:
    """A load, which a damping of nothing lets grow without end."""
    return _load(value) if np.isfinite(value) else "no bound"


def _by_limit(
    record: Record, of: Quantity, there: np.ndarray, columns: Iterable[_Column]
) -> list[str]:
    """A row for each entry of a quantity over limits, sections (and places) that is `there`."""
    axes = [axis.name for axis in of.axes]
    named, rows = [labels(axis) for axis in of.axes[1:]], list[list[str]]()
    known = [
        (having(record, _LIMIT + path, *axes) or having(record, _LIMIT + path, "limit"), unit, how)
        for path, _, unit, how in columns
    ]
    for i, *place in np.argwhere(there).tolist():
        row = [str(i + 1), *(own[j] for own, j in zip(named, place, strict=True))]
        for one, unit, write in known:
            factor = convert(1.0, one.unit, unit) if one is not None and unit else 1.0
            at = (i, *place)[: one.values.ndim] if one is not None else ()
            row.append("" if one is None else write(factor * float(one.values[at])))
        rows.append(row)
    heads = [number("limit"), *(Column(name.rpartition("_")[2]) for name in axes[1:])]
    return table([*heads, *(number(title) for _, title, *_ in columns)], rows)


def _held(record: Record) -> tuple[Quantity, np.ndarray] | None:
    """Which sections a limit is for: a diameter in its basis, or a torque that it allows."""
    parts = [
        one
        for name in ("basis/diameter", "operating/torque_allowed")
        if (one := having(record, _LIMIT + name, "limit", "section")) is not None
    ]
    return (parts[0], np.any([one.values > 0.0 for one in parts], axis=0)) if parts else None


_BASIS: tuple[_Column, ...] = (
    ("basis/diameter", "diameter\nmm", "mm", _plain),
    ("basis/tensile_strength", "sigma_B\nN/mm^2", "N/mm^2", _plain),
    ("basis/counted_strength", "as counted\nN/mm^2", "N/mm^2", _plain),
    ("basis/design_factor", "c_K", "", _plain),
    ("basis/size_factor", "c_D", "", _plain),
    ("basis/rated_speed", "rated speed\nrpm", "", turns),
)


def basis(result: Result) -> list[str]:
    """Diameter, strength and factors behind the rule of each section."""
    record = result.record
    factor = having(record, f"{_LIMIT}basis/design_factor", "limit", "section")
    held, rated = _held(record), vector(record, "limit/basis/rated_speed", "limit")
    if held is None or rated is None or factor is None:
        return []
    return _by_limit(record, held[0], held[1] & (factor.values > 0.0) & (rated[:, None] > 0.0),
                     _BASIS)  # fmt: skip


def uses_by_section(result: Result) -> list[str]:
    """Stress, what is allowed, and use of each section: where the use is largest, and operating.

    Then the same of torques.
    """
    record, given = result.record, limits_of(result)
    held, torques = _held(record), of_torque(record)
    blocks = []
    for name, prefix, unit in (("stress", "", "N/mm^2"), ("torque", "torque_", "N*m")):
        chosen = torques == (name == "torque")
        columns: tuple[_Column, ...] = (
            ("each/speed", "worst at\nrpm", "", _speed),
            (f"each/{name}", name, unit, _endless),
            (f"each/{prefix}allowed", "allowed\nlasting", unit, _load),
            ("each/use", "use\n%", "", _use),
            (f"each/{prefix}transient", "allowed\npassing", unit, _load),
            ("each/transient_use", "use\n%", "", _use),
            (f"operating/{name}", f"operating\n{name}", unit, _load),
            (f"operating/{prefix}allowed", "allowed\nlasting", unit, _load),
            ("operating/use", "use\n%", "", _use),
        )
        there = held[1] & chosen[:, None] if held else np.zeros((0, 0), bool)
        if held is None or not there.any():
            continue
        some = np.flatnonzero(there.any(axis=1)).tolist()
        listed = "; ".join(f"{i + 1}: {rule_of(given[i]).name}" for i in some)
        words = f"Half ranges of the {name} in {unit}. Limit {listed}."
        if any(given[i].get("rule") for i in some):
            words += " A rule is informative here: the society's current text counts."
        blocks.append([*_by_limit(record, held[0], there, columns), *paragraph(words)])
    return stacked(*blocks)


_CRANK: tuple[_Column, ...] = (
    ("crank/bending_factor", "factor in\nbending", "", _known),
    ("crank/torsion_factor", "factor in\ntorsion", "", _known),
    ("crank/bending_stress", "bending\nN/mm^2", "N/mm^2", _known),
    ("crank/fatigue_strength", "sigma_DW\nN/mm^2", "N/mm^2", _known),
    ("crank/acceptability", "worst\nQ", "", _known),
    ("crank/operating_acceptability", "operating\nQ", "", _known),
)


def crank_places(result: Result) -> list[str]:
    """Acceptability of each place of the throws that the rule for crankshafts is held against."""
    record = result.record
    for strength in every(record, "limit/crank", "limit section crank_place", "fatigue_strength"):
        words = "Crankshafts by IACS UR M53: Q = sigma_DW / sigma_v is to be 1.15 at least."
        lines = _by_limit(record, strength, strength.values > 0.0, _CRANK)
        return [*paragraph(words), *lines]
    return []
