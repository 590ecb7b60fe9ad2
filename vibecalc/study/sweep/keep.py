"""Which results a sweep keeps, and whether every point will have them."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibecalc.errors import Problem
from vibecalc.pipeline.entries.entry import Entry
from vibecalc.pipeline.plan import planned_quantities
from vibecalc.pipeline.targets import unknown_quantity
from vibecalc.study.sweep.checks import Settings, choice_cases
from vibecalc.study.sweep.design import Design

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: axes whose entries are chosen while a point is computed, so that no two points share them
OWN_AXES = ("speed", "masked", "instant_time", "reversal_time", "passage", "contact")


def kept_paths(
    keep: Sequence[str], case: "Case", design: Design, resolved: Mapping[str, Any]
) -> tuple[str, ...]:
    """Result paths that a sweep keeps, sorted.

    Those that `keep` names; by default all single numbers of the stages that every point runs,
    and of the same stages what limits and references name.
    """
    if keep:
        return tuple(sorted(set(keep)))
    planned = planned_quantities(case)
    for _, plan in _plans(design, resolved):
        planned = {path: entry for path, entry in planned.items() if path in plan}
    named = {limit.quantity for limit in case.limit}
    named |= {reference.quantity for reference in case.reference}
    wanted = {path for path in planned if not planned[path].axes or path in named}
    return tuple(sorted(path for path in wanted if not _own_axis(planned[path])))


def keep_problems(
    keep: Sequence[str], case: "Case", design: Design, resolved: Mapping[str, Any]
) -> list[Problem]:
    """Problems of the paths that `keep` names: unknown, twice, or not the same at all points."""
    problems = []
    plans = _plans(design, resolved)
    everywhere = planned_quantities(case)
    for _, plan in plans:
        everywhere |= plan
    for position, path in enumerate(keep):
        place = ("sweep", "keep", position)
        if path in keep[:position]:
            problems.append(Problem(path=place, message=f"{path} is kept twice"))
        elif path not in everywhere:
            problems.append(replace(unknown_quantity(place, path, everywhere), path=place))
        elif missing := [settings for settings, plan in plans if path not in plan]:
            problems.append(
                Problem(
                    path=place,
                    message="not every point of the sweep has this quantity",
                    found=f"{path}, without it: {_said(missing[0])}",
                    hint="keep what all points have, or sweep the choices one by one",
                )
            )
        elif axis := _own_axis(everywhere[path]):
            problems.append(
                Problem(
                    path=place,
                    message=f"its axis {axis!r} is chosen anew at every point",
                    found=path,
                    allowed="a quantity whose axes all points share",
                    hint=_instead(path, everywhere),
                )
            )
    return problems


def _plans(design: Design, resolved: Mapping[str, Any]) -> list[tuple[Settings, dict[str, Entry]]]:
    return [
        (settings, planned_quantities(case)) for settings, case in choice_cases(design, resolved)
    ]


def _own_axis(entry: Entry) -> str:
    return next((axis for axis in entry.axes if axis in OWN_AXES), "")


def _instead(path: str, known: Mapping[str, Entry]) -> str:
    peak = f"{path}_peak"
    if peak in known:
        return f"keep {peak} instead"
    shared = [other for other, entry in known.items() if not _own_axis(entry)]
    near = difflib.get_close_matches(path, shared, n=1, cutoff=0.7)
    return f"keep {near[0]} instead" if near else ""


def _said(settings: Settings) -> str:
    return ", ".join(f"{key} = {value}" for key, value in settings.items()) or "the first point"
