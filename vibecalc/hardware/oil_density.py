"""Density of an oil against temperature."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError

#: K, at which densities of oils are stated
STANDARD_TEMPERATURE = 288.15

#: kg/(m^3 K): expansion of lubricating oils over their density (API MPMS 11.1, ASTM D1250)
_LUBRICATING = 0.6278


def oil_density(
    density_at_15: ArrayLike, temperature: ArrayLike, expansion: ArrayLike | None = None
) -> WithError:
    """rho_15 exp(-a T (1 + 0.8 a T)) in kg/m^3, T the kelvins above 15 C, a in 1/K.

    Without `expansion` that of lubricating oils, 0.6278 / rho_15; silicone fluids want their own.
    Source: API MPMS 11.1 (ASTM D1250), lubricating oils.
    """
    dense, warm = floats(density_at_15, temperature)
    rate = _LUBRICATING / dense if expansion is None else np.asarray(expansion, dtype=float)
    swell = rate * (warm - STANDARD_TEMPERATURE)
    value = dense * np.exp(-swell * (1.0 + 0.8 * swell))
    error = value * UNIT_ROUNDOFF * (4.0 + 8.0 * np.abs(swell) * (1.0 + np.abs(swell)))
    return WithError(value, np.asarray(error))
