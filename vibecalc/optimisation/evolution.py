"""A population that breeds: differential evolution, for objectives with many valleys."""

import numpy as np

from vibecalc.optimisation.augmented import Walk
from vibecalc.optimisation.sampler import Values

#: fixed, so that a case gives the same result every day
SEED = 20000301
MOST_GENERATIONS = 1000
#: spread of the objective over the population, relative to its mean or in scaled units
SPREAD = 1e-9


def differential_evolution(sampler: Values, start: np.ndarray) -> Walk:
    """Let a population spread over the whole unit cube evolve; the start is one of its members.

    Points that break a limit lose against any that keep all of them, and among themselves by how
    far they break it. R. Storn and K. Price, J. Global Optim. 11 (1997), 341-359, as in scipy.
    """
    from scipy.optimize import NonlinearConstraint
    from scipy.optimize import differential_evolution as evolve

    first = sampler(start)
    assert first is not None
    entries = sampler.entries
    margins = first.size - entries

    def objective(unit: np.ndarray) -> float:
        vector = sampler(np.clip(unit, 0.0, 1.0))
        return np.inf if vector is None else float(np.max(vector[:entries]))

    def kept(unit: np.ndarray) -> np.ndarray:
        vector = sampler(np.clip(unit, 0.0, 1.0))
        return np.full(margins, -1e6) if vector is None else vector[entries:]

    found = evolve(
        objective,
        [(0.0, 1.0)] * start.size,
        constraints=(NonlinearConstraint(kept, 0.0, np.inf),) if margins else (),
        seed=np.random.default_rng(SEED),
        x0=start,
        polish=False,
        tol=SPREAD,
        atol=SPREAD,
        maxiter=MOST_GENERATIONS,
    )
    reason = "converged" if found.success else f"stopped after {MOST_GENERATIONS} generations"
    return Walk(np.clip(found.x, 0.0, 1.0), reason, bool(found.success))
