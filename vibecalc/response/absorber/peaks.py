"""All stationary maxima of |H| over frequency, from a polynomial, not from a grid."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.coefficients import Coupling, coupling, denominator, ends, numerator
from vibecalc.response.absorber.measure import Measure, measure
from vibecalc.response.absorber.model import Absorber, Transfer, transfer_of
from vibecalc.response.absorber.peaks_polish import Tops, each_once, slope, tops
from vibecalc.response.absorber.peaks_quick import quick_maxima
from vibecalc.response.absorber.poles import landmarks, roots_of
from vibecalc.response.absorber.polynomials import excess_polynomials, positive_roots, stationarity

#: more maxima than a quotient of these degrees has
_MOST = 4
#: damping ratio below which a resonance is narrower than double precision can place it
_SHARP = 2e-14
#: relative difference below which two heights count as one
SAME_HEIGHT = 1e-12
#: starts beside a pole, in half widths
_BESIDE = np.array([0.0, -1.0, 1.0, -2.5, 2.5])


class Peaks(NamedTuple):
    """Stationary maxima by rising frequency (..., 4) and what the curve does at both ends (...).

    `frequency` x, `magnitude` |H| with absolute `error`, `excess` |H|^2 - f^2 over the floor f;
    zero where `found` is false. Infinite on an undamped natural frequency.
    `at_zero`, `at_infinity`: limits of |H|. `largest` with `largest_error`: the supremum of |H|
    over 0 <= x <= infinity, reached at `where` (0 or infinity for an end); of several places of
    one height, as a tuning makes them, the lowest.
    """

    frequency: np.ndarray
    magnitude: np.ndarray
    error: np.ndarray
    excess: np.ndarray
    found: np.ndarray
    at_zero: np.ndarray
    at_infinity: np.ndarray
    largest: np.ndarray
    largest_error: np.ndarray
    where: np.ndarray


def peaks(absorber: Absorber, excitation: str = "force", response: str = "displacement") -> Peaks:
    """Find every peak of one response, for arrays of absorbers at once.

    Newton's method on the function itself, from the undamped natural frequencies; signs of the
    stationarity polynomial A' Q - A Q' count whether these are all. Where that is not sure it is
    solved by companion eigenvalues, and each root and pole polished in the same way. Source of the
    response: eqs. 2.9, 2.10 and 3.14.
    Raises NumericalFailure where a resonance is damped, but by less than 2e-14 of critical.
    """
    transfer = transfer_of(excitation, response)
    parts = coupling(absorber)
    shape = parts.mass.shape
    flat = Coupling(*(np.reshape(a, -1) for a in parts))
    moved = np.any(numerator(flat, transfer), axis=-1)
    rows, u, value, doubt, square = _with_resonances(
        flat, absorber, moved, *_all_maxima(flat, transfer)
    )

    size = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        error = np.minimum(doubt / np.maximum(size, 1e-300), np.sqrt(doubt))
        error = np.where(np.isinf(size), 0.0, error + 2.0 * UNIT_ROUNDOFF * size)
    place = _places(rows, len(flat.mass))
    kept = place < _MOST
    blank = np.zeros((len(flat.mass), _MOST))
    table = {name: blank.copy() for name in ("frequency", "magnitude", "error", "excess")}
    found = blank.astype(bool)
    spot = rows[kept], place[kept]
    for name, column in (
        ("frequency", np.sqrt(u)), ("magnitude", size), ("error", error), ("excess", value)
    ):  # fmt: skip
        table[name][spot] = column[kept]
    found[spot] = True

    limit = ends(flat, transfer)
    low, high = np.abs(limit.at_zero), limit.magnitude_at_infinity
    heights = np.concatenate([low[:, None], table["magnitude"], high[:, None]], axis=1)
    wrong = np.concatenate(
        [4.0 * UNIT_ROUNDOFF * low[:, None], table["error"], _end_error(high)[:, None]], axis=1
    )
    places = np.concatenate(
        [np.zeros_like(low)[:, None], table["frequency"], np.full_like(high, np.inf)[:, None]],
        axis=1,
    )
    best = np.argmax(heights, axis=1)[:, None]
    pick = [np.take_along_axis(a, best, axis=1)[:, 0] for a in (heights, wrong)]
    first = np.argmax(heights >= pick[0][:, None] * (1.0 - SAME_HEIGHT), axis=1)[:, None]
    pick.append(np.take_along_axis(places, first, axis=1)[:, 0])
    wide = [a.reshape(*shape, _MOST) for a in (*table.values(), found)]
    return Peaks(*wide, *(a.reshape(shape) for a in (low, high, *pick)))


def maxima(
    parts: Coupling,
    weights: Measure,
    more: tuple[np.ndarray, np.ndarray] | None = None,
    ceiling: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows, u = x^2, A / Q and its error of all maxima, by row and rising u; `parts` (rows,).

    `more`: rows and u of further places to start from. `ceiling` (rows,): maxima above it are of no
    interest, so that starts above it are left out. Resonances without any damping are not
    maxima of a function and are left out.
    """
    return _maxima(parts, weights, more, ceiling)[:4]


def _maxima(
    parts: Coupling,
    weights: Measure,
    more: tuple[np.ndarray, np.ndarray] | None = None,
    ceiling: np.ndarray | None = None,
) -> Tops:
    above, below = excess_polynomials(parts, weights)
    rows, u = positive_roots(stationarity(above, below))
    if more is not None:
        rows, u = np.concatenate([rows, more[0]]), np.concatenate([u, more[1]])
    if ceiling is not None and len(rows):
        own = Coupling(*(a[rows] for a in parts))
        mine = Measure(*(a[rows] for a in weights))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            low = ~(slope(own, mine, u).value >= ceiling[rows])
        rows, u = rows[low], u[low]
    return tops(parts, weights, rows, u)[0]


def _all_maxima(parts: Coupling, transfer: Transfer) -> tuple[np.ndarray, ...]:
    """Rows, u, A / Q, its error and |H|^2 of all: quickly where that is sure, else thoroughly."""
    quick = quick_maxima(parts, transfer)
    found = quick.tops[:5]
    rest = np.flatnonzero(~quick.told)
    if not len(rest):
        return found
    own = Coupling(*(a[rest] for a in parts))
    _refuse_sharp(own)
    others = _thorough(own, transfer)
    others = others._replace(rows=rest[others.rows])
    joined = [np.concatenate(pair) for pair in zip(found, others[:5], strict=True)]
    order = np.lexsort((joined[1], joined[0]))
    return tuple(a[order] for a in joined)


def _thorough(parts: Coupling, transfer: Transfer) -> Tops:
    """From all roots and poles; far below the floor from |H|^2 itself."""
    weights, starts = measure(parts, transfer), near_poles(parts)
    high, floor = _maxima(parts, weights, starts), weights.floor_squared
    if not np.any(floor):
        return high
    plain = measure(parts, transfer, plain=True)
    low = _maxima(parts, plain, starts, 0.5 * floor)
    above, below = high.value >= -0.6 * floor[high.rows], low.value < 0.5 * floor[low.rows]
    low = low._replace(value=low.value - floor[low.rows])
    both = zip(high, low, strict=True)
    return each_once(Tops(*(np.concatenate([a[above], b[below]]) for a, b in both)))


def _refuse_sharp(parts: Coupling) -> None:
    """Raise NumericalFailure where a damped resonance cannot be told from an undamped one."""
    found = roots_of(denominator(parts))
    bare = (parts.primary_damping == 0.0) & (parts.g1 == 0.0)
    swings = found.found & (found.value.imag > 0.0) & ~bare[:, None]
    least = np.maximum(_SHARP * np.abs(found.value), 4.0 * found.error)
    sharp = np.any(swings & (-found.value.real < least), axis=1)
    if np.any(sharp):
        row = int(np.argmax(sharp))
        raise NumericalFailure(
            f"a resonance is damped by less than {_SHARP:g} of critical (primary damping "
            f"{parts.primary_damping[row]:.3g}, mass ratio {parts.mass[row]:.3g}): its peak is "
            "beyond double precision; take the damping as zero, or as more"
        )


def near_poles(parts: Coupling) -> tuple[np.ndarray, np.ndarray]:
    """Rows and u of all damped natural frequencies: beside a narrow peak the polynomial is blurred.

    A light secondary leaves a peak and a zero so close together that the roots run into each
    other; the poles stay apart.
    """
    found = roots_of(denominator(parts))
    rows, which = np.nonzero(found.found & (found.value.imag > 0.0))
    pole = found.value[rows, which]
    # beside a zero the top stands off the pole, by about its half width
    x = pole.imag - pole.real * _BESIDE[:, None]
    ahead = x > 0.0
    return np.broadcast_to(rows, x.shape)[ahead], np.square(x[ahead])


def _with_resonances(
    parts: Coupling, absorber: Absorber, moved: np.ndarray, rows: np.ndarray, u: np.ndarray,
    value: np.ndarray, doubt: np.ndarray, square: np.ndarray,
) -> tuple[np.ndarray, ...]:  # fmt: skip
    """Add the infinite peaks of rows without damping; what was found on them is dropped.

    `moved` (rows,): the response is not zero throughout, as that of a free secondary is.
    """
    bare = (parts.primary_damping == 0.0) & (parts.g1 == 0.0) & moved
    if not np.any(bare):
        return rows, u, value, doubt, square
    _, mass, stiffness, damping = (
        np.reshape(a, -1) for a in np.broadcast_arrays(*(np.asarray(r, float) for r in absorber))
    )
    stiffness = np.where(np.isinf(damping), np.inf, stiffness)
    marks = landmarks(mass, stiffness)
    both = np.stack([marks.lower, marks.upper], axis=-1)
    # the free secondary's own frequency, zero, is not seen by the primary
    true = bare[:, None] & np.isfinite(both) & (both > 0.0)
    squares = np.where(true, np.square(np.where(true, both, 1.0)), np.inf)
    near = np.abs(u[:, None] - squares[rows]) < 1e-6 * u[:, None]
    keep = ~np.any(near, axis=1)
    more, which = np.nonzero(true)
    many = np.full(len(more), np.inf)
    joined = [
        np.concatenate([old[keep], new])
        for old, new in (
            (rows, more), (u, np.square(both[more, which])), (value, many), (doubt, 0.0 * more),
            (square, many),
        )
    ]  # fmt: skip
    order = np.lexsort((joined[1], joined[0]))
    return tuple(a[order] for a in joined)


def _places(rows: np.ndarray, count: int) -> np.ndarray:
    """Position of each entry within its row; rows come sorted."""
    starts = np.searchsorted(rows, np.arange(count))
    place: np.ndarray = np.arange(len(rows)) - starts[rows]
    return place


def _end_error(value: np.ndarray) -> np.ndarray:
    return np.where(np.isinf(value), 0.0, 8.0 * UNIT_ROUNDOFF * np.where(np.isinf(value), 0, value))
