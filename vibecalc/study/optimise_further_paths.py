"""Result paths of what an optimisation adds only if it is asked to: methods, front, slopes."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from vibecalc.case.overrides import field_unit
from vibecalc.pipeline.entries.entry import Entry

if TYPE_CHECKING:
    from vibecalc.case.tables import Optimisation

ROOT = "optimisation"
#: most runs of the stages that one compared method may spend
COMPARE_BUDGET = 5000
_FRONT_POINTS = 15


def front_points(study: "Optimisation") -> int:
    """Points of the front that are asked for."""
    return _FRONT_POINTS if study.front_points is None else study.front_points


def further_entries(study: "Optimisation", planned: Mapping[str, Entry]) -> Iterator[Entry]:
    """Catalogue entries of the parts that `study` asks for."""
    goal = planned.get(study.objective.quantity)
    unit, kind = (goal.unit, goal.amplitude) if goal else ("", None)
    keys = [variable.key for variable in study.variables]
    if study.sensitivity:
        yield Entry(f"{ROOT}/gain", (), unit, "how much better the optimum is than the start", kind)
        for key in keys:
            yield from _sensitivity(key, unit)
    if study.compare:
        yield from _methods(unit, kind)
    if study.second_objective:
        second = planned.get(study.second_objective.quantity)
        own, own_kind = (second.unit, second.amplitude) if second else ("", None)
        axes = ("front_point",)
        yield Entry(f"{ROOT}/front/objective", axes, unit, "objective along the front", kind)
        yield Entry(f"{ROOT}/front/second_objective", axes, own, "second objective there", own_kind)
        for key in keys:
            yield Entry(f"{ROOT}/front/variable/{key}", axes, field_unit(key), f"{key} there")
        yield Entry(f"{ROOT}/front/evaluations", (), "", "points evaluated for the front")


def _sensitivity(key: str, unit: str) -> Iterator[Entry]:
    own = field_unit(key)
    yield Entry(
        f"{ROOT}/sensitivity/{key}",
        ("point",),
        _over(unit, own),
        f"objective per unit of {key}",
    )
    cost = f"{ROOT}/deviation"
    yield Entry(f"{cost}/size/{key}", (), own, f"1 % of the bounds of {key}, the worse way")
    yield Entry(f"{cost}/loss/{key}", (), unit, "objective lost by it at the optimum")
    yield Entry(f"{cost}/margin/{key}", (), "", "least margin of all limits there")


def _methods(unit: str, kind: str | None) -> Iterator[Entry]:
    axes = ("method",)
    for name, own, words, amplitude in (
        ("objective", unit, "objective where the method ended", kind),
        ("shortfall", unit, "how much worse it is than the optimum", None),
        ("distance", "", "largest distance of a variable from the optimum, over its bounds", None),
        ("violation", "", "most negative margin, as a positive number", None),
        ("kkt_residual", "", "what is left of the gradients; infinite on a kink", None),
        ("converged", "", "1 where the method says that it has converged", None),
        ("evaluations", "", "points evaluated", None),
        ("failures", "", "points that could not be evaluated", None),
    ):
        yield Entry(f"{ROOT}/methods/{name}", axes, own, words, amplitude)


def _over(unit: str, own: str) -> str:
    """Unit of a slope."""
    if not own:
        return unit
    bottom = f"({own})" if any(mark in own for mark in "*/") else own
    return f"{unit or '1'}/{bottom}"
