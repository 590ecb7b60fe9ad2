"""A and Q of |H|^2 = f^2 + A / Q at one frequency, with derivatives, free of cancellation."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.measure import Measure

#: order of the derivatives: value, u, uu, then g0, g1, u g0, u g1, g0 g0, g0 g1, g1 g1
ALL = 10
ALONG_U = 3


class Forms(NamedTuple):
    """|N1|^2, Re(N1 g*), the part of Im(N1 g*) that damping sees, |g|^2 and |m s^2|^2.

    Each (slots, ...): derivatives in the order of `ALL`; all over u^shift.
    """

    motion: np.ndarray
    mixed: np.ndarray
    cross: np.ndarray
    link: np.ndarray
    relative: np.ndarray


def forms(parts: Coupling, u: np.ndarray, slots: int = ALONG_U) -> Forms:
    """The five forms at u = x^2; derivatives by g0 and g1 (slots = ALL) of a sprung damper only."""
    g0, g1, own = parts.g0, parts.g1, parts.own
    away = g0 - own * u  # kept as a difference: small where a light absorber is tuned
    shape = np.shape(away)
    motion, mixed, cross, link, relative = np.zeros((5, slots, *shape))
    g1g1, ownown = g1 * g1, own * own
    motion[0], motion[1], motion[2] = (
        away * away + g1g1 * u, g1g1 - 2.0 * own * away, 2.0 * ownown,
    )  # fmt: skip
    mixed[0], mixed[1] = g0 * away + g1g1 * u, g1g1 - own * g0
    cross[0], cross[1], cross[2] = g1 * own * u * u, 2.0 * g1 * own * u, 2.0 * g1 * own
    link[0], link[1] = g0 * g0 + g1g1 * u, g1g1
    relative[0], relative[1], relative[2] = ownown * u * u, 2.0 * ownown * u, 2.0 * ownown
    if slots == ALL:
        motion[3], motion[4], motion[5], motion[6] = 2.0 * away, 2.0 * g1 * u, -2.0 * own, 2.0 * g1
        mixed[3], mixed[4], mixed[5], mixed[6] = g0 + away, 2.0 * g1 * u, -own, 2.0 * g1
        link[3], link[4], link[6] = 2.0 * g0, 2.0 * g1 * u, 2.0 * g1
        cross[4], cross[6] = own * u * u, 2.0 * own * u
        for form in (motion, mixed, link):
            form[7], form[9] = 2.0, 2.0 * u
        return Forms(motion, mixed, cross, link, relative)
    if not np.any(parts.shift):
        return Forms(motion, mixed, cross, link, relative)
    late, free = parts.shift == 1, parts.shift == 2
    zero = np.zeros(shape)
    for form, without_spring, alone in (
        (motion, (g1g1 + ownown * u, ownown), ownown), (mixed, (g1g1, zero), zero),
        (cross, (g1 * own * u, g1 * own), zero), (link, (g1g1, zero), zero),
        (relative, (ownown * u, ownown), ownown),
    ):  # fmt: skip
        form[0] = np.where(free, alone, np.where(late, without_spring[0], form[0]))
        form[1] = np.where(free, 0.0, np.where(late, without_spring[1], form[1]))
        form[2] = np.where(free | late, 0.0, form[2])
    return Forms(motion, mixed, cross, link, relative)


class Excess(NamedTuple):
    """A and Q (slots, ...) and the sums of magnitudes (...) behind their values."""

    above: np.ndarray
    below: np.ndarray
    above_size: np.ndarray
    below_size: np.ndarray


def excess(parts: Coupling, weights: Measure, u: np.ndarray, slots: int = ALONG_U) -> Excess:
    """A and Q of the measure at u; `parts` and `weights` broadcast against u."""
    z1, m = parts.primary_damping, parts.mass
    form = forms(parts, u, slots)
    stiff = 1.0 - u
    mixed = (-2.0 * m * u * stiff, -2.0 * m * (stiff - u), 4.0 * m)
    cross = (4.0 * z1 * m * u, 4.0 * z1 * m, np.zeros_like(z1))
    link = (m * m * u * u, 2.0 * m * m * u, 2.0 * m * m)
    terms = [_times(mixed, form.mixed), _times(cross, form.cross), _times(link, form.link)]
    absorbed = terms[0] + terms[1] + terms[2]
    pieces = [
        _times(_horner(weight, u), part)
        for weight, part in (
            (weights.motion, form.motion), (weights.mixed, form.mixed), (weights.link, form.link),
            (weights.relative, form.relative),
        )
        if np.any(weight)
    ] or [np.zeros(form.motion.shape)]  # fmt: skip
    above = -(sum(pieces[1:], pieces[0]) + weights.floor_squared * absorbed)
    # |N1|^2 and Re(N1 g*) are only as good as g0 - own u
    blur = np.abs(parts.g0) + parts.own * np.abs(u)
    lost = 1.0 + blur / np.maximum(np.sqrt(form.motion[0]), 1e-300)
    other = np.abs(terms[0][0]) + np.abs(terms[1][0]) + np.abs(terms[2][0])
    above_size = (sum(np.abs(p[0]) for p in pieces) + weights.floor_squared * other) * lost
    below, below_size = _squared_stiffness(parts, u, slots)
    return Excess(above, below, above_size, below_size)


def _squared_stiffness(parts: Coupling, u: np.ndarray, slots: int) -> tuple[np.ndarray, np.ndarray]:
    """Q = |D|^2 as a sum of two squares, so that nothing cancels on a sharp resonance."""
    z1, m, g0, g1, own = parts.primary_damping, parts.mass, parts.g0, parts.g1, parts.own
    stiff = 1.0 - u
    real, imaginary = np.zeros((2, slots, *np.shape(g0 * stiff)))
    away, both = g0 - own * u, stiff - m * u
    c = 2.0 * z1
    real[0] = stiff * away - c * g1 * u - m * u * g0
    real[1], real[2] = -away - own * stiff - c * g1 - m * g0, 2.0 * own
    imaginary[0], imaginary[1] = c * away + g1 * both, -c * own - g1 * (1.0 + m)
    # magnitudes behind both, the distance 1 - u taken as exact
    blur = np.abs(stiff) * (g0 + own * u) + c * g1 * u + m * u * g0
    blur_imaginary = c * (g0 + own * u) + g1 * (np.abs(stiff) + m * u)
    if slots == ALL:
        real[3], real[4], real[5], real[6] = both, -c * u, -1.0 - m, -c
        imaginary[3], imaginary[4], imaginary[6] = c, both, -1.0 - m
    elif np.any(parts.shift):
        late, free = parts.shift == 1, parts.shift == 2
        for side, without_spring, alone in (
            (real, (g1 * both - c * own * u, -g1 * (1.0 + m) - c * own), (own * stiff, -own)),
            (imaginary, (own * stiff + c * g1, -own), (c * own, 0.0 * own)),
        ):  # fmt: skip
            for slot, (one, other) in enumerate(zip(without_spring, alone, strict=True)):
                side[slot] = np.where(free, other, np.where(late, one, side[slot]))
            side[2] = np.where(free | late, 0.0, side[2])
        blur = np.where(late, g1 * (np.abs(stiff) + m * u) + c * own * u, blur)
        blur_imaginary = np.where(late, own * np.abs(stiff) + c * g1, blur_imaginary)
        blur = np.where(free, np.abs(real[0]), blur)
        blur_imaginary = np.where(free, imaginary[0], blur_imaginary)
    below = _square(real) + _times((u, 1.0, 0.0), _square(imaginary))
    return below, 2.0 * (np.abs(real[0]) * blur + u * np.abs(imaginary[0]) * blur_imaginary)


def _square(form: np.ndarray) -> np.ndarray:
    """Square of a form in all slots."""
    result: np.ndarray = 2.0 * form[0] * form
    result[0] *= 0.5
    result[2] += 2.0 * form[1] * form[1]
    if form.shape[0] == ALL:
        result[5] += 2.0 * form[1] * form[3]
        result[6] += 2.0 * form[1] * form[4]
        result[7] += 2.0 * form[3] * form[3]
        result[8] += 2.0 * form[3] * form[4]
        result[9] += 2.0 * form[4] * form[4]
    return result


def _times(weight: tuple[np.ndarray | float, ...], form: np.ndarray) -> np.ndarray:
    """Product of a function of u alone, given with two derivatives, with a form in all slots."""
    value, first, second = weight
    result: np.ndarray = value * form
    result[2] += second * form[0] + 2.0 * first * form[1]
    result[1] += first * form[0]
    if form.shape[0] == ALL:
        result[5] += first * form[3]
        result[6] += first * form[4]
    return result


def _horner(polynomial: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """Value and two derivatives; trailing zeros of all polynomials are passed over."""
    count = polynomial.shape[-1]
    while count > 1 and not np.any(polynomial[..., count - 1]):
        count -= 1
    value = np.broadcast_to(polynomial[..., count - 1], np.shape(u)) + 0.0 * u
    first = second = np.zeros_like(value)
    for place in range(count - 2, -1, -1):
        second = second * u + first
        first = first * u + value
        value = value * u + polynomial[..., place]
    return value, first, 2.0 * second
