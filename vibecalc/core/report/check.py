"""What `check` says of a case: its plan with harmonics, counted work, time and memory."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibecalc.core.report.writing import pairs, paragraph
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
    rows += list(_studies(case, needs))
    seconds = needs.seconds + sum(row["needs"]["seconds"] for row in rows[len(needs.stages) :])
    total = {
        "seconds": seconds,
        "megabytes": needs.megabytes,
        "text": f"in all about {rough(seconds)} and {rough_megabytes(needs.megabytes)}, on one "
        "thread, within a factor of 3" + _longer(case),
    }
    return rows, total


def _longer(case: "Case") -> str:
    """What no estimate can know: whether a search finds a way to keep the limits."""
    if case.optimisation is None or not case.limit:
        return ""
    return "; some ten times that where the limits cannot all be kept"


def rough(seconds: float) -> str:
    """Seconds as no more digits than they are good for."""
    if seconds < 1.0:
        return f"{float(f'{1e3 * seconds:.1g}'):g} ms"
    if seconds < 90.0:
        return f"{float(f'{seconds:.2g}'):g} s"
    return f"{float(f'{seconds / 60.0:.2g}'):g} min"


def rough_megabytes(megabytes: float) -> str:
    """Memory in steps of 10 MB."""
    return f"{10 * round(megabytes / 10.0):d} MB"


def _row(stage: StageNeeds) -> dict[str, Any]:
    harmonics = stage.harmonics
    texts = stage.plan.as_texts()
    counted = [_counted(number, units()[unit].words) for number, unit in stage.work[:-1]]
    return texts | {
        "orders": texts["orders"] if harmonics is None else harmonics.words(),
        "cost": f"{texts['cost']}\n"
        + "; ".join([*counted, f"about {rough(stage.seconds)}, imports included"]),
        "needs": {
            "harmonics": None if harmonics is None else harmonics._asdict(),
            "work": {unit: number for number, unit in stage.work},
            "seconds": stage.seconds,
            "megabytes": stage.megabytes,
        },
    }


def _counted(number: float, words: str) -> str:
    """A number with what it counts, `words` being of several."""
    one = re.sub(r"(?<=ch)es\b|(?<=ss)es\b|(?<!s)s\b", "", words, count=1)
    return f"{number:,.6g} {one if number == 1 else words}"


def _studies(case: "Case", needs: Needs) -> Iterator[dict[str, Any]]:
    """Rows of an optimisation and of searches, which run the stages many times."""
    study = case.optimisation
    if study is not None:
        from vibecalc.core.study.planned import describe_study, goals_of, runs_expected

        limited = frozenset(limit.quantity for limit in case.limit)
        wanted = limited | {goal.quantity for goal in goals_of(study)}
        points, count = runs_expected(case), 1
        each = _each(case, needs, wanted)
        if study.robust is not None:
            from vibecalc.core.study.scatter import by_arrays

            count, keys = study.robust.samples, tuple(one.key for one in study.robust.tolerances)
            together = by_arrays(case.model_copy(update={"optimisation": None}), keys, wanted)
            each *= 1.5 + count / _AT_ONCE if together else count
        yield _study(describe_study(case), points * count, points * each)
    if case.find:
        from vibecalc.core.study.planned import describe_find

        runs = sum(search.points + _SOLUTION for search in case.find)
        seconds = sum(
            (search.points + _SOLUTION) * _each(case, needs, frozenset({search.quantity}))
            for search in case.find
        )
        yield _study(describe_find(case), runs, seconds)
    if case.fit is not None:
        from vibecalc.core.study.measured_points import chosen_references, describe_fit, fit_runs

        quantities = frozenset(one.quantity for _, one in chosen_references(case))
        runs = fit_runs(case)
        yield _study(describe_fit(case), runs, runs * _each(case, needs, quantities))


def _each(case: "Case", needs: Needs, wanted: frozenset[str]) -> float:
    """Seconds of one further run for some results: of the stages that bring them, all imported."""
    names = {stage.name for stage in needed_stages(case, wanted)}
    work = sum(work_seconds(stage.work) for stage in needs.stages if stage.plan.name in names)
    return FURTHER_RUN[0] * work + FURTHER_RUN[1]


def _study(row: dict[str, str], runs: int, running: float) -> dict[str, Any]:
    seconds = running + LIBRARIES["scipy.optimize"][0]
    return row | {
        "cost": f"{row['cost']}\n{_counted(runs, 'runs')}; about {rough(seconds)}",
        "needs": {
            "harmonics": None,
            "work": {"run": runs},
            "seconds": seconds,
            "megabytes": 0.0,
        },
    }


# ----------------------------------------------------------------------------
# What `check` shows: the case in a few lines, then what a run would do and why.
# ----------------------------------------------------------------------------

#: keys of a plan row, in the order shown, with their headings
ROWS = (
    ("why", "why"),
    ("parts", "reads"),
    ("orders", "orders"),
    ("cost", "cost"),
    ("quantities", "makes"),
)


def plan_object(
    loaded: "LoadedCase", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> dict[str, Any]:
    """What `check --json` prints of one case; `plan` and `total` as for `render_plan`."""
    from vibecalc.core.run.machine_checks import machine_warnings

    return {
        "case": str(loaded.path),
        "title": loaded.case.title,
        "sha256": loaded.sha256,
        "warnings": machine_warnings(loaded.case),
        "plan": plan,
        "needs": total,
    }


def render_plan(
    path: str, case: "Case", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> str:
    """The plan as text: stages, why, what they read, orders, cost, quantities; the whole.

    `plan` and `total` are those of `study.check_rows`.
    """
    from vibecalc.core.run.machine_checks import machine_warnings

    lines = [f"{path}: {case.title}", f"no problems; accuracy rtol = {case.accuracy.rtol:g}"]
    for words in machine_warnings(case):
        lines += paragraph(words, "warning:")
    for number, stage in enumerate(plan, start=1):
        lines += ["", f"{number}. {stage['stage']}"]
        shown = {**stage, "quantities": _by_folder(stage.get("quantities", ""))}
        lines += pairs([(name, shown[key]) for key, name in ROWS if shown.get(key)], width=8)
    counted = [row for row in case.reference if row.kind == "published"]
    counted = [row for row in counted if not row.known_difference]
    lines += [
        "",
        str(total["text"]),
        f"{_count(len(case.reference), 'reference')}, {len(counted)} of them counted; "
        f"{_count(len(case.limit), 'limit')}",
    ]
    return "\n".join(lines)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _by_folder(quantities: str) -> str:
    """One line per folder of result paths, so that no path is broken in two."""
    folders: dict[str, list[str]] = {}
    for path in quantities.split(", "):
        folder, _, name = path.rpartition("/")
        folders.setdefault(folder, []).append(name)
    return "\n".join(f"{folder}: {', '.join(names)}" for folder, names in folders.items() if folder)
