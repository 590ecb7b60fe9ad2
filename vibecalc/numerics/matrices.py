"""A linear machine as matrices, with what rounding may have done to them."""

from typing import NamedTuple

import numpy as np


class Matrices(NamedTuple):
    """Mass, stiffness, damping and structural (loss) matrices, each (6, 6), with absolute errors.

    Units by block: kg, kg m, kg m^2; N/m, N, N m; N s/m, N s, N m s. The error of an entry counts
    the magnitudes of all terms that were added for it, so it stands where an entry cancels to 0.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray
    mass_error: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray
    structural_error: np.ndarray
