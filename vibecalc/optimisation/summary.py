"""From the unit cube back to variables, units and words."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.choice import Choice
from vibecalc.optimisation.optimum import LocalOptimum, Optimum, Search
from vibecalc.optimisation.sampler import Sampler
from vibecalc.optimisation.search import NEARLY_KEPT, Ends
from vibecalc.optimisation.variables import Box


def summary(
    sampler: Sampler,
    whole: Box,
    moving: np.ndarray,
    search: Ends,
    choice: Choice,
    rtol: float,
) -> Optimum:
    """Put the choice into the units of the caller.

    Parameters
    ----------
    sampler : Sampler
    whole : Box
        Bounds of all n variables.
    moving : (n,) array
        Which of them are not held by equal bounds.
    search, choice : Ends, Choice
    rtol : float
        As in `minimise`.
    """
    best = choice.best
    scale = sampler.scale

    def spread_out(part: np.ndarray, held: np.ndarray) -> np.ndarray:
        full = held.copy()
        full[moving] = part
        return full

    def variables(unit: np.ndarray) -> np.ndarray:
        return spread_out(sampler.box.values(unit), whole.lower)

    vector = sampler(best.unit)
    assert vector is not None
    optimum = variables(best.unit)
    inner = sampler.box.slope(optimum[moving])
    nothing = np.zeros(whole.lower.size)
    objective = float(np.max(vector[: sampler.entries])) * scale
    objective_error = best.rise * scale + 2 * EPSILON * abs(objective)
    return Optimum(
        variables=optimum,
        variables_error=spread_out(
            inner * best.error
            + np.where(best.sides == 0, 2 * EPSILON, 0.0) * np.abs(optimum[moving]),
            nothing,
        ),
        objective=objective,
        objective_error=objective_error,
        margins=vector[sampler.entries :],
        active_margins=best.active_margins,
        margin_multipliers=best.margins * scale,
        active_bounds=spread_out(best.sides, np.zeros(whole.lower.size, dtype=int)),
        bound_multipliers=spread_out(best.bounds * scale / inner, nothing),
        active_entries=best.active_entries,
        kkt_residual=best.residual,
        free_directions=best.free_directions,
        method=best.method,
        evaluations=sampler.count,
        failures=len(sampler.failures),
        failure_messages=tuple(dict.fromkeys(sampler.failures.values())),
        history=tuple(
            Search(
                start=variables(end.start),
                end=variables(end.unit),
                objective=end.objective * scale,
                violation=end.violation,
                feasible=end.violation <= NEARLY_KEPT,
                reason=end.reason,
                evaluations=end.evaluations,
            )
            for end in search.ends
        ),
        optima=tuple(
            LocalOptimum(
                variables=variables(one.unit),
                objective=one.objective * scale,
                found_by=one.found_by,
            )
            for one in choice.distinct
        ),
        notes=search.notes
        + _notes(
            best.free_directions, best.unit.size, objective_error, rtol * max(abs(objective), scale)
        ),
    )


def _notes(free_directions: int, size: int, error: float, tolerance: float) -> tuple[str, ...]:
    notes = []
    if size and free_directions == size:
        notes.append("the objective does not change with the variables here")
    elif free_directions:
        notes.append(
            f"equally good optima form a continuum with {free_directions} free direction"
            f"{'s' if free_directions > 1 else ''}; one of them is given"
        )
    if error > tolerance:
        notes.append(f"the objective is known to {error:.2g} only, {tolerance:.2g} was asked for")
    return tuple(notes)
