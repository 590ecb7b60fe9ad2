"""Values with their errors, how much a double-precision sum may be off, and what is too much."""

from typing import NamedTuple

import numpy as np

#: largest relative error of one rounded operation
UNIT_ROUNDOFF = 2.0**-53

#: distance from 1 to the next double: twice that
EPSILON = 2.0 * UNIT_ROUNDOFF

#: roundings granted to data that an earlier stage formed (a moment of inertia from a box, say)
DATA_ROUNDINGS = 8

#: a response whose relative error estimate reaches this is refused: fewer than four digits remain
SINGULAR = 1e-4


class WithError(NamedTuple):
    """Real or complex values and an absolute error of the same shape and unit."""

    value: np.ndarray
    error: np.ndarray
