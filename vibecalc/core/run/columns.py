"""Many points of a sweep as one run: numbers of the case and results with a leading axis."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.number_range import ANGLES, LARGEST, LARGEST_ANGLE, SMALLEST
from vibecalc.core.case.walk import COMPARE, Shape, shape_at
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Axis
from vibecalc.core.run.run import StageCache, run_stage
from vibecalc.core.run.stage import Scene, Stage
from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.parts.machine import build_machine
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Numbers of a case that differ from point to point, as arrays over the points.
# ----------------------------------------------------------------------------

#: values (points,) by their place in the case
Varied = Mapping[KeyPath, np.ndarray]


def case_at_points(case: Case, varied: Varied) -> Case:
    """The case with arrays in place of some numbers, which nothing validates.

    What reads it may do arithmetic with them, and broadcast; what is not varied is as it was.
    """
    changed: Case = _with(case, varied)
    return changed


def _with(part: Any, varied: Varied) -> Any:
    """A table, list or number with arrays at places below it, or in place of it."""
    if () in varied:
        return varied[()]
    below: dict[str | int, dict[KeyPath, np.ndarray]] = {}
    for path, values in varied.items():
        below.setdefault(path[0], {})[path[1:]] = values
    if isinstance(part, tuple):
        return tuple(_with(one, below[n]) if n in below else one for n, one in enumerate(part))
    changed = {str(name): _with(getattr(part, str(name)), inner) for name, inner in below.items()}
    return part.model_copy(update=changed)


class Untouchable:
    """Stands for a number which nobody may read: whatever is done with it ends with an error."""

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


def _refuse(*_: Any) -> Any:
    raise TypeError("a number that varies is read")


for _name in (
    *("eq", "ne", "lt", "le", "gt", "ge", "hash", "bool", "float", "int", "index", "complex"),
    *("abs", "neg", "pos", "round", "iter", "len", "array", "repr", "str", "format"),
    *(f"{side}{name}" for side in ("", "r") for name in ("add", "sub", "mul", "truediv", "pow")),
    *(f"{side}{name}" for side in ("", "r") for name in ("floordiv", "mod", "divmod", "matmul")),
):
    setattr(Untouchable, f"__{_name}__", _refuse)


def case_untouchable(case: Case, keys: Collection[KeyPath]) -> Case:
    """The case for `reads`: nothing can be done with the numbers at `keys`."""
    untouchable: Any = Untouchable()
    return case_at_points(case, dict.fromkeys(keys, untouchable))


def reads(check: Callable[[Case], Any], case: Case) -> bool:
    """Whether a function reads a number of a case that is `Untouchable`.

    It goes the same way at all points where it reads none of those that vary.
    """
    try:
        check(case)
    except Exception:
        return True
    return False


def allowed_by(shape: Shape | None, values: np.ndarray) -> BoolArray:
    """Whether each value is finite and within the bounds of its place in a case."""
    allowed: BoolArray = np.isfinite(values)
    for name, bound in () if shape is None else shape.bounds:
        allowed &= COMPARE[name](values, bound)
    return allowed


def out_of_range(varied: Varied, count: int) -> BoolArray:
    """Points (points,) with a number outside its bounds, or of what can be computed with."""
    found = np.zeros(count, dtype=bool)
    for path, values in varied.items():
        inside, size = allowed_by(shape_at(path), values), np.abs(values)
        name = next(str(part) for part in reversed(path) if isinstance(part, str))
        inside &= size <= (LARGEST_ANGLE if name in ANGLES else LARGEST)
        inside &= (size == 0.0) | (size >= SMALLEST)
        found |= ~inside
    return found


# ----------------------------------------------------------------------------
# The stages of all points at once; their results as columns under their paths.
# ----------------------------------------------------------------------------


class Column(NamedTuple):
    """One quantity: values (points, own axes...), the largest error (points,), and its axes."""

    values: np.ndarray
    errors: FloatArray
    axes: tuple[Axis, ...]


@dataclass(kw_only=True, repr=False, eq=False)
class PointsScene(Scene):
    """A run of `count` points: results are put into `columns`, not into the record.

    `alone` (points,) are points whose results mean nothing: they need a run of their own.
    """

    count: int
    alone: BoolArray
    columns: dict[str, Column] = field(default_factory=dict)

    def again(self, name: str, inputs: Sequence[Any], make: Callable[[], Any]) -> Any:
        """As of one run, from the first on: many points have it in common."""
        if super().again(name, inputs, make) is None and self.keeper is None:
            return make()
        return super().again(name, inputs, make)

    def emit(
        self,
        path: str,
        values: Any,
        error: Any = 0.0,
        axes: Mapping[str, Any] | None = None,
        standard_error: float | None = None,
        terms: Any = 0.0,
    ) -> None:
        """As of one run, with values and errors (points, own axes...) or (own axes...)."""
        if not self.wants(path):
            return
        names, given = CATALOGUE[path].axes, axes or {}
        if isinstance(values, Bounded):
            values, error = values
        if np.isnan(values).any():
            raise NumericalFailure(f"{path} has no defined value at some points")
        shape = np.broadcast_shapes(np.shape(values), np.shape(error))
        shape = shape if len(shape) > len(names) else (1, *shape)
        largest = np.broadcast_to(error, shape).reshape(shape[0], -1).max(axis=1, initial=0.0)
        self.columns[path] = Column(
            np.broadcast_to(values, (self.count, *shape[1:])).copy(),
            np.broadcast_to(largest, self.count).copy(),
            tuple(self._axis(name, given[name]) for name in names),
        )


def run_points(
    case: Case,
    stages: tuple[Stage, ...],
    varied: Varied,
    count: int,
    wanted: frozenset[str],
    cache: StageCache | None = None,
) -> PointsScene:
    """Run stages that take a leading axis; `cache` has what earlier runs have left.

    Raises PointsApart where points differ in kind, NumericalFailure where any of them fails.
    """
    at_points = case_at_points(case, varied)
    scene = PointsScene(
        case=at_points,
        parts=build_machine(at_points),
        wanted=wanted,
        count=count,
        alone=np.zeros(count, dtype=bool),
        keeper=None if cache is None else cache.at(case, wanted).again,
    )
    for stage in stages:
        own = stage.leading.adapter if stage.leading is not None else ""
        run_stage(stage._replace(adapter=own or stage.adapter), scene)
    return scene
