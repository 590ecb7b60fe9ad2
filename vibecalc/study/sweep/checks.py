"""What can be found wrong with a sweep before its first run."""

from collections.abc import Iterator, Mapping
from itertools import islice, product
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.case.load import validate
from vibecalc.errors import CaseError, KeyPath, Problem
from vibecalc.study.sweep.bounds import forbidden_values
from vibecalc.study.sweep.design import Design
from vibecalc.study.sweep.place import case_at

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

Settings = dict[str, float | int | str]

_SHOWN = 3
_PROBED = 16
_COMBINATIONS = 64


def check_design(design: Design, resolved: Mapping[str, Any]) -> list[Problem]:
    """Values that the schema forbids, and a sweep of which no point is a case.

    `resolved` is the case in SI with its defaults. Physics is left to the single points: there a
    case that cannot be is one failed point of many.
    """
    return list(forbidden_values(design)) or list(_no_point(design, resolved))


def choice_cases(design: Design, resolved: Mapping[str, Any]) -> Iterator[tuple[Settings, "Case"]]:
    """One case for each combination of choices that the sweep varies, with what they are.

    Stages and results hang on choices alone. Without choices there is one case, the first point.
    Points that are no case are left out, and so are combinations after the first 64.
    """
    names = dict(zip(design.keys, design.choices, strict=True))
    for settings in islice(_combinations(design), _COMBINATIONS):
        try:
            case = validate(case_at(resolved, settings))
        except CaseError:
            continue
        yield {key: value for key, value in settings.items() if names[key]}, case


def _combinations(design: Design) -> Iterator[Settings]:
    first = design.settings(0)
    steps: list[list[Settings]] = []
    for axis in design.axes:
        if axis.count is None or not any(axis.choices):
            steps.append([{key: first[key] for key in axis.keys}])
        else:
            alone = Design(axes=(axis,))
            steps.append([alone.settings(n) for n in range(min(axis.count, _COMBINATIONS))])
    for parts in product(*steps):
        yield {key: value for part in parts for key, value in part.items()}


def _no_point(design: Design, resolved: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of the first point if none of some points spread over the design is a case."""
    numbers = np.unique(np.linspace(0, design.count - 1, _PROBED).astype(np.int64))
    found: list[Problem] = []
    for number in numbers:
        try:
            validate(case_at(resolved, design.settings(int(number))))
        except CaseError as error:
            found = found or list(error.problems)
        else:
            return
    places = {
        path: place
        for axis in design.axes
        for path, place in zip(axis.paths, axis.places, strict=True)
    }
    for problem in found[:_SHOWN]:
        place: KeyPath = places.get(problem.path, ("sweep",))
        yield Problem(
            path=place,
            message=f"no point of the sweep is a case: {problem.message}",
            found=problem.found,
            allowed=problem.allowed,
            hint=problem.hint,
            also=problem.path if problem.path not in places else None,
        )
