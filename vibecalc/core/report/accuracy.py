"""The report of `vibecalc accuracy`: topics with their levels, orders, cheapest and failures."""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.pages import rerun, warnings
from vibecalc.core.report.writing import (
    Column,
    heading,
    number,
    pairs,
    paragraph,
    table,
    text_of,
    titled,
)
from vibecalc.core.results.layout import (
    ALGEBRAIC,
    BETWEEN,
    GEOMETRIC,
    MEASURED,
    TARGETS,
    TRIAL_DONE,
    TRIAL_FAILED,
    TRIAL_STATUS_WORDS,
)
from vibecalc.core.results.record import Result
from vibecalc.core.results.trials import cheapest, extra, on_front
from vibecalc.errors import ResultError
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# A result of `vibecalc accuracy` as its report reads it: topics with their levels.
# ----------------------------------------------------------------------------


class TrialView(NamedTuple):
    """One method at one setting; `setting` is empty where there is nothing to set.

    `seconds` is None where the level was not run; errors are infinite where it was not measured,
    and `position` also where the method gives none.
    """

    method: str
    setting: str
    status: int
    cause: str
    work: float
    seconds: float | None
    relative: float
    level: float
    position: float
    is_default: bool
    in_work: bool
    in_seconds: bool

    @property
    def done(self) -> bool:
        """Whether it has an error."""
        return self.status == TRIAL_DONE


class MethodView(NamedTuple):
    """A method: what it is, what it steps, the order it shows, empty if none, and the theory."""

    name: str
    words: str
    setting: str
    shown: str
    theory: str


class TopicView(NamedTuple):
    """A topic. `extra_...`: of the default over the least as accurate, in work and seconds."""

    folder: str
    words: dict[str, str]
    agreement: float
    trials: tuple[TrialView, ...]
    methods: tuple[MethodView, ...]
    extra_work: float
    extra_seconds: float

    def of(self, method: str) -> list[TrialView]:
        """The levels of one method, from coarse to fine."""
        return [trial for trial in self.trials if trial.method == method]

    def cheapest(self, target: float, by_work: bool) -> TrialView | None:
        """The trial with the least work, or the fastest, of an error of at most `target`."""
        error = [max(trial.relative, 0.0) for trial in self.trials]
        cost = [trial.work if by_work else trial.seconds or 0.0 for trial in self.trials]
        place = cheapest(error, cost, target)
        return None if place is None else self.trials[place]

    @property
    def default(self) -> TrialView | None:
        """What vibecalc takes."""
        return next((trial for trial in self.trials if trial.is_default), None)

    @property
    def noise(self) -> float:
        """The error below which trials are not told apart."""
        return max(self.agreement, 64.0 * EPSILON)

    @property
    def failed(self) -> list[TrialView]:
        """Levels that failed or were not run."""
        return [trial for trial in self.trials if trial.status != TRIAL_DONE]


def topics_of(result: Result) -> tuple[TopicView, ...]:
    """All topics in the order they were measured; ResultError for a file that lacks parts."""
    try:
        measured = json.loads(str(result.provenance.get(MEASURED, "{}")))
        return tuple(
            _topic_view(result, row, list(measured.get(row["folder"], [])))
            for row in (dict(row) for row in result.plan)
            if "method" not in row
        )
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise ResultError(
            f"the result of {result.name!r} lacks parts of its accuracy measurement: {error}"
        ) from error


def _topic_view(result: Result, words: dict[str, str], seconds: list[Any]) -> TopicView:
    folder, record = words["folder"], result.record
    names = [str(name) for name in record[f"{folder}/work"].axes[0].values]
    count = len(names)
    times = [None if one is None else float(one) for one in seconds or [None] * count]

    def column(name: str) -> Any:
        return record[f"{folder}/{name}"].values

    away = f"{folder}/position_error"
    position = column("position_error") if away in record else np.full(count, math.inf)
    relative = column("worst_relative")
    agreement = float(column("agreement"))
    error = np.maximum(relative, max(agreement, 64.0 * EPSILON)).tolist()
    cost = [math.inf if one is None else one for one in times]
    fast = on_front(error, cost) if seconds else [False] * count
    trials = tuple(
        TrialView(
            method=names[i].partition(BETWEEN)[0],
            setting=_shown_setting(names[i].partition(BETWEEN)[2]),
            status=int(column("status")[i]),
            cause=str(column("cause")[i]),
            work=float(column("work")[i]),
            seconds=times[i],
            relative=float(relative[i]),
            level=float(column("worst_level")[i]),
            position=float(position[i]),
            is_default=bool(column("is_default")[i]),
            in_work=bool(column("on_front")[i]),
            in_seconds=fast[i],
        )
        for i in range(count)
    )
    methods, more = _methods(result, folder), float(column("extra_work"))
    slower = extra(error, cost, column("is_default").tolist()) if seconds else math.inf
    return TopicView(folder, words, agreement, trials, methods, more, slower)


def _methods(result: Result, folder: str) -> tuple[MethodView, ...]:
    order = result.record[f"{folder}/order"]
    kind = result.record[f"{folder}/order_kind"].values
    rows = {
        row["method"]: row for row in result.plan if "method" in row and row["folder"] == folder
    }
    found = []
    for place, name in enumerate(str(label) for label in order.axes[0].values):
        row, value = rows[name], float(order.values[place])
        shown = {
            ALGEBRAIC: f"order {value:.2f}",
            GEOMETRIC: f"{value:.3g} digits per unit",
        }.get(str(kind[place]), "")
        found.append(MethodView(name, row["why"], row["setting"], shown, row["theory"]))
    return tuple(found)


def _shown_setting(text: str) -> str:
    return f"{float(text):.6g}" if text else ""


# ----------------------------------------------------------------------------
# The table of `vibecalc accuracy`: for each topic its levels, orders, cheapest and failures.
# ----------------------------------------------------------------------------

_LEGEND = (
    "Marks: * on the front between error and work, s on that between error and seconds (nothing "
    "as accurate is cheaper), < what vibecalc takes. Work and errors are the same in every run, "
    "seconds are those of this machine."
)
_NARROW = 25
#: rows of the answer; with what stands around them it fits on a screen
_ROWS = 28


def render_answer(result: Result) -> str:
    """What the screen shows, at most 40 lines: ours against the fastest as accurate."""
    topics = topics_of(result)
    lines = heading(f"Speed against error: {result.case.get('title') or result.name}", 1)
    lines += ["", *_summary(topics[:_ROWS])]
    failed = sum(trial.status == TRIAL_FAILED for topic in topics for trial in topic.trials)
    late = sum(len(topic.failed) for topic in topics) - failed
    more = (
        (max(len(topics) - _ROWS, 0), "more questions"),
        (failed, "settings that failed"),
        (late, "settings not run for want of time (--longest)"),
        (len(result.record.warnings), "questions left out"),
    )
    said = ", ".join(f"{words}: {count}" for count, words in more if count)
    return text_of([*lines, *paragraph(f"In the text: {said}.") * bool(said)])


def render_accuracy(result: Result) -> str:
    """The whole report of one measurement, at most 100 columns wide."""
    return text_of(accuracy_lines(result))


def accuracy_lines(result: Result) -> list[str]:
    """The blocks of that report."""
    topics = topics_of(result)
    lines = heading(f"Speed against error: {result.case.get('title') or result.name}", 1)
    lines += pairs([("case", result.name), ("sha256 of the case", result.case_sha256)], 20)
    lines += ["", *paragraph(_LEGEND), "", *_summary(topics)]
    for topic in topics:
        lines += _section(topic)
    left_out = warnings(result)
    if left_out is not None:
        lines += titled("Left out", left_out.lines)
    return lines + titled("Machine (changes from run to run)", _machine(result))


def _summary(topics: tuple[TopicView, ...]) -> list[str]:
    """One row for each topic: what the default reaches and what it costs against the cheapest."""
    columns = (
        Column("question", 41),
        number("error", 7),
        number("seconds", 8),
        Column("fastest as accurate", 25),
        number("time x", 6),
        number("work x", 6),
    )
    rows = []
    for topic in topics:
        ours, name = topic.default, f"{topic.words['stage']}: {topic.words['name']}"[:41]
        if ours is None or not ours.done:
            said = "no method of ours" if ours is None else "ours failed"
            rows.append([name, "", "", said, "", ""])
            continue
        best = topic.cheapest(max(ours.relative, topic.noise), by_work=False)
        shown = "ours" if best is None or best.is_default else best.method[:_NARROW]
        times = [f"{one:.3g}" if one < 100.0 else f"{one:.0f}"
                 for one in (topic.extra_seconds, topic.extra_work)]  # fmt: skip
        rows.append([name, _error(ours.relative), _seconds(ours), shown, *times])
    words = (
        "Error and time of what vibecalc takes; time and work over the least that is as accurate."
    )
    return [*table(columns, rows), "", *paragraph(words)]


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
    lines += [*pairs(about, 12), "", *_trials(topic)]
    lines += ["", *_orders(topic), "", *_cheapest(topic)]
    if topic.failed:
        lines += ["", *_failures(topic)]
    if float(words["default_extra"]) > 1.0:
        more = f"The default may take {words['default_extra']} times the least work: "
        lines += ["", *paragraph(more + words["default_why"])]
    return lines


def _trials(topic: TopicView) -> list[str]:
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
    for trial in topic.trials:
        cells = [trial.method if trial.method != last else "", trial.setting or "-"]
        last = trial.method
        cells += [_work(trial), _seconds(trial)]
        if trial.done:
            cells += [_error(trial.relative), _error(trial.level)]
        else:
            cells += [TRIAL_STATUS_WORDS[trial.status], ""]
        if topic.words["position"]:
            cells.append(_error(trial.position) if math.isfinite(trial.position) else "-")
        rows.append([*cells, _marks(trial)])
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
    rows = [
        [
            f"{target:g}",
            *(_pick(topic.cheapest(target, by_work), by_work) for by_work in (True, False)),
        ]
        for target in TARGETS
    ]
    return table(columns, rows)


def _pick(trial: TrialView | None, by_work: bool) -> str:
    if trial is None:
        return "none reaches it"
    return f"{_name(trial)}: " + (_work(trial) if by_work else f"{_seconds(trial)} s")


def _failures(topic: TopicView) -> list[str]:
    """Each cause once, with the settings that it befell."""
    causes: dict[tuple[str, int, str], list[str]] = {}
    for trial in topic.failed:
        causes.setdefault((trial.method, trial.status, trial.cause), []).append(trial.setting)
    lines = []
    for (method, status, cause), settings in causes.items():
        at = f" at {', '.join(settings)}" if any(settings) else ""
        lines += paragraph(f"{method}{at}: {TRIAL_STATUS_WORDS[status]}: {cause}", "-")
    return lines


def _machine(result: Result) -> list[str]:
    found = result.provenance
    names = ("machine", "versions", "threads", "platform", "time")
    rows = [(name, str(found[name])) for name in names if name in found]
    for name, seconds in result.timings.items():
        rows.append((f"{name} s", f"{seconds:.2f}"))
    return pairs([*rows, ("rerun", rerun(result))], 44)


def _name(trial: TrialView) -> str:
    return f"{trial.method}, {trial.setting}" if trial.setting else trial.method


def _marks(trial: TrialView) -> str:
    marks = ((trial.in_work, "*"), (trial.in_seconds, "s"), (trial.is_default, "<"))
    return "".join(mark for there, mark in marks if there)


def _error(value: float) -> str:
    if value == 0.0:
        return "0"
    return f"{value:.1e}" if math.isfinite(value) else "unbounded"


def _work(trial: TrialView) -> str:
    return f"{trial.work:.4g}" if trial.work else ""


def _seconds(trial: TrialView) -> str:
    return "" if trial.seconds is None else f"{trial.seconds:.2e}"


# ----------------------------------------------------------------------------
# The object that `vibecalc accuracy --json` prints.
# ----------------------------------------------------------------------------


def accuracy_object(result: Result, path: Path) -> dict[str, Any]:
    """Topics with their levels as plain objects; what is not finite is None."""
    found = result.provenance
    return {
        "case": result.name,
        "result": str(path),
        "topics": [_topic(topic) for topic in topics_of(result)],
        "left_out": list(result.record.warnings),
        "machine": {name: found.get(name) for name in ("machine", "versions", "threads", "time")},
        "rerun": rerun(result),
    }


def _topic(topic: TopicView) -> dict[str, Any]:
    words = topic.words
    return {
        "stage": words["stage"],
        "name": words["name"],
        "words": words["why"],
        "quantity": words["quantity"] or None,
        "work": words["work"],
        "reference": {"words": words["reference"], "agreement": _finite(topic.agreement)},
        "trials": [_trial(trial, bool(words["position"])) for trial in topic.trials],
        "methods": [
            {"method": method.name, "shown": method.shown or None, "theory": method.theory or None}
            for method in topic.methods
        ],
        "cheapest": [
            {
                "error": target,
                "in_work": _place(topic, topic.cheapest(target, True)),
                "in_seconds": _place(topic, topic.cheapest(target, False)),
            }
            for target in TARGETS
        ],
        "extra_work": _finite(topic.extra_work),
        "extra_seconds": _finite(topic.extra_seconds),
    }


def _trial(trial: TrialView, with_position: bool) -> dict[str, Any]:
    position = {"position_error": _finite(trial.position)} if with_position else {}
    return {
        "method": trial.method,
        "setting": float(trial.setting) if trial.setting else None,
        "status": TRIAL_STATUS_WORDS[trial.status],
        "cause": trial.cause or None,
        "work": trial.work,
        "seconds": trial.seconds,
        "worst_relative": _finite(trial.relative),
        "worst_level": _finite(trial.level),
        **position,
        "default": trial.is_default,
        "front_in_work": trial.in_work,
        "front_in_seconds": trial.in_seconds,
    }


def _place(topic: TopicView, trial: TrialView | None) -> int | None:
    """Place in the list of levels."""
    return None if trial is None else topic.trials.index(trial)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
