"""What can be found wrong with a sweep before its first run."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice, product
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase, validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.case.walk import bound_words
from vibecalc.core.results.catalogue import deciding
from vibecalc.core.results.record import Entry
from vibecalc.core.run.columns import allowed_by
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.targets import unknown_quantity
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.values import Scatter
from vibecalc.errors import CaseError, KeyPath, Problem
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Values of a sweep that the schema forbids: which, how many, at how many points.
# ----------------------------------------------------------------------------

_BLOCK = 1 << 18  # values looked through at a time
_SHOWN = 3


def forbidden_values(design: Design) -> Iterator[Problem]:
    """One problem for each key with values outside its bounds; no run is needed for it."""
    for column, key in enumerate(design.every):
        values, shape = key.values, key.shape
        if key.choices or np.all(allowed_by(shape, np.array(values.ends))):
            continue
        drawn, total = values.count is None, values.count or design.count
        count, first = 0, list[float]()
        for start in range(0, total, _BLOCK):
            numbers = np.arange(start, min(start + _BLOCK, total))
            some = design.value_of(numbers)[:, column] if drawn else values.at(numbers)
            wrong = some[~allowed_by(shape, some)]
            count += wrong.size
            first += wrong[:_SHOWN].tolist()
        if not count:
            continue
        shown = ", ".join(f"{value:.6g}" for value in first[:_SHOWN]) + ", ..." * (count > _SHOWN)
        many = f"({count} of {total:.6g} {'points' if drawn else 'values'})"
        one_sided = isinstance(values, Scatter) and values.kind == "normal"
        yield Problem(
            path=key.place,
            message=f"{key.key} takes values that it must not have",
            found=" ".join(filter(None, (shown, key.unit, many))),
            allowed=bound_words(shape) or "a finite number",
            hint="lognormal and triangular distributions have an end" if one_sided else "",
        )


# ----------------------------------------------------------------------------
# What can be found wrong with a sweep before its first run.
# ----------------------------------------------------------------------------

Settings = dict[str, Any]

_PROBED = 16
_COMBINATIONS = 64


def check_design(design: Design, resolved: Mapping[str, Any]) -> list[Problem]:
    """Values that the schema forbids, and a sweep of which no point is a case.

    `resolved` is the case in SI with its defaults. Physics is left to the single points: there a
    case that cannot be is one failed point of many.
    """
    return list(forbidden_values(design)) or list(_no_point(design, resolved))


def _plans(design: Design, resolved: Mapping[str, Any]) -> list[tuple[Settings, dict[str, Entry]]]:
    """Results of one case for each combination of choices that the sweep varies, with these.

    Stages and results hang on choices alone. Without choices there is one case, the first point.
    Points that are no case are left out, and so are combinations after the first 64.
    """
    chosen, plans = {key.key for key in design.every if key.choices}, []
    for settings in islice(_combinations(design), _COMBINATIONS):
        with suppress(CaseError):
            planned = planned_quantities(validate(case_at(resolved, settings)))
            plans.append(({key: settings[key] for key in settings if key in chosen}, planned))
    return plans


def _combinations(design: Design) -> Iterator[Settings]:
    first = design.settings(0)
    steps: list[list[Settings]] = []
    for axis in design.axes:
        if axis.count is None or not any(key.choices for key in axis.keys):
            steps.append([{key.key: first[key.key] for key in axis.keys}])
        else:
            alone = Design(axes=(axis,))
            steps.append([alone.settings(n) for n in range(min(axis.count, _COMBINATIONS))])
    for parts in product(*steps):
        yield {key: value for part in parts for key, value in part.items()}


def _no_point(design: Design, resolved: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of the first point if none of some points spread over the design is a case."""
    numbers = np.unique(np.linspace(0, design.count - 1, _PROBED).astype(np.int64))
    problems: list[Problem] = []
    for number in numbers:
        try:
            validate(case_at(resolved, design.settings(int(number))))
        except CaseError as error:
            problems = problems or list(error.problems)
        else:
            return
    for problem in problems[:_SHOWN]:
        at = [key.place for key in design.every if problem.path[: len(key.path)] == key.path]
        place = at[0] if at else ("sweep",)
        yield problem._replace(
            path=place,
            message=f"no point of the sweep is a case: {problem.message}",
            also=problem.path if place == ("sweep",) else None,
        )


# ----------------------------------------------------------------------------
# Which results a sweep keeps, and whether every point will have them.
# ----------------------------------------------------------------------------

#: axes whose entries are chosen while a point is computed, so that no two points share them
UNSHARED_AXES = ("speed", "masked", "instant_time", "reversal_time", "passage", "contact")


def stored_paths(
    keep: Sequence[str], case: "Case", design: Design, resolved: Mapping[str, Any]
) -> tuple[str, ...]:
    """Result paths that a sweep keeps, sorted.

    Those that `keep` names, and the objective; by default all single numbers of the stages that
    every point runs, and of the same stages what limits and references name.
    """
    goal = {*_goal(case)}
    if keep:
        return tuple(sorted({*keep, *goal}))
    planned = planned_quantities(case)
    for _, plan in _plans(design, resolved):
        planned = {path: entry for path, entry in planned.items() if path in plan}
    named = goal | {
        deciding(limit.quantity, limit.where, side)
        for limit in case.limit
        for side in ("max", "min")
        if getattr(limit, side) is not None
    }
    named |= {reference.quantity for reference in case.reference}
    wanted = {path for path in planned if not planned[path].axes or path in named}
    return tuple(sorted(path for path in wanted if not _unshared_axis(planned[path])))


def _goal(case: "Case") -> list[str]:
    """What the objective of a sweep is on, if it has one."""
    goal = None if case.sweep is None else case.sweep.objective
    return [] if goal is None else [goal.quantity]


def keep_problems(
    keep: Sequence[str], case: "Case", design: Design, resolved: Mapping[str, Any]
) -> Iterator[Problem]:
    """Problems of the paths that `keep` and objective name: unknown, or not the same at all
    points.
    """
    plans = _plans(design, resolved)
    everywhere = planned_quantities(case)
    for _, plan in plans:
        everywhere |= plan
    places: list[tuple[KeyPath, str]] = [(("sweep", "keep", n), one) for n, one in enumerate(keep)]
    for place, path in [*places, *((("sweep", "objective"), one) for one in _goal(case))]:
        if path not in everywhere:
            if "keep" in place:  # of an objective the targets of the case say it
                yield unknown_quantity(place, path, everywhere)._replace(path=place)
        elif missing := [settings for settings, plan in plans if path not in plan]:
            at = ", ".join(f"{key} = {value}"[:100] for key, value in missing[0].items())
            yield Problem(
                path=place,
                message="not every point of the sweep has this quantity",
                found=f"{path}, without it: {at or 'the first point'}",
                hint="keep what all points have, or sweep the choices one by one",
            )
        elif axis := _unshared_axis(everywhere[path]):
            yield Problem(
                path=place,
                message=f"its axis {axis!r} is chosen anew at every point",
                found=path,
                allowed="a quantity whose axes all points share",
                hint=_instead(path, everywhere),
            )


def _unshared_axis(entry: Entry) -> str:
    return next((axis for axis in entry.axes if axis in UNSHARED_AXES), "")


def _instead(path: str, known: Mapping[str, Entry]) -> str:
    peak = f"{path}_peak"
    if peak in known:
        return f"keep {peak} instead"
    shared = [other for other, entry in known.items() if not _unshared_axis(entry)]
    near = difflib.get_close_matches(path, shared, n=1, cutoff=0.7)
    return f"keep {near[0]} instead" if near else ""


# ----------------------------------------------------------------------------
# What `check` says of a case with [sweep], before anything is computed.
# ----------------------------------------------------------------------------


def sweep_problems(loaded: LoadedCase) -> list[Problem]:
    """Problems of axes, sampling, values and kept results; none without a sweep."""
    case, resolved = loaded.case, loaded.resolved
    if case.sweep is None or not case.sweep.axes:
        return []
    try:
        design = make_design(case.sweep, resolved)
    except CaseError as error:
        return list(error.problems)
    resolved = loaded.base(design.keys)
    problems = [*_optimised_too(case, design), *check_design(design, resolved)]
    return problems or list(keep_problems(case.sweep.keep, case, design, resolved))


def _optimised_too(case: Case, design: Design) -> Iterator[Problem]:
    study = case.optimisation
    if study is None:
        return
    searched: list[tuple[KeyPath, str]] = [
        (("variables", index, "key"), variable.key)
        for index, variable in enumerate(study.variables)
    ]
    for index, stock in enumerate(study.stock):
        settled = stock.items[0].values if stock.items else ()
        tables = (stock.table, *stock.also)
        searched += [(("stock", index), f"{one}.{key}") for one in tables for key in settled]
    for path, key in searched:
        if key in design.keys:
            yield Problem(
                path=("optimisation", *path),
                message="a key that the sweep sets cannot be searched for as well",
                found=key,
                allowed="one or the other",
                also=("sweep", "axes"),
            )
