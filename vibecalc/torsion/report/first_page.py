"""What comes first on a shaft line: one sentence, and its variants side by side with limits."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.core.report.pages import limit_verdict
from vibecalc.core.report.sections import Section, having, labels
from vibecalc.core.report.writing import Column, hertz, number, paragraph, rpm, show, table
from vibecalc.core.results.record import BROKEN, Quantity, Record, Result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.torsion.report.limits import (
    has_limits,
    limited_words,
    limits_of,
    ranges_in_words,
    rule_of,
    separation_rule,
)
from vibecalc.torsion.report.line import (
    MEGA,
    MILLI,
    TORSION,
    Detail,
    asked,
    elastic_modes,
    joined,
    meeting,
    mode_names,
    names,
    torque_unit,
    turns,
    vector,
)
from vibecalc.torsion.report.verdicts import AT_SPEED, PASSING, flags
from vibecalc.units import convert

#: what has another section
_APART = tuple(TORSION + name for name in ("variable_inertia/", "transient/", "as_published/"))
CONVENTIONS = (
    "Half range: (highest - lowest) / 2 of all orders over the cycle. Single orders: 0-to-peak."
)


def torsion(result: Result) -> Section | None:
    """The section, None if the result has nothing of a shaft line."""
    shown = frozenset(
        path for path in result.record if path.startswith(TORSION) and not path.startswith(_APART)
    )
    if not shown:
        return None
    lines = [*paragraph(conclusion(result)), *paragraph(CONVENTIONS)]
    columns = variants(result)
    # without a misfire the table of the speed range has the other variant, as a column
    first = any(variant.prefix == HEALTHY for variant in columns)
    lines += ["", *variant_table(result)] if first else []
    return Section(
        "Torsional vibration of the shaft line",
        lines,
        shown,
        "variants of the line",
        Detail(result, *[variant_table] * (not first), _where) if len(columns) > 1 else (),
    )


# ----------------------------------------------------------------------------
# What the table of variants is made of: its columns, its rows, a limit of the case.
# ----------------------------------------------------------------------------

HEALTHY, BARE = "healthy/", "bare/"
ANY, OPERATING = "speed range", "operating"
CLOSE = "CLOSE"
#: behind a value above a limit that is for another column
ABOVE = " !"


class Variant(NamedTuple):
    """A column: its title, its name in a row, and what its paths start with below `TORSION`."""

    title: str
    name: str
    prefix: str


class SummaryRow(NamedTuple):
    """A quantity: a text and a place for each variant by its prefix, limit and flag."""

    words: str
    unit: str
    value: dict[str, str]
    limit: str = ""
    flag: str = ""
    where: dict[str, tuple[str, str]] = {}  # noqa: RUF012


def variants(result: Result) -> list[Variant]:
    """The columns that the result has: all fire, misfire, without dampers."""
    record = result.record
    silent = asked(result).get("misfire")
    found = []
    if isinstance(silent, list | tuple) and silent:
        if any(path.startswith(TORSION + HEALTHY) for path in record):
            found.append(Variant("all\nfire", "all fire", HEALTHY))
        name = f"misfire {', '.join(map(str, silent))}"
        found.append(Variant(name.replace(" ", "\n", 1), name, ""))
        bare = Variant(f"{name},\nwithout\ndampers", "no dampers", BARE)
    else:
        found.append(Variant("all\nfire", "all fire", ""))
        bare = Variant("all fire,\nwithout\ndampers", "no dampers", BARE)
    if any(path.startswith(TORSION + BARE) for path in record):
        found.append(bare)
    return found


def section_entry(record: Record, path: str, section: str) -> float | None:
    """The entry of a section under `TORSION`, None if it has none."""
    quantity: Quantity | None = having(record, TORSION + path, "section")
    names = [] if quantity is None else labels(quantity.axes[0])
    if quantity is None or section not in names:
        return None
    return float(quantity.values[names.index(section)])


def bound_of(result: Result, path: str, factor: float) -> tuple[str, str, float]:
    """The first `[[limit]]` of the case on a whole quantity, its verdict, and its size."""
    for row in verdicts_of(result):
        whole = row.quantity == path and not row.where and row.at != "start" and not row.element
        if whole and row.max is not None:
            unit = result.record[path].unit
            bound = factor * convert(row.max, row.unit, unit)
            return show(bound, digits=4), limit_verdict(row), bound
    return "", "", np.inf


# ----------------------------------------------------------------------------
# Rows of the table of variants: frequencies, limits; the separation and the gears of the sentence.
# ----------------------------------------------------------------------------


def frequencies(result: Result, columns: list[Variant]) -> Iterator[SummaryRow]:
    record = result.record
    natural = having(record, TORSION + "modes/natural_frequency", "mode")
    modes = elastic_modes(result)
    if natural is None or not modes:
        return
    first, error = float(natural.values[modes[0]]), natural.error_estimate
    text = show(hertz(first), hertz(error), 4)
    value = {variant.prefix: text for variant in columns if variant.prefix != BARE}
    named = mode_names(result)[modes[0]]
    where = {columns[0].prefix: (named, f"{show(rpm(first), digits=4)} cpm")}
    bare = vector(record, BARE + "natural_frequency", "bare_mode")
    if bare is not None and np.any(bare > 0.0):
        lowest = int(np.flatnonzero(bare > 0.0)[0])
        value[BARE] = show(hertz(bare[lowest]), digits=4)
        where[BARE] = ("1st elastic", f"{show(rpm(bare[lowest]), digits=4)} cpm")
    yield SummaryRow("lowest natural frequency", "Hz", value, where=where)


def stress_limits(result: Result, columns: list[Variant]) -> Iterator[SummaryRow]:
    """A row for each limit: use, over the speed range and at the operating speed."""
    record, flagged = result.record, {ANY: flags(result), OPERATING: flags(result, AT_SPEED)}
    for i, limit in enumerate(limits_of(result) if has_limits(record) else ()):
        for scope, path in ((ANY, "limit/largest_use"), (OPERATING, "limit/operating_use")):
            uses = {
                variant.prefix: float(use[i])
                for variant in columns
                if (use := vector(record, variant.prefix + path, "limit")) is not None
                and i < use.size
            }
            if not uses:
                continue
            value = {
                prefix: show(100.0 * use, digits=4) + (ABOVE if prefix and use > 1.0 else "")
                for prefix, use in uses.items()
            }
            own = [
                row
                for row in verdicts_of(result)
                if scope == ANY
                and row.element
                and row.quantity == f"{TORSION}limit/each/use"
                and row.where["limit"] == i + 1
            ]
            worst = max(own, key=lambda row: row.use, default=None)
            at = f"{turns(worst.speed)} rpm" if worst else OPERATING
            yield SummaryRow(
                f"{limited_words(record, some=[i])} over limit {i + 1}, {scope}",
                "%",
                value,
                "100",
                flagged[scope][i],
                {"": (worst.element if worst else "", f"{at}: {rule_of(limit).name}")},
            )  # fmt: skip


# ----------------------------------------------------------------------------
# The table of variants, with limit and flag, and where the values are.
#
# A variant is the line with all cylinders firing, with a misfire, or without its dampers. Limits of
# a case file are for the line as the file describes it; in the other columns they are marks only.
# ----------------------------------------------------------------------------

#: words, path below `TORSION`, factor from SI, unit as shown
_LARGEST = (
    ("torque, half range", "torque_half_range", 1.0, "N m"),
    ("stress, half range", "stress_half_range", MEGA, "N/mm^2"),
    ("twist, half range", "twist_half_range", MILLI, "mrad"),
)
_DAMPERS = (
    ("heat in a damper", "damper/heat", 1.0, "W"),
    ("travel in a damper", "damper/travel", MILLI, "mrad"),
)


def _rows(result: Result) -> list[SummaryRow]:
    columns = variants(result)
    parts = (frequencies, _largest, stress_limits, _dampers)
    return [row for part in parts for row in part(result, columns)]


def variant_table(result: Result) -> list[str]:
    columns, rows = variants(result), _rows(result)
    head = [Column("quantity"), Column("unit")]
    head += [number(variant.title) for variant in columns]
    head += [number("limit"), Column("flag")]
    lines = table(head, [
        [row.words, row.unit, *(row.value.get(variant.prefix, "") for variant in columns),
         row.limit, row.flag]
        for row in rows
    ])  # fmt: skip
    if any(text.endswith(ABOVE) for row in rows for text in row.value.values()):
        lines += paragraph("!: above the limit, which the case sets for another column.")
    return lines


def _where(result: Result) -> list[str]:
    """Section and speed of the values in the table of variants."""
    columns = variants(result)
    places = [
        [row.words if first else "", variant.name, *row.where[prefix]]
        for row in _rows(result)
        for first, variant, prefix in _places(row, columns)
    ]
    head = [Column("where"), Column("variant"), Column("section or mode"),
            Column("at")]  # fmt: skip
    return table(head, places) if places else []


def _places(row: SummaryRow, columns: list[Variant]) -> Iterator[tuple[bool, Variant, str]]:
    there = [variant for variant in columns if variant.prefix in row.where]
    for place, variant in enumerate(there):
        yield place == 0, variant, variant.prefix


def _largest(result: Result, columns: list[Variant]) -> Iterator[SummaryRow]:
    """Torque, stress and twist: the worst section over the speeds, and at the operating speed."""
    record = result.record
    for words, name, factor, unit in _LARGEST:
        if name == "torque_half_range":
            factor, unit = torque_unit(record)
        for scope, path in ((ANY, f"largest/{name}"), (OPERATING, name)):
            sizes = {
                variant.prefix: top
                for variant in columns
                if (top := _top(record, variant.prefix, path, factor)) is not None
            }
            if not sizes:
                continue
            limit, flag, most = bound_of(result, TORSION + path, factor)
            value, where = {}, {}
            for prefix, (size, text, section) in sizes.items():
                value[prefix] = text + (ABOVE if prefix and size > most else "")
                at = _at_speed(result, prefix, name, section) if scope == ANY else OPERATING
                endless = ("", "undamped criticals, listed below")
                where[prefix] = (section, at) if np.isfinite(size) else endless
            yield SummaryRow(f"{words}, {scope}", unit, value, limit, flag, where)


def _top(record: Record, prefix: str, path: str, factor: float) -> tuple[float, str, str] | None:
    """Size, text and section of the largest entry; None if there is none above zero."""
    quantity = having(record, TORSION + prefix + path, "section")
    if quantity is None:
        return None
    # the twist of a damper is the travel of its ring, which has another row
    rings = set(names(record, "damper/travel", "damper"))
    named = labels(quantity.axes[0])
    counts = np.array([label not in rings for label in named])
    values = np.where(counts, np.asarray(quantity.values, dtype=float), 0.0)
    if not np.any(values > 0.0):
        return None
    place = int(np.argmax(values))
    size = factor * float(values[place])
    return size, show(size, factor * quantity.error_estimate, 4), named[place]


def _at_speed(result: Result, prefix: str, name: str, section: str) -> str:
    """Where the largest entry of a section is; the speed may be that of one quantity."""
    record = result.record
    paths = [f"{prefix}largest/{one}" for one in (name.replace("half_range", "speed"), "speed")]
    speed = next(
        (s for path in paths if (s := section_entry(record, path, section)) is not None), None
    )
    if speed is None:
        return ANY
    mode, order = (
        section_entry(record, f"{prefix}largest/{part}", section) for part in ("mode", "half_order")
    )
    met = "" if mode is None or order is None else meeting(mode_names(result), mode, order)
    return f"{turns(speed)} rpm" + (f" ({met})" if met else "")


def _dampers(result: Result, columns: list[Variant]) -> Iterator[SummaryRow]:
    record = result.record
    for words, path, factor, unit in _DAMPERS:
        value, where = {}, {}
        limit, flag, most = bound_of(result, TORSION + path, factor)
        for variant in columns:
            quantity = having(record, TORSION + variant.prefix + path, "damper")
            if quantity is None:
                continue
            sizes = factor * np.asarray(quantity.values, dtype=float)
            place = int(np.argmax(sizes))
            text = show(sizes[place], factor * quantity.error_estimate, 4)
            value[variant.prefix] = text + (ABOVE if variant.prefix and sizes[place] > most else "")
            where[variant.prefix] = (labels(quantity.axes[0])[place], OPERATING)
        if value:
            yield SummaryRow(f"{words}, {OPERATING}", unit, value, limit, flag, where)


# ----------------------------------------------------------------------------
# One sentence on a shaft line: what it keeps, where it has to be passed, what breaks a limit.
# ----------------------------------------------------------------------------


def conclusion(result: Result) -> str:
    """One sentence: what the line keeps, where it has to be passed, and what breaks a limit."""
    record = result.record
    driven = TORSION + "torque_half_range" in record
    none = "the case sets no limit of the stress" if driven else "nothing drives the line"
    clauses = list(_of_limits(result)) or [none]
    clauses += _of_gears(result)
    clauses += _of_majors(result)
    if f"{TORSION}masked/from" in record and record[f"{TORSION}masked/from"].values.size:
        clauses.append("at some critical speeds nothing damps the line")
    silent = asked(result).get("misfire")
    if isinstance(silent, list | tuple) and silent:
        clauses.append(f"all values with misfire of cylinder {joined(map(str, silent))}")
    text = "; ".join(clauses)
    return f"{text[:1].upper()}{text[1:]}."


def _of_limits(result: Result) -> Iterator[str]:
    record, words_of = result.record, flags(result)
    if not has_limits(record):
        return
    broken = [str(i + 1) for i, word in enumerate(words_of) if word == "BROKEN"]
    if broken:
        plural = "limits" if len(broken) > 1 else "limit"
        what = limited_words(record, "or", [int(one) - 1 for one in broken])
        where = [words for kind, words in _WHERE.items() if "BROKEN" in flags(result, kind)]
        yield f"the {what} exceeds {plural} {joined(broken)} {joined(where or [_NOT_BARRED])}"
    else:
        what = "limits" if len(words_of) > 1 else "limit"
        words = limited_words(record)
        verb = "are" if " " in words else "is"
        yield f"the {words} at the operating speed {verb} within the {what}"
    ranges = ranges_in_words(result)
    yield from ranges
    if not ranges and not broken and "pass only" not in words_of:
        yield "no speed range is barred"


#: where limits are broken
_WHERE = {AT_SPEED: "at the operating speed", PASSING: "even for passing through"}
_NOT_BARRED = "where the rule lets no range of speeds be barred"


def _of_majors(result: Result) -> Iterator[str]:
    """Natural frequencies that a major order meets nearly at the operating speed."""
    rule = separation_rule(result)
    for row in verdicts_of(result) if rule else ():
        if row.where.get("order_class") == "major" and row.state == BROKEN and rule:
            mode, order = row.element.removesuffix(" mode"), row.limit.rpartition(" ")[2]
            yield (
                f"the {mode} natural frequency lies {row.computed:.1f} % from major order {order} "
                f"of the operating speed, less than {rule.rule.name} asks"
            )


def _of_gears(result: Result) -> Iterator[str]:
    """Gears whose torque reverses: at the operating speed, and in which ranges."""
    low, high, gear = (
        vector(result.record, f"hammering/{name}", "hammering") for name in ("from", "to", "gear")
    )
    places: dict[str, list[str]] = {}
    named = names(result.record, "speeds/gear_hammers", "gear")
    for row in verdicts_of(result):
        if "gear" not in row.where or not row.element or row.state != BROKEN:
            continue
        found = places.setdefault(row.element, [])
        if row.limit.endswith(AT_SPEED):
            found.insert(0, "at the operating speed")
            continue
        ends = []
        if low is not None and high is not None and gear is not None:
            some = np.flatnonzero(gear == named.index(row.element) + 1)
            ends = [f"{turns(low[i])} to {turns(high[i])}" for i in some]
        found.append(f"from {joined(ends)} rpm" if ends else "from somewhere")
    for name, where in places.items():
        yield f"gear {name!r} hammers {joined(where)}"
