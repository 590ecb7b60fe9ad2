"""Values of closed formulas in which nothing cancels, with the rounding they carry."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray


def closed_form(value: ArrayLike, roundings: float) -> WithError:
    """`value` with the absolute error of that many rounded operations on positive terms."""
    found = np.asarray(value, dtype=float)
    return WithError(found, np.asarray(roundings * UNIT_ROUNDOFF * np.abs(found)))


def floats(*values: ArrayLike) -> tuple[FloatArray, ...]:
    """All values as arrays of doubles, of their own shapes."""
    return tuple(np.asarray(value, dtype=float) for value in values)
