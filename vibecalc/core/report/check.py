"""What `check` says of a case: its plan with harmonics, counted work, time and memory."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibecalc.core.report.writing import many, pairs, paragraph
from vibecalc.core.run.plan import (
    FURTHER_RUN,
    LIBRARIES,
    Needs,
    StageNeeds,
    needed_stages,
    needs_of,
    units,
    work_seconds,
)

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.schema import Case

#: runs of one solution of a find
_SOLUTION = 15
#: machines within tolerances, computed by arrays, that take as long as one run
_AT_ONCE = 200


def check_rows(case: "Case") -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """One row for each stage and each study of `case`, and what the whole run will take.

    A row has short texts for the reader and, under `needs`, the same as numbers and full lists.
    Raises NumericalFailure where no number of harmonics meets the tolerance.
    """
    needs = needs_of(case)
    rows = [_row(stage) for stage in needs.stages]
    seconds = needs.seconds
    for row, runs, running in _studies(case, needs):
        rows.append(_told(row, [_counted(runs, "runs")], {"run": runs}, running))
        seconds += running
    time = time_in_words(seconds)
    # what no estimate can know: whether a search finds a way to keep the limits
    searched = case.optimisation is not None and case.limit
    more = "; about ten times as long if not all limits can be met" if searched else ""
    megabytes = 10 * round(needs.megabytes / 10.0)
    text = f"estimate: {time} on one thread, about {megabytes} MB{more}"
    return rows, {"time": time, "megabytes": needs.megabytes, "text": text}


def counted_seconds(case: "Case") -> float:
    """Seconds of all counted work of a case, of which the order of magnitude is said."""
    needs = needs_of(case)
    return needs.seconds + sum(running for _, _, running in _studies(case, needs))


#: seconds up to which a time is called so
_TIMES = (
    (0.3, "less than a second"),
    (2.5, "about a second"),
    (20.0, "seconds"),
    (100.0, "about a minute"),
    (2000.0, "minutes"),
    (7000.0, "about an hour"),
    (1e5, "hours"),
)


def time_in_words(seconds: float) -> str:
    """The order of magnitude of a time, which is all that counted work tells."""
    return next((words for most, words in _TIMES if seconds < most), "days")


def _row(stage: StageNeeds) -> dict[str, Any]:
    harmonics, texts = stage.harmonics, stage.plan.as_texts()
    counted = [_counted(number, units()[unit].words) for number, unit in stage.work[:-1]]
    work = {unit: number for number, unit in stage.work}
    row = _told(texts, counted, work, stage.seconds, stage.megabytes)
    if harmonics is not None:
        row["needs"]["harmonics"], row["orders"] = harmonics._asdict(), harmonics.words()
    return row


def _told(
    row: Mapping[str, str],
    counted: Sequence[str],
    work: Mapping[str, float],
    seconds: float,
    megabytes: float = 0.0,
) -> dict[str, Any]:
    """A row of the plan with what it takes, in words and as numbers."""
    time = time_in_words(seconds)
    needs = {"harmonics": None, "work": work, "time": time, "megabytes": megabytes}
    return {**row, "cost": f"{row['cost']}\n{'; '.join([*counted, time])}", "needs": needs}


def _counted(number: float, words: str) -> str:
    """A number with what it counts, `words` being of several."""
    one = re.sub(r"(?<=ch)es\b|(?<=ss)es\b|(?<!s)s\b", "", words, count=1)
    return f"{number:,.6g} {one if number == 1 else words}"


def _studies(case: "Case", needs: Needs) -> Iterator[tuple[dict[str, str], int, float]]:
    """Rows of an optimisation and of searches, which run the stages many times; runs, seconds."""
    study, scipy = case.optimisation, LIBRARIES["scipy.optimize"][0]
    if study is not None:
        from vibecalc.core.study.planned import describe_study, front_runs, search_runs

        limited = frozenset(limit.quantity for limit in case.limit)
        wanted = limited | {goal.quantity for goal in study.goals}
        points, count = search_runs(case) + front_runs(study), 1
        each = _each(case, needs, wanted)
        if study.robust is not None:
            from vibecalc.core.study.scatter import by_arrays

            count, keys = study.robust.samples, tuple(one.key for one in study.robust.tolerances)
            together = by_arrays(case.model_copy(update={"optimisation": None}), keys, wanted)
            each *= 1.5 + count / _AT_ONCE if together else count
        yield describe_study(case), points * count, scipy + points * each
    if case.find:
        from vibecalc.core.study.planned import describe_find

        counts = [(one.points + _SOLUTION, frozenset({one.quantity})) for one in case.find]
        seconds = sum(count * _each(case, needs, wanted) for count, wanted in counts)
        yield describe_find(case), sum(count for count, _ in counts), scipy + seconds
    if case.fit is not None:
        from vibecalc.core.study.measured_points import chosen_references
        from vibecalc.core.study.planned import describe_fit, fit_runs

        quantities, runs = {one.quantity for _, one in chosen_references(case)}, fit_runs(case)
        yield describe_fit(case), runs, scipy + runs * _each(case, needs, frozenset(quantities))


def _each(case: "Case", needs: Needs, wanted: frozenset[str]) -> float:
    """Seconds of one further run for some results: of the stages that bring them, all imported."""
    names = {stage.name for stage in needed_stages(case, wanted)}
    work = sum(work_seconds(stage.work) for stage in needs.stages if stage.plan.name in names)
    return FURTHER_RUN[0] * work + FURTHER_RUN[1]


# ----------------------------------------------------------------------------
# What `check` shows: the case in a few lines, then what a run would do and why.
# ----------------------------------------------------------------------------

#: keys of a plan row, in the order shown, with their headings
ROWS = {"why": "reason", "parts": "inputs", "orders": "orders", "cost": "cost",
        "quantities": "results"}  # fmt: skip


def plan_object(
    loaded: "LoadedCase", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> dict[str, Any]:
    """What `check --json` prints of one case; `plan` and `total` as for `render_plan`."""
    from vibecalc.core.run.machine_checks import machine_warnings

    told = {"case": str(loaded.path), "title": loaded.case.title, "sha256": loaded.sha256}
    return told | {"warnings": machine_warnings(loaded.case), "plan": plan, "needs": total}


def render_plan(
    path: str, case: "Case", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> str:
    """The plan as text: stages, why, what they read, orders, cost, quantities; the whole.

    `plan` and `total` are those of `study.check_rows`.
    """
    from vibecalc.core.run.machine_checks import machine_warnings

    warned = [*machine_warnings(case)]
    valid = f"valid, {many(len(warned), 'warning')}:" if warned else "valid"
    lines = [f"{path}: {case.title}", valid]
    for words in warned:
        lines += paragraph(words, "warning:")
    for number, stage in enumerate(plan, start=1):
        lines += ["", f"{number}. {stage['stage']}"]
        shown = {**stage, "quantities": _by_folder(stage.get("quantities", ""))}
        lines += pairs([(name, shown[key]) for key, name in ROWS.items() if shown.get(key)])
    counted = sum(row.kind == "published" and not row.known_difference for row in case.reference)
    words = f"{many(len(case.limit), 'limit')}, "
    words += f"{many(len(case.reference), 'reference number')} ({counted} counted)"
    return "\n".join([*lines, "", str(total["text"]), words])


def _by_folder(quantities: str) -> str:
    """One line per folder of result paths, so that no path is broken in two."""
    folders: dict[str, list[str]] = {}
    for path in quantities.split(", "):
        folder, _, name = path.rpartition("/")
        folders.setdefault(folder, []).append(name)
    return "\n".join(f"{folder}: {', '.join(names)}" for folder, names in folders.items() if folder)
