"""Weights that turn, sought for the least residual: linear in their components, so convex."""

import re
from typing import TYPE_CHECKING, NamedTuple

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


class BalancedWeights(NamedTuple):
    """The least residual that weights within their bounds reach, lower bounds and limits apart.

    `allowed` says that `optimum` keeps those, too; `lower_bound` holds in any case.
    """

    optimum: Optimum
    lower_bound: float
    allowed: bool


class _Weight(NamedTuple):
    """Places among the variables; `phase` None where the angle is not one."""

    unbalance: int
    phase: int | None


def balances(case: "Case") -> bool:
    """Whether [optimisation] seeks the least residual by weights that turn and by nothing else."""
    study = case.optimisation
    if study is None or study.method is not None or study.robust is not None:
        return False
    if study.stock or len(study.moving) < len(study.variables):
        return False
    goal = study.objective
    asked = goal.quantity == _QUANTITY and goal.sense == "min" and not goal.where
    return asked and bool(_weights(tuple(variable.key for variable in study.variables)))


def balance(binding: "Binding", case: "Case") -> BalancedWeights | None:
    """Solve for the weights; None where forces turn out not to be linear in them, as with ties.

    Raises NumericalFailure where the case has no forces.
    """

    problem = _Problem(binding, case)
    constant, columns = problem.linear()
    size = float(np.linalg.norm(constant) + np.sum(np.linalg.norm(columns, axis=0) * problem.reach))
    for share in (0.5, 0.8):
        somewhere = problem.somewhere(share)
        off = problem.forces(problem.variables(somewhere)) - constant - columns @ somewhere
        if np.linalg.norm(off) > _LINEAR * size:
            return None
    solution = least_norm(constant, columns, problem.block, problem.radius)
    variables = problem.variables(solution.unknowns)
    objective, margins = binding.worst(variables)
    # a bound that is far off must not enlarge errors: of each column by itself
    length = np.linalg.norm(columns, axis=0)
    rounding = np.linalg.norm(constant) + length @ np.abs(solution.unknowns)
    rounding = _ROUNDINGS * EPSILON * float(rounding)
    lower_bound = max(0.0, solution.lower_bound - rounding)
    inside, moved = problem.moved_inside(variables)
    unit = np.where(length > 0.0, length, 1.0)
    stiffness = np.linalg.svd(columns / unit, compute_uv=False)
    weakest = stiffness[stiffness > 1e-12 * stiffness[0]][-1] if stiffness[0] > 0.0 else 1.0
    error = rounding / float(weakest) / unit
    end = Search(
        start=binding.first,
        end=moved,
        objective=objective,
        violation=float(np.max(-margins, initial=0.0)),
        reason="solved as linear least squares within bounds",
        evaluations=problem.evaluations,
    )
    pulls = columns.T @ (constant + columns @ solution.unknowns) / (solution.value or 1.0)
    held, price = problem.bounds(solution.held, solution.unknowns, pulls)
    optimum = Optimum(
        variables=moved,
        variables_error=problem.errors(solution.unknowns, held, error),
        objective=objective,
        objective_error=objective - lower_bound if objective > lower_bound else rounding,
        margins=margins,
        active_margins=(),
        margin_multipliers=np.zeros(margins.size),
        active_bounds=held,
        bound_multipliers=price,
        kkt_residual=max(0.0, objective - lower_bound) / size if size else 0.0,
        free_directions=solution.free_directions,
        method="convex",
        evaluations=problem.evaluations,
        failures=0,
        failure_messages=(),
        history=(end,),
        optima=(LocalOptimum(moved, objective, 1),),
        notes=_notes(solution.free_directions),
    )
    return BalancedWeights(optimum, lower_bound, inside and bool(np.all(margins >= 0.0)))


def _notes(free_directions: int) -> tuple[str, ...]:
    if not free_directions:
        return ()
    return (
        f"equally good weights form a continuum with {free_directions} free "
        f"direction{'s' if free_directions > 1 else ''}; the smallest or most central are given",
    )


def _weights(keys: tuple[str, ...]) -> tuple[_Weight, ...]:
    """The weights that the keys change, or none where a key changes anything else."""
    place: dict[str, dict[str, int]] = {}
    for index, key in enumerate(keys):
        match = _WEIGHT.match(key)
        if match is None:
            return ()
        place.setdefault(match[1], {})[match[2]] = index
    if any("unbalance" not in parts for parts in place.values()):
        return ()  # a weight of given size at any angle lies on a circle, which is not convex
    return tuple(_Weight(parts["unbalance"], parts.get("phase")) for parts in place.values())


class _Problem:
    """Unknowns x (n,) for the variables of a case: components of weights, or sizes about a middle.

    `block` (n,) says which weight one belongs to, `radius` (m,) how large that may be, and `reach`
    (n,) the same for each unknown.
    """

    def __init__(self, binding: "Binding", case: "Case"):
        options = case.excitation
        assert options is not None and options.residual is not None
        residual = options.residual
        self._binding = binding
        self._scales = (residual.force_weight, residual.couple_weight / residual.reference_length)
        self._weights = _weights(binding.keys)
        counts = [1 if weight.phase is None else 2 for weight in self._weights]
        self.block = np.repeat(np.arange(len(counts)), counts)
        sizes = np.array([weight.unbalance for weight in self._weights])
        low, high = binding.lower[sizes], binding.upper[sizes]
        fixed = np.array([weight.phase is None for weight in self._weights])
        self._middle = np.where(fixed, 0.5 * (low + high), 0.0)
        self.radius = np.where(fixed, 0.5 * (high - low), high)
        self.reach = self.radius[self.block]
        self.evaluations = 0

    def forces(self, variables: np.ndarray) -> np.ndarray:
        """What the residual is the norm of, as real numbers."""
        self.evaluations += 1
        record = self._binding.results(variables, frozenset(_FORCES))
        parts = [
            scale * record[path].values.ravel()
            for scale, path in zip(self._scales, _FORCES, strict=True)
        ]
        return np.concatenate([part for whole in parts for part in (whole.real, whole.imag)])

    def linear(self) -> tuple[np.ndarray, np.ndarray]:
        """Forces without the unknowns, (k,), and what a unit of each adds, (k, n)."""
        count = self.block.size
        unknowns = [np.zeros(count), *(np.eye(count) * self.reach)]
        rows = [self.forces(self.variables(one)) for one in unknowns]
        constant, turned = rows[0], rows[1:]
        return constant, np.stack(
            [(one - constant) / reach for one, reach in zip(turned, self.reach, strict=True)],
            axis=1,
        )

    def somewhere(self, share: float) -> np.ndarray:
        """Unknowns like no others, at a share of the bounds."""
        return np.asarray(share * self.reach * np.cos(1.0 + 2.4 * np.arange(self.block.size)) / 1.5)

    def variables(self, unknowns: np.ndarray) -> np.ndarray:
        """Sizes and angles; the angle of a weight of none is that of the case."""
        binding, found = self._binding, self._binding.first.copy()
        for index, weight in enumerate(self._weights):
            parts = unknowns[self.block == index]
            if weight.phase is None:
                found[weight.unbalance] = self._middle[index] + parts[0]
                continue
            found[weight.unbalance] = np.hypot(*parts)
            if found[weight.unbalance] > EPSILON * self.radius[index]:
                low, period = binding.lower[weight.phase], binding.period[weight.phase]
                turned = (np.arctan2(parts[1], parts[0]) - low) % period
                near = period - turned < 16.0 * EPSILON * period
                found[weight.phase] = low + (0.0 if near else turned)
        return found

    def moved_inside(self, variables: np.ndarray) -> tuple[bool, np.ndarray]:
        """Whether variables keep all their bounds but for rounding, and the same within them."""
        binding = self._binding
        slack = _INSIDE * (binding.upper - binding.lower)
        inside = (variables >= binding.lower - slack) & (variables <= binding.upper + slack)
        moved = np.clip(variables, binding.lower, binding.upper)
        return bool(np.all(inside)), np.where(inside, moved, variables)

    def bounds(
        self, held: np.ndarray, unknowns: np.ndarray, pulls: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """-1, 0 or 1 for each variable, and the derivative of the residual by that bound."""
        sides, price = (
            np.zeros(len(self._binding.keys), dtype=int),
            np.zeros(len(self._binding.keys)),
        )
        for index in np.flatnonzero(held):
            of_weight = self.block == index
            size = float(np.linalg.norm(unknowns[of_weight]))
            place, weight = self._weights[index].unbalance, self._weights[index]
            sides[place] = 1 if weight.phase is not None or unknowns[of_weight][0] > 0.0 else -1
            price[place] = (
                sides[place] * float(pulls[of_weight] @ unknowns[of_weight]) / (size or 1.0)
            )
        return sides, price

    def errors(self, unknowns: np.ndarray, sides: np.ndarray, each: np.ndarray) -> np.ndarray:
        """Absolute errors of the variables for those of `each` of the unknowns (n,)."""
        found = np.zeros(len(self._binding.keys))
        for index, weight in enumerate(self._weights):
            mine = self.block == index
            size, off = float(np.linalg.norm(unknowns[mine])), float(np.max(each[mine]))
            if sides[weight.unbalance] == 0:
                found[weight.unbalance] = off
            if weight.phase is not None and size > 0.0:
                turned = np.arctan2(off, size)
                found[weight.phase] = float(turned) + 8.0 * EPSILON
        return found
