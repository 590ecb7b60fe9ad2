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
from vibecalc.errors import CaseError, KeyPath, Problem
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Values of a sweep that the schema forbids: which, how many, at how many points.
# ----------------------------------------------------------------------------

_BLOCK = 1 << 18  # values looked through at a time
_SHOWN = 3


def _forbidden_values(design: Design) -> Iterator[Problem]:
    """One problem for each key with values outside its bounds; no run is needed for it."""
    for column, key in enumerate(design.every):
        values, shape = key.values, key.shape
        if key.choices or np.all(allowed_by(shape, np.array(values.ends))):
            continue
        total = values.count or design.count
        wrong = np.empty(0)
        for start in range(0, total, _BLOCK):
            numbers = np.arange(start, min(start + _BLOCK, total))
            some = values.at(numbers) if values.count else design.value_of(numbers)[:, column]
            wrong = np.append(wrong, some[~allowed_by(shape, some)])
        if not wrong.size:
            continue
        shown = ", ".join(f"{value:.6g}" for value in wrong[:_SHOWN])
        shown += ", ..." * (wrong.size > _SHOWN)
        many = f"({wrong.size} of {total:.6g} {'values' if values.count else 'points'})"
        one_sided = values.described.get("distribution") == "normal"
        yield Problem(
            path=key.place,
            message=f"{key.key} takes values outside its range",
            found=" ".join(filter(None, (shown, key.unit, many))),
            allowed=bound_words(shape) or "a finite number",
            hint="lognormal and triangular distributions have an end" if one_sided else "",
        )


# ----------------------------------------------------------------------------
# What can be found wrong with a sweep before its first run.
# ----------------------------------------------------------------------------

_PROBED = 16
_COMBINATIONS = 64


def check_design(design: Design, resolved: Mapping[str, Any]) -> list[Problem]:
    """Values that the schema forbids, and a sweep of which no point is a case.

    `resolved` is the case in SI with its defaults. Physics is left to the single points: there a
    case that cannot be is one failed point of many.
    """
    return list(_forbidden_values(design)) or list(_no_point(design, resolved))


def _plans(
    design: Design, resolved: Mapping[str, Any]
) -> list[tuple[dict[str, Any], dict[str, Entry]]]:
    """Results of one case for each combination of choices that the sweep varies, with these.

    Stages and results hang on choices alone. Without choices there is one case, the first point.
    Points that are no case are left out, and so are combinations after the first 64.
    """
    axes = [one for one in design.axes if one.count and any(key.choices for key in one.keys)]
    alone = [Design(axes=(axis,)) for axis in axes]
    first, chosen = design.settings(0), {key.key for key in design.every if key.choices}
    plans = []
    for places in islice(product(*(range(one.count) for one in alone)), _COMBINATIONS):
        settings = dict(first)
        for one, place in zip(alone, places, strict=True):
            settings |= one.settings(place)
        with suppress(CaseError):
            planned = planned_quantities(validate(case_at(resolved, settings)))
            plans.append(({key: settings[key] for key in settings if key in chosen}, planned))
    return plans


def _no_point(design: Design, resolved: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of the first point if none of some points spread over the design is a case."""
    numbers = np.unique(np.linspace(0, design.count - 1, _PROBED).astype(np.int64))
    problems: list[Problem] = []
    for settings in design.settings_of(numbers):
        try:
            validate(case_at(resolved, settings))
        except CaseError as error:
            problems = problems or list(error.problems)
        else:
            return
    for problem in problems[:_SHOWN]:
        at = [key.place for key in design.every if problem.path[: len(key.path)] == key.path]
        yield problem._replace(
            path=at[0] if at else ("sweep",),
            message=f"no point of the sweep is a case: {problem.message}",
            also=None if at else problem.path,
        )


# ----------------------------------------------------------------------------
# Which results a sweep keeps, and whether every point will have them.
# ----------------------------------------------------------------------------

#: axes whose entries are chosen while a point is computed, so that no two points share them
UNSHARED_AXES = (
    *("speed", "resonance_skipped", "instant_time", "reversal_time"),
    *("passage", "contact"),
)


def stored_paths(
    keep: Sequence[str], case: "Case", design: Design, resolved: Mapping[str, Any]
) -> tuple[str, ...]:
    """Result paths that a sweep keeps, sorted.

    Those that `keep` names, and the objective; by default all single numbers of the stages that
    every point runs, and of the same stages what limits and references name.
    """
    objective = None if case.sweep is None else case.sweep.objective
    goal = set() if objective is None else {objective.quantity}
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
    if case.sweep is not None and case.sweep.objective is not None:
        places.append((("sweep", "objective"), case.sweep.objective.quantity))
    for place, path in places:
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
