"""How an optimum moves with primary damping and mass ratio: derivatives of its own conditions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.several_newton import Held, hold
from vibecalc.optimisation.absorber.several_problem import Problem
from vibecalc.optimisation.absorber.several_starts import usual_size
from vibecalc.response.absorber.model import transfer_of
from vibecalc.response.absorber.several_slopes import several_slopes

#: curvature, in units of `usual_size`, below which the optimum has no definite place
_FLAT = 1e-9


class Sensitivity(NamedTuple):
    """Derivatives by primary damping (first) and by each mass ratio (then): (1 + n,) columns.

    `peak` (1 + n,), `stiffness_ratio`, `secondary_damping` (n, 1 + n); zero where a bound holds
    the ratio or the absorber is fastened rigidly. Errors are absolute.
    """

    peak: np.ndarray
    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    peak_error: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray


def sensitivity(
    primary_damping: float, mass_ratio: ArrayLike, stiffness_ratio: ArrayLike,
    secondary_damping: ArrayLike, parent: tuple[int, ...] = (0,), excitation: str = "force",
    response: str = "displacement",
) -> Sensitivity:  # fmt: skip
    """Derivatives of the minimax optimum at which the given k (n) and z2 (n) stand.

    The conditions (levels of the active peaks equal, their weighted slopes zero) are differentiated
    implicitly, with the second derivatives of each peak. The peak itself moves as its own
    derivative at fixed ratios says, weighted (envelope theorem).
    Raises NumericalFailure where the point is no optimum, or one of a set.
    """
    m = np.atleast_1d(np.asarray(mass_ratio, dtype=float))
    start = np.concatenate([
        np.atleast_1d(np.asarray(stiffness_ratio, dtype=float)),
        np.atleast_1d(np.asarray(secondary_damping, dtype=float)),
    ])  # fmt: skip
    n = len(m)
    locked = np.isinf(start[:n]) | np.isinf(start[n:])
    fixed = np.concatenate([locked, locked])
    start = np.where(fixed, 0.0, start)
    problem = Problem(
        float(primary_damping), m, parent, excitation, response, np.zeros(2 * n),
        np.where(fixed, 0.0, np.inf), locked=tuple(bool(one) for one in locked),
    )  # fmt: skip
    scale = usual_size(problem)
    held = hold(problem, start, scale)
    if held is None or not np.all(held.rows.moves[held.active]):
        raise NumericalFailure(
            "sensitivity: the given stiffness and damping are not an optimum held by its peaks, or "
            "its peaks stand too little above an end of the frequency range to tell"
        )
    if float(np.max(np.abs(held.ratios - start) / scale)) > 1e-3:
        raise NumericalFailure(
            "sensitivity: the optimum lies elsewhere, at stiffness ratios "
            f"{held.ratios[:n]} and dampings {held.ratios[n:]}"
        )
    table, right, free, slope = _conditions(problem, held, scale)
    if held.curvature < _FLAT:
        raise NumericalFailure("sensitivity: the optimum is one of a set and has no derivative")
    found = -np.linalg.solve(table, right)
    # what a residual and rounding may change, by the condition of the system
    grown = np.abs(np.linalg.inv(table)) @ (np.abs(right) + np.abs(table) @ np.abs(found))
    doubt = (held.residual + held.step + 4.0 * float(np.max(held.rows.error))) * grown
    moved, error = np.zeros((2 * n, 1 + n)), np.zeros((2 * n, 1 + n))
    count = int(np.sum(free))
    moved[free], error[free] = found[:count], doubt[:count]
    moved, error = moved * scale[:, None], error * scale[:, None]
    weight = held.weight[held.active]
    peak = float(np.exp(0.5 * np.max(held.rows.level[held.active])))
    change = 0.5 * peak * (weight @ slope)
    roughness = 0.5 * peak * (held.residual + 1e-12) * np.max(np.abs(slope), axis=0)
    shift = 0.5 * peak * held.residual * np.sum(np.abs(moved / scale[:, None]), axis=0)
    return Sensitivity(
        change, moved[:n], moved[n:], roughness + shift + 1e-13 * np.abs(change), error[:n],
        error[n:],
    )  # fmt: skip


def _conditions(
    problem: Problem, held: Held, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix of the conditions, their derivatives by the data, free unknowns, slopes by the data.

    Unknowns: ratios in units of `scale`, weights, level.
    """
    size, count = len(scale), int(np.sum(held.active))
    found = several_slopes(
        problem.system(held.ratios), held.rows.frequency[held.active],
        transfer_of(problem.excitation, problem.response),
    )  # fmt: skip
    weight = held.weight[held.active]
    free = ~(held.on_lower | held.on_upper)
    bend = np.tensordot(weight, found.second, 1)
    own = (scale[:, None] * bend[:size, :size] * scale)[np.ix_(free, free)]
    slope = (found.first[:, :size] * scale)[:, free]
    width = int(np.sum(free))
    table = np.zeros((width + count + 1, width + count + 1))
    table[:width, :width] = own
    table[:width, width:-1], table[width:-1, :width] = slope.T, slope
    table[width:-1, -1], table[-1, width:-1] = -1.0, 1.0
    data = found.first[:, size:]
    right = np.zeros((width + count + 1, data.shape[1]))
    right[:width] = (scale[:, None] * bend[:size, size:])[free]
    right[width:-1] = data
    return table, right, free, data
