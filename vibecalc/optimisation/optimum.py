"""What a search returns."""

from dataclasses import dataclass

import numpy as np

from vibecalc.errors import NumericalFailure


class Infeasible(NumericalFailure):
    """No point within the bounds keeps all limits; `variables` (n,) come nearest, of those met."""

    def __init__(self, message: str, variables: np.ndarray, evaluations: int):
        self.variables, self.evaluations = variables, evaluations
        super().__init__(message)


@dataclass(frozen=True, kw_only=True)
class Search:
    """One local search: where it began, where it ended and why it stopped there.

    `objective` is NaN only where the start itself could not be evaluated, and `end` then is the
    start. `violation` is the most negative margin at the end, as a positive number, or 0.
    """

    start: np.ndarray
    end: np.ndarray
    objective: float
    violation: float
    feasible: bool
    reason: str
    evaluations: int


@dataclass(frozen=True, kw_only=True)
class LocalOptimum:
    """A distinct end point that keeps all limits, with the number of searches that ended there."""

    variables: np.ndarray
    objective: float
    found_by: int


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """The best point found, how well it is known and how it was reached.

    Attributes
    ----------
    variables, variables_error : (n,) arrays
        The optimum and the absolute error of each variable. Where a continuum of points is
        equally good the error is the distance to the nearest of them.
    objective, objective_error : float
        The objective (its largest entry) and its absolute error.
    margins : (m,) array
        As `evaluate` gave them at the optimum; those of active limits are zero to round-off.
    active_margins : tuple of int
        Margins that hold the optimum where it is.
    margin_multipliers : (m,) array
        Rise of the objective for each unit by which a margin is asked to be larger, >= 0.
    active_bounds : (n,) array
        -1 at its lower bound, +1 at its upper bound, 0 in between.
    bound_multipliers : (n,) array
        Derivative of the objective by that bound, in the units of objective and variable; 0 in
        between. It is >= 0 at a lower and <= 0 at an upper bound.
    active_entries : tuple of int
        Entries of the objective that are largest together.
    kkt_residual : float
        What is left of the sum of gradients that should vanish, relative to their magnitudes.
    free_directions : int
        Number of directions in which the objective does not change to second order.
    method : str
        How the last digits were found: "newton", "zero", "sampled planes", "flat", "fixed" or
        "convex".
    evaluations, failures : int
        Points evaluated, and how many of them could not be.
    failure_messages : tuple of str
        The distinct messages of those, in the order met.
    """

    variables: np.ndarray
    variables_error: np.ndarray
    objective: float
    objective_error: float
    margins: np.ndarray
    active_margins: tuple[int, ...]
    margin_multipliers: np.ndarray
    active_bounds: np.ndarray
    bound_multipliers: np.ndarray
    active_entries: tuple[int, ...]
    kkt_residual: float
    free_directions: int
    method: str
    evaluations: int
    failures: int
    failure_messages: tuple[str, ...]
    history: tuple[Search, ...]
    optima: tuple[LocalOptimum, ...]
    notes: tuple[str, ...] = ()
