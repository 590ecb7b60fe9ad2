"""|H|^2 above its floor without cancellation: values with derivatives, polynomials."""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from vibecalc.absorber.transfer import Coupling, Transfer

# ----------------------------------------------------------------------------
# What is made small: |H|^2 above the floor that no absorber can lower, without cancellation.
#
# |H|^2 = f^2 + A / Q. f is the limit of |H| at x = 0 or at infinity where that is fixed by the
# primary system, and zero elsewhere. Near f a difference of P and Q would lose all digits; A is
# built from polynomials from which the common part has been taken away on paper.
# ----------------------------------------------------------------------------

#: an array or a number, and one with its derivatives
Term: TypeAlias = Any
Derivatives: TypeAlias = Sequence[Term]

#: most coefficients of a weight, a polynomial in u = x^2
_TERMS = 6
#: 1/sqrt 2 as a sum of two doubles
_ROOT_HALF = (0.7071067811865476, -4.833646656726457e-17)


class Measure(NamedTuple):
    """A = -(motion |N1|^2 + mixed Re(N1 g*) + link |g|^2 + relative |m s^2|^2 + f^2 B).

    `floor_squared` f^2 (...); the others (..., 6) are polynomials in u = x^2, lowest power first;
    B is what the absorber adds to Q = |1 + 2 z1 s + s^2|^2 |N1|^2 + B.
    """

    floor_squared: np.ndarray
    motion: np.ndarray
    mixed: np.ndarray
    link: np.ndarray
    relative: np.ndarray


def damping_excess(primary_damping: np.ndarray) -> np.ndarray:
    """4 z1^2 - 2 to full relative precision, also next to its zero at z1 = 1 / sqrt 2."""
    z = np.asarray(primary_damping, dtype=float)
    away = (z - _ROOT_HALF[0]) - _ROOT_HALF[1]
    return 4.0 * away * (z + _ROOT_HALF[0])


def measure(parts: Coupling, transfer: Transfer, plain: bool = False) -> Measure:
    """Weights of one response; `plain`: with the floor left at zero, A = P, for small |H|."""
    z1, m = parts.primary_damping, parts.mass
    c, q = damping_excess(z1), 4.0 * z1 * z1
    one, zero = np.ones_like(z1), np.zeros_like(z1)
    kind = (transfer.power, transfer.ground, transfer.motion)
    bare = _gain(transfer, q)
    empty = np.zeros_like(bare)
    if transfer.motion == "secondary":
        return Measure(zero, empty, empty, -bare, empty)
    if transfer.motion == "relative":
        return Measure(zero, empty, empty, empty, -bare)
    if plain and transfer.motion == "primary":
        return Measure(zero, -bare, empty, empty, empty)
    undamped = (z1 == 0.0) & (not plain)
    wide = undamped[..., None]
    if transfer.motion == "ground":
        # with z1 = 0: (1 - 2 u) |N1|^2 - 2 m u Re(N1 g*), and B leaves nothing else
        special = _poly(one, -2.0 * one)
        mixed = _poly(zero, -2.0 * m) - _times_u(_poly(-2.0 * m, 2.0 * m))
        link = -_poly(zero, zero, m * m)
        thin = m[..., None]
        return Measure(
            undamped.astype(float), np.where(wide, special, -bare),
            np.where(wide, mixed, -2.0 * thin * bare), np.where(wide, link, -thin * thin * bare),
            empty,
        )  # fmt: skip
    table = {
        (0, 0, "primary"): (one, _poly(zero, c, one)),
        (1, 0, "primary"): (zero, _poly(zero, -one)),
        (2, 0, "primary"): (one, _poly(one, c)),
        (0, 1, "primary"): (one, _poly(zero, -2.0 * one, one)),
        (1, 1, "primary"): (q, _poly(q, q * c - 1.0)),
    }
    if kind == (2, 1, "primary"):  # grows without bound as soon as the primary is damped
        floor = undamped.astype(float)
        return Measure(floor, np.where(wide, _poly(one, c), -bare), empty, empty, empty)
    floor, motion = table.get(kind, (zero, -bare))
    return Measure(floor, motion, empty, empty, empty)


def stiffness_weights(parts: Coupling) -> tuple[np.ndarray, ...]:
    """Q = a |N1|^2 + B, B = b Re(N1 g*) + d S + e |g|^2: polynomials a, b, d, e (..., 6) in u."""
    z1, m = parts.primary_damping, parts.mass
    one, zero = np.ones_like(z1), np.zeros_like(z1)
    return (
        _poly(one, damping_excess(z1), one), _poly(zero, -2.0 * m, 2.0 * m),
        _poly(zero, 4.0 * z1 * m), _poly(zero, zero, m * m),
    )  # fmt: skip


def _gain(transfer: Transfer, q: np.ndarray) -> np.ndarray:
    """u^power (1 + q u)^ground."""
    result = _poly(np.ones_like(q))
    for _ in range(transfer.ground):
        result = result + q[..., None] * _times_u(result)
    for _ in range(transfer.power):
        result = _times_u(result)
    return result


def _times_u(polynomial: np.ndarray) -> np.ndarray:
    moved = np.zeros_like(polynomial)
    moved[..., 1:] = polynomial[..., :-1]
    return moved


def _poly(*coefficients: np.ndarray) -> np.ndarray:
    result = np.zeros((*np.shape(coefficients[0]), _TERMS))
    for place, value in enumerate(coefficients):
        result[..., place] = value
    return result


# ----------------------------------------------------------------------------
# A and Q of |H|^2 = f^2 + A / Q at one frequency, with derivatives, free of cancellation.
# ----------------------------------------------------------------------------


class Forms(NamedTuple):
    """|N1|^2, Re(N1 g*), the part of Im(N1 g*) that damping sees, |g|^2 and |m s^2|^2.

    Each (3, ...): value and two derivatives by u; all over u^shift.
    """

    motion: np.ndarray
    mixed: np.ndarray
    cross: np.ndarray
    link: np.ndarray
    relative: np.ndarray


def forms(parts: Coupling, u: np.ndarray) -> Forms:
    """The five forms at u = x^2."""
    g0, g1, inertia = parts.g0, parts.g1, parts.inertia
    g1g1, squared = g1 * g1, inertia * inertia
    shape = np.shape(g0 - inertia * u)
    motion, mixed, cross, link, relative = result = np.zeros((5, 3, *shape))
    for form, known in zip(result, _sprung_forms(inertia, g0, g1, u), strict=True):
        form[0], form[1], form[2] = known
    if not np.any(parts.shift):
        return Forms(motion, mixed, cross, link, relative)
    late, free = parts.shift == 1, parts.shift == 2
    zero = np.zeros(shape)
    for form, without_spring, alone in (
        (motion, (g1g1 + squared * u, squared), squared), (mixed, (g1g1,
        zero), zero), (cross, (g1 * inertia * u, g1 * inertia), zero), (link, (g1g1, zero), zero),
        (relative, (squared * u, squared), squared),
    ):  # fmt: skip
        form[0] = np.where(free, alone, np.where(late, without_spring[0], form[0]))
        form[1] = np.where(free, 0.0, np.where(late, without_spring[1], form[1]))
        form[2] = np.where(free | late, 0.0, form[2])
    return Forms(motion, mixed, cross, link, relative)


def _sprung_forms(inertia: Term, g0: Term, g1: Term, u: Term) -> tuple[Derivatives, ...]:
    """The five forms of a sprung damper, each with two derivatives by u."""
    away = g0 - inertia * u  # kept as a difference: small where a light absorber is tuned
    g1g1u, squared, lag = g1 * g1 * u, inertia * inertia, g1 * inertia
    return (
        (away * away + g1g1u, g1 * g1 - 2.0 * inertia * away, 2.0 * squared),
        (g0 * away + g1g1u, g1 * g1 - inertia * g0, 0.0),
        (lag * u * u, 2.0 * lag * u, 2.0 * lag),
        (g0 * g0 + g1g1u, g1 * g1, 0.0),
        (squared * u * u, 2.0 * squared * u, 2.0 * squared),
    )


class Excess(NamedTuple):
    """A and Q (3, ...), two derivatives by u, and the sums of magnitudes (...) behind both."""

    above: np.ndarray
    below: np.ndarray
    above_size: np.ndarray
    below_size: np.ndarray


def excess(parts: Coupling, weights: Measure, u: np.ndarray) -> Excess:
    """A and Q of the measure at u; `parts` and `weights` broadcast against u."""
    z1, m = parts.primary_damping, parts.mass
    form = forms(parts, u)
    mixed, cross, link = _absorbed(z1, m, u)
    terms = [_times(mixed, form.mixed), _times(cross, form.cross), _times(link, form.link)]
    absorbed = terms[0] + terms[1] + terms[2]
    parts_of_sum = [
        _times(_polynomial(columns(weight), u), part)
        for weight, part in (
            (weights.motion, form.motion), (weights.mixed, form.mixed), (weights.link, form.link),
            (weights.relative, form.relative),
        )
        if np.any(weight)
    ] or [np.zeros(form.motion.shape)]  # fmt: skip
    above = -(sum(parts_of_sum[1:], parts_of_sum[0]) + weights.floor_squared * absorbed)
    # |N1|^2 and Re(N1 g*) are only as good as g0 - inertia u
    blur = np.abs(parts.g0) + parts.inertia * np.abs(u)
    lost = 1.0 + blur / np.maximum(np.sqrt(form.motion[0]), 1e-300)
    other = np.abs(terms[0][0]) + np.abs(terms[1][0]) + np.abs(terms[2][0])
    above_size = (sum(np.abs(p[0]) for p in parts_of_sum) + weights.floor_squared * other) * lost
    below, below_size = _squared_stiffness(parts, u)
    return Excess(above, below, above_size, below_size)


def _absorbed(z1: Term, m: Term, u: Term) -> tuple[Derivatives, ...]:
    """What B = Q - |1 + 2 z1 s + s^2|^2 |N1|^2 takes of Re(N1 g*), Im(N1 g*) and |g|^2."""
    stiff, square = 1.0 - u, m * m
    return (
        (-2.0 * m * u * stiff, -2.0 * m * (stiff - u), 4.0 * m),
        (4.0 * z1 * m * u, 4.0 * z1 * m, 0.0),
        (square * u * u, 2.0 * square * u, 2.0 * square),
    )


def _stiffness(
    z1: Term, m: Term, inertia: Term, g0: Term, g1: Term, u: Term
) -> tuple[Derivatives, Derivatives]:
    """Real part and imaginary part over x of D with a sprung damper, and two derivatives by u."""
    stiff, away, c = 1.0 - u, g0 - inertia * u, 2.0 * z1
    return (
        (
            stiff * away - c * g1 * u - m * u * g0, -away - inertia * stiff - c * g1 - m * g0,
            2.0 * inertia,
        ),
        (c * away + g1 * (stiff - m * u), -c * inertia - g1 * (1.0 + m), 0.0),
    )  # fmt: skip


def _squared_stiffness(parts: Coupling, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Q = |D|^2 as a sum of two squares, so that nothing cancels on a sharp resonance."""
    z1, m, g0, g1, inertia = parts.primary_damping, parts.mass, parts.g0, parts.g1, parts.inertia
    stiff, c = 1.0 - u, 2.0 * z1
    both = stiff - m * u
    real, imaginary = sides = np.zeros((2, 3, *np.shape(g0 * stiff)))
    for side, known in zip(sides, _stiffness(z1, m, inertia, g0, g1, u), strict=True):
        side[0], side[1], side[2] = known
    # magnitudes behind both, the distance 1 - u taken as exact
    blur = np.abs(stiff) * (g0 + inertia * u) + c * g1 * u + m * u * g0
    blur_imaginary = c * (g0 + inertia * u) + g1 * (np.abs(stiff) + m * u)
    if np.any(parts.shift):
        late, free = parts.shift == 1, parts.shift == 2
        for side, without_spring, alone in (
            (real, (g1 * both - c * inertia * u, -g1 * (1.0 + m) - c * inertia), (inertia * stiff,
            -inertia)), (imaginary, (inertia * stiff + c * g1, -inertia), (c * inertia, 0.0 *
            inertia)),
        ):  # fmt: skip
            for slot, (one, other) in enumerate(zip(without_spring, alone, strict=True)):
                side[slot] = np.where(free, other, np.where(late, one, side[slot]))
            side[2] = np.where(free | late, 0.0, side[2])
        blur = np.where(late, g1 * (np.abs(stiff) + m * u) + c * inertia * u, blur)
        blur_imaginary = np.where(late, inertia * np.abs(stiff) + c * g1, blur_imaginary)
        blur = np.where(free, np.abs(real[0]), blur)
        blur_imaginary = np.where(free, imaginary[0], blur_imaginary)
    below = _square(real) + _times((u, 1.0, 0.0), _square(imaginary))
    return below, 2.0 * (np.abs(real[0]) * blur + u * np.abs(imaginary[0]) * blur_imaginary)


def _square(form: np.ndarray) -> np.ndarray:
    """Square of a form."""
    result: np.ndarray = 2.0 * form[0] * form
    result[0] *= 0.5
    result[2] += 2.0 * form[1] * form[1]
    return result


def _times(weight: Derivatives, form: np.ndarray) -> np.ndarray:
    """Product of two functions of u, each with two derivatives."""
    value, first, second = weight
    result: np.ndarray = value * form
    result[2] += second * form[0] + 2.0 * first * form[1]
    result[1] += first * form[0]
    return result


def columns(polynomial: np.ndarray) -> tuple[np.ndarray, ...]:
    """Coefficients (...) by rising power of u, up to the last that is not zero everywhere."""
    size = polynomial.shape[-1]
    there = np.flatnonzero(polynomial.reshape(-1, size).any(axis=0))
    return tuple(polynomial[..., place] for place in range(there[-1] + 1 if len(there) else 0))


def _polynomial(coefficients: Sequence[Term], u: Term) -> Derivatives:
    value = first = second = 0.0 * u
    for coefficient in coefficients[::-1]:
        second = second * u + first
        first = first * u + value
        value = value * u + coefficient
    return value, first, 2.0 * second


# ----------------------------------------------------------------------------
# The same for a sprung damper with all derivatives by u, g0 and g1 that a search needs, entry by
# entry: for arrays, or for one case in single numbers, which take a tenth of the time of arrays
# of one entry.
# ----------------------------------------------------------------------------


def excess_derivatives(
    z1: Term, m: Term, inertia: Term, g0: Term, g1: Term, u: Term,
    floor_squared: Term, weights: Sequence[Sequence[Term]],
) -> tuple[Derivatives, Derivatives]:  # fmt: skip
    """A and Q, each with derivatives: value, u, uu, g0, g1, u g0, u g1, g0 g0, g0 g1, g1 g1.

    `weights`: the polynomials of `Measure` in `columns`. All terms broadcast.
    """
    away, double, twice = g0 - inertia * u, 2.0 * g1, 2.0 * u
    bent = (2.0, 0.0, twice)
    by_coupling: tuple[Derivatives, ...] = (
        (2.0 * away, twice * g1, -2.0 * inertia, double, *bent),
        (g0 + away, twice * g1, -inertia, double, *bent),
        (0.0, inertia * u * u, 0.0, twice * inertia, 0.0, 0.0, 0.0),
        (2.0 * g0, twice * g1, 0.0, double, *bent),
        _NONE,
    )
    sprung = _sprung_forms(inertia, g0, g1, u)
    every = [(*by_u, *rest) for by_u, rest in zip(sprung, by_coupling, strict=True)]
    motion, mixed, cross, link, relative = every
    asked = zip(weights, (motion, mixed, link, relative), strict=True)
    parts = [_product(_polynomial(weight, u), form) for weight, form in asked if len(weight)]
    absorbed = zip(_absorbed(z1, m, u), (mixed, cross, link), strict=True)
    parts += [_product([floor_squared * w for w in weight], form) for weight, form in absorbed]
    above = tuple(-sum(slot[1:], slot[0]) for slot in zip(*parts, strict=True))
    real, imaginary = _stiffness(z1, m, inertia, g0, g1, u)
    both, c = 1.0 - u - m * u, 2.0 * z1
    squares = (
        _squared((*real, both, -c * u, -1.0 - m, -c)),
        _product((u, 1.0, 0.0), _squared((*imaginary, c, both, 0.0, -1.0 - m))),
    )
    return above, tuple(one + other for one, other in zip(*squares, strict=True))


_NONE = (0.0,) * 7


def _product(weight: Derivatives, form: Derivatives) -> Derivatives:
    """A function of u alone, with two derivatives, times a form with ten."""
    value, first, second = weight
    f, f_u, f_uu, by_0, by_1, by_u0, by_u1, by_00, by_01, by_11 = form
    return (
        value * f, value * f_u + first * f, value * f_uu + second * f + 2.0 * first * f_u,
        value * by_0, value * by_1, value * by_u0 + first * by_0, value * by_u1 + first * by_1,
        value * by_00, value * by_01, value * by_11,
    )  # fmt: skip


def _squared(form: Derivatives) -> Derivatives:
    """Square of a form that is linear in g0 and g1, from its first seven derivatives."""
    f, f_u, f_uu, by_0, by_1, by_u0, by_u1 = form
    return (
        f * f, 2.0 * f * f_u, 2.0 * (f * f_uu + f_u * f_u), 2.0 * f * by_0, 2.0 * f * by_1,
        2.0 * (f * by_u0 + f_u * by_0), 2.0 * (f * by_u1 + f_u * by_1),
        2.0 * by_0 * by_0, 2.0 * by_0 * by_1, 2.0 * by_1 * by_1,
    )  # fmt: skip


# ----------------------------------------------------------------------------
# |H|^2 as a quotient of two polynomials in u = x^2, and where it is stationary.
# ----------------------------------------------------------------------------

_Row: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray]


def excess_polynomials(parts: Coupling, weights: Measure) -> tuple[np.ndarray, np.ndarray]:
    """A and Q (..., n) by rising power of u."""
    motion, mixed, cross, link, relative = form_polynomials(parts)
    inertia, b, d, e = stiffness_weights(parts)
    absorbed = product(b, mixed) + product(d, cross) + product(e, link)
    free = product(inertia, motion)
    asked = (
        product(weights.motion, motion) + product(weights.mixed, mixed)
        + product(weights.link, link) + product(weights.relative, relative)
    )  # fmt: skip
    above = -(asked + weights.floor_squared[..., None] * absorbed)
    return above, (free + absorbed)[..., :5]


def form_polynomials(parts: Coupling) -> tuple[np.ndarray, ...]:
    """The five forms of `excess.Forms` as polynomials (..., 3) in u, after the shift."""
    g0, g1, inertia = parts.g0, parts.g1, parts.inertia
    shift = parts.shift[..., None]
    zero = np.zeros_like(inertia)
    g0g0, g1g1, squared = g0 * g0, g1 * g1, inertia * inertia

    def chosen(whole: _Row, late: _Row, free: np.ndarray) -> np.ndarray:
        stacked = [np.stack(rows, axis=-1) for rows in (whole, late, (free, zero, zero))]
        return np.where(shift == 0, stacked[0], np.where(shift == 1, stacked[1], stacked[2]))

    return (
        chosen((g0g0, g1g1 - 2.0 * g0 * inertia, squared), (g1g1, squared, zero), squared),
        chosen((g0g0, g1g1 - inertia * g0, zero), (g1g1, zero, zero), zero),
        chosen((zero, zero, g1 * inertia), (zero, g1 * inertia, zero), zero),
        chosen((g0g0, g1g1, zero), (g1g1, zero, zero), zero),
        chosen((zero, zero, squared), (zero, squared, zero), squared),
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
    rows_of_roots: list[np.ndarray] = []
    all_roots: list[np.ndarray] = []
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
        section = polynomials[rows, first : last + 1]
        degree = last - first
        scale = np.exp((np.log(np.abs(section[:, 0])) - np.log(np.abs(section[:, -1]))) / degree)
        level = np.log(scale)[:, None] * np.arange(degree + 1)
        with np.errstate(divide="ignore"):
            logs = np.log(np.abs(section)) + level
        logs -= logs[:, -1:]
        monic = np.sign(section) * np.sign(section[:, -1:]) * np.exp(np.minimum(logs, 650.0))
        matrix = np.zeros((len(rows), degree, degree))
        matrix[:, np.arange(1, degree), np.arange(degree - 1)] = 1.0
        matrix[:, :, -1] = -monic[:, :-1]
        roots = np.linalg.eigvals(matrix)
        real = (roots.real > 0.0) & (np.abs(roots.imag) <= 1e-5 * np.abs(roots.real))
        where, which = np.nonzero(real)
        rows_of_roots.append(rows[where])
        all_roots.append(roots[where, which].real * scale[where])
    if not rows_of_roots:
        return np.zeros(0, dtype=int), np.zeros(0)
    return np.concatenate(rows_of_roots), np.concatenate(all_roots)
