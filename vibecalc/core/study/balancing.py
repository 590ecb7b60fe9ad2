"""Weights that turn, sought for the least residual: linear in their components, so convex."""

import re
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.study.search.problem import LocalOptimum, Optimum, Search
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The least norm of what weights leave: linear least squares with each weight within its bound.
# ----------------------------------------------------------------------------

MOST_STEPS = 200
#: growth of the weight of the objective against the barrier, from round to round
_GROWTH = 8.0
_ROUNDS = 40
#: share of a bound that rounding may pass it by
_WITHIN = 1e-12


class LeastNorm(NamedTuple):
    """The minimum and its proof.

    `unknowns` (n,); `value` the norm there, and no unknowns within the bounds give less than
    `lower_bound`; `held` (m,) tells which bounds hold it; `free_directions` counts those in which
    the norm does not change.
    """

    unknowns: np.ndarray
    value: float
    lower_bound: float
    held: np.ndarray
    free_directions: int


def least_norm(
    constant: np.ndarray, columns: np.ndarray, block: np.ndarray, radius: np.ndarray
) -> LeastNorm:
    """Minimise |constant + columns x| where every block of x is no longer than its radius.

    Parameters
    ----------
    constant : (k,) array
        What is there without the unknowns.
    columns : (k, n) array
        What a unit of each unknown adds.
    block : (n,) array of int
        The block, 0 .. m-1, that an unknown belongs to: one for a weight at a given angle, two for
        the components of a weight at any angle.
    radius : (m,) array
        Largest length of each block, > 0.

    Raises
    ------
    NumericalFailure
        If the iteration does not end, which a convex problem gives no reason for.

    Notes
    -----
    Without the bounds it is linear least squares; the solution of least length, in shares of the
    radii, counts where it keeps them. Else Newton's method follows the logarithmic barrier of the
    bounds (S. Boyd and L. Vandenberghe, Convex Optimization, 2004, ch. 11) and then solves the
    conditions of the bounds that hold. Any y with |y| <= 1 proves a lower bound (ibid., ch. 5),

        |c + A x| >= y.(c + A x) >= y.c - sum_j r_j |(A^T y)_j|,

    and that of the residual's own direction meets the minimum.
    """
    count = radius.size
    size = float(np.max(np.abs(columns * radius[block]), initial=0.0)) or 1.0
    constant, scaled = constant / size, columns * (radius[block] / size)
    member = (block[None, :] == np.arange(count)[:, None]).astype(float)
    solution, _, rank, _ = np.linalg.lstsq(scaled, -constant, rcond=1e-12)
    held = np.zeros(count, dtype=bool)
    if np.max(member @ solution**2, initial=0.0) > 1.0:
        start = _barrier(constant, scaled, member, block)
        solution, held = _sharpened(constant, scaled, member, block, start)
        outwards = _outwards(solution, member, held).T
        rank = int(np.linalg.matrix_rank(np.vstack([scaled, outwards])))
    residual = constant + scaled @ solution
    value = float(np.linalg.norm(residual))
    return LeastNorm(
        unknowns=solution * radius[block],
        value=size * value,
        lower_bound=size * _lower_bound(constant, scaled, member, residual, value),
        held=held,
        free_directions=int(solution.size - rank),
    )


def _lower_bound(
    constant: np.ndarray,
    columns: np.ndarray,
    member: np.ndarray,
    residual: np.ndarray,
    value: float,
) -> float:
    if value == 0.0:
        return 0.0
    direction = residual / value
    pulls = np.sqrt(member @ (columns.T @ direction) ** 2)
    return max(0.0, float(direction @ constant - np.sum(pulls)))


def _outwards(solution: np.ndarray, member: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Gradients of the bounds that hold, (n, number of them)."""
    return np.asarray((member[held] * solution).T)


def _barrier(
    constant: np.ndarray, columns: np.ndarray, member: np.ndarray, block: np.ndarray
) -> np.ndarray:
    """A point inside all bounds, close to the minimum."""
    point = np.zeros(columns.shape[1])
    gram, slope = columns.T @ columns, columns.T @ constant
    weight = 1.0 / max(float(np.max(np.abs(slope))), np.finfo(float).tiny)
    steps = 0
    for _ in range(_ROUNDS):
        for _ in range(MOST_STEPS):
            steps += 1
            room = 1.0 - member @ point**2
            gradient = weight * (gram @ point + slope) + 2.0 * point / room[block]
            outwards = member * (2.0 * point) / room[:, None]
            curvature = weight * gram + np.diag(2.0 / room[block]) + outwards.T @ outwards
            step = -np.linalg.solve(curvature, gradient)
            decrement = float(-gradient @ step)
            length = 1.0 / (1.0 + np.sqrt(max(decrement, 0.0)))  # damped: it stays inside
            point = point + (1.0 if decrement < 0.05 else length) * step
            if decrement < 1e-9:
                break
        weight *= _GROWTH
        gap = member.shape[0] / weight
        norm = float(np.linalg.norm(constant + columns @ point))
        if gap <= 1e-9 * max(norm**2, 1e-6 * float(constant @ constant)):
            break
    return point


def _sharpened(
    constant: np.ndarray,
    columns: np.ndarray,
    member: np.ndarray,
    block: np.ndarray,
    start: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method on the conditions of the minimum: unknowns, and which bounds hold."""
    gram, slope = columns.T @ columns, columns.T @ constant
    pull = np.sqrt(member @ (gram @ start + slope) ** 2)
    room = 1.0 - member @ start**2
    # multiplier times room is the same for all on the path of the barrier: who has the larger one?
    held = pull / max(float(np.max(pull)), np.finfo(float).tiny) > room
    for _ in range(2 * held.size + 1):
        point, price = start.copy(), np.where(held, pull, 0.0)
        for _ in range(MOST_STEPS):
            outwards = _outwards(point, member, held)
            first = gram @ point + slope + price[block] * point
            second = 0.5 * (member[held] @ point**2 - 1.0)
            size = outwards.shape[1]
            matrix = np.block(
                [[gram + np.diag(price[block]), outwards], [outwards.T, np.zeros((size, size))]]
            )
            step = -np.linalg.lstsq(matrix, np.concatenate([first, second]), rcond=None)[0]
            point = point + step[: point.size]
            price[held] += step[point.size :]
            if np.max(np.abs(step[: point.size])) <= 8.0 * EPSILON:
                break
        over = member @ point**2 > 1.0 + _WITHIN
        negative = price < -_WITHIN * max(float(np.max(np.abs(price))), np.finfo(float).tiny)
        if not np.any(over | negative):
            length = np.sqrt(member @ point**2)
            return point / np.maximum(length, 1.0)[block], held & (price > 0.0)
        held = (held | over) & ~negative
    raise NumericalFailure("the least residual within the bounds of the weights was not settled")


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
    objective, margins = binding.evaluate(variables)
    lower_bound = max(0.0, solution.lower_bound - _ROUNDINGS * EPSILON * size)
    inside, moved = problem.moved_inside(variables)
    stiffness = np.linalg.svd(columns * problem.reach, compute_uv=False)
    weakest = stiffness[stiffness > 1e-12 * stiffness[0]][-1] if stiffness[0] > 0.0 else size
    error = _ROUNDINGS * EPSILON * size / float(weakest)
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
        objective_error=objective - lower_bound if objective > lower_bound else EPSILON * size,
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

    def errors(self, unknowns: np.ndarray, sides: np.ndarray, share: float) -> np.ndarray:
        """Absolute errors of the variables for an error of the unknowns in shares of the radii."""
        found = np.zeros(len(self._binding.keys))
        for index, weight in enumerate(self._weights):
            size = float(np.linalg.norm(unknowns[self.block == index]))
            if sides[weight.unbalance] == 0:
                found[weight.unbalance] = share * self.radius[index]
            if weight.phase is not None and size > 0.0:
                turned = np.arctan2(share * self.radius[index], size)
                found[weight.phase] = float(turned) + 8.0 * EPSILON
        return found
