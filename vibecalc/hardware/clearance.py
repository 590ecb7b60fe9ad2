"""Rule for the clearance between seismic mass and casing."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError

_INCH = 0.0254


def clearance_rule(outer_radius: ArrayLike) -> WithError:
    """0.010 in * (1 + sqrt(D / 10 in)) in m, D twice the outer radius (m); Baca 2007, eq. 3.19."""
    (radius,) = floats(outer_radius)
    return closed_form(0.010 * _INCH * (1.0 + np.sqrt(2.0 * radius / (10.0 * _INCH))), 8.0)
