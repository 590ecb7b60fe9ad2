"""All peaks of |H| over frequency, from seeds that a count or a polynomial shows to be enough."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.squared_magnitude import (
    Measure,
    excess,
    excess_polynomials,
    measure,
    positive_roots,
    stationarity,
    stationarity_size,
)
from vibecalc.absorber.transfer import (
    Absorber,
    Coupling,
    coupling,
    denominator,
    ends,
    landmarks,
    numerator,
    roots_of,
    transfer_of,
)
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.maxima import Jet, Maxima, by_slopes, joined, seeds_about
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, IntArray

# ----------------------------------------------------------------------------
# How many maxima a quotient of polynomials has, by Sturm's chain, where rounding lets it be
# certain.
#
# Changes of sign along the chain of the stationarity polynomial, at zero less at infinity, count
# its roots u > 0. Along a curve maxima and minima alternate, so that the slopes at both ends tell
# how many of them are maxima. Every coefficient of the chain is followed by a bound of its error;
# where one that counts is not clear of its bound, nothing is claimed.
# ----------------------------------------------------------------------------

#: error granted to a coefficient of the polynomial, over the sum of magnitudes behind it
_GRANTED = 256.0 * UNIT_ROUNDOFF
#: coefficients below this share of the largest are zero, as for `positive_roots`
_NOTHING = 1e-280
#: what is returned where the count cannot be determined
UNCERTAIN = -1


def maxima_counted(polynomials: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Number (rows,) of maxima over u > 0 of a function whose slope has the sign of polynomials.

    `polynomials` (rows, n) by rising power, `sizes` (rows, n) sums of the magnitudes that each
    coefficient was formed from. `UNCERTAIN` where rounding could change the answer.
    """
    result = np.full(len(polynomials), UNCERTAIN)
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
        section, size = polynomials[rows, first : last + 1], sizes[rows, first : last + 1]
        with np.errstate(all="ignore"):
            result[rows] = _counted(*_scaled(section, size))
    return result


def _scaled(section: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both with an unknown in which the outermost sizes are alike, and errors for sizes."""
    degree = section.shape[-1] - 1
    growth = (np.log(size[:, 0]) - np.log(size[:, -1])) / degree
    factor = np.exp(growth[:, None] * np.arange(degree + 1) - np.log(size[:, :1]))
    return section * factor, _GRANTED * size * factor


def _counted(p: np.ndarray, uncertainty: np.ndarray) -> np.ndarray:
    degree = p.shape[-1] - 1
    rises, falls = p[:, 0] > 0.0, p[:, -1] < 0.0
    # the chain divides by the highest coefficient, so in 1 / u where the lowest one is larger
    turned = (np.abs(p[:, -1]) < np.abs(p[:, 0]))[:, None]
    p, uncertainty = (np.where(turned, a[:, ::-1], a) for a in (p, uncertainty))
    ahead = np.arange(1, degree + 1)
    q, blur = p[:, 1:] * ahead, uncertainty[:, 1:] * ahead
    chain = [(p, uncertainty), (q, blur)]
    for _ in range(degree - 1):
        p, uncertainty, q, blur = q, blur, *_remainder(p, uncertainty, q, blur)
        chain.append((q, blur))
    sure = np.ones(len(p), dtype=bool)
    for one, off in chain:
        for place in (0, -1):
            sure &= np.abs(one[:, place]) > off[:, place]
    at_zero, at_infinity = (np.stack([one[:, at] > 0.0 for one, _ in chain]) for at in (0, -1))
    roots = _changes(at_zero) - _changes(at_infinity)
    # between the ends maxima and minima take turns
    tops = roots + rises.astype(int) - (~falls).astype(int)
    return np.where(sure & (tops % 2 == 0), tops // 2, UNCERTAIN)


def _remainder(
    p: np.ndarray, uncertainty: np.ndarray, q: np.ndarray, blur: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """-(p mod q) for q of one degree less, brought to the size of one, and a bound of its error."""
    lead, known, unknown = q[:, -1:], np.abs(q[:, :-1]), blur[:, :-1]
    unsure = blur[:, -1:] / np.abs(lead)
    for shift in (1, 0):
        share = p[:, -1:] / lead
        most = np.abs(share)
        off = most * (uncertainty[:, -1:] / np.abs(p[:, -1:]) + unsure)
        p, uncertainty = (
            p[:, :-1].copy(),
            uncertainty[:, :-1] + 4.0 * UNIT_ROUNDOFF * np.abs(p[:, :-1]),
        )
        p[:, shift:] -= share * q[:, :-1]
        uncertainty[:, shift:] += most * unknown + off * (known + unknown)
        uncertainty[:, shift:] += 4.0 * UNIT_ROUNDOFF * most * known
    size = np.max(np.abs(p), axis=-1, keepdims=True)
    return -p / size, uncertainty / size


def _changes(positive: np.ndarray) -> np.ndarray:
    changes: np.ndarray = np.sum(positive[1:] != positive[:-1], axis=0)
    return changes


# ----------------------------------------------------------------------------
# Maxima of |H|^2 = f^2 + A / Q over u = x^2.
#
# Seeds about the undamped natural frequencies, which have a closed form, find the peaks of nearly
# every absorber; whether they are all is shown by a count from signs alone. Elsewhere the roots of
# the stationarity polynomial are seeds. Near a narrow peak they are blurred: a light secondary
# leaves a peak and a zero so close together that the roots run into each other. The poles stay
# apart.
# ----------------------------------------------------------------------------

#: seeds about the undamped natural frequencies
_ABOUT = np.array([0.2, 0.75, 1.0, 1.25, 4.0])
#: excess over the floor squared below which |H|^2 itself keeps its digits
_LOW = -0.5
#: decay of all poles, over the upper natural frequency, from which none is too sharp to be placed
_DAMPED = 1e-6
#: share of rounding granted to the test of that
_CLEAR = 1e-12
#: damping ratio below which a resonance is narrower than double precision can place it
_SHARP = 2e-14


class Response(NamedTuple):
    """|H|^2 of rows: `plain`, where the floor is left at zero, keeps the digits far below it."""

    parts: Coupling
    weights: Measure
    plain: Measure | None = None

    def some(self, rows: IntArray) -> "Response":
        parts = Coupling(*(a[rows] for a in self.parts))
        weights = Measure(*(a[rows] for a in self.weights))
        return Response(parts, weights, self.plain and Measure(*(a[rows] for a in self.plain)))

    def jet(self, row: IntArray, u: FloatArray) -> Jet:
        """|H|^2 and its derivatives by u."""
        jet = _jet(self.parts, self.weights, row, u)
        floor = self.weights.floor_squared[row]
        low = np.flatnonzero(jet.value < _LOW * floor)
        total = floor + jet.value
        if self.plain is not None and len(low):
            sharper = _jet(self.parts, self.plain, row[low], u[low])
            for column, new in zip(jet, sharper, strict=True):
                column[low] = new
            total[low] = sharper.value
        return jet._replace(value=total)

    def excess(self, tops: Maxima) -> FloatArray:
        """|H|^2 less the floor squared at maxima of |H|^2."""
        value = _jet(self.parts, self.weights, tops.row, tops.place.value).value
        floor = self.weights.floor_squared[tops.row]
        return np.where(value < _LOW * floor, tops.height.value - floor, value)


def _jet(parts: Coupling, weights: Measure, row: IntArray, u: FloatArray) -> Jet:
    """A / Q and its derivatives by u, free of the cancellation that polynomials suffer."""
    coupled, mine = Coupling(*(a[row] for a in parts)), Measure(*(a[row] for a in weights))
    found = excess(coupled, mine, u)
    a, q = found.above, found.below
    value = a[0] / q[0]
    first = (a[1] - value * q[1]) / q[0]
    second = (a[2] - 2.0 * first * q[1] - value * q[2]) / q[0]
    error = 8.0 * UNIT_ROUNDOFF * (found.above_size + np.abs(value) * found.below_size) / q[0]
    return Jet(value, error, first, second)


def maxima(parts: Coupling, weights: Measure) -> Maxima:
    """Maxima of A / Q by row of `parts` (rows,) and rising u = x^2.

    Resonances without any damping are no maxima of a function and mean nothing here.
    """
    whole = Response(parts, weights)
    with np.errstate(all="ignore"):
        tops = by_slopes(whole.jet, _thorough_seeds(whole))
        value = _jet(parts, weights, tops.row, tops.place.value).value
    return tops._replace(height=Bounded(value, tops.height.error))


def _all_maxima(whole: Response) -> Maxima:
    """Of |H|^2: quickly where that is sure, else thoroughly."""
    quick, uncertain = quick_maxima(whole)
    if not len(uncertain):
        return quick
    others = whole.some(uncertain)
    _refuse_sharp(others.parts)
    tops = by_slopes(others.jet, _thorough_seeds(others))
    return joined([quick, tops._replace(row=uncertain[tops.row])])


def quick_maxima(whole: Response) -> tuple[Maxima, IntArray]:
    """Maxima from few seeds, and the rows that are left out: those may have others."""
    parts, weights = whole.parts, whole.weights
    marks = landmarks(parts.mass, parts.mass * parts.g0 / parts.inertia)
    locked = parts.inertia == 0.0
    # without a spring the peak is between those with the secondary locked and free
    lower = np.choose(parts.shift, (marks.lower, marks.locked, marks.free))[:, None]
    upper = np.where(locked, marks.lower, marks.upper)[:, None]
    certain = _decays(parts, upper[:, 0])
    middle = np.sqrt(lower * upper)
    seeds = np.concatenate([lower * _ABOUT[:-1], middle, upper * _ABOUT[1:]], axis=1)
    tops = by_slopes(whole.jet, np.square(np.where(certain[:, None], seeds, np.nan)))
    above, below = excess_polynomials(parts, weights)
    counted = maxima_counted(stationarity(above, below), stationarity_size(above, below))
    certain &= counted == np.bincount(tops.row, minlength=len(certain))
    return tops.some(certain[tops.row]), np.flatnonzero(~certain)


def _thorough_seeds(whole: Response) -> FloatArray:
    """u (rows, n) of stationary places, of others between them, and of places about the poles."""
    poles, count = roots_of(denominator(whole.parts)), len(whole.parts.mass)
    tables = []
    for weights in filter(None, whole[1:]):
        row, u = positive_roots(stationarity(*excess_polynomials(whole.parts, weights)))
        table = np.full((count, 16), np.nan)
        order = np.lexsort((u, row))
        table[row[order], _places(row[order], count)] = np.sqrt(u[order])
        tables.append(table)
    present = np.where(poles.present, poles.value, 0.0)
    return np.square(seeds_about(present, np.concatenate(tables, axis=1)))


def _decays(parts: Coupling, upper: np.ndarray) -> np.ndarray:
    """Rows (rows,) whose poles all decay at a rate to speak of, as Routh and Hurwitz tell it."""
    moved, whole = denominator(parts), denominator(parts) > 0.0
    with np.errstate(all="ignore"):
        # D(s - decay), by Horner's rule
        decay = _DAMPED * upper
        for first in range(4):
            for place in range(3, first - 1, -1):
                moved[:, place] -= decay * moved[:, place + 1]
        d0, d1, d2, d3, d4 = moved.T
        terms = d3 * d2 * d1, d4 * d1 * d1, d3 * d3 * d0
        stable = terms[0] - terms[1] - terms[2] > _CLEAR * terms[0]
    positive = np.all((moved > 0.0) == whole, axis=-1) & np.all(whole[:, :3], axis=-1)
    decays: np.ndarray = positive & (stable | ~whole[:, 3])
    return decays


def _refuse_sharp(parts: Coupling) -> None:
    """Raise NumericalFailure where a damped resonance cannot be parted from an undamped one."""
    found = roots_of(denominator(parts))
    bare = (parts.primary_damping == 0.0) & (parts.g1 == 0.0)
    swings = found.present & (found.value.imag > 0.0) & ~bare[:, None]
    least = np.maximum(_SHARP * np.abs(found.value), 4.0 * found.error)
    sharp = np.any(swings & (-found.value.real < least), axis=1)
    if np.any(sharp):
        row = int(np.argmax(sharp))
        raise NumericalFailure(
            f"a resonance is damped by less than {_SHARP:g} of critical (primary damping "
            f"{parts.primary_damping[row]:.3g}, mass ratio {parts.mass[row]:.3g}): its peak is "
            "beyond double precision; take the damping as zero, or as more"
        )


# ----------------------------------------------------------------------------
# All stationary maxima of |H| over frequency, and what the curve does at both ends.
# ----------------------------------------------------------------------------

#: more maxima than a quotient of these degrees has
_MOST = 4
#: relative difference below which two heights count as one
SAME_HEIGHT = 1e-12


class Peaks(NamedTuple):
    """Stationary maxima by rising frequency (..., 4) and what the curve does at both ends (...).

    `frequency` x, `magnitude` |H| with absolute `error`, `excess` |H|^2 - f^2 over the floor f;
    zero where `present` is false. Infinite on an undamped natural frequency.
    `at_zero`, `at_infinity`: limits of |H|. `largest` with `largest_error`: the supremum of |H|
    over 0 <= x <= infinity, reached at `where` (0 or infinity for an end); of several places of
    one height, as a tuning makes them, the lowest.
    """

    frequency: np.ndarray
    magnitude: np.ndarray
    error: np.ndarray
    excess: np.ndarray
    present: np.ndarray
    at_zero: np.ndarray
    at_infinity: np.ndarray
    largest: np.ndarray
    largest_error: np.ndarray
    where: np.ndarray

    @property
    def top(self) -> Bounded:
        """The largest with its error."""
        return Bounded(self.largest, self.largest_error)


def peaks(
    absorber: Absorber, excitation: str = "force", response: str | Sequence[str] = "displacement"
) -> Peaks:
    """Find every peak of one response, for arrays of absorbers at once.

    Of several responses, found at once as well, these are the leading axis.

    Newton's method on the function itself, between seeds at the damped poles. Source of the
    response: eqs. 2.9, 2.10 and 3.14.
    Raises NumericalFailure where a resonance is damped, but by less than 2e-14 of critical.
    """
    names = [response] if isinstance(response, str) else response
    transfers, parts = [transfer_of(excitation, name) for name in names], coupling(absorber)
    shape = parts.mass.shape if isinstance(response, str) else (len(names), *parts.mass.shape)
    own = Coupling(*(np.reshape(a, -1) for a in parts))
    flat = Coupling(*(np.concatenate([a] * len(names)) for a in own))
    moved = np.concatenate([np.any(numerator(own, one), axis=-1) for one in transfers])
    bare = (flat.primary_damping == 0.0) & (flat.g1 == 0.0)
    weights, plain = (
        Measure(*map(np.concatenate, zip(*each, strict=True)))
        for each in (
            [measure(own, one) for one in transfers],
            [measure(own, one, plain=True) for one in transfers],
        )
    )
    whole = Response(flat, weights, plain)
    with np.errstate(all="ignore"):
        tops = _all_maxima(whole)
        value = whole.excess(tops)
    every = Absorber(*(np.broadcast_to(a, shape) for a in absorber))
    rows, u, value, uncertainty, square = _with_resonances(every, bare & moved, tops, value)

    size = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        error = np.minimum(uncertainty / np.maximum(size, 1e-300), np.sqrt(uncertainty))
        error = np.where(np.isinf(size), 0.0, error + 2.0 * UNIT_ROUNDOFF * size)
    place = _places(rows, len(flat.mass))
    stored = place < _MOST
    blank = np.zeros((len(flat.mass), _MOST))
    table = {name: blank.copy() for name in ("frequency", "magnitude", "error", "excess")}
    present = blank.astype(bool)
    spot = rows[stored], place[stored]
    for name, column in (
        ("frequency", np.sqrt(u)), ("magnitude", size), ("error", error), ("excess", value)
    ):  # fmt: skip
        table[name][spot] = column[stored]
    present[spot] = True

    limits = [ends(own, one) for one in transfers]
    low = np.abs(np.concatenate([one.at_zero for one in limits]))
    high = np.concatenate([one.magnitude_at_infinity for one in limits])
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
    wide = [a.reshape(*shape, _MOST) for a in (*table.values(), present)]
    return Peaks(*wide, *(a.reshape(shape) for a in (low, high, *pick)))


def _with_resonances(
    absorber: Absorber, moved: np.ndarray, tops: Maxima, value: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Rows, u, A / Q, its error and |H|^2 of all peaks, with infinite ones of rows without damping.

    What was found on these is dropped. `moved` (rows,): without damping, and with a response that
    is not zero throughout, as that of a free secondary is.
    """
    found = tops.row, tops.place.value, value, tops.height.error, tops.height.value
    if not np.any(moved):
        return found
    rows, u = found[:2]
    _, mass, stiffness, damping = (
        np.reshape(a, -1) for a in np.broadcast_arrays(*(np.asarray(r, float) for r in absorber))
    )
    stiffness = np.where(np.isinf(damping), np.inf, stiffness)
    marks = landmarks(mass, stiffness)
    both = np.stack([marks.lower, marks.upper], axis=-1)
    # the free secondary's own frequency, zero, is not seen by the primary
    true = moved[:, None] & np.isfinite(both) & (both > 0.0)
    squares = np.where(true, np.square(np.where(true, both, 1.0)), np.inf)
    near = np.abs(u[:, None] - squares[rows]) < 1e-6 * u[:, None]
    keep = ~np.any(near, axis=1)
    more, which = np.nonzero(true)
    many = np.full(len(more), np.inf)
    added = more, np.square(both[more, which]), many, np.zeros(len(more)), many
    every = [np.concatenate([old[keep], new]) for old, new in zip(found, added, strict=True)]
    order = np.lexsort((every[1], every[0]))
    return tuple(a[order] for a in every)


def _places(rows: np.ndarray, count: int) -> np.ndarray:
    """Position of each entry within its row; rows come sorted."""
    starts = np.searchsorted(rows, np.arange(count))
    place: np.ndarray = np.arange(len(rows)) - starts[rows]
    return place


def _end_error(value: np.ndarray) -> np.ndarray:
    return np.where(np.isinf(value), 0.0, 8.0 * UNIT_ROUNDOFF * np.where(np.isinf(value), 0, value))
