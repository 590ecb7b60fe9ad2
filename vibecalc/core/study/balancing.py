"""Weights that turn, sought for the least residual: linear in their components, so convex."""

import re
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.study.search.problem import LocalOptimum, Optimum, Search
from vibecalc.numerics.least_norm import least_norm
from vibecalc.numerics.rounding import EPSILON

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Weights that turn, sought for the least residual: linear in their components, so convex.
#
# A weight u at the angle p pulls in proportion to u cos p and u sin p. In these components the
# residual is the norm of a linear expression, and a bound on u a disc: there is one basin.
# ----------------------------------------------------------------------------

_QUANTITY = "excitation/residual"
_FORCES = ("excitation/force", "excitation/couple")
_WEIGHT = re.compile(
    r"(machine\.crank_train\.(?:counterweights|balance_shafts)\[\d+\])\.(unbalance|phase)\Z"
)
#: of the sizes that add up, what may be missing where forces are linear in the components
_LINEAR = 1e-10
#: of a bound, what rounding may pass it by
_INSIDE = 1e-9
#: roundings of forces and of their sum
_ROUNDINGS = 64.0


def balances(case: "Case") -> bool:
    """Whether [optimisation] seeks the least residual by weights that turn and by nothing else."""
    study = case.optimisation
    if study is None or study.robust is not None:
        return False
    if study.stock or len(study.moving) < len(study.variables):
        return False
    goal = study.objective
    asked = goal.quantity == _QUANTITY and goal.sense == "min" and not goal.where
    return asked and _places(tuple(variable.key for variable in study.variables)) is not None


def balance(binding: "Binding") -> tuple[Optimum, float, bool] | None:
    """The least residual that weights within their bounds reach, lower bounds and limits apart;
    what no weights fall below; and whether the optimum keeps lower bounds and limits, too.

    None where forces turn out not to be linear in them, as with ties. Raises NumericalFailure where
    the case has no forces.
    """
    problem = _Weights(binding)
    reach = problem.radius[problem.block]
    constant, *turned = map(problem.forces, (np.zeros(reach.size), *np.diag(reach)))
    columns = np.stack([one - constant for one in turned], axis=1) / reach
    length = np.linalg.norm(columns, axis=0)
    size = float(np.linalg.norm(constant) + length @ reach)
    for share in (0.5, 0.8):  # unknowns like no others
        somewhere = share * reach * np.cos(1.0 + 2.4 * np.arange(length.size)) / 1.5
        off = problem.forces(somewhere) - constant - columns @ somewhere
        if np.linalg.norm(off) > _LINEAR * size:
            return None
    solution = least_norm(constant, columns, problem.block, problem.radius)
    variables, low, high = problem.variables(solution.unknowns), binding.lower, binding.upper
    objective, margins = binding.worst(variables)
    # a bound that is far off must not enlarge errors: of each column by itself
    rounding = float(np.linalg.norm(constant) + length @ np.abs(solution.unknowns))
    rounding *= _ROUNDINGS * EPSILON
    least = max(0.0, solution.lower_bound - rounding)
    unit = np.where(length > 0.0, length, 1.0)
    stiffness = np.linalg.svd(columns / unit, compute_uv=False)
    weakest = stiffness[stiffness > 1e-12 * stiffness[0]][-1] if stiffness[0] > 0.0 else 1.0
    slack, sides = _INSIDE * (high - low), problem.sides(solution.held, solution.unknowns)
    inside = (variables >= low - slack) & (variables <= high + slack)
    moved = np.where(inside, np.clip(variables, low, high), variables)
    moved = np.where(sides == 0, moved, np.where(sides < 0, low, high))
    violation, free = float(np.max(-margins, initial=0.0)), solution.free_directions
    note = (
        f"the optimum is not unique: {free} free direction{'s' if free > 1 else ''}; the smallest "
        "or most central weights are shown"
    )
    optimum = Optimum(
        variables=moved,
        variables_error=problem.errors(solution.unknowns, sides, rounding / float(weakest) / unit),
        objective=objective,
        objective_error=objective - least if objective > least else rounding,
        margins=margins,
        margin_multipliers=np.zeros(margins.size),
        active_bounds=sides,
        kkt_residual=max(0.0, objective - least) / size if size else 0.0,
        free_directions=free,
        method="convex",
        evaluations=problem.evaluations,
        history=(Search(binding.first, moved, objective, violation, problem.evaluations),),
        optima=(LocalOptimum(moved, objective, 1),),
        notes=(note,) if free else (),
    )
    return optimum, least, bool(np.all(inside)) and violation == 0.0


def _places(keys: tuple[str, ...]) -> np.ndarray | None:
    """Places (m, 2) of the size and the angle of each weight among the keys, -1 for no angle.

    None where a key changes anything else, or the angle alone: a weight of given size at any angle
    lies on a circle, which is not convex.
    """
    place: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        match = _WEIGHT.match(key)
        if match is None:
            return None
        place.setdefault(match[1], [-1, -1])[match[2] == "phase"] = index
    found = np.array(list(place.values()))
    return None if np.any(found[:, 0] < 0) else found


class _Weights:
    """Unknowns x (n,) for the variables of a case: components of weights, or sizes about a middle.

    `block` (n,) says which weight one belongs to, `radius` (m,) how large that may be; `_basis`
    (m, n) makes complex weights of them.
    """

    def __init__(self, binding: "Binding"):
        options, places = binding.case.excitation, _places(binding.keys)
        assert options is not None and options.residual is not None and places is not None
        residual = options.residual
        self._binding, self.evaluations = binding, 0
        self._scales = (residual.force_weight, residual.couple_weight / residual.reference_length)
        self._sizes, self._phases = places.T
        self._turns = self._phases >= 0
        self.block = np.repeat(np.arange(len(places)), 1 + self._turns)
        second = np.diff(self.block, prepend=-1) == 0
        self._basis = np.eye(len(places))[:, self.block] * np.where(second, 1j, 1.0)
        low, high = binding.lower[self._sizes], binding.upper[self._sizes]
        self._middle = np.where(self._turns, 0.0, 0.5 * (low + high))
        self.radius = high - self._middle

    def forces(self, unknowns: np.ndarray) -> np.ndarray:
        """What the residual is the norm of, as real numbers."""
        self.evaluations += 1
        record = self._binding.results(self.variables(unknowns), frozenset(_FORCES))
        scaled = zip(self._scales, _FORCES, strict=True)
        parts = [scale * record[path].values.ravel() for scale, path in scaled]
        return np.concatenate([part for whole in parts for part in (whole.real, whole.imag)])

    def variables(self, unknowns: np.ndarray) -> np.ndarray:
        """Sizes and angles; the angle of a weight of none is that of the case."""
        binding, found = self._binding, self._binding.first.copy()
        weights = self._basis @ unknowns
        found[self._sizes] = np.where(self._turns, np.abs(weights), self._middle + weights.real)
        there = self._turns & (np.abs(weights) > EPSILON * self.radius)
        phases = self._phases[there]
        low, period = binding.lower[phases], binding.period[phases]
        turned = (np.angle(weights[there]) - low) % period
        found[phases] = low + np.where(period - turned < 16.0 * EPSILON * period, 0.0, turned)
        return found

    def sides(self, held: np.ndarray, unknowns: np.ndarray) -> np.ndarray:
        """-1, 0 or 1 for each variable where bounds of weights are `held` (m,)."""
        upper = self._turns | ((self._basis @ unknowns).real > 0.0)
        found = np.zeros(len(self._binding.keys), dtype=int)
        found[self._sizes] = np.where(held, np.where(upper, 1, -1), 0)
        return found

    def errors(self, unknowns: np.ndarray, sides: np.ndarray, each: np.ndarray) -> np.ndarray:
        """Absolute errors of the variables for those of `each` of the unknowns (n,)."""
        found, size = np.zeros(sides.size), np.abs(self._basis @ unknowns)
        parts = self._basis @ each
        off = np.maximum(parts.real, parts.imag)
        found[self._sizes] = np.where(sides[self._sizes] == 0, off, 0.0)
        there = self._turns & (size > 0.0)
        found[self._phases[there]] = np.arctan2(off, size)[there] + 8.0 * EPSILON
        return found
