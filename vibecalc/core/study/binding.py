"""A case with some of its keys set to numbers, as a function that a search can call."""

import copy
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from vibecalc.core.case.raw import NOT_COMPUTED, field_unit, number_at, parse_key
from vibecalc.core.case.study_tables import Objective, Variable
from vibecalc.core.case.tables import Limit
from vibecalc.core.results.catalogue import CATALOGUE, MAXIMA, deciding
from vibecalc.core.results.record import Record
from vibecalc.core.results.select import Side, Where, numbers, parts_of, worst
from vibecalc.core.results.verdicts import Bound, bounds_of
from vibecalc.core.run.run import StageCache, checked_case, run_case
from vibecalc.core.study.choices import choices_of, ends_of, in_words, ties_of
from vibecalc.core.study.search.problem import Problem
from vibecalc.core.study.sweep.at_once import Part, Plan, compute, planned, unsupported
from vibecalc.core.study.variables import period_of, shown_as
from vibecalc.errors import CaseError, NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.study.scatter import Machines, Scatter
    from vibecalc.schema import Case

#: results of a candidate: of itself, or of the machines within its tolerances
Found = Union[Record, "Machines"]


class Varied:
    """A case with some of its keys set to numbers between bounds.

    `lower`, `upper` and `first` (n,) are in SI, `first` the case as written (of a key that it
    leaves out the middle of the bounds); `period` (n,) is that of angles, 0 of others. `picked`
    are the places of options that are set besides, `scatter` the tolerances about each candidate.
    """

    picked: tuple[int, ...] = ()
    scatter: "Scatter | None" = None

    def __init__(
        self, loaded: "LoadedCase", moving: Sequence[Variable], cache: StageCache | None = None
    ):
        # most points of a search change some parts only, and a front comes back to old points
        self._cache = StageCache() if cache is None else cache
        self.keys, self._ties = tuple(one.key for one in moving), [ties_of(one) for one in moving]
        # what a point of the search is computed from; its own tables hold the rest
        base = loaded.base([*self.keys, *(key for ties in self._ties for key, _, _ in ties)])
        self._resolved = {k: v for k, v in base.items() if k not in NOT_COMPUTED}
        self.units = tuple(map(field_unit, self.keys))
        self._written = tuple(one.upper or 0.0 for one in moving)
        self.lower, self.upper = np.array([ends_of(one) for one in moving]).reshape(-1, 2).T
        middle = zip(self.keys, (0.5 * (self.lower + self.upper)).tolist(), strict=True)
        self.first = np.array([number_at(loaded.resolved, key, where) for key, where in middle])
        self.period = np.array([period_of(key, loaded.case.machine) for key in self.keys])

    def settings(self, variables: np.ndarray) -> dict[str, Any]:
        """Keys of the case and what they are set to."""
        settings: dict[str, Any] = {}
        for key, value, ties in zip(self.keys, map(float, variables), self._ties, strict=True):
            settings[key] = value
            settings |= {tied: factor * value + offset for tied, factor, offset in ties}
        return settings

    def case_at(self, variables: np.ndarray, more: Mapping[str, Any] | None = None) -> "Case":
        """The case with its variables and `more` keys set, checked again.

        NumericalFailure if it is not a case.
        """
        settings = self.settings(variables) | dict(more or {})
        try:
            return checked_case(self._resolved, settings, self._cache)
        except CaseError as error:
            raise NumericalFailure(str(error.problems[0].message)) from error

    def scattering(self, scatter: "Scatter", settings: Mapping[str, Any]) -> dict[str, float]:
        """What the keys that scatter are in a candidate."""
        return {
            key: float(settings.get(key, number_at(self._resolved, key, 0.0)))
            for key in scatter.keys
        }

    def results(
        self, variables: np.ndarray, wanted: frozenset[str], more: Mapping[str, Any] | None = None
    ) -> Record:
        """Some results of the case with its variables set; NumericalFailure as in a run."""
        return run_case(self.case_at(variables, more), wanted=wanted, cache=self._cache)


class Binding(Varied):
    """Variables, objective and limits of one `[optimisation]` on its case.

    The variables are those between bounds; what is picked from lists is as the case has it, or as
    `with_picked` says. `held` is each bound of each limit on the result that decides, in the order
    of the margins. `shown` is told the objective of each point evaluated, and whether it keeps all
    limits.
    """

    def __init__(self, loaded: "LoadedCase"):
        study = loaded.case.optimisation
        if study is None:
            raise ValueError("the case has no [optimisation]")
        super().__init__(loaded, study.moving)
        self.case, self.study, self.goal = loaded.case, study, study.objective
        self.choices = choices_of(study)
        if study.robust is not None:
            from vibecalc.core.study.scatter import scatter_of

            self.scatter = scatter_of(study.robust)
        self.sign, self.held = sign_of(study.objective), tuple(_held(loaded.case))
        self.shown: Callable[[float, bool], None] = lambda objective, keeps: None
        self._limited = frozenset(limit.quantity for limit, _ in self.held)
        self._foreseen = Foreseen()
        self._maxima: dict[str, int] = {}
        self._others: dict[tuple[int, ...], Binding] = {}

    def with_picked(self, picked: tuple[int, ...]) -> "Binding":
        """The same with one option of each choice, by their places; always the same object."""
        if picked not in self._others:
            self._others[picked] = other = copy.copy(self)
            other.picked = picked
        return self._others[picked]

    def settings(self, variables: np.ndarray) -> dict[str, Any]:
        """Keys of the case and what they are set to."""
        settings: dict[str, Any] = {}
        for choice, place in zip(self.choices, self.picked or (), strict=bool(self.picked)):
            settings |= choice.options[place].settings
        return settings | super().settings(variables)

    def problem(self, goals: tuple[Objective, ...] | None = None) -> Problem:
        """What a search takes: of the objective, or of several `goals`."""
        evaluate = self.evaluate if goals is None else partial(self.evaluate_all, goals=goals)
        at = self.lower, self.upper, self.first, self.period
        every = goals or (self.goal,)
        maxima = any(one.quantity in MAXIMA and worse_side(one) == "max" for one in every)
        return Problem(evaluate, *at, partial(self.ahead, goals=goals), maxima)

    def evaluate(self, variables: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
        """The objective, as its parts (p,) to be made small, the margins of each limit, and the
        absolute errors of the objective, then of the margins.

        Margins are dimensionless and kept where >= 0: those of the whole interval of a value and
        its error, as verdicts are. Parts and margins are those of all entries of a result.
        """
        (parts,), margins, errors = self.evaluate_all(variables, (self.goal,))
        self.shown(float(np.max(parts)), all((one >= 0.0).all() for one in margins))
        return parts, margins, errors

    def evaluate_all(
        self, variables: np.ndarray, goals: tuple[Objective, ...]
    ) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
        """Some objectives (all to be made small), the margins, and the errors of all."""
        found, values, margins, errors = self._results_at(variables, goals), [], [], []
        for goal in goals:
            parts, reach = self._entries(found, goal.quantity, goal.where, worse_side(goal))
            values.append(sign_of(goal) * parts)
            errors.append(np.max(reach))
        for limit, bound in self.held:
            at, reach = self._entries(found, limit.quantity, limit.where, bound.side)
            margins.append(bound.scaled(bound.left(at) - reach))
            errors.append(bound.scaled(np.max(reach)))
        return values, margins, np.array(errors)

    def worst(self, variables: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective, and the smallest margin of each limit."""
        parts, margins, _ = self.evaluate(variables)
        return float(np.max(parts)), np.array([np.min(one) for one in margins])

    def ahead(self, points: np.ndarray, goals: tuple[Objective, ...] | None = None) -> None:
        """Compute objectives and limits at points (k, n) that are about to be asked for, at once.

        Does nothing where the stages of the case take no leading axis, and leaves out points that
        need a run of their own.
        """
        self._foreseen.add(self, points, self._wanted(goals or (self.goal,)))

    def machines_at(
        self, variables: np.ndarray, scatter: "Scatter", wanted: frozenset[str]
    ) -> "Machines":
        """Some results of the machines within tolerances about a candidate.

        Raises NumericalFailure where one of the machines has no result.
        """
        from vibecalc.core.study.scatter import Machines, by_arrays

        case, count = self.case_at(variables), len(scatter.steps)
        varied = scatter.values(self.scattering(scatter, self.settings(variables)))
        parts: list[Part] = []
        alone, left = [], np.arange(count)
        if by_arrays(case, scatter.keys, wanted):
            at_paths = {parse_key(key): values for key, values in varied.items()}
            parts, left = compute(case, at_paths, count, wanted)
        for place in left.tolist():
            more = {key: float(values[place]) for key, values in varied.items()}
            try:
                alone.append((place, self.results(variables, wanted, more)))
            except NumericalFailure as failure:
                raise NumericalFailure(f"a machine within the tolerances: {failure}") from failure
        return Machines(count, parts, alone)

    def _wanted(self, goals: tuple[Objective, ...]) -> frozenset[str]:
        """Results behind objectives and limits."""
        wanted = self._limited | {goal.quantity for goal in (self.goal, *goals)}
        return wanted | {MAXIMA[path] for path in wanted & MAXIMA.keys() if self.scatter is None}

    def _results_at(self, variables: np.ndarray, goals: tuple[Objective, ...]) -> Found:
        wanted = self._wanted(goals)
        known = self._foreseen.find(self, variables, wanted)
        if known is not None:
            return known
        if self.scatter is not None:
            return self.machines_at(variables, self.scatter, wanted)
        return self.results(variables, wanted)

    def _entries(
        self, found: Found, path: str, where: Where, side: Side
    ) -> tuple[np.ndarray, np.ndarray]:
        """Entries of a result, and how far the truth may lie beyond each.

        Over tolerances it is the mean of the worst entries and some deviations more.
        """
        if isinstance(found, Record):
            entries = parts_of(found[path], where, side)
            if side == "min" or path not in MAXIMA:
                return entries
            return self._each_maximum(found, path, where, entries)
        assert self.scatter is not None
        middle, apart, error = found.moments(path, where, side)
        more = self.scatter.sigmas * apart * (1.0 if side == "max" else -1.0)
        return np.array([middle + more]), np.array([error * max(1.0, self.scatter.sigmas)])

    def _each_maximum(
        self, found: Record, path: str, where: Where, largest: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """The maxima of which a result is the largest, and that where it is none of them.

        Each is smooth where their largest has a kink. Of more than at the first point the highest
        count, of fewer some are zero.
        """
        (top,), (reach,) = largest
        heights, _, errors, _ = numbers(found[MAXIMA[path]], where)
        count = self._maxima.setdefault(path, heights.size)
        highest = np.sort(np.argsort(-heights, kind="stable")[:count])
        values = np.zeros((2, count + 1))
        values[:, : len(highest)] = heights[highest], errors[highest]
        if top > np.max(values[0]):
            values[:, -1] = top, reach
        return values[0], values[1]

    def words(self, variables: np.ndarray) -> str:
        """The variables by name, in the units that the case gives their bounds in."""
        chosen = [in_words(self.choices, self.picked)] if self.picked else []
        rows = zip(self.keys, variables, self.units, self._written, strict=True)
        shown = (f"{key} = {shown_as(float(x), unit, said)}" for key, x, unit, said in rows)
        return ", ".join([*chosen, *shown])

    def broken(self, variables: np.ndarray) -> str:
        """Which limits a point breaks and by how much, in the units of the case.

        Raises NumericalFailure as a run does.
        """
        found, said = self._results_at(variables, ()), []
        of = "" if self.scatter is None else f"mean and {self.scatter.sigmas:g} deviations of "
        for limit, bound in self.held:
            values, reach = self._entries(found, limit.quantity, limit.where, bound.side)
            left, label = bound.left(values) - reach, ""
            if np.min(left) < 0.0:
                if isinstance(found, Record):
                    _, label = worst(found[limit.quantity], limit.where, bound.side)
                of_unit = CATALOGUE[limit.quantity].unit, bound.written
                said.append(
                    f"{of}{limit.quantity}{f' at {label}' if label else ''} is "
                    f"{shown_as(float(values[np.argmin(left)]), *of_unit)}, at "
                    f"{'most' if bound.side == 'max' else 'least'} "
                    f"{shown_as(bound.value, *of_unit)} is allowed"
                )
        return "; ".join(said)

    def margin_names(self) -> tuple[str, ...]:
        """One name per margin, in the order of `evaluate`."""
        return tuple(f"{one.quantity} {bound.side} {bound.written}" for one, bound in self.held)


def _held(case: "Case") -> Iterator[tuple[Limit, Bound]]:
    """Each bound of each limit that the optimum is to keep, on the result that decides."""
    for limit in case.limit:
        if limit.at == "optimum" and limit.expect == "kept":
            both = {"max": limit.max, "min": limit.min}
            for bound in bounds_of(both, CATALOGUE[limit.quantity].unit):
                path = deciding(limit.quantity, limit.where, bound.side)
                yield limit.model_copy(update={"quantity": path}), bound


def sign_of(goal: Objective) -> float:
    """1 where an objective is to be made small, -1 where large."""
    return 1.0 if goal.sense == "min" else -1.0


def worse_side(goal: Objective) -> Side:
    """The side of the entries of an objective that counts."""
    return "max" if goal.sense == "min" else "min"


# ----------------------------------------------------------------------------
# Points that a search is about to ask for, computed at once by arrays.
# ----------------------------------------------------------------------------

#: points that are kept; a search comes back to those it has met last
MOST = 4096
#: what is picked, the variables (n,) and the paths that are wanted
_Key = tuple[tuple[int, ...], bytes, frozenset[str]]


class Foreseen:
    """Results of points by what is picked, the variables (n,) and the paths that are wanted.

    Over tolerances those of the machines about each point.
    """

    def __init__(self) -> None:
        #: None of a point that needs a run of its own
        self._known: OrderedDict[_Key, Found | None] = OrderedDict()
        self._cache = StageCache()
        #: what is picked, and wanted -> the case whose numbers become arrays; None: they cannot
        self._plans: dict[tuple[tuple[int, ...], frozenset[str]], tuple[Case, Plan] | None] = {}

    def find(self, binding: Varied, variables: np.ndarray, wanted: frozenset[str]) -> Found | None:
        """The results at a point, or None where it needs a run of its own."""
        self.add(binding, variables[None, :], wanted)
        return self._known.get((binding.picked, variables.tobytes(), wanted))

    def add(self, binding: Varied, points: np.ndarray, wanted: frozenset[str]) -> None:
        """Compute the results `wanted` at points (k, n), where arrays can."""
        keys = [(binding.picked, point.tobytes(), wanted) for point in points]
        fresh = [place for place, key in enumerate(keys) if key not in self._known]
        known = self._planned(binding, wanted) if fresh else None
        if known is None:
            return
        settings = [binding.settings(points[place]) for place in fresh]
        values = {
            key: np.array([one[key] for one in settings], dtype=float)
            for key in _numbers(settings[0])
        }
        scatter, each = binding.scatter, 1
        if scatter is not None:
            each = len(scatter.steps)
            rows = [scatter.values(binding.scattering(scatter, one)) for one in settings]
            values = {key: np.repeat(column, each) for key, column in values.items()}
            values |= {key: np.concatenate([row[key] for row in rows]) for key in scatter.keys}
        varied = {parse_key(key): column for key, column in values.items()}
        parts, left = compute(known[0], varied, each * len(fresh), wanted, known[1], self._cache)
        self._known |= dict.fromkeys(keys[fresh[place]] for place in (left // each).tolist())
        if scatter is not None:
            self._add_machines([keys[place] for place in fresh], parts, set(left // each), each)
            parts = []
        for part in parts:
            for row, place in enumerate(part.places.tolist()):
                made = {
                    path: CATALOGUE[path].quantity(
                        one.values[row], float(one.errors[row]), one.axes
                    )
                    for path, one in part.columns.items()
                }
                self._known[keys[fresh[place]]] = Record(quantities=made)
        while len(self._known) > MOST:
            self._known.popitem(last=False)

    def _add_machines(
        self, keys: list["_Key"], parts: list[Part], left: set[int], each: int
    ) -> None:
        """Enter the machines, `each` so many, of all points but those of which some are `left`."""
        from vibecalc.core.study.scatter import Machines

        for place, key in enumerate(keys):
            if place not in left:
                own = [part.some(part.places // each == place) for part in parts]
                mine = [one._replace(places=one.places % each) for one in own if len(one.places)]
                self._known[key] = Machines(each, mine, [])

    def takes(self, binding: Varied, wanted: frozenset[str]) -> bool:
        """Whether arrays compute results `wanted` over what is set to numbers."""
        return self._planned(binding, wanted) is not None

    def _planned(self, binding: Varied, wanted: frozenset[str]) -> "tuple[Case, Plan] | None":
        what = (binding.picked, wanted)
        if what not in self._plans:
            scatter = () if binding.scatter is None else binding.scatter.keys
            named = dict.fromkeys((*_numbers(binding.settings(binding.first)), *scatter))
            keys = [parse_key(key) for key in named]
            self._plans[what] = None
            try:
                case = binding.case_at(binding.first).model_copy(update={"optimisation": None})
            except NumericalFailure:
                return None
            if keys and unsupported(case, keys, wanted) is None:
                self._plans[what] = case, planned(case, wanted, keys)
        return self._plans[what]


def _numbers(settings: Mapping[str, Any]) -> list[str]:
    """Keys that are set to numbers."""
    return [key for key, value in settings.items() if isinstance(value, float)]
