"""|H|^2 as a quotient of two polynomials in u = x^2, and where it is stationary."""

from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.response.absorber.coefficients import Coupling, coupling
from vibecalc.response.absorber.measure import Measure, measure, stiffness_weights
from vibecalc.response.absorber.model import Absorber, transfer_of

_Row: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray]


class SquaredMagnitude(NamedTuple):
    """|H|^2 = P(u) / Q(u) = f^2 + A(u) / Q(u).

    `numerator` P, `denominator` Q and `excess` A (..., n): coefficients by rising power of u,
    both over what a missing spring or a free secondary makes them share; `floor` f (...).
    """

    numerator: np.ndarray
    denominator: np.ndarray
    excess: np.ndarray
    floor: np.ndarray


def squared_magnitude(
    absorber: Absorber, excitation: str = "force", response: str = "displacement"
) -> SquaredMagnitude:
    """Polynomials of one response, for any shape of ratios."""
    parts = coupling(absorber)
    weights = measure(parts, transfer_of(excitation, response))
    above, below = excess_polynomials(parts, weights)
    floor = weights.floor_squared[..., None]
    size = max(above.shape[-1], below.shape[-1])
    top = _widened(above, size) + floor * _widened(below, size)
    return SquaredMagnitude(top, below, above, np.sqrt(weights.floor_squared))


def excess_polynomials(parts: Coupling, weights: Measure) -> tuple[np.ndarray, np.ndarray]:
    """A and Q (..., n) by rising power of u."""
    motion, mixed, cross, link, relative = form_polynomials(parts)
    own, b, d, e = stiffness_weights(parts)
    absorbed = product(b, mixed) + product(d, cross) + product(e, link)
    free = product(own, motion)
    asked = (
        product(weights.motion, motion) + product(weights.mixed, mixed)
        + product(weights.link, link) + product(weights.relative, relative)
    )  # fmt: skip
    above = -(asked + weights.floor_squared[..., None] * absorbed)
    return above, (free + absorbed)[..., :5]


def form_polynomials(parts: Coupling) -> tuple[np.ndarray, ...]:
    """The five forms of `excess.Forms` as polynomials (..., 3) in u, after the shift."""
    g0, g1, own = parts.g0, parts.g1, parts.own
    shift = parts.shift[..., None]
    zero = np.zeros_like(own)
    g0g0, g1g1, ownown = g0 * g0, g1 * g1, own * own

    def chosen(whole: _Row, late: _Row, free: np.ndarray) -> np.ndarray:
        stacked = [np.stack(rows, axis=-1) for rows in (whole, late, (free, zero, zero))]
        return np.where(shift == 0, stacked[0], np.where(shift == 1, stacked[1], stacked[2]))

    return (
        chosen((g0g0, g1g1 - 2.0 * g0 * own, ownown), (g1g1, ownown, zero), ownown),
        chosen((g0g0, g1g1 - own * g0, zero), (g1g1, zero, zero), zero),
        chosen((zero, zero, g1 * own), (zero, g1 * own, zero), zero),
        chosen((g0g0, g1g1, zero), (g1g1, zero, zero), zero),
        chosen((zero, zero, ownown), (zero, ownown, zero), ownown),
    )


def stationarity(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """A' Q - A Q' (..., n): its positive roots are the stationary frequencies squared."""
    return _slope_products(above, below, False)


def stationarity_size(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Sums of magnitudes (..., n) behind the coefficients of `stationarity`."""
    return _slope_products(np.abs(above), np.abs(below), True)


def _slope_products(above: np.ndarray, below: np.ndarray, summed: bool) -> np.ndarray:
    size, other = above.shape[-1], below.shape[-1]
    result = np.zeros((*np.broadcast_shapes(above.shape[:-1], below.shape[:-1]), size + other - 2))
    powers = np.arange(other)
    for i in range(size):
        if np.any(above[..., i]):
            less = i - powers
            product = (np.abs(less) if summed else less) * above[..., i, None] * below
            # the constants of both have no slope: without them all has one power less
            result[..., max(i - 1, 0) : i + other - 1] += product[..., 1 if i == 0 else 0 :]
    return result


def product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of polynomials along the last axis."""
    size = one.shape[-1] + other.shape[-1] - 1
    result = np.zeros((*np.broadcast_shapes(one.shape[:-1], other.shape[:-1]), size))
    for place in range(other.shape[-1]):
        if np.any(other[..., place]):
            result[..., place : place + one.shape[-1]] += other[..., place, None] * one
    return result


def positive_roots(polynomials: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and values of the real positive roots of polynomials (rows, n), by rising power.

    Eigenvalues of companion matrices after a scaling of the unknown; rows are grouped by how many
    of their outermost coefficients are zero. A root counts as real when its imaginary part is
    below 1e-5 of it: a close pair must not be lost, and the polish that follows sorts it out.
    """
    rows_found: list[np.ndarray] = []
    roots_found: list[np.ndarray] = []
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.abs(polynomials) / np.max(np.abs(polynomials), axis=-1, keepdims=True)
    there = relative > 1e-280
    width = polynomials.shape[-1]
    low = np.argmax(there, axis=-1)
    high = width - 1 - np.argmax(there[..., ::-1], axis=-1)
    some = np.any(there, axis=-1) & (high > low)
    code = np.where(some, low * width + high, -1)
    for each in np.unique(code[some]):
        rows = np.flatnonzero(code == each)
        first, last = divmod(int(each), width)
        piece = polynomials[rows, first : last + 1]
        degree = last - first
        scale = np.exp((np.log(np.abs(piece[:, 0])) - np.log(np.abs(piece[:, -1]))) / degree)
        level = np.log(scale)[:, None] * np.arange(degree + 1)
        with np.errstate(divide="ignore"):
            logs = np.log(np.abs(piece)) + level
        logs -= logs[:, -1:]
        monic = np.sign(piece) * np.sign(piece[:, -1:]) * np.exp(np.minimum(logs, 650.0))
        matrix = np.zeros((len(rows), degree, degree))
        matrix[:, np.arange(1, degree), np.arange(degree - 1)] = 1.0
        matrix[:, :, -1] = -monic[:, :-1]
        roots = np.linalg.eigvals(matrix)
        real = (roots.real > 0.0) & (np.abs(roots.imag) <= 1e-5 * np.abs(roots.real))
        where, which = np.nonzero(real)
        rows_found.append(rows[where])
        roots_found.append(roots[where, which].real * scale[where])
    if not rows_found:
        return np.zeros(0, dtype=int), np.zeros(0)
    return np.concatenate(rows_found), np.concatenate(roots_found)


def _widened(polynomial: np.ndarray, size: int) -> np.ndarray:
    result = np.zeros((*polynomial.shape[:-1], size))
    result[..., : polynomial.shape[-1]] = polynomial
    return result
