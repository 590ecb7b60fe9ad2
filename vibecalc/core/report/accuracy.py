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
    GEOMETRIC,
    MEASURED,
    TARGETS,
    TRIAL_FAILED,
    TRIAL_STATUS_WORDS,
)
from vibecalc.core.results.record import Result
from vibecalc.core.results.trials import Trial, cheapest, extra, marked, noise_of
from vibecalc.errors import ResultError

# ----------------------------------------------------------------------------
# A result of `vibecalc accuracy` as its report reads it: topics with their levels.
# ----------------------------------------------------------------------------

#: results of a trial
_COLUMNS = ("setting", "is_default", "status", "cause", "work", "worst_relative", "worst_level")


class TopicView(NamedTuple):
    """A topic with its words and trials.

    A method has its name, its setting, the order that it has `shown`, if any, and the theory.
    """

    words: dict[str, str]
    agreement: float
    trials: tuple[Trial, ...]
    methods: tuple[Mapping[str, str], ...]

    def more(self, cost: str) -> float:
        """Work or seconds of the default over the least as accurate."""
        return extra(self.trials, self.noise, cost)

    @property
    def default(self) -> Trial | None:
        """What vibecalc takes."""
        return next((trial for trial in self.trials if trial.is_default), None)

    @property
    def noise(self) -> float:
        """The error below which trials are not told apart."""
        return noise_of(self.agreement)

    @property
    def failed(self) -> list[Trial]:
        """Levels that failed or were not run."""
        return [trial for trial in self.trials if not trial.done]


def topics_of(result: Result) -> tuple[TopicView, ...]:
    """All topics in the order they were measured; ResultError for a file that lacks parts."""
    try:
        seconds = json.loads(str(result.provenance[MEASURED]))
        return tuple(
            _topic_view(result, dict(row), seconds[row["folder"]])
            for row in result.plan
            if "method" not in row
        )
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise ResultError(
            f"the result of {result.name!r} lacks parts of its accuracy measurement: {error}"
        ) from error


def _topic_view(result: Result, words: dict[str, str], seconds: list[float | None]) -> TopicView:
    def column(name: str) -> Any:
        return result.record[f"{words['folder']}/{name}"].values.tolist()

    of_trials = result.record[f"{words['folder']}/work"].axes[0].values.tolist()
    names = [*_COLUMNS, *["position_error"] * bool(words["position"]), "seconds"]
    known = (math.inf if one is None else one for one in seconds)
    columns = zip(of_trials, *map(column, names[:-1]), known, strict=True)
    trials = [Trial(name, **dict(zip(names, row, strict=True))) for name, *row in columns]
    agreement = float(column("agreement"))
    shown = {ALGEBRAIC: "order {:.2f}", GEOMETRIC: "{:.3g} digits per unit"}
    rows = (row for row in result.plan if row["folder"] == words["folder"] and "method" in row)
    methods = tuple(
        {**row, "shown": shown.get(str(how), "").format(value)}
        for row, value, how in zip(rows, column("order"), column("order_kind"), strict=True)
    )
    return TopicView(words, agreement, marked(trials, noise_of(agreement)), methods)


# ----------------------------------------------------------------------------
# The table of `vibecalc accuracy`: for each topic its levels, orders, cheapest and failures.
# ----------------------------------------------------------------------------

_LEGEND = (
    "Marks: * Pareto-optimal in error and work, s in error and seconds, < default of vibecalc. "
    "Work and errors are reproducible, seconds are those of this machine."
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
        (max(len(topics) - _ROWS, 0), "more topics"),
        (failed, "failed settings"),
        (late, "settings skipped, time limit (--longest)"),
        (len(result.record.warnings), "topics left out"),
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
            said = "no method of vibecalc" if ours is None else "vibecalc failed"
            rows.append([name, "", "", said, "", ""])
            continue
        best = cheapest(topic.trials, max(ours.worst_relative, topic.noise), "seconds") or ours
        shown = "vibecalc" if best.is_default else best.method[:_NARROW]
        times = [f"{one:.3g}" if one < 100.0 else f"{one:.0f}"
                 for one in (topic.more("seconds"), topic.more("work"))]  # fmt: skip
        rows.append([name, _error(ours.worst_relative), _seconds(ours), shown, *times])
    heads = ("topic", number("error"), number("seconds"), "fastest of that accuracy",
             number("time x"), number("work x"))  # fmt: skip
    words = "Error and time of vibecalc's default; time and work relative to the fastest."
    return [*table(heads, rows), "", *paragraph(words)]


def _section(topic: TopicView) -> list[str]:
    words = topic.words
    about = {
        "quantity": words["quantity"],
        "reference": f"{words['reference']}; agreement {_error(topic.agreement)}",
        "work": words["work"],
        "position": words["position"],
    }
    more = f"The default may need {words['default_extra']} times the minimum work: "
    dear = float(words["default_extra"]) > 1.0
    orders = [[one["method"], one["setting"] or "none", one["shown"] or "-",
               one["theory"] or "-"] for one in topic.methods]  # fmt: skip
    picks = [[f"{target:g}", *(_pick(topic, target, cost) for cost in ("work", "seconds"))]
             for target in TARGETS]  # fmt: skip
    blocks = stacked(
        [*paragraph(words["why"]), *pairs(row for row in about.items() if row[1])],
        _trials(topic),
        table(("method", "steps", "observed convergence", "theory"), orders),
        table((number("error"), "least work", "least time"), picks),
        _failures(topic),
        paragraph(more + words["default_why"]) if dear else [],
    )
    return titled(f"{words['stage']}: {words['name']}", blocks)


def _trials(topic: TopicView) -> list[str]:
    rows = []
    last = ""
    for trial in topic.trials:
        errors = [_error(trial.worst_relative), _error(trial.worst_level)]
        away = _error(trial.position_error) if math.isfinite(trial.position_error) else "-"
        marks = "*" * trial.front_in_work + "s" * trial.front_in_seconds + "<" * trial.is_default
        rows.append([
            trial.method if trial.method != last else "", trial.shown or "-", _work(trial),
            _seconds(trial), *(errors if trial.done else [TRIAL_STATUS_WORDS[trial.status], ""]),
            away if topic.words["position"] else "", marks,
        ])  # fmt: skip
        last = trial.method
    heads = map(number, ("setting", "work", "seconds", "relative", "dB", "position"))
    return table(("method", *heads, "marks"), rows)


def _pick(topic: TopicView, target: float, cost: str) -> str:
    trial = cheapest(topic.trials, target, cost)
    if trial is None:
        return "not reached"
    name = f"{trial.method}, {trial.shown}" if trial.shown else trial.method
    return f"{name}: " + (_work(trial) if cost == "work" else f"{_seconds(trial)} s")


def _failures(topic: TopicView) -> list[str]:
    """Each cause once, with the settings that it befell."""
    causes: dict[tuple[str, int, str], list[str]] = {}
    for trial in topic.failed:
        causes.setdefault((trial.method, trial.status, trial.cause), []).append(trial.shown)
    lines = []
    for (method, status, cause), settings in causes.items():
        at = f" at {', '.join(settings)}" if any(settings) else ""
        lines += paragraph(f"{method}{at}: {TRIAL_STATUS_WORDS[status]}: {cause}", "-")
    return lines


def _machine(result: Result) -> list[str]:
    found = result.provenance
    names = ("machine", "versions", "threads", "platform", "time")
    rows = [(name, str(found[name])) for name in names if name in found]
    rows += [(f"{name} s", f"{seconds:.2f}") for name, seconds in result.timings.items()]
    return pairs([*rows, ("rerun", rerun(result))])


def _error(value: float) -> str:
    if value == 0.0:
        return "0"
    return f"{value:.1e}" if math.isfinite(value) else "unbounded"


def _work(trial: Trial) -> str:
    return f"{trial.work:.4g}" if trial.work else ""


def _seconds(trial: Trial) -> str:
    return f"{trial.seconds:.2e}" if trial.seconds < math.inf else ""


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
    words, places = topic.words, list[dict[str, Any]]()
    for target in TARGETS:  # in the list of levels
        row: dict[str, Any] = {"error": target}
        for cost in ("work", "seconds"):
            trial = cheapest(topic.trials, target, cost)
            row[f"in_{cost}"] = None if trial is None else topic.trials.index(trial)
        places.append(row)
    methods = [{name: one[name] or None for name in ("method", "shown", "theory")}
               for one in topic.methods]  # fmt: skip
    return {
        "stage": words["stage"],
        "name": words["name"],
        "words": words["why"],
        "quantity": words["quantity"] or None,
        "work": words["work"],
        "reference": {"words": words["reference"], "agreement": finite(topic.agreement)},
        "trials": [_trial(trial, bool(words["position"])) for trial in topic.trials],
        "methods": methods,
        "cheapest": places,
        "extra_work": finite(topic.more("work")),
        "extra_seconds": finite(topic.more("seconds")),
    }


def _trial(trial: Trial, with_position: bool) -> dict[str, Any]:
    told = trial._asdict() | {
        "setting": float(trial.shown) if trial.shown else None,
        "status": TRIAL_STATUS_WORDS[trial.status],
        "cause": trial.cause or None,
    }
    told = {name: finite(one) if isinstance(one, float) else one for name, one in told.items()}
    default = {"method": trial.method, "default": bool(trial.is_default)}
    left_out = {"name", "is_default", *["position_error"] * (not with_position)}
    return default | {name: one for name, one in told.items() if name not in left_out}
