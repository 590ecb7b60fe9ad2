"""Peaks of a response with several absorbers, and their derivatives by every ratio."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.peaks import SAME_HEIGHT
from vibecalc.absorber.several import Polynomial, Several, added, several_polynomials, squared
from vibecalc.absorber.transfer import Transfer, transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.maxima import Jet, Maxima, by_slopes, seeds_about
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Every peak of a response of several absorbers, from the stationarity polynomial.
# ----------------------------------------------------------------------------

#: part of a pole's size that its damping must exceed for the peak to count as finite
_DAMPED = 1e-13


class SeveralPeaks(NamedTuple):
    """Maxima of |H| by rising frequency (p,), and its limits at both ends.

    `error` is absolute, of `magnitude`. `largest` is the supremum over 0 <= x <= infinity, at
    `where`, the lowest of places of one height. `shoulder`: frequencies of poles without a peak of
    their own. `evaluations` counts evaluations of |H|^2 with two derivatives.
    """

    frequency: np.ndarray
    magnitude: np.ndarray
    error: np.ndarray
    at_zero: float
    at_infinity: float
    largest: float
    largest_error: float
    where: float
    shoulder: np.ndarray
    evaluations: int


def several_peaks(
    system: Several, excitation: str = "force", response: str = "displacement", absorber: int = 1
) -> SeveralPeaks:
    """All maxima of one system (no leading axes).

    Roots of P' Q - P Q', |H|^2 = P(u) / Q(u), by companion eigenvalues, and places about the poles
    are seeds of a search on |N / D|^2 itself, which alone decides the digits.
    Raises NumericalFailure on an undamped natural frequency, where the peak is infinite.
    """
    above, below = several_polynomials(system, transfer_of(excitation, response), absorber)
    if not np.any(above):
        none = np.zeros(0)
        return SeveralPeaks(none, none, none, 0.0, 0.0, 0.0, 0.0, 0.0, none, 0)
    above, below = _without_common_power(above, below)
    poles = _roots(below)
    bare = (np.abs(poles.real) < _DAMPED * np.abs(poles)) & (poles.imag > 0.0)
    if np.any(bare) and np.any(_relative_size(above, poles[bare]) > 1e-10):
        raise NumericalFailure(
            f"the response is infinite at x = {float(poles[bare][0].imag):.9g}, an undamped "
            "natural frequency of primary system and absorbers"
        )
    found, evaluations = _stationary(above, below, _seeds(above, below, poles))
    frequency, value = found.place.value, np.sqrt(found.height.value)
    error = 0.5 * found.height.error / value
    low = float(abs(above[0]) / below[0]) if below[0] else 0.0
    excess = (len(above) - 1) - (len(below) - 1)
    high = float(abs(above[-1]) / below[-1]) if excess == 0 else (np.inf if excess > 0 else 0.0)
    heights = np.concatenate([[low], value, [high]])
    uncertainties = np.concatenate(
        [[8 * UNIT_ROUNDOFF * low], error, [8 * UNIT_ROUNDOFF * min(high, 1)]]
    )
    places = np.concatenate([[0.0], frequency, [np.inf]])
    best = int(np.argmax(heights))
    first = int(np.argmax(heights >= heights[best] * (1.0 - SAME_HEIGHT)))
    return SeveralPeaks(
        frequency, value, error, low, high, float(heights[best]), float(uncertainties[best]),
        float(places[first]), _shoulders(poles[~bare], frequency), evaluations,
    )  # fmt: skip


def _shoulders(poles: np.ndarray, peaks: np.ndarray) -> np.ndarray:
    """Poles that swing, without the one nearest to each peak."""
    size = np.sort(np.abs(poles[poles.imag > 0.0]))
    for x in peaks:
        if len(size):
            size = np.delete(size, int(np.argmin(np.abs(size - x))))
    return size


def _without_common_power(above: Polynomial, below: Polynomial) -> tuple[Polynomial, Polynomial]:
    first = min(int(np.argmax(above != 0.0)), int(np.argmax(below != 0.0)))
    return np.trim_zeros(above[first:], "b"), np.trim_zeros(below[first:], "b")


def _roots(polynomial: Polynomial) -> np.ndarray:
    """Roots, with leading coefficients that are only rounding left out."""
    size = np.max(np.abs(polynomial))
    there = np.flatnonzero(np.abs(polynomial) > 1e-300 * size)
    roots: np.ndarray = np.roots(polynomial[: there[-1] + 1][::-1] / size)
    return roots.astype(complex)


def _relative_size(polynomial: Polynomial, s: np.ndarray) -> np.ndarray:
    powers = np.abs(s[:, None]) ** np.arange(len(polynomial))
    value = np.polynomial.polynomial.polyval(s, polynomial)
    size: np.ndarray = np.abs(value) / (powers @ np.abs(polynomial))
    return size


def _seeds(above: Polynomial, below: Polynomial, poles: np.ndarray) -> np.ndarray:
    """Frequencies (1, n) of stationary places, of others between them, and about the poles."""
    top, bottom = squared(above), squared(below)

    def slope(p: Polynomial) -> Polynomial:
        return p[1:] * np.arange(1, len(p)) if len(p) > 1 else np.zeros(1)

    stationary = added(np.convolve(slope(top), bottom), -np.convolve(top, slope(bottom)))
    u = _roots(stationary) if np.any(stationary) else np.zeros(0)
    u = u[(u.real > 0.0) & (np.abs(u.imag) < u.real)].real
    return seeds_about(poles[None], np.sqrt(u)[None])


def _stationary(above: Polynomial, below: Polynomial, seeds: np.ndarray) -> tuple[Maxima, int]:
    """Maxima of |H|^2, and how often it was evaluated."""
    evaluations = 0

    def jet_at(_: np.ndarray, x: np.ndarray) -> Jet:
        nonlocal evaluations
        evaluations += len(x)
        (top, top_slope, top_bend), top_lost = _logarithmic(above, x)
        (bottom, bottom_slope, bottom_bend), bottom_lost = _logarithmic(below, x)
        square = np.square(np.abs(top / bottom))
        first = -2.0 * (top_slope - bottom_slope).imag
        second = -2.0 * (top_bend - bottom_bend).real
        error = 8.0 * UNIT_ROUNDOFF * (len(below) + top_lost + bottom_lost) * square
        return Jet(square, error, square * first, square * (second + first * first))

    return by_slopes(jet_at, seeds), evaluations


def _logarithmic(polynomial: Polynomial, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """p(s), first and second derivative of log p by s = i x (3, ...), and digits lost in p."""
    order = np.arange(len(polynomial))
    terms = polynomial * 1j ** (order % 4)
    powers = x[:, None] ** order
    value = powers @ terms
    first = (powers[:, :-1] @ (order * terms)[1:]) / value
    second = (powers[:, :-2] @ (order * (order - 1) * terms)[2:]) / value
    # by x, and then by s
    log = np.stack([value, first / 1j, -(second - first * first)])
    return log, (powers @ np.abs(polynomial)) / np.abs(value)


# ----------------------------------------------------------------------------
# Derivatives of a peak of several absorbers by every ratio, up to the second, from the matrices.
#
# Z(x) theta = f with Z = K - x^2 M + 2 i x C; H = l' Z^-1 r, so that by two ratios a and b
# H_a = v' (r_a - Z_a y) and H_ab = -v' (Z_a y_b + Z_b y_a + Z_ab y), Z y = r, Z' v = l.
# ----------------------------------------------------------------------------


class PeakSlopes(NamedTuple):
    """log |H|^2 at the peaks (p,): level, its gradient (p, q) and second derivatives (p, q, q).

    The frequency follows each peak unless set to stay. Ratios in the order k (n), z (n), z1,
    m (n): q = 3 n + 1.
    `width` (p,): second derivative by x, negative.
    """

    level: np.ndarray
    first: np.ndarray
    second: np.ndarray
    width: np.ndarray


def several_slopes(
    system: Several, frequency: np.ndarray, transfer: Transfer, absorber: int = 1,
    follow: bool = True,
) -> PeakSlopes:  # fmt: skip
    """Derivatives at peaks `frequency` (p,) of one system (no leading axes).

    With `follow` false the frequencies stay, and need not be peaks. By an infinite k or z, which
    locks an absorber, and by its partner the derivatives are zero.
    """
    z1 = float(np.asarray(system.primary_damping))
    m, k, z = (np.asarray(part, dtype=float) for part in system[1:4])
    count = len(m)
    locked = np.isinf(k) | np.isinf(z)
    unit = _coordinates(system.parent, locked)
    k, z = np.where(locked, 0.0, k), np.where(locked, 0.0, z)
    link = unit[1:] - unit[list(system.parent)]
    bonds = link[:, :, None] * link[:, None, :]
    per_unit = unit[:, :, None] * unit[:, None, :]
    x = np.asarray(frequency, dtype=float)
    inertia = np.concatenate([[1.0], m])
    mass = np.tensordot(inertia, per_unit, 1)
    drag = np.tensordot(z, bonds, 1) + z1 * per_unit[0]
    stiff = np.tensordot(k, bonds, 1) + per_unit[0]
    wide = x[:, None, None]
    matrix = stiff - wide**2 * mass + 2j * wide * drag

    # by k, z, z1, m and last x
    size = 3 * count + 2
    width = unit.shape[1]
    by = np.zeros((len(x), size, width, width), dtype=complex)
    turn = 2j * x[:, None, None, None]
    by[:, :count] = bonds
    by[:, count : 2 * count] = turn * bonds
    by[:, 2 * count] = turn[:, 0] * per_unit[0]
    by[:, 2 * count + 1 : -1] = -(x[:, None, None, None] ** 2) * per_unit[1:]
    by[:, -1] = -2.0 * wide * mass + 2j * drag
    twice = np.zeros_like(by)  # by x and the other
    twice[:, count : 2 * count] = 2j * bonds
    twice[:, 2 * count] = 2j * per_unit[0]
    twice[:, 2 * count + 1 : -1] = -2.0 * x[:, None, None, None] * per_unit[1:]
    twice[:, -1] = -2.0 * mass

    left, right, right_by = _ends(transfer, absorber, inertia, unit, link, size)
    y = np.linalg.solve(matrix, np.broadcast_to(right, (len(x), width))[..., None])[..., 0]
    v = np.linalg.solve(
        np.swapaxes(matrix, -1, -2), np.broadcast_to(left, (len(x), width))[..., None]
    )[..., 0]
    load = right_by - np.einsum("pqij,pj->pqi", by, y)
    moved = np.linalg.solve(matrix[:, None], load[..., None])[..., 0]
    value = y @ left
    first = np.einsum("pi,pqi->pq", v, load) / value[:, None]
    pulled = np.einsum("pi,pqij->pqj", v, by)
    second = -np.einsum("paj,pbj->pab", pulled, moved)
    second = second + np.swapaxes(second, -1, -2)
    mixed = np.einsum("pi,pqij,pj->pq", v, twice, y)
    second[:, :, -1] -= mixed
    second[:, -1, :-1] -= mixed[:, :-1]
    second = second / value[:, None, None] - first[:, :, None] * first[:, None, :]
    first, second = 2.0 * first.real, 2.0 * second.real

    level = 2.0 * np.log(np.abs(value)) + 2.0 * transfer.power * np.log(x)
    first[:, -1] += 2.0 * transfer.power / x
    second[:, -1, -1] -= 2.0 * transfer.power / x**2
    if transfer.ground:
        square = 1.0 + 4.0 * z1 * z1 * x * x
        g, d = float(transfer.ground), 2 * count
        level = level + g * np.log(square)
        first[:, d] += g * 8.0 * z1 * x * x / square
        first[:, -1] += g * 8.0 * z1 * z1 * x / square
        second[:, d, d] += g * 8.0 * x * x * (2.0 - square) / square**2
        second[:, -1, -1] += g * 8.0 * z1 * z1 * (2.0 - square) / square**2
        second[:, d, -1] += g * 16.0 * z1 * x / square**2
        second[:, -1, d] += g * 16.0 * z1 * x / square**2
    if not follow:
        return PeakSlopes(level, first[:, :-1], second[:, :-1, :-1], second[:, -1, -1])
    return _following(level, first, second)


def _coordinates(parent: tuple[int, ...], locked: np.ndarray) -> np.ndarray:
    """Displacements (n + 1, free) of all masses by those that are free of their support."""
    free = np.flatnonzero(np.concatenate([[True], ~locked]))
    unit = np.zeros((len(locked) + 1, len(free)))
    unit[free, np.arange(len(free))] = 1.0
    for i in np.flatnonzero(locked):
        unit[i + 1] = unit[parent[i]]
    return unit


def _ends(
    transfer: Transfer, absorber: int, inertia: np.ndarray, unit: np.ndarray, link: np.ndarray,
    size: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """What is read (l), what drives (r), and the derivatives of r."""
    by = np.zeros((size, unit.shape[1]))
    left, right = unit[0], unit[0]
    if transfer.motion == "ground":
        right = inertia @ unit
        by[-len(unit) : -1] = unit[1:]
    elif transfer.motion == "relative":
        left = link[absorber - 1]
    elif transfer.motion == "secondary":
        left = unit[absorber]
    return left, right, by


def _following(level: np.ndarray, first: np.ndarray, second: np.ndarray) -> PeakSlopes:
    """Let the frequency go to the top of the parabola."""
    width, tilt, across = second[:, -1, -1], first[:, -1], second[:, :-1, -1]
    return PeakSlopes(
        level - 0.5 * tilt**2 / width,
        first[:, :-1] - across * (tilt / width)[:, None],
        second[:, :-1, :-1] - across[:, :, None] * across[:, None, :] / width[:, None, None],
        width,
    )
