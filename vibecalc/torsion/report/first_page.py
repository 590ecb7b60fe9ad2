"""What comes first on a shaft line, the conclusion, and the calculation as it is handed in."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.core.report.calculation import Calculation, Chapter, limit_table
from vibecalc.core.report.headline import first_table
from vibecalc.core.report.pages import conclusion as counted
from vibecalc.core.report.pages import limit_verdict
from vibecalc.core.report.sections import Section, having, labels, read_as, stacked, table_of
from vibecalc.core.report.writing import Column, hertz, number, paragraph, rpm, show, table, turns
from vibecalc.core.results.record import BARRED, BROKEN, Result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.numerics.rounding import first_of_largest
from vibecalc.torsion.report.excitation import VARIANTS, variant_words
from vibecalc.torsion.report.gears import AT_SPEED, CONDITION_LEAST, TRANSIENT_LEAST
from vibecalc.torsion.report.limits import (
    FLAGS,
    PASSING,
    crank_places,
    flags,
    formulas,
    has_limits,
    limited_words,
    limits_of,
    rule_of,
    separation_rule,
    uses_by_section,
)
from vibecalc.torsion.report.line import (
    TORSION,
    Detail,
    elastic_modes,
    joined,
    meeting,
    mode_names,
    names,
    place_of,
    silent,
    torque_unit,
    vector,
)
from vibecalc.torsion.report.vibration import (
    all_ranges_in_words,
    barred_ranges,
    exceeded_table,
    ranges_in_words,
)
from vibecalc.torsion.study_results import COUPLING
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
    first = HEALTHY in columns
    lines += ["", *variant_table(result)] if first else []
    return Section(
        "Torsional vibration of the shaft line",
        lines,
        shown,
        "variants of the line",
        Detail(result, *[variant_table] * (not first), _where) if len(columns) > 1 else (),
    )


# ----------------------------------------------------------------------------
# The table of variants, with limit and flag, and where the values are.
#
# A variant is the line with all cylinders firing, with a misfire, or without its dampers. Limits of
# a case file are for the line as the file describes it; in the other columns they are marks only.
# ----------------------------------------------------------------------------

HEALTHY, BARE = "healthy/", "without_dampers/"
ANY, OPERATING = "speed range", "operating speed"
#: behind a value above a limit that is for another column
ABOVE = " !"
#: words, path below `TORSION` and unit as shown, that of torques where none is said
_LARGEST = (
    ("torque, half range", "torque_half_range", ""),
    ("stress, half range", "stress_half_range", "N/mm^2"),
    ("twist, half range", "twist_half_range", "mrad"),
)
_DAMPERS = (("heat", "W"), ("travel", "mrad"))


class Value(NamedTuple):
    """A cell: size in the unit shown, text, where it is, and at which speed."""

    size: float
    text: str
    place: str = ""
    at: str = ""


class SummaryRow(NamedTuple):
    """A quantity: its value in each variant by the prefix of that, limit and flag."""

    words: str
    unit: str
    value: dict[str, Value]
    bound: float = np.inf
    limit: str = ""
    flag: str = ""


def variants(result: Result) -> dict[str, tuple[str, str]]:
    """What paths of a column start with below `TORSION` -> its title, and its name in a row.

    The columns that the result has: all fire, misfire, without dampers.
    """
    ill = silent(result)
    name = f"misfire {', '.join(ill)}" if ill else "all fire"
    every = {
        **({HEALTHY: ("all\nfire", "all fire")} if ill else {}),
        "": (name.replace(" ", "\n", 1), name),
        BARE: (f"{name},\nwithout\ndampers", "no dampers"),
    }
    paths = tuple(result.record)
    return {
        prefix: words
        for prefix, words in every.items()
        if not prefix or any(path.startswith(TORSION + prefix) for path in paths)
    }


def _rows(result: Result) -> Iterator[SummaryRow]:
    yield from _frequencies(result)
    for words, path, unit in _LARGEST:
        for scope, of in ((ANY, f"largest/{path}"), (OPERATING, path)):
            yield from _load(result, f"{words}, {scope}", of, "section", unit)
    yield from _uses(result)
    for name, unit in _DAMPERS:
        yield from _load(result, f"damper {name}, {OPERATING}", f"damper/{name}", "damper", unit)


def variant_table(result: Result) -> list[str]:
    """A row for each quantity, with those above a limit of another column marked."""
    columns, rows = variants(result), list[list[str]]()
    for words, unit, value, bound, limit, flag in _rows(result):
        cells = [
            value[prefix].text + ABOVE * bool(prefix and value[prefix].size > bound)
            if prefix in value
            else ""
            for prefix in columns
        ]
        rows.append([words, unit, *cells, limit, flag])
    head = [Column("quantity"), Column("unit"), *(number(title) for title, _ in columns.values())]
    lines = table([*head, number("limit"), Column("flag")], rows)
    if any(text.endswith(ABOVE) for row in rows for text in row):
        lines += paragraph("!: above the limit, which applies to another column.")
    return lines


def _where(result: Result) -> list[str]:
    """Section and speed of the values in the table of variants."""
    columns, places = variants(result), list[list[str]]()
    for row in _rows(result):
        words = row.words
        for prefix, (_, name) in columns.items():
            if prefix in row.value and row.value[prefix].at:
                places.append([words, name, *row.value[prefix][2:]])
                words = ""
    heads = ("where", "variant", "section or mode", "at")
    return table([Column(head) for head in heads], places)


def _frequencies(result: Result) -> Iterator[SummaryRow]:
    quantity = having(result.record, TORSION + "modes/natural_frequency", "mode")
    modes, value = elastic_modes(result), dict[str, Value]()
    if quantity is None or not modes:
        return

    def cell(frequency: float, error: float, name: str) -> Value:
        at = f"{show(rpm(frequency), digits=4)} cpm" if name else ""
        return Value(frequency, show(hertz(frequency), hertz(error), 4), name, at)

    for prefix in variants(result):
        if prefix != BARE:
            name = "" if value else mode_names(result)[modes[0]]
            value[prefix] = cell(float(quantity.values[modes[0]]), quantity.error_estimate, name)
    bare = vector(result.record, BARE + "natural_frequency", "mode_without_dampers")
    if bare is not None and np.any(bare > 0.0):
        value[BARE] = cell(bare[bare > 0.0][0], 0.0, "1st elastic")
    yield SummaryRow("lowest natural frequency", "Hz", value)


def _load(result: Result, words: str, path: str, axis: str, unit: str) -> Iterator[SummaryRow]:
    """The worst section or damper in each variant, with the limit of the case."""
    record, value = result.record, dict[str, Value]()
    unit = unit or torque_unit(record)[1]
    # the twist of a damper is the travel of its ring, which has another row
    rings = [] if axis == "damper" else names(record, "damper/travel", "damper")
    for prefix in variants(result):
        quantity = having(record, TORSION + prefix + path, axis)
        if quantity is None:
            continue
        named, factor = labels(quantity.axes[0]), convert(1.0, quantity.unit, unit)
        values = np.where(np.isin(named, rings), 0.0, np.asarray(quantity.values, dtype=float))
        place = first_of_largest(values)
        size, name, at = factor * float(values[place]), named[place], OPERATING
        if size <= 0.0 and axis == "section":
            continue
        if not np.isfinite(size):
            name, at = "", "undamped critical speeds, listed below"
        elif path.startswith("largest/"):
            at = _at_speed(result, prefix, path, name)
        value[prefix] = Value(size, show(size, factor * quantity.error_estimate, 4), name, at)
    bounds = [
        row
        for row in (verdicts_of(result) if value else ())
        if row.quantity == TORSION + path and not row.where and not row.element
        if row.at != "start" and row.max is not None
    ]
    for row in bounds[:1]:
        bound = convert(row.max or 0.0, row.unit, unit)
        text = show(bound, digits=4)
        yield SummaryRow(words, unit, value, bound, text, limit_verdict(row))
    if value and not bounds:
        yield SummaryRow(words, unit, value)


def _at_speed(result: Result, prefix: str, path: str, section: str) -> str:
    """Where the largest entry of a section is; the speed may be that of one quantity."""

    def entry(path: str) -> float | None:
        quantity = having(result.record, TORSION + prefix + path, "section")
        place = place_of(quantity, section)
        return None if quantity is None or place is None else float(quantity.values[place])

    speed = entry(path.replace("half_range", "speed"))
    speed = entry("largest/speed") if speed is None else speed
    if speed is None:
        return ANY
    mode, order = entry("largest/mode"), entry("largest/order")
    met = meeting(mode_names(result), mode or 0.0, order or 0.0)
    return f"{turns(speed)} rpm" + f" ({met})" * bool(met)


def _uses(result: Result) -> Iterator[SummaryRow]:
    """A row for each limit: use, over the speed range and at the operating speed."""
    record = result.record
    for i, limit in enumerate(limits_of(result) if has_limits(record) else ()):
        own = [row for row in verdicts_of(result)
               if row.element and row.quantity == f"{TORSION}limit/each/utilisation"
               and row.where["limit"] == i + 1]  # fmt: skip
        worst, rule = max(own, key=lambda row: row.utilisation, default=None), rule_of(limit).name
        here = (worst.element, f"{turns(worst.speed)} rpm: {rule}") if worst else None
        for scope, path, place, flagged in (
            (ANY, "limit/largest_utilisation", here, flags(result)),
            (OPERATING, "limit/operating_utilisation", None, flags(result, AT_SPEED)),
        ):
            value = dict[str, Value]()
            for prefix in variants(result):
                use = vector(record, prefix + path, "limit")
                if use is not None and i < use.size:
                    share = 100.0 * float(use[i])
                    where = ("", "") if prefix else place or ("", f"{OPERATING}: {rule}")
                    value[prefix] = Value(share, show(share, digits=4), *where)
            if value:
                words = f"{limited_words(record, some=[i])} utilisation, limit {i + 1}, {scope}"
                yield SummaryRow(words, "%", value, 100.0, "100", flagged[i])


# ----------------------------------------------------------------------------
# One sentence on a shaft line: what it keeps, where it has to be passed, what breaks a limit.
# ----------------------------------------------------------------------------

#: where limits are broken
_WHERE = {AT_SPEED: "at the operating speed", PASSING: "even for passage"}
_NOT_BARRED = "where the rule permits no barred range"


def conclusion(result: Result) -> str:
    """One sentence: what the line keeps, where it has to be passed, and what breaks a limit."""
    record = result.record
    driven = TORSION + "torque_half_range" in record
    none = "the case sets no stress limit" if driven else "the line has no excitation"
    clauses = [*_of_limits(result)] or [*_of_own_limits(result)] or [none]
    clauses += [*_of_couplings(result), *_of_gears(result), *_of_majors(result)]
    if vector(record, "resonances_skipped/from", "resonance_skipped") is not None:
        clauses.append("some critical speeds are undamped")
    if ill := silent(result):
        clauses.append(f"all values with misfire of cylinder {joined(ill)}")
    text = "; ".join(clauses)
    return f"{text[:1].upper()}{text[1:]}."


def _of_limits(result: Result) -> Iterator[str]:
    record, words_of = result.record, flags(result)
    if not has_limits(record):
        return
    broken = [i for i, word in enumerate(words_of) if word == "BROKEN"]
    if broken:
        what = limited_words(record, "or", broken)
        where = [words for kind, words in _WHERE.items() if "BROKEN" in flags(result, kind)]
        listed = joined(str(i + 1) for i in broken)
        plural = "s" * (len(broken) > 1)
        yield f"the {what} exceeds limit{plural} {listed} {joined(where or [_NOT_BARRED])}"
    else:
        words = limited_words(record)
        verb, plural = "are" if " " in words else "is", "s" * (len(words_of) > 1)
        yield f"the {words} at the operating speed {verb} within the limit{plural}"
    ranges = ranges_in_words(result)
    yield from ranges
    if not ranges and not broken and FLAGS[BARRED] not in words_of:
        yield "no speed range is barred"
    for variant in VARIANTS:
        yield from ranges_in_words(result, variant)


def _of_own_limits(result: Result) -> Iterator[str]:
    """What became of each `[[limit]]` on the load of sections: stress, torque or twist."""
    told = dict.fromkeys(
        (read_as(row.quantity, row.unit)[0], limit_verdict(row))
        for row in verdicts_of(result)
        if row.quantity.startswith(TORSION) and row.quantity.endswith("_half_range")
        if not row.element
    )
    yield from (f"the limit on the {name} is {verdict}" for name, verdict in told)


def _of_majors(result: Result) -> Iterator[str]:
    """Natural frequencies that a major order meets nearly at the operating speed."""
    rule = separation_rule(result)
    for row in verdicts_of(result) if rule else ():
        if row.where.get("order_class") == "major" and row.state == BROKEN and rule:
            mode, order = row.element.removesuffix(" mode"), row.limit.rpartition(" ")[2]
            yield (
                f"the {mode} natural frequency is {row.computed:.1f} % from major order {order} "
                f"at the operating speed, less than {rule.rule.name} requires"
            )


def _of_couplings(result: Result) -> Iterator[str]:
    """Limits of couplings that the line exceeds as the case has it."""
    for row in verdicts_of(result):
        own = row.element and row.quantity.startswith(f"{TORSION}coupling/")
        if own and row.state == BROKEN:
            where = f" at {turns(row.speed)} rpm" if np.isfinite(row.speed) else ""
            yield (
                f"the {row.limit} of {row.element!r} exceeds the limit{where}: "
                f"{show(100.0 * row.utilisation)} %"
            )


def _of_gears(result: Result) -> Iterator[str]:
    """Gears whose torque reverses: at the operating speed, and in which ranges."""
    record, places = result.record, dict[str, list[str]]()
    low, high, gear = (
        vector(record, f"hammering/{name}", "hammering") for name in ("from", "to", "gear")
    )
    for row in verdicts_of(result):
        if "gear" not in row.where or not row.element or row.state != BROKEN:
            continue
        found = places.setdefault(row.element, [])
        if row.quantity == CONDITION_LEAST:
            found.append(f"at the operating speed with {row.condition}")
        elif row.limit.endswith(AT_SPEED):
            found.insert(0, "at the operating speed")
        elif row.quantity == TRANSIENT_LEAST:
            found.append("in the transient")
        elif low is None or high is None or gear is None:
            found.append("within the speed range")
        else:
            own = gear == names(record, "speeds/gear_hammers", "gear").index(row.element) + 1
            ends = [f"{turns(one)} to {turns(two)}" for one, two in zip(low[own], high[own],
                                                                       strict=True)]  # fmt: skip
            found.append(f"from {joined(ends)} rpm" if ends else "within the speed range")
    for name, where in places.items():
        yield f"gear hammer in {name!r} {joined(where)}"


def in_one_sentence(result: Result) -> str:
    """How many limits are kept, which are not, and the speed ranges that are barred."""
    rows = verdicts_of(result)
    if not rows:
        return "The case sets no limits."
    ranges = all_ranges_in_words(result)
    if not ranges and having(result.record, f"{TORSION}limit/largest_utilisation", "limit"):
        ranges = ["no speed range is barred"]
    return "; ".join([counted([], rows).rstrip("."), *ranges]) + "."


_COUPLINGS = "Coupling utilisation: T_KW corrected for frequency; temperature by its rise."


def conclusion_table(result: Result) -> list[str]:
    """The sentence, and the table of limits."""
    rows = verdicts_of(result)
    coupled = any(row.element and row.quantity.startswith(COUPLING) for row in rows)
    advice = [line for words in recommendations(result) for line in paragraph(words, "-")]
    notes = [_COUPLINGS] * coupled
    return [*paragraph(in_one_sentence(result)), *advice, *limit_table(rows, *notes)]


def recommendations(result: Result) -> Iterator[str]:
    """What follows for those who run the line, from the ranges of speeds above its limits."""
    for variant in ("", *VARIANTS):
        barred, not_ = (
            barred_ranges(result, permitted=one, variant=variant) for one in (True, False)
        )
        lead = f"With {variant_words(result, variant)}: " if variant else ""
        told = []
        if barred:
            told.append(f"bar {joined(barred)} for continuous operation and pass through quickly")
        if not_:
            told.append(f"avoid {joined(not_)}, also in passing, or reduce the load there")
        words = f"{lead}{'; '.join(told)}."
        if told:
            yield f"{words[:1].upper()}{words[1:]}"


# ----------------------------------------------------------------------------
# The chapters in their order. What a result does not have is no chapter.
# ----------------------------------------------------------------------------


def _chapter(title: str, *parts: str, details: tuple[str, ...] = ()) -> Chapter:
    """Parts that are functions of the folder of reports are named by file and function."""
    return Chapter(title, tuple(map(_named_part, parts)), tuple(map(_named_part, details)))


def _named_part(part: str) -> str:
    return f"vibecalc.torsion.report.{part}" if ":" in part and "." not in part else part


CALCULATION = Calculation(
    title="Torsional vibration calculation",
    applies=_named_part("first_page:has_calculation"),
    summary=_named_part("first_page:summary"),
    chapters=(
        _chapter("System data", "line:torsion_line", "vibecalc.torsion.pictures.modes:draw_system"),
        _chapter(
            "Natural frequencies and mode shapes",
            *("modes:torsion_modes", "modes:node_table", "torsion_shapes"),
        ),
        _chapter("Holzer tables", "modes:lowest_holzer"),
        _chapter(
            "Excitation",
            *("excitation:engine_torque", "excitation:cylinder_orders"),
            *("excitation:station_torques", "torsion_excitation"),
            details=("excitation:vector_sums", "torsion_vectors"),
        ),
        _chapter("Damping", "line:torsion_damping", "damping_over_speed"),
        _chapter(
            "Forced vibration",
            *("first_page:conventions", "vibration:torsion_steady"),
            *("vibration:torsion_speeds", "torsion_speeds"),
            *("first_page:loads_and_limits", "torsion_limits", "gear_torque"),
            *("vibration:torsion_curves", "torsion_curves", "torsion_station_curves"),
            *("couplings:torsion_couplings", "torsion_couplings", "torsion_twists"),
            *("vibration:torsion_irregularity", "cyclic_irregularity"),
            details=("torsion_orders", "station_angles", "section_stress"),
        ),
        _chapter(
            "Misfire and worst condition",
            *("first_page:misfire", "vibration:torsion_conditions", "worst_condition"),
        ),
        _chapter(
            "Barred ranges and critical speeds",
            *("first_page:barred", "excitation:torsion_excitation", "torsion_campbell"),
        ),
        _chapter(
            "Transient response",
            *("studies:torsion_transient", "torsion_transient", "torsion_waterfall"),
            *("clutch_slip", "counted_cycles"),
        ),
        _chapter("Variable inertia", "studies:torsion_variable", "torsion_variable_inertia"),
        _chapter("As published", "studies:torsion_published"),
        _chapter("Damper design", "studies:damper_design", "damper_map", "damper_response"),
        _chapter("Conclusion", "first_page:conclusion_table"),
    ),
    elsewhere=(
        _named_part("first_page:torsion"),
        _named_part("vibration:torsion_limits"),
    ),
)


def has_calculation(result: Result) -> bool:
    """Whether a case asks for the vibration of a shaft line, and has it."""
    asks = bool(table_of(result.case, "response", "torsion"))
    return asks and TORSION + "modes/natural_frequency" in result.record


def summary(result: Result) -> list[str]:
    """The sentence of the first page, and the results that are looked for first."""
    return stacked(paragraph(in_one_sentence(result)), first_table(result, verdicts_of(result)))


# ----------------------------------------------------------------------------
# What the text report has elsewhere, or not.
# ----------------------------------------------------------------------------


def conventions(result: Result) -> list[str]:
    """What a half range is."""
    driven = TORSION + "torque_half_range" in result.record
    return paragraph(CONVENTIONS) if driven else []


def loads_and_limits(result: Result) -> list[str]:
    """What each section bears and may bear, by each limit, with the formulas of the rules."""
    uses, places = uses_by_section(result), crank_places(result)
    return stacked(uses, places, formulas(result)) if uses else []


def misfire(result: Result) -> list[str]:
    """The line with all cylinders firing beside that of the case."""
    return variant_table(result) if HEALTHY in variants(result) else []


def barred(result: Result) -> list[str]:
    """The ranges of speeds that are barred, and what bars them."""
    record = result.record
    if f"{TORSION}limit/largest_utilisation" not in record:
        there = having(record, TORSION + "critical/speed", "mode", "order") is not None
        none = "no speed range is barred: no limit of the case bars one"
        words = "; ".join([*_of_own_limits(result), none])
        return paragraph(f"{words[0].upper()}{words[1:]}.") if there else []
    words = "; ".join(all_ranges_in_words(result)) or "no range is barred"
    return stacked(paragraph(f"{words[0].upper()}{words[1:]}."), exceeded_table(record))
