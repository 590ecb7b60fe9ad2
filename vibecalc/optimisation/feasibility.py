"""A point that keeps all limits, or the proof of the nearest miss."""

import numpy as np

from vibecalc.optimisation.local_search import local_search
from vibecalc.optimisation.optimum import Infeasible
from vibecalc.optimisation.sampler import Sampler, Violations

MOST_TRIES = 3


def feasible_point(sampler: Sampler, ends: list[np.ndarray], margins: int) -> np.ndarray:
    """Make the worst margin as large as can be, from the least violated points known.

    Parameters
    ----------
    sampler : Sampler
    ends : list of (n,) arrays
        Points of the unit cube, the least violated first.
    margins : int
        m.

    Returns
    -------
    unit : (n,) array
        A point with all margins >= 0.

    Raises
    ------
    Infeasible
        If there is none: it names the least violated point and what is violated there.
    """
    view = Violations(sampler, margins)
    best, least = ends[0], np.inf
    for start in ends[:MOST_TRIES]:
        end = local_search(view, start).unit
        vector = view(end)
        assert vector is not None
        if np.max(vector) < least:
            best, least = end, float(np.max(vector))
        if least <= 0:
            return best
    found = sampler(best)
    assert found is not None
    kept = found[sampler.entries :]
    worst = ", ".join(f"margin {index} is {kept[index]:.6g}" for index in np.flatnonzero(kept < 0))
    nearest = sampler.box.values(best)
    raise Infeasible(
        f"no point within the bounds keeps all limits. The least violated one found is at "
        f"{nearest.tolist()}: {worst} (relative to the limit, needs >= 0). "
        "Widen the bounds of the variables or relax these limits.",
        nearest,
        sampler.count,
    )
