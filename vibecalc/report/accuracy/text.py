"""The table of `vibecalc accuracy`: for each topic its rungs, orders, cheapest and failures."""

import math

from vibecalc.report.accuracy.view import RungView, TopicView, topics_of
from vibecalc.report.sections.closing import rerun, warnings
from vibecalc.report.tables import Column, fold, number, pairs, paragraph, table
from vibecalc.results.accuracy_layout import STATUS_WORDS, TARGETS
from vibecalc.results.record import Result

_LEGEND = (
    "Marks: * on the front between error and work, s on that between error and seconds (nothing "
    "as accurate is cheaper), < what vibecalc takes. Work and errors are the same in every run, "
    "seconds are those of this machine."
)
_NARROW = 25


def render_accuracy(result: Result) -> str:
    """The whole report of one measurement, at most 100 columns wide."""
    topics = topics_of(result)
    title = fold(f"Speed against error: {result.case.get('title') or result.name}", 98)
    lines = [*title, "=" * max(len(line) for line in title)]
    lines += pairs([("case", result.name), ("sha256 of the case", result.case_sha256)], 20)
    lines += ["", *paragraph(_LEGEND), "", *_summary(topics)]
    for topic in topics:
        lines += _section(topic)
    left_out = warnings(result)
    if left_out is not None:
        lines += _titled("Left out", left_out.lines)
    lines += _titled("Machine (changes from run to run)", _machine(result))
    return "\n".join(lines) + "\n"


def _summary(topics: tuple[TopicView, ...]) -> list[str]:
    """One row for each topic: what the default reaches and what it costs against the cheapest."""
    columns = (
        Column("stage", 15),
        Column("topic", 28),
        Column("default", _NARROW),
        number("error", 8),
        number("work x", 8),
        number("time x", 8),
    )
    rows = []
    for topic in topics:
        default = next((rung for rung in topic.rungs if rung.is_default), None)
        cells = [topic.words["stage"], topic.words["name"]]
        if default is None:
            rows.append([*cells, "-", "", "", ""])
            continue
        extra = [f"{x:.2f}" for x in (topic.extra_work, topic.extra_seconds)]
        rows.append([*cells, _name(default), _error(default.relative), *extra])
    return [
        *table(columns, rows),
        "",
        *paragraph("work x, time x: what the default takes over the cheapest that is as accurate."),
    ]


def _section(topic: TopicView) -> list[str]:
    words = topic.words
    lines = ["", f"{words['stage']}: {words['name']}"]
    lines.append("-" * len(lines[-1]))
    lines += paragraph(words["why"])
    about = [("stands for", words["quantity"])] if words["quantity"] else []
    about.append(("reference", f"{words['reference']}; agreement {_error(topic.agreement)}"))
    about.append(("work", words["work"]))
    if words["position"]:
        about.append(("position", words["position"]))
    lines += [*pairs(about, 12), "", *_rungs(topic)]
    lines += ["", *_orders(topic), "", *_cheapest(topic)]
    if topic.failed:
        lines += ["", *_failures(topic)]
    if float(words["default_extra"]) > 1.0:
        more = f"The default may take {words['default_extra']} times the least work: "
        lines += ["", *paragraph(more + words["default_why"])]
    return lines


def _rungs(topic: TopicView) -> list[str]:
    columns = [
        Column("method", _NARROW + 4),
        number("setting", 11),
        number("work", 10),
        number("seconds", 9),
        number("relative", 9),
        number("dB", 9),
    ]
    if topic.words["position"]:
        columns.append(number("position", 9))
    columns.append(Column("marks", 5))
    rows = []
    last = ""
    for rung in topic.rungs:
        cells = [rung.method if rung.method != last else "", rung.setting or "-"]
        last = rung.method
        cells += [_work(rung), _seconds(rung)]
        if rung.done:
            cells += [_error(rung.relative), _error(rung.level)]
        else:
            cells += [STATUS_WORDS[rung.status], ""]
        if topic.words["position"]:
            cells.append(_error(rung.position) if math.isfinite(rung.position) else "-")
        rows.append([*cells, _marks(rung)])
    return table(columns, rows)


def _orders(topic: TopicView) -> list[str]:
    columns = (
        Column("method", _NARROW + 4),
        Column("steps", 21),
        Column("convergence shown", 20),
        Column("theory", 24),
    )
    rows = [
        [method.name, method.setting or "nothing to set", method.shown or "-", method.theory or "-"]
        for method in topic.methods
    ]
    return table(columns, rows)


def _cheapest(topic: TopicView) -> list[str]:
    columns = (number("error", 9), Column("cheapest in work", 42), Column("in seconds", 42))
    picked = zip(TARGETS, topic.cheapest_in_work, topic.cheapest_in_seconds, strict=True)
    rows = [
        [f"{target:g}", _pick(work, by_work=True), _pick(seconds, by_work=False)]
        for target, work, seconds in picked
    ]
    return table(columns, rows)


def _pick(rung: RungView | None, by_work: bool) -> str:
    if rung is None:
        return "none reaches it"
    return f"{_name(rung)}: " + (_work(rung) if by_work else f"{_seconds(rung)} s")


def _failures(topic: TopicView) -> list[str]:
    """Each cause once, with the settings that it befell."""
    causes: dict[tuple[str, int, str], list[str]] = {}
    for rung in topic.failed:
        causes.setdefault((rung.method, rung.status, rung.cause), []).append(rung.setting)
    lines = []
    for (method, status, cause), settings in causes.items():
        at = f" at {', '.join(settings)}" if any(settings) else ""
        lines += paragraph(f"{method}{at}: {STATUS_WORDS[status]}: {cause}", "-")
    return lines


def _machine(result: Result) -> list[str]:
    found = result.provenance
    names = ("machine", "versions", "threads", "platform", "time")
    rows = [(name, str(found[name])) for name in names if name in found]
    for name, seconds in result.timings.items():
        rows.append((f"{name} s", f"{seconds:.2f}"))
    return pairs([*rows, ("rerun", rerun(result))], 44)


def _name(rung: RungView) -> str:
    return f"{rung.method}, {rung.setting}" if rung.setting else rung.method


def _marks(rung: RungView) -> str:
    marks = ((rung.in_work, "*"), (rung.in_seconds, "s"), (rung.is_default, "<"))
    return "".join(mark for there, mark in marks if there)


def _error(value: float) -> str:
    if value == 0.0:
        return "0"
    return f"{value:.1e}" if math.isfinite(value) else "unbounded"


def _work(rung: RungView) -> str:
    return f"{rung.work:.6g}" if rung.work else ""


def _seconds(rung: RungView) -> str:
    return "" if rung.seconds is None else f"{rung.seconds:.2e}"


def _titled(title: str, lines: list[str]) -> list[str]:
    return ["", title, "-" * len(title), *lines]
