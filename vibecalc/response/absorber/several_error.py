"""Rounding in the response of several absorbers, from the polynomials that it is a quotient of."""

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.absorber.model import transfer_of
from vibecalc.response.absorber.several import Several, several_amplitude
from vibecalc.response.absorber.several_polynomials import Polynomial, several_polynomials

#: roundings on the way to a coefficient and to a power of the frequency
_ROUNDINGS = 8.0


def several_with_error(
    system: Several, frequency: np.ndarray, excitation: str, response: str, absorber: int = 1
) -> WithError:
    """`several_amplitude` of one system at frequencies x (n,) with the error of |H|.

    Numerator and denominator are sums of terms that cancel near a zero or a resonance: what is left
    keeps the rounding of the largest of them. Zero error where the response is infinite.
    """
    value = several_amplitude(system, frequency, excitation, response, absorber)
    above, below = several_polynomials(system, transfer_of(excitation, response), absorber)
    if not np.any(above):  # a mass that nothing moves, at a resonance as well
        return WithError(np.zeros_like(value), np.zeros(value.shape))
    finite = np.isfinite(value)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        lost = [_lost(side, frequency) for side in (above, below)]
        share = np.where(value == 0.0, 0.0, lost[0]) + lost[1]
        error = _ROUNDINGS * UNIT_ROUNDOFF * np.abs(value) * share
    return WithError(value, np.where(finite & np.isfinite(error), error, 0.0))


def _lost(polynomial: Polynomial, x: np.ndarray) -> np.ndarray:
    """Sum of the magnitudes of all terms at s = i x over that of their sum."""
    size = np.polynomial.polynomial.polyval(np.abs(x), np.abs(polynomial))
    value = np.abs(np.polynomial.polynomial.polyval(1j * x, polynomial))
    return np.asarray(size / value)
