"""The conclusion of a calculation of a shaft line: a line for each limit that was computed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.pages import limit_verdict
from vibecalc.core.report.sections import having, labels, read_as, speed_of
from vibecalc.core.report.verdicts import judge_limits
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.core.results.select import held
from vibecalc.torsion.coupling_results import COUPLING, HEALTHY
from vibecalc.torsion.report.couplings import BORNE, ICE, LIMIT_WORDS, borne_at_speed, permitted
from vibecalc.torsion.report.first_page import separation_rule
from vibecalc.torsion.report.limits import (
    barred_ranges,
    by_section,
    exceeded_rows,
    held_sections,
    limited_sections,
    limits_of,
    of_torque,
    rule_of,
)
from vibecalc.torsion.report.line import (
    MEGA,
    TORSION,
    asked,
    joined,
    line_of,
    mode_names,
    order_text,
    short,
    speed_range,
    torque_unit,
    turns,
    vector,
)

if TYPE_CHECKING:
    from vibecalc.torsion.couplings import Coupling
    from vibecalc.torsion.stress_limits import Rule

KEPT, BARRED, BROKEN, UNDECIDED = "kept", "kept but where barred", "BROKEN", "UNDECIDED"
_OF_STATE = {1: KEPT, 0: UNDECIDED, -1: BROKEN}


class ConclusionRow(NamedTuple):
    """A limit on an element: what is allowed and computed, use (nan: none), rpm, verdict.

    `status`: informative, or whose limit it is, the case's or the maker's; `path` is the result
    that decides.
    """

    element: str
    limit: str
    rule: str
    status: str
    allowed: str
    computed: str
    unit: str
    use: float
    at: str
    verdict: str
    path: str


def conclusion_rows(result: Result) -> list[ConclusionRow]:
    """Every limit of a result that was computed: by rules, of the makers, and of the case.

    What holds at all speeds of the range has no line of its own for the operating speed within it.
    """
    parts = (_by_rules, _of_conditions, _of_couplings, _of_gears, _separated, _of_case)
    return [row for part in parts for row in part(result)]


def in_one_sentence(result: Result) -> str:
    """How many limits are kept, which are not, and the speed ranges that are barred."""
    rows = conclusion_rows(result)
    if not rows:
        return "The case sets no limit, so none is judged."
    kept = [row for row in rows if row.verdict in (KEPT, BARRED)]
    expected = [row for row in rows if row.verdict.endswith("as expected")]
    if len(kept) == len(rows):
        words = "The one limit is kept" if len(rows) == 1 else f"All {len(rows)} limits are kept"
    else:
        words = f"{len(kept)} of {len(rows)} limits are kept"
    apart = sum(row.verdict == BARRED for row in rows)
    words += f", {apart} of them by barring a speed range" if apart else ""
    for verdict, verb in ((BROKEN, "broken"), (UNDECIDED, "undecided")):
        some = [row for row in rows if row.verdict.startswith(verdict)]
        if some:
            listed = "; ".join(map(_in_words, some))
            words += f"; {len(some)} {'is' if len(some) == 1 else 'are'} {verb}: {listed}"
    if expected:
        verb = "is" if len(expected) == 1 else "are"
        words += f"; {len(expected)} {verb} broken, as the case expects"
    barred = barred_ranges(result.record)
    if barred:
        what = "range is" if len(barred) == 1 else "ranges are"
        words += f"; {len(barred)} speed {what} barred for continuous running: {joined(barred)}"
    elif having(result.record, f"{TORSION}limit/largest_use", "limit"):
        words += "; no speed range is barred"
    silent = asked(result).get("misfire")
    if isinstance(silent, list | tuple) and silent:
        words += f". All values with misfire of cylinder {joined(map(str, silent))}"
        words += ", where no other condition is named"
    return words + "."


def conclusion_table(result: Result) -> list[str]:
    """The sentence, and the table of limits."""
    rows = conclusion_rows(result)
    columns = [Column("element", 12), Column("limit", 16), Column("rule", 14), Column("status", 11),
               number("allowed", 7), number("computed", 8), Column("unit", 6), number("use\n%", 5),
               number("at\nrpm", 4), Column("verdict", 6)]  # fmt: skip
    cells = [
        [one.element, one.limit, one.rule, one.status, one.allowed, one.computed, one.unit,
         show(100.0 * one.use, digits=4) if np.isfinite(one.use) else "", one.at, one.verdict]
        for one in rows
    ]  # fmt: skip
    words = ""
    if any(row.verdict == BARRED for row in rows):
        words += "Kept but where barred: exceeded only in speed ranges that the rule lets be barred"
        words += " for continuous running, and not at the operating speed. "
    if any(row.verdict == UNDECIDED and row.element.startswith("limit ") for row in rows):
        words += "Undecided in a condition: no ranges to bar are looked for in it. "
    if any(row.status == "informative" for row in rows):
        words += "Informative: the society's or the standard's current text counts. "
    if any(row.path.startswith(COUPLING) and row.status != "case" for row in rows):
        words += "Use of a coupling: T_KW counts by its frequency, a temperature by its rise."
    return [*paragraph(in_one_sentence(result)), *(table(columns, cells) if rows else []),
            *(paragraph(words.strip()) if words else [])]  # fmt: skip


def _in_words(row: ConclusionRow) -> str:
    use = f" ({short(100.0 * row.use)} %)" if np.isfinite(row.use) else ""
    return f"{row.element}, {row.limit}{use}" + (f" at {row.at} rpm" if row.at else "")


def _state(use: float, quantity: Quantity) -> str:
    """Of a use, with its error."""
    return _OF_STATE[int(held(1.0 - use, quantity.error_estimate, 1.0))]


def _covered(result: Result, verdict: str | None) -> bool:
    """Whether the operating speed lies in a range of speeds over which a limit is kept."""
    low, high = speed_range(result)
    speed = speed_of(result)
    return verdict == KEPT and speed is not None and low <= speed <= high


def _operating(result: Result) -> str:
    speed = speed_of(result)
    return "" if speed is None else turns(speed)


# ----------------------------------------------------------------------------
# Limits of stress and torque by rules and tables.
# ----------------------------------------------------------------------------


def _by_rules(result: Result) -> Iterator[ConclusionRow]:
    """Continuous running over the range and at the operating speed, passing through."""
    record = result.record
    applies, named = held_sections(record), limited_sections(record)
    if applies is None or not named:
        return
    torques, given = of_torque(record), limits_of(result)
    for i, j in np.argwhere(applies):
        rule = rule_of(given[i])
        of = "torque" if torques[i] else "stress"
        prefix = "torque_" if torques[i] else ""
        factor, unit = torque_unit(record) if torques[i] else (MEGA, "N/mm^2")
        first = (named[j], *_named(i, rule, given[i]))
        found = None
        for kind, use, load, allowed in (
            ("continuous", "each/use", f"each/{of}", f"each/{prefix}allowed"),
            ("passing through", "each/transient_use", f"each/{of}", f"each/{prefix}transient"),
            ("operating speed", "operating/use", f"operating/{of}",
             f"operating/{prefix}allowed"),
        ):  # fmt: skip
            uses = by_section(record, use)
            if uses is None or not uses[i, j] > 0.0:
                continue
            here = use.startswith("operating")
            verdict = _state(uses[i, j], record[f"{TORSION}limit/{use}"])
            if here and _covered(result, found):
                continue
            if use == "each/use":
                found = verdict = _barred(record, int(i), int(j), verdict)
            loads = (by_section(record, load), by_section(record, allowed))
            sizes = [None if one is None else float(one[i, j]) for one in loads]
            at = _operating(result) if here else _where(record, int(i), int(j))
            cells = _pair(sizes, uses[i, j], factor, unit)
            at = at if cells[1] else ""
            yield ConclusionRow(
                first[0], f"{of}, {kind}", first[1], first[2], *cells, float(uses[i, j]), at,
                verdict, f"{TORSION}limit/{use}",
            )  # fmt: skip


def _named(place: int, rule: "Rule", limit: Mapping[str, Any]) -> tuple[str, str]:
    """Number and rule with its edition, and whether it is informative or the case's own."""
    words = f"{place + 1}: {rule.name}"
    return (f"{words}, {rule.edition}", rule.status) if limit.get("rule") else (words, "case")


def _where(record: Record, i: int, j: int) -> str:
    speed = by_section(record, "each/speed")
    return "" if speed is None or not speed[i, j] else turns(float(speed[i, j]))


def _pair(
    sizes: Sequence[float | None], use: float, factor: float, unit: str
) -> tuple[str, str, str]:
    """What is allowed and computed with the unit, where these belong to the use; else blank."""
    load, allowed = sizes
    if load is None or allowed is None or not np.isfinite(allowed) or not allowed > 0.0:
        return "", "", ""
    if np.isfinite(use) and abs(load / allowed - use) > 1e-6 * use:
        return "", "", ""
    return show(factor * allowed, digits=4), show(factor * load, digits=4), unit


def _barred(record: Record, i: int, j: int, verdict: str) -> str:
    """The verdict on continuous running: exceeded only where a range may be barred is kept."""
    here = by_section(record, "operating/use")
    ranges = [one for one in exceeded_rows(record) if one.limit == i + 1]
    may = bool(ranges) and all(one.permitted for one in ranges)
    at_speed = here is not None and here[i, j] > 1.0
    return BARRED if verdict == BROKEN and may and not at_speed else verdict


def _of_conditions(result: Result) -> Iterator[ConclusionRow]:
    """The largest use of each limit with all cylinders firing, and in the worst condition.

    What exceeds a limit for continuous running is undecided: it may be in a range to be barred.
    """
    record, given = result.record, limits_of(result)
    for stem in ("healthy", "conditions"):
        found = None
        for name, here in (("largest_use", False), ("operating_use", True)):
            path = f"{TORSION}{stem}/limit/{name}"
            quantity = record.quantities.get(path)
            if quantity is None or (here and _covered(result, found)):
                continue
            values = np.asarray(quantity.values, dtype=float)
            axes = [axis.name for axis in quantity.axes]
            words = labels(quantity.axes[0]) if axes[0] == "condition" else ["all cylinders fire"]
            rows = values if axes[0] == "condition" else values[None]
            speed = record.quantities.get(f"{TORSION}{stem}/limit/speed")
            verdicts = []
            for i in range(rows.shape[1]):
                worst = int(np.argmax(rows[:, i]))
                at = _operating(result) if here else ""
                if speed is not None and not here and speed.values.ndim == 2:
                    at = turns(float(speed.values[worst, i]))
                verdicts.append(_state(rows[worst, i], quantity))
                if not here and verdicts[-1] == BROKEN:
                    verdicts[-1] = UNDECIDED  # no ranges to bar were looked for in it
                rule = rule_of(given[i])
                kind = "operating speed" if here else "continuous"
                which = words[worst] + f", worst of {len(words)}" * (len(words) > 1)
                yield ConclusionRow(
                    f"limit {i + 1}, its worst element", f"{kind}; {which}",
                    *_named(i, rule, given[i]), "", "", "", float(rows[worst, i]), at,
                    verdicts[-1], path,
                )  # fmt: skip
            found = KEPT if all(one == KEPT for one in verdicts) else BROKEN


# ----------------------------------------------------------------------------
# Couplings, gears, distance from orders, limits of the case.
# ----------------------------------------------------------------------------


def _of_couplings(result: Result) -> Iterator[ConclusionRow]:
    """What the maker permits, over the speeds and at the operating one."""
    from vibecalc.torsion.couplings import LIMITS, has_limit

    record, line = result.record, line_of(result)
    if line is None:
        return
    for place, one in enumerate(line.couplings):
        said = dict(zip(LIMITS, has_limit(one), strict=True))
        for stem, condition in ((COUPLING, ""), (HEALTHY, "; all cylinders fire")):
            use = having(record, f"{stem}/use", "coupling", "coupling_limit")
            if use is None:
                continue
            largest = having(record, f"{stem}/largest_use", "coupling", "coupling_limit")
            at = having(record, f"{stem}/largest_use_speed", "coupling", "coupling_limit")
            for k, name in enumerate(labels(use.axes[1])):
                if not said[name]:
                    continue
                words = LIMIT_WORDS[name]
                if words.startswith(" "):  # another reading of the line above it
                    words = f"{LIMIT_WORDS['T_KW']}, by orders"
                allowed, _, unit = permitted(one, name).partition(" ")
                verdict = None
                for quantity, path in ((largest, "largest_use"), (use, "use")):
                    if quantity is None or (quantity is use and _covered(result, verdict)):
                        continue
                    share = float(quantity.values[place, k])
                    verdict = _state(share, quantity)
                    here = quantity is use
                    speed = None if here or at is None else float(at.values[place, k])
                    borne = ""
                    if not condition:
                        borne = (borne_at_speed(result, name, place) if here
                                 else _borne_at(result, one, name, speed))  # fmt: skip
                    yield ConclusionRow(
                        one.name, words + condition, one.type or "values of the case",
                        "maker" if one.type else "case", allowed, borne.partition(" ")[0], unit,
                        share, _operating(result) if speed is None else turns(speed), verdict,
                        f"{stem}/{path}",
                    )  # fmt: skip


def _borne_at(result: Result, one: "Coupling", name: str, speed: float | None) -> str:
    """What a coupling bears at a speed of the range, blank between the speeds of the curve."""
    if speed is not None and name == "n_max":
        return turns(abs(one.ratio) * speed)
    found = having(result.record, f"{COUPLING}/speeds/{BORNE[name]}", "coupling", "speed")
    if found is None or speed is None:
        return ""
    speeds = np.asarray(found.axes[1].values, dtype=float)
    at = int(np.argmin(np.abs(speeds - speed)))
    if abs(speeds[at] - speed) > 1e-9 * speed:
        return ""
    value = float(found.values[labels(found.axes[0]).index(one.name), at])
    if name == "temperature":
        return show(value - ICE, digits=4)
    return show(value if name == "P_KV" else 1e-3 * value, digits=4)


def _of_gears(result: Result) -> Iterator[ConclusionRow]:
    """No reversal of the torque of teeth: over the speeds, and at the operating one."""
    record = result.record
    factor, unit = torque_unit(record)
    hammers = having(record, TORSION + "gear/hammers", "gear")
    loud = having(record, TORSION + "speeds/gear_hammers", "gear", "speed")
    least = having(record, TORSION + "speeds/gear_minimum_torque", "gear", "speed")
    here = vector(record, "gear/minimum_torque", "gear")
    known = hammers or loud
    for place, name in enumerate(labels(known.axes[0]) if known else []):
        verdict = None
        rule = ("sign of the torque of the teeth", "informative", "min 0")
        if loud is not None:
            verdict = BROKEN if np.any(loud.values[place]) else KEPT
            lowest, at = "", ""
            if least is not None:
                k = int(np.argmin(least.values[place]))
                lowest = show(factor * float(least.values[place, k]), digits=4)
                at = turns(float(least.axes[1].values[k]))
            words = "no reversal of the torque, any speed"
            yield ConclusionRow(name, words, *rule, lowest, unit, np.nan, at, verdict, loud.path)
        if hammers is not None and not _covered(result, verdict):
            lowest = "" if here is None else show(factor * here[place], digits=4)
            verdict = BROKEN if hammers.values[place] else KEPT
            words = "no reversal of the torque, operating speed"
            yield ConclusionRow(
                name, words, *rule, lowest, unit, np.nan, _operating(result), verdict, hammers.path
            )


def _separated(result: Result) -> Iterator[ConclusionRow]:
    """Distance of the natural frequencies from orders of the operating speed, by a rule."""
    record, rule = result.record, separation_rule(result)
    stem = f"{TORSION}separation/operating"
    margin, order, enough = (
        having(record, f"{stem}/{name}", "mode", "order_class")
        for name in ("margin", "half_order", "sufficient")
    )
    if rule is None or margin is None or order is None or enough is None:
        return
    named = mode_names(result)
    for i, k in np.argwhere(np.isfinite(margin.values) & (np.asarray(order.values) > 0.0)):
        required = rule.margin.get(float(order.values[i, k]), 0.0)
        if not required:
            continue
        yield ConclusionRow(
            f"{named[i]} mode", f"distance from order {order_text(order.values[i, k])}",
            f"{rule.rule.name}, {rule.rule.edition}", rule.rule.status,
            f"min {100.0 * required:g}", show(100.0 * float(margin.values[i, k]), digits=3), "%",
            np.nan, _operating(result),
            KEPT if enough.values[i, k] else BROKEN, f"{stem}/sufficient",
        )  # fmt: skip


def _of_case(result: Result) -> Iterator[ConclusionRow]:
    """Each `[[limit]]` of the case, with the verdict of the report."""
    for row in judge_limits(result):
        sides = (("min", row.min), ("max", row.max))
        bounds = [f"{side} {short(bound)}" for side, bound in sides if bound is not None]
        picks = ", ".join(f"{axis.replace('_', ' ')} {one}" for axis, one in row.where.items())
        at_start = " (start)" if row.at == "start" else ""
        share = row.computed / row.max if row.max and np.isfinite(row.computed) else np.nan
        yield ConclusionRow(
            row.place.strip() or picks or "line", read_as(row.quantity, row.unit)[0] + at_start,
            row.source or "limit of the case", "case", ", ".join(bounds),
            show(row.computed, row.error_estimate), row.unit, share, "",
            limit_verdict(row), row.quantity,
        )  # fmt: skip
