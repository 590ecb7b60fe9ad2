"""All peaks of |H| over frequency: by polynomial, or faster where a count proves them all."""

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
    Transfer,
    coupling,
    denominator,
    ends,
    landmarks,
    numerator,
    roots_of,
    transfer_of,
)
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

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
# Newton's method for the maxima of A / Q over u = x^2, each start let go once it has settled.
# ----------------------------------------------------------------------------

#: rounds at most; a well separated maximum settles in three to five
_ROUNDS = 12
#: longest step in ln u; of starts that may lead anywhere
_LONGEST, _FAR = 0.05, 0.2
#: a maximum farther than this from its start, in ln u, belongs to another one
REACH = 0.1
#: a start that has come so far will not end within reach
_ASTRAY = 0.14
#: maxima nearer than this, in ln u, are one
_SAME = 1e-8
#: steps below this that no longer shrink are those of rounding
_FINE = 1e-9


class Slope(NamedTuple):
    """First and second derivative of A / Q by ln u, A / Q itself and its error, each (k,)."""

    first: np.ndarray
    second: np.ndarray
    value: np.ndarray
    uncertainty: np.ndarray


def slope(parts: Coupling, weights: Measure, u: np.ndarray) -> Slope:
    """Derivatives by ln u, free of the cancellation that the polynomials suffer."""
    found = excess(parts, weights, u)
    a, q = found.above, found.below
    value = a[0] / q[0]
    first = (a[1] - value * q[1]) / q[0]
    second = (a[2] - 2.0 * first * q[1] - value * q[2]) / q[0]
    uncertainty = 8.0 * UNIT_ROUNDOFF * (found.above_size + np.abs(value) * found.below_size) / q[0]
    return Slope(u * first, u * first + u * u * second, value, uncertainty)


class Tops(NamedTuple):
    """Maxima by row and rising u = x^2, all (k,).

    `value` A / Q with its error `uncertainty`, `square` |H|^2, and `blur`, how far ln u is off at
    most.
    """

    rows: np.ndarray
    u: np.ndarray
    value: np.ndarray
    uncertainty: np.ndarray
    square: np.ndarray
    blur: np.ndarray


def tops(
    parts: Coupling, weights: Measure, rows: np.ndarray, start: np.ndarray, far: bool = False
) -> tuple[Tops, np.ndarray]:
    """Maxima that Newton's method reaches from places `start` (k,) of rows (k,), and its
    evaluations.

    Those farther than `REACH` from their start are left out, unless `far`. Looks (k,) count
    evaluations of `slope`.
    """
    coupled, mine = _of_rows(parts, weights, rows)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u, steps = polished(coupled, mine, start, far)
        first, second, value, uncertainty = slope(coupled, mine, u)
        # on a very sharp peak the last bit of u is felt
        short = 0.5 * np.square(first) / np.abs(second)
        last = 0.5 * np.abs(second) * (4.0 * UNIT_ROUNDOFF) ** 2
        uncertainty = uncertainty + short + last
        # what has not settled came from a pole without a peak of its own
        size = mine.floor_squared + value
        near = short < 1e-8 * size + 64.0 * last
        if not far:
            near &= np.abs(np.log(u / start)) < REACH
        blur = np.abs(first / second)
    keep = near & (second < 0.0) & np.isfinite(value)
    stationary = Tops(rows[keep], u[keep], value[keep], uncertainty[keep], size[keep], blur[keep])
    return each_once(stationary), steps + 1


def each_once(stationary: Tops) -> Tops:
    """By row and rising u; of what was found twice, the one that has settled better."""
    order = np.lexsort((stationary.u, stationary.rows))
    stationary = Tops(*(a[order] for a in stationary))
    while len(stationary.u) > 1:
        apart = np.diff(np.log(stationary.u))
        alike = np.maximum(_SAME, 4.0 * (stationary.blur[1:] + stationary.blur[:-1]))
        twice = np.flatnonzero((stationary.rows[1:] == stationary.rows[:-1]) & (apart < alike))
        if not len(twice):
            break
        # of each row of equal ones only the first pair, the others in the next round
        first = np.ones(len(twice), dtype=bool)
        first[1:] = np.diff(twice) > 1
        pair = twice[first]
        worse = np.where(stationary.blur[pair] > stationary.blur[pair + 1], pair, pair + 1)
        stationary = Tops(*(np.delete(a, worse) for a in stationary))
    return stationary


def _of_rows(parts: Coupling, weights: Measure, rows: np.ndarray) -> tuple[Coupling, Measure]:
    return Coupling(*(a[rows] for a in parts)), Measure(*(a[rows] for a in weights))


def polished(
    parts: Coupling, weights: Measure, start: np.ndarray, far: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Places u (k,) that Newton's method reaches from `start` (k,), and the steps it took (k,).

    `parts` and `weights` (k,). Each start ends by itself, so that its last bit does not depend on
    the others: where the next step, with steps that square, would be below rounding, where small
    steps no longer shrink, or well beyond `REACH`. Whether that is a maximum is for the caller to
    see. With `far` no place is out of reach, and every step goes uphill.
    """
    longest = _FAR if far else _LONGEST
    u, steps = start.copy(), np.zeros(len(start), dtype=int)
    live, before = np.arange(len(start)), np.full(len(start), np.inf)
    for _ in range(_ROUNDS):
        if not len(live):
            break
        coupled, mine = _of_rows(parts, weights, live)
        at = slope(coupled, mine, u[live])
        # the reciprocal of a resonance is nearly a parabola
        size = mine.floor_squared + at.value
        bend = at.second - 2.0 * at.first * at.first / size
        step = at.first / (-np.abs(bend) if far else bend)
        step = np.where(np.isfinite(step), np.clip(step, -longest, longest), 0.0)
        u[live] = u[live] * np.exp(-step)
        steps[live] += 1
        step = np.abs(step)
        squaring = step * np.square(step / before) <= 0.125 * UNIT_ROUNDOFF
        stuck = (step > 0.25 * before) | (step <= UNIT_ROUNDOFF)
        settled = (step <= _FINE) & (squaring | stuck)
        going = ~settled
        if not far:
            going &= np.abs(np.log(u[live] / start[live])) <= _ASTRAY
        live, before = live[going], step[going]
    return u, steps


# ----------------------------------------------------------------------------
# Maxima of |H| from the undamped natural frequencies, where a count says that these are all.
#
# Both natural frequencies of the undamped system have a closed form, and Newton's method from there
# finds the peaks of nearly every absorber. Whether they are all is shown by `peak_count`, from
# signs alone. What is not certain, or damped so little that it has to be examined, is left to the
# slower way by eigenvalues.
# ----------------------------------------------------------------------------

#: decay of all poles, over the upper natural frequency, from which none is too sharp to be placed
_DAMPED = 1e-6
#: share of rounding granted to the test of that
_CLEAR = 1e-12
#: error of ln u at which a start has settled
_SETTLED = 1e-9
#: excess over the floor squared below which |H|^2 itself keeps its digits
_LOW = -0.5


class QuickMaxima(NamedTuple):
    """All maxima of the rows that `certain` (rows,) names.

    `evaluations` (rows,) counts evaluations of |H|^2 with two derivatives, of rows not certain as
    well.
    """

    certain: np.ndarray
    tops: Tops
    evaluations: np.ndarray


def quick_maxima(parts: Coupling, transfer: Transfer) -> QuickMaxima:
    """Maxima of all rows of `parts` (rows,) that are sure to be all there are."""
    count = len(parts.mass)
    weights = measure(parts, transfer)
    lower, upper = _first_guesses(parts)
    certain, evaluations = _decays(parts, upper), np.zeros(count, dtype=int)
    chosen = np.flatnonzero(certain)
    if not len(chosen):
        none = np.zeros(0)
        return QuickMaxima(certain, Tops(chosen, none, none, none, none, none), evaluations)
    pair = chosen[lower[chosen] < upper[chosen]]
    rows = np.concatenate([pair, chosen])
    starts = np.square(np.concatenate([lower[pair], upper[chosen]]))
    refined, taken = tops(parts, weights, rows, starts, far=True)
    evaluations += np.bincount(rows, taken, count).astype(int)
    # one that has not settled counts for none
    tallied = np.bincount(refined.rows[refined.blur <= _SETTLED], minlength=count)[chosen]
    certain[chosen] &= _counted_maxima(parts, weights, chosen) == tallied
    refined = Tops(*(a[certain[refined.rows]] for a in refined))
    floor = weights.floor_squared[refined.rows]
    low = np.flatnonzero(refined.value < _LOW * floor)
    if len(low):
        rows = refined.rows[low]
        again, taken = tops(parts, measure(parts, transfer, plain=True), rows, refined.u[low])
        evaluations += np.bincount(rows, taken, count).astype(int)
        if np.array_equal(again.rows, rows):
            for column, new in zip(refined, again, strict=True):
                column[low] = new
            refined.value[low] = again.square - floor[low]
        else:
            certain[rows] = False
            refined = Tops(*(a[certain[refined.rows]] for a in refined))
    return QuickMaxima(certain, refined, evaluations)


def _first_guesses(parts: Coupling) -> tuple[np.ndarray, np.ndarray]:
    """Frequency ratios near both peaks, one and the same where there is but one resonance."""
    with np.errstate(divide="ignore", invalid="ignore"):
        marks = landmarks(parts.mass, parts.mass * parts.g0 / parts.inertia)
    locked = parts.inertia == 0.0
    # without a spring the peak is between those with the secondary locked and free
    lower = np.choose(parts.shift, (marks.lower, marks.locked, marks.free))
    return lower, np.where(locked, marks.lower, marks.upper)


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


def _counted_maxima(parts: Coupling, weights: Measure, chosen: np.ndarray) -> np.ndarray:
    above, below = excess_polynomials(
        Coupling(*(a[chosen] for a in parts)), Measure(*(a[chosen] for a in weights))
    )
    return maxima_counted(stationarity(above, below), stationarity_size(above, below))


# ----------------------------------------------------------------------------
# All stationary maxima of |H| over frequency, from a polynomial, not from a grid.
# ----------------------------------------------------------------------------

#: more maxima than a quotient of these degrees has
_MOST = 4
#: damping ratio below which a resonance is narrower than double precision can place it
_SHARP = 2e-14
#: relative difference below which two heights count as one
SAME_HEIGHT = 1e-12
#: starts next to a pole, in half widths
_NEARBY = np.array([0.0, -1.0, 1.0, -2.5, 2.5])


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
    rows, u, value, uncertainty, square = _with_resonances(
        flat, absorber, moved, *_all_maxima(flat, transfer)
    )

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
    wide = [a.reshape(*shape, _MOST) for a in (*table.values(), present)]
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
        coupled = Coupling(*(a[rows] for a in parts))
        mine = Measure(*(a[rows] for a in weights))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            low = ~(slope(coupled, mine, u).value >= ceiling[rows])
        rows, u = rows[low], u[low]
    return tops(parts, weights, rows, u)[0]


def _all_maxima(parts: Coupling, transfer: Transfer) -> tuple[np.ndarray, ...]:
    """Rows, u, A / Q, its error and |H|^2 of all: quickly where that is sure, else thoroughly."""
    quick = quick_maxima(parts, transfer)
    quick_tops = quick.tops[:5]
    uncertain = np.flatnonzero(~quick.certain)
    if not len(uncertain):
        return quick_tops
    coupled = Coupling(*(a[uncertain] for a in parts))
    _refuse_sharp(coupled)
    others = _thorough(coupled, transfer)
    others = others._replace(rows=uncertain[others.rows])
    joined = [np.concatenate(pair) for pair in zip(quick_tops, others[:5], strict=True)]
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


def near_poles(parts: Coupling) -> tuple[np.ndarray, np.ndarray]:
    """Rows and u of all damped natural frequencies: at a narrow peak the polynomial is blurred.

    A light secondary leaves a peak and a zero so close together that the roots run into each
    other; the poles stay apart.
    """
    found = roots_of(denominator(parts))
    rows, which = np.nonzero(found.present & (found.value.imag > 0.0))
    pole = found.value[rows, which]
    # next to a zero the top stands off the pole, by about its half width
    x = pole.imag - pole.real * _NEARBY[:, None]
    ahead = x > 0.0
    return np.broadcast_to(rows, x.shape)[ahead], np.square(x[ahead])


def _with_resonances(
    parts: Coupling, absorber: Absorber, moved: np.ndarray, rows: np.ndarray, u: np.ndarray,
    value: np.ndarray, uncertainty: np.ndarray, square: np.ndarray,
) -> tuple[np.ndarray, ...]:  # fmt: skip
    """Add the infinite peaks of rows without damping; what was found on them is dropped.

    `moved` (rows,): the response is not zero throughout, as that of a free secondary is.
    """
    bare = (parts.primary_damping == 0.0) & (parts.g1 == 0.0) & moved
    if not np.any(bare):
        return rows, u, value, uncertainty, square
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
            (rows, more), (u, np.square(both[more, which])), (value, many), (uncertainty,
            0.0 * more),
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
