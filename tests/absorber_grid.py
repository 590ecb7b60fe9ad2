"""The grid search of Baca Vasquez (2007), section 2.4 and appendix I, on a part of its grid."""

import numpy as np

from vibecalc.absorber.transfer import Absorber, amplitude, damping_from_own_ratio

#: the program's frequencies; the text says 0 to 1
FREQUENCIES = np.arange(0, 2001) / 1000.0


def grid_search(
    primary_damping: float, mass_ratio: float, stiffness: np.ndarray, own_damping: np.ndarray
) -> tuple[float, float, float]:
    """k, eps2 and the least of the largest amplitudes at the program's frequencies."""
    best = (np.nan, np.nan, np.inf)
    for k in stiffness:
        z2 = damping_from_own_ratio(own_damping, mass_ratio, k)
        with np.errstate(divide="ignore", invalid="ignore"):
            system = Absorber(primary_damping, mass_ratio, k, z2[:, None])
            top = np.max(np.abs(amplitude(system, FREQUENCIES)), axis=1)
        place = int(np.argmin(top))
        if top[place] < best[2]:
            best = (float(k), float(own_damping[place]), float(top[place]))
    return best


def thousandths(first: int, last: int) -> np.ndarray:
    """The grid of stiffness and damping from one thousandth to another."""
    return np.arange(first, last + 1) / 1000.0
