"""What `check` says of a case: its plan with harmonics, counted work, time and memory."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.pipeline.needs import Needs, StageNeeds, needs_of, work_seconds
from vibecalc.pipeline.needs_units import FURTHER_RUN, LIBRARIES, UNITS
from vibecalc.pipeline.plan import needed_stages

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.case.tables import Optimisation

#: runs of one search, of one solution of a find, of one point of a front, of weights solved for
#: beside one for each variable
_SEARCH, _SOLUTION, _FRONT, _SOLVED = 50, 15, 100, 5


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
    counted = [f"{number:,.6g} {UNITS[unit].words}" for number, unit in stage.work[:-1]]
    return texts | {
        "orders": texts["orders"] if harmonics is None else harmonics.words(),
        "cost": f"{texts['cost']}\n"
        + "; ".join([*counted, f"about {rough(stage.seconds)}, imports with it"]),
        "needs": {
            "harmonics": None if harmonics is None else harmonics._asdict(),
            "work": {unit: number for number, unit in stage.work},
            "seconds": stage.seconds,
            "megabytes": stage.megabytes,
        },
    }


def _studies(case: "Case", needs: Needs) -> Iterator[dict[str, Any]]:
    """Rows of an optimisation and of searches, which run the stages many times."""
    study = case.optimisation
    if study is not None:
        from vibecalc.study.balancing import balances
        from vibecalc.study.optimise_paths import describe_study

        second = study.second_objective
        wanted = {study.objective.quantity, *(limit.quantity for limit in case.limit)}
        wanted |= set() if second is None else {second.quantity}
        solved = balances(case)
        runs = len(study.variables) + _SOLVED if solved and not case.limit else _runs(study)
        seconds = runs * _each(case, needs, frozenset(wanted))
        yield _study(describe_study(case), runs, seconds)
    if case.find:
        from vibecalc.study.find_paths import describe_find

        runs = sum(search.points + _SOLUTION for search in case.find)
        seconds = sum(
            (search.points + _SOLUTION) * _each(case, needs, frozenset({search.quantity}))
            for search in case.find
        )
        yield _study(describe_find(case), runs, seconds)


def _each(case: "Case", needs: Needs, wanted: frozenset[str]) -> float:
    """Seconds of one further run for some results: of the stages that bring them, all imported."""
    names = {stage.stage for stage in needed_stages(case, wanted)}
    work = sum(work_seconds(stage.work) for stage in needs.stages if stage.plan.stage in names)
    return FURTHER_RUN[0] * work + FURTHER_RUN[1]


def _study(row: dict[str, str], runs: int, running: float) -> dict[str, Any]:
    seconds = running + LIBRARIES["scipy.optimize"][0]
    return row | {
        "cost": f"{row['cost']}\n{runs:,} runs; about {rough(seconds)}",
        "needs": {
            "harmonics": None,
            "work": {"run": runs},
            "seconds": seconds,
            "megabytes": 0.0,
        },
    }


def _runs(study: "Optimisation") -> int:
    """Runs that an optimisation is likely to take; methods beside it end half way as a rule."""
    from vibecalc.study.optimise_further_paths import COMPARE_BUDGET, front_points

    front = front_points(study) * _FRONT if study.second_objective else 0
    return (study.starts + 1) * _SEARCH + len(study.compare) * COMPARE_BUDGET // 2 + front
