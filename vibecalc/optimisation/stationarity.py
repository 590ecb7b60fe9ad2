"""How far a point is from a stationary one, whoever found it."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.differences import gradient, measured_noise
from vibecalc.optimisation.multipliers import identify
from vibecalc.optimisation.sampler import Values

#: distances on the unit cube within which a limit, a bound or an entry may count as holding
CLOSENESS = (1e-6, 1e-4, 3e-3)


def stationarity(sampler: Values, unit: np.ndarray) -> float:
    """What is left of the gradients that should balance, relative to their magnitudes.

    Parameters
    ----------
    sampler : Values
    unit : (n,) array
        Point of the unit cube at which the sampler gives values.

    Returns
    -------
    residual : float
        0 at a point that satisfies the first-order conditions, 1 or so far from any; infinity
        where they cannot be formed, as on a kink or beside points that cannot be evaluated.
    """
    try:
        noise = measured_noise(sampler, unit)
        slopes = gradient(sampler, unit, noise)
    except NumericalFailure:
        return np.inf
    vector = sampler(unit)
    assert vector is not None
    residual = np.inf
    for closeness in CLOSENESS:
        _, pulls = identify(vector, slopes.first, sampler.entries, unit, closeness)
        if not np.any(slopes.kinked & (np.abs(pulls.weights) > 1e-9)):
            residual = min(residual, pulls.residual)
    return residual
