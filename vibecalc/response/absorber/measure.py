"""What is made small: |H|^2 above the floor that no absorber can lower, without cancellation.

|H|^2 = f^2 + A / Q. f is the limit of |H| at x = 0 or at infinity where that is fixed by the
primary system, and zero elsewhere. Near f a difference of P and Q would lose all digits; A is
built from polynomials from which the common part has been taken away on paper.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.model import Transfer

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
    """4 z1^2 - 2 to full relative precision, also beside its zero at z1 = 1 / sqrt 2."""
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
