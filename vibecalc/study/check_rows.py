"""What `check` says of a case: its plan with harmonics, modules, counted work, time and memory."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.pipeline.needs import Needs, StageNeeds, foreign, needs_of, own, work_seconds
from vibecalc.pipeline.needs_imports import PACKAGE
from vibecalc.pipeline.needs_lazy import modules_needed
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
    libraries = sorted({name for row in rows for name in row["needs"]["libraries"]})
    total = {
        "seconds": seconds,
        "megabytes": needs.megabytes,
        "modules_of_every_run": list(needs.frame),
        "libraries": libraries,
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


def rooms(modules: tuple[str, ...]) -> str:
    """`kinematics 4, response/torsion 12`: how many modules of which room."""
    count: dict[str, int] = {}
    for name in modules:
        room = "/".join(name.split(".")[:-1]) or name
        count[room] = count.get(room, 0) + 1
    return ", ".join(f"{room} {number}" for room, number in sorted(count.items()))


def _row(stage: StageNeeds) -> dict[str, Any]:
    harmonics = stage.harmonics
    texts = stage.plan.as_texts()
    counted = [f"{number:,.6g} {UNITS[unit].words}" for number, unit in stage.work[:-1]]
    return texts | {
        "orders": texts["orders"] if harmonics is None else harmonics.words(),
        "modules": _modules(stage.modules, stage.libraries, stage.libraries_perhaps),
        "cost": f"{texts['cost']}\n"
        + "; ".join([*counted, f"about {rough(stage.seconds)}, imports with it"]),
        "needs": {
            "harmonics": None if harmonics is None else harmonics._asdict(),
            "modules": list(stage.modules),
            "modules_perhaps": list(stage.perhaps),
            "libraries": list(stage.libraries),
            "libraries_perhaps": list(stage.libraries_perhaps),
            "work": {unit: number for number, unit in stage.work},
            "seconds": stage.seconds,
            "megabytes": stage.megabytes,
        },
    }


def _modules(modules: tuple[str, ...], libraries: tuple[str, ...], more: tuple[str, ...]) -> str:
    perhaps = f"; perhaps {', '.join(more)}" if more else ""
    return f"{len(modules)}: {rooms(modules)}; {', '.join(libraries)}{perhaps}"


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
        root = f"{PACKAGE}.study.optimise"
        yield _study(case, describe_study(case), root, runs, seconds)
    if case.find:
        from vibecalc.study.find_paths import describe_find

        runs = sum(search.points + _SOLUTION for search in case.find)
        seconds = sum(
            (search.points + _SOLUTION) * _each(case, needs, frozenset({search.quantity}))
            for search in case.find
        )
        yield _study(case, describe_find(case), f"{PACKAGE}.study.find", runs, seconds)


def _each(case: "Case", needs: Needs, wanted: frozenset[str]) -> float:
    """Seconds of one further run for some results: of the stages that bring them, all imported."""
    names = {stage.stage for stage in needed_stages(case, wanted)}
    work = sum(work_seconds(stage.work) for stage in needs.stages if stage.plan.stage in names)
    return FURTHER_RUN[0] * work + FURTHER_RUN[1]


def _study(
    case: "Case", row: dict[str, str], root: str, runs: int, running: float
) -> dict[str, Any]:
    sure, perhaps = modules_needed(case, (root,))
    libraries = foreign(sure | perhaps)
    loaded = max((LIBRARIES[name][0] for name in libraries if name in LIBRARIES), default=0.0)
    seconds = running + loaded
    return row | {
        "modules": _modules(own(sure), foreign(sure), foreign(perhaps)),
        "cost": f"{row['cost']}\n{runs:,} runs; about {rough(seconds)}",
        "needs": {
            "harmonics": None,
            "modules": list(own(sure)),
            "modules_perhaps": list(own(perhaps)),
            "libraries": list(foreign(sure)),
            "libraries_perhaps": list(foreign(perhaps)),
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
