"""Points that a search is about to ask for, computed at once by arrays."""

from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibecalc.core.case.raw import parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import StageCache
from vibecalc.core.study.sweep.at_once import Plan, compute, planned, unsupported
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.schema import Case

#: points that are kept; a search comes back to those it has met last
MOST = 4096


class Bound(Protocol):
    """A case with variables, as `binding.Binding` is one."""

    picked: tuple[int, ...]
    first: np.ndarray

    def settings(self, variables: np.ndarray) -> dict[str, Any]:
        """Keys of the case and what they are set to."""

    def case_at(self, variables: np.ndarray) -> "Case":
        """The case with its variables set, checked."""


Key = tuple[tuple[int, ...], bytes, frozenset[str]]


class Foreseen:
    """Results of points by what is picked, the variables (n,) and the paths that are wanted."""

    def __init__(self) -> None:
        self._known: OrderedDict[Key, Record] = OrderedDict()
        self._cache = StageCache()
        #: what is picked, and wanted -> the case whose numbers become arrays; None: they cannot
        self._plans: dict[tuple[tuple[int, ...], frozenset[str]], tuple[Case, Plan] | None] = {}

    def __len__(self) -> int:
        return len(self._known)

    def find(self, binding: Bound, variables: np.ndarray, wanted: frozenset[str]) -> Record | None:
        """The results at a point, or None where it needs a run of its own."""
        key = (binding.picked, variables.tobytes(), wanted)
        if key not in self._known:
            self.add(binding, variables[None, :], wanted)
        return self._known.get(key)

    def add(self, binding: Bound, points: np.ndarray, wanted: frozenset[str]) -> None:
        """Compute the results `wanted` at points (k, n), where arrays can."""
        known = self._planned(binding, wanted)
        if known is None:
            return
        case, plan = known
        fresh = [(binding.picked, point.tobytes(), wanted) not in self._known for point in points]
        points = points[fresh]
        if not len(points):
            return
        settings = [binding.settings(point) for point in points]
        varied = {
            parse_key(key): np.array([one[key] for one in settings])
            for key, value in settings[0].items()
            if isinstance(value, float)
        }
        parts, _ = compute(case, varied, len(points), wanted, plan, self._cache)
        for part in parts:
            for row, place in enumerate(part.places.tolist()):
                quantities = {
                    path: CATALOGUE[path].quantity(
                        one.values[row], float(one.errors[row]), one.axes
                    )
                    for path, one in part.columns.items()
                }
                key = (binding.picked, points[place].tobytes(), wanted)
                self._known[key] = Record(quantities=quantities)
        while len(self._known) > MOST:
            self._known.popitem(last=False)

    def _planned(self, binding: Bound, wanted: frozenset[str]) -> "tuple[Case, Plan] | None":
        what = (binding.picked, wanted)
        if what not in self._plans:
            settings = binding.settings(binding.first)
            keys = [parse_key(key) for key, value in settings.items() if isinstance(value, float)]
            self._plans[what] = None
            try:
                case = binding.case_at(binding.first).model_copy(update={"optimisation": None})
            except NumericalFailure:
                return None
            if keys and unsupported(case, keys, wanted) is None:
                self._plans[what] = case, planned(case, wanted, keys, again=True)
        return self._plans[what]
