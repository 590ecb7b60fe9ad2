"""The report of `vibecalc accuracy`: topics with their levels, orders, cheapest and failures."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from vibecalc.core.report.pages import rerun, warnings
from vibecalc.core.report.sections import stacked
from vibecalc.core.report.writing import (
    finite,
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
    and `position_error` also where the method gives none.
    """

    method: str
    setting: str
    seconds: float | None
    front_in_seconds: bool
    status: int
    cause: str
    work: float
    worst_relative: float
    worst_level: float
    default: bool
    front_in_work: bool
    position_error: float

    @property
    def done(self) -> bool:
        """Whether it has an error."""
        return self.status == TRIAL_DONE


#: results of a trial, in the order in which `TrialView` has them
_COLUMNS = ("status", "cause", "work", "worst_relative", "worst_level", "is_default", "on_front")


class TopicView(NamedTuple):
    """A topic. `extra_...`: of the default over the least as accurate, in work and seconds.

    A method has its name, its setting, the order that it has `shown`, if any, and the theory.
    """

    folder: str
    words: dict[str, str]
    agreement: float
    trials: tuple[TrialView, ...]
    methods: tuple[Mapping[str, str], ...]
    extra_work: float
    extra_seconds: float

    def cheapest(self, target: float, by_work: bool) -> TrialView | None:
        """The trial with the least work, or the fastest, of an error of at most `target`."""
        error = [max(trial.worst_relative, 0.0) for trial in self.trials]
        cost = [trial.work if by_work else trial.seconds or 0.0 for trial in self.trials]
        place = cheapest(error, cost, target)
        return None if place is None else self.trials[place]

    @property
    def default(self) -> TrialView | None:
        """What vibecalc takes."""
        return next((trial for trial in self.trials if trial.default), None)

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
    names = [str(name).partition(BETWEEN) for name in record[f"{folder}/work"].axes[0].values]
    times = [None if one is None else float(one) for one in seconds or [None] * len(names)]

    def column(name: str) -> list[Any]:
        return list(record[f"{folder}/{name}"].values.tolist())

    away = f"{folder}/position_error" in record
    position = column("position_error") if away else [math.inf] * len(names)
    agreement, more = (
        float(record[f"{folder}/{one}"].values) for one in ("agreement", "extra_work")
    )
    error = [max(one, agreement, 64.0 * EPSILON) for one in column("worst_relative")]
    cost = [math.inf if one is None else one for one in times]
    fast = on_front(error, cost) if seconds else [False] * len(names)
    trials = tuple(
        TrialView(method, f"{float(setting):.6g}" if setting else "", *parts)
        for (method, _, setting), *parts in zip(
            names, times, fast, *map(column, _COLUMNS), position, strict=True
        )
    )
    slower = extra(error, cost, column("is_default")) if seconds else math.inf
    methods = _methods(result, folder)
    return TopicView(folder, words, agreement, trials, methods, more, slower)


def _methods(result: Result, folder: str) -> tuple[Mapping[str, str], ...]:
    order, kind = (result.record[f"{folder}/{name}"].values for name in ("order", "order_kind"))
    shown = {ALGEBRAIC: "order {:.2f}", GEOMETRIC: "{:.3g} digits per unit"}
    rows = {row["method"]: row for row in result.plan if row["folder"] == folder if "method" in row}
    names = map(str, result.record[f"{folder}/order"].axes[0].values)
    return tuple(
        {**rows[name], "shown": shown.get(str(how), "").format(value)}
        for name, value, how in zip(names, order.tolist(), kind, strict=True)
    )


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


def accuracy_lines(result: Result) -> list[str]:
    """The blocks of the whole report of one measurement."""
    topics = topics_of(result)
    lines = heading(f"Speed against error: {result.case.get('title') or result.name}", 1)
    lines += pairs([("case", result.name), ("sha256 of the case", result.case_sha256)])
    lines += ["", *paragraph(_LEGEND), "", *_summary(topics)]
    for topic in topics:
        lines += _section(topic)
    left_out = warnings(result)
    if left_out is not None:
        lines += titled("Left out", left_out.lines)
    return lines + titled("Machine (changes from run to run)", _machine(result))


def _summary(topics: tuple[TopicView, ...]) -> list[str]:
    """One row for each topic: what the default reaches and what it costs against the cheapest."""
    rows = []
    for topic in topics:
        ours, name = topic.default, f"{topic.words['stage']}: {topic.words['name']}"[:41]
        if ours is None or not ours.done:
            said = "no method of ours" if ours is None else "ours failed"
            rows.append([name, "", "", said, "", ""])
            continue
        best = topic.cheapest(max(ours.worst_relative, topic.noise), by_work=False)
        shown = "ours" if best is None or best.default else best.method[:_NARROW]
        times = [f"{one:.3g}" if one < 100.0 else f"{one:.0f}"
                 for one in (topic.extra_seconds, topic.extra_work)]  # fmt: skip
        rows.append([name, _error(ours.worst_relative), _seconds(ours), shown, *times])
    heads = ("question", number("error"), number("seconds"), "fastest as accurate",
             number("time x"), number("work x"))  # fmt: skip
    words = (
        "Error and time of what vibecalc takes; time and work over the least that is as accurate."
    )
    return [*table(heads, rows), "", *paragraph(words)]


def _section(topic: TopicView) -> list[str]:
    words = topic.words
    about = {
        "stands for": words["quantity"],
        "reference": f"{words['reference']}; agreement {_error(topic.agreement)}",
        "work": words["work"],
        "position": words["position"],
    }
    more = f"The default may take {words['default_extra']} times the least work: "
    dear = float(words["default_extra"]) > 1.0
    blocks = stacked(
        [*paragraph(words["why"]), *pairs(row for row in about.items() if row[1])],
        _trials(topic),
        _orders(topic),
        _cheapest(topic),
        _failures(topic),
        paragraph(more + words["default_why"]) if dear else [],
    )
    title = f"{words['stage']}: {words['name']}"
    return ["", title, "-" * len(title), *blocks]


def _trials(topic: TopicView) -> list[str]:
    rows = []
    last = ""
    for trial in topic.trials:
        errors = [_error(trial.worst_relative), _error(trial.worst_level)]
        away = _error(trial.position_error) if math.isfinite(trial.position_error) else "-"
        marks = "*" * trial.front_in_work + "s" * trial.front_in_seconds + "<" * trial.default
        rows.append([
            trial.method if trial.method != last else "", trial.setting or "-", _work(trial),
            _seconds(trial), *(errors if trial.done else [TRIAL_STATUS_WORDS[trial.status], ""]),
            away if topic.words["position"] else "", marks,
        ])  # fmt: skip
        last = trial.method
    heads = map(number, ("setting", "work", "seconds", "relative", "dB", "position"))
    return table(("method", *heads, "marks"), rows)


def _orders(topic: TopicView) -> list[str]:
    rows = [
        [
            one["method"],
            one["setting"] or "nothing to set",
            one["shown"] or "-",
            one["theory"] or "-",
        ]
        for one in topic.methods
    ]
    return table(("method", "steps", "convergence shown", "theory"), rows)


def _cheapest(topic: TopicView) -> list[str]:
    rows = [
        [f"{target:g}", *(_pick(topic.cheapest(target, one), one) for one in (True, False))]
        for target in TARGETS
    ]
    return table((number("error"), "cheapest in work", "in seconds"), rows)


def _pick(trial: TrialView | None, by_work: bool) -> str:
    if trial is None:
        return "none reaches it"
    name = f"{trial.method}, {trial.setting}" if trial.setting else trial.method
    return f"{name}: " + (_work(trial) if by_work else f"{_seconds(trial)} s")


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
    return pairs([*rows, ("rerun", rerun(result))])


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
        "reference": {"words": words["reference"], "agreement": finite(topic.agreement)},
        "trials": [_trial(trial, bool(words["position"])) for trial in topic.trials],
        "methods": [
            {name: one[name] or None for name in ("method", "shown", "theory")}
            for one in topic.methods
        ],
        "cheapest": [
            {
                "error": target,
                "in_work": _place(topic, topic.cheapest(target, True)),
                "in_seconds": _place(topic, topic.cheapest(target, False)),
            }
            for target in TARGETS
        ],
        "extra_work": finite(topic.extra_work),
        "extra_seconds": finite(topic.extra_seconds),
    }


def _trial(trial: TrialView, with_position: bool) -> dict[str, Any]:
    told = trial._asdict() | {
        "setting": float(trial.setting) if trial.setting else None,
        "status": TRIAL_STATUS_WORDS[trial.status],
        "cause": trial.cause or None,
    }
    return {
        name: finite(one) if isinstance(one, float) else one
        for name, one in told.items()
        if with_position or name != "position_error"
    }


def _place(topic: TopicView, trial: TrialView | None) -> int | None:
    """Place in the list of levels."""
    return None if trial is None else topic.trials.index(trial)
