"""How many maxima a quotient of polynomials has, by Sturm's chain, where rounding lets it be told.

Changes of sign along the chain of the stationarity polynomial, at zero less at infinity, count its
roots u > 0. Along a curve maxima and minima alternate, so that the slopes at both ends tell how
many of them are maxima. Every coefficient of the chain is followed by a bound of its error; where
one that counts is not clear of its bound, nothing is claimed.
"""

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF

#: error granted to a coefficient of the polynomial, over the sum of magnitudes behind it
_GRANTED = 256.0 * UNIT_ROUNDOFF
#: coefficients below this share of the largest are zero, as for `positive_roots`
_NOTHING = 1e-280
#: what is returned where the count cannot be told
UNTOLD = -1


def maxima_counted(polynomials: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Number (rows,) of maxima over u > 0 of a function whose slope has the sign of polynomials.

    `polynomials` (rows, n) by rising power, `sizes` (rows, n) sums of the magnitudes that each
    coefficient was formed from. `UNTOLD` where rounding could change the answer.
    """
    result = np.full(len(polynomials), UNTOLD)
    largest = np.max(np.abs(polynomials), axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        there = np.abs(polynomials) / largest > _NOTHING
    width = polynomials.shape[-1]
    low = np.argmax(there, axis=-1)
    high = width - 1 - np.argmax(there[:, ::-1], axis=-1)
    code = np.where(np.any(there, axis=-1) & (high > low), low * width + high, -1)
    for each in np.unique(code[code >= 0]):
        rows = np.flatnonzero(code == each)
        first, last = divmod(int(each), width)
        piece, size = polynomials[rows, first : last + 1], sizes[rows, first : last + 1]
        with np.errstate(all="ignore"):
            result[rows] = _counted(*_scaled(piece, size))
    return result


def _scaled(piece: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both with an unknown in which the outermost sizes are alike, and errors for sizes."""
    degree = piece.shape[-1] - 1
    rise = (np.log(size[:, 0]) - np.log(size[:, -1])) / degree
    factor = np.exp(rise[:, None] * np.arange(degree + 1) - np.log(size[:, :1]))
    return piece * factor, _GRANTED * size * factor


def _counted(p: np.ndarray, doubt: np.ndarray) -> np.ndarray:
    degree = p.shape[-1] - 1
    rises, falls = p[:, 0] > 0.0, p[:, -1] < 0.0
    # the chain divides by the highest coefficient, so in 1 / u where the lowest one is larger
    turned = (np.abs(p[:, -1]) < np.abs(p[:, 0]))[:, None]
    p, doubt = (np.where(turned, a[:, ::-1], a) for a in (p, doubt))
    ahead = np.arange(1, degree + 1)
    q, blur = p[:, 1:] * ahead, doubt[:, 1:] * ahead
    chain = [(p, doubt), (q, blur)]
    for _ in range(degree - 1):
        p, doubt, q, blur = q, blur, *_remainder(p, doubt, q, blur)
        chain.append((q, blur))
    sure = np.ones(len(p), dtype=bool)
    for one, off in chain:
        for place in (0, -1):
            sure &= np.abs(one[:, place]) > off[:, place]
    at_zero, at_infinity = (np.stack([one[:, at] > 0.0 for one, _ in chain]) for at in (0, -1))
    roots = _changes(at_zero) - _changes(at_infinity)
    # between the ends maxima and minima take turns
    tops = roots + rises.astype(int) - (~falls).astype(int)
    return np.where(sure & (tops % 2 == 0), tops // 2, UNTOLD)


def _remainder(
    p: np.ndarray, doubt: np.ndarray, q: np.ndarray, blur: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """-(p mod q) for q of one degree less, brought to the size of one, and a bound of its error."""
    lead, known, unknown = q[:, -1:], np.abs(q[:, :-1]), blur[:, :-1]
    unsure = blur[:, -1:] / np.abs(lead)
    for shift in (1, 0):
        share = p[:, -1:] / lead
        most = np.abs(share)
        off = most * (doubt[:, -1:] / np.abs(p[:, -1:]) + unsure)
        p, doubt = p[:, :-1].copy(), doubt[:, :-1] + 4.0 * UNIT_ROUNDOFF * np.abs(p[:, :-1])
        p[:, shift:] -= share * q[:, :-1]
        doubt[:, shift:] += most * unknown + off * (known + unknown)
        doubt[:, shift:] += 4.0 * UNIT_ROUNDOFF * most * known
    size = np.max(np.abs(p), axis=-1, keepdims=True)
    return -p / size, doubt / size


def _changes(positive: np.ndarray) -> np.ndarray:
    changes: np.ndarray = np.sum(positive[1:] != positive[:-1], axis=0)
    return changes
