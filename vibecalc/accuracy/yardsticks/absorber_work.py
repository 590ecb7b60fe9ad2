"""What the peaks of absorbers take, counted in evaluations of |H| at one frequency."""

import numpy as np

from vibecalc.accuracy.yardsticks.absorber_searches import several, single
from vibecalc.accuracy.yardsticks.absorber_truths import System
from vibecalc.response.absorber.coefficients import Coupling, coupling
from vibecalc.response.absorber.measure import measure
from vibecalc.response.absorber.model import transfer_of
from vibecalc.response.absorber.peaks import near_poles
from vibecalc.response.absorber.peaks_polish import tops
from vibecalc.response.absorber.peaks_quick import quick_maxima
from vibecalc.response.absorber.polynomials import (
    excess_polynomials,
    positive_roots,
    stationarity,
)
from vibecalc.response.absorber.several_peaks import several_peaks
from vibecalc.response.absorber.several_polynomials import several_polynomials

#: value and two derivatives of |H|^2, in evaluations of |H|
_JET = 3.0
#: multiplications in an evaluation of |H|, and in polynomials with signs of Sturm's chain, and with
#: all poles, polished
_PRODUCTS, _CHAIN, _POLES = 20.0, 450.0, 1000.0
#: multiplications of an eigenproblem, over the cube of its size
_EIGENVALUES = 10.0


def own_work(system: System) -> float:
    """What all peaks take: evaluations of |H|, and the rest at its multiplications.

    Of one absorber both ways where the quick one fails.
    """
    pair = system.excitation, system.response
    if len(system.mass_ratio) > 1:
        above, below = several_polynomials(several(system), transfer_of(*pair))
        # |D|^2 has the degree of D in u, |N|^2 that of N
        degrees = len(below) - 1, len(above) + len(below) - 3
        solved = sum(_EIGENVALUES / _PRODUCTS * degree**3 for degree in degrees)
        return _JET * several_peaks(several(system), *pair).looks + solved
    flat, transfer = _flat(system), transfer_of(*pair)
    quick = quick_maxima(flat, transfer)
    work = _JET * float(quick.looks[0]) + _CHAIN / _PRODUCTS
    if quick.told[0]:
        return work
    work += _POLES / _PRODUCTS
    weights = measure(flat, transfer)
    u = np.concatenate([stationary_places(system)[0], near_poles(flat)[1]])
    looks = float(np.sum(tops(flat, weights, np.zeros(len(u), dtype=int), u)[1]))
    # without the floor what lies below it is looked at again, here that only
    rounds = 2 if np.any(weights.floor_squared) else 1
    return work + _JET * (looks + (rounds - 1) * len(u)) + rounds * stationary_places(system)[1]


def _flat(system: System) -> Coupling:
    parts = coupling(single(system))
    return Coupling(*(np.reshape(part, -1) for part in parts))


def stationary_places(system: System) -> tuple[np.ndarray, float]:
    """Roots u > 0 of the stationarity polynomial, and what its eigenvalues cost."""
    flat = _flat(system)
    weights = measure(flat, transfer_of(system.excitation, system.response))
    polynomial = stationarity(*excess_polynomials(flat, weights))
    there = np.flatnonzero(polynomial[0])
    degree = float(there[-1] - there[0]) if len(there) else 0.0
    return positive_roots(polynomial)[1], _EIGENVALUES / _PRODUCTS * degree**3
