"""The mean squares of a two-mass system as quotients of sums of positive terms.

Every integral of |B(ix) / D(ix)|^2 over all x (I_4 of D. E. Newland, An Introduction to Random
Vibrations and Spectral Analysis, 2nd ed. 1984, sec. 7.5 and appendix 1, after James, Nichols and
Phillips, 1947) was multiplied out by hand; what is subtracted there is gone. One difference is
left, that of a tuned secondary, and it is kept so that it costs a few roundings of the whole.
"""

from typing import NamedTuple

import numpy as np


class Form(NamedTuple):
    """z [(a - k - b k)^2 + c k + d k^2] + e k + f k^2 + 4 z (z + z1 k)(g z + h), k, z = z2 unknown.

    All coefficients are zero or positive. `z1` is the primary damping. Of a light secondary b is
    small: a - k is then exact near k = a, and next to it c k and d k^2 are small too.
    """

    z1: np.ndarray
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    e: np.ndarray
    f: np.ndarray
    g: np.ndarray
    h: np.ndarray


class Terms(NamedTuple):
    """A form with its derivatives by k and z."""

    value: np.ndarray
    by_k: np.ndarray
    by_z: np.ndarray
    by_kk: np.ndarray
    by_kz: np.ndarray
    by_zz: np.ndarray


#: integral of |N / D|^2 over all x: pi / 2 times the form of this name over the denominator
NUMERATORS = ("motion", "motion_rate", "ground", "ground_rate")


def numerator_form(name: str, primary_damping: np.ndarray, mass_ratio: np.ndarray) -> Form:
    """Form over N1 ("motion"), s N1, N1 + m g ("ground", all inertia forces) and s (N1 + m g)."""
    z1, m = primary_damping, mass_ratio
    whole, zero, one = 1.0 + m, np.zeros_like(m), np.ones_like(m)
    if name == "motion":
        return Form(z1, m, m, m * m, zero, zero, m * m * z1, whole, z1 * m)
    if name == "motion_rate":
        return Form(z1, m, zero, zero, m, zero, m * m * z1, one, z1 * m)
    square = whole * whole
    if name == "ground":
        return Form(
            z1, m, m * (2.0 + m), (m * whole) ** 2, zero, z1 * m**4, z1 * (m * whole) ** 2,
            whole * square, square * z1 * m,
        )  # fmt: skip
    return Form(z1, m, m, zero, square * m, zero, z1 * m * m * whole, square, z1 * m)


def evaluate(form: Form, k: np.ndarray, z: np.ndarray) -> Terms:
    """Value and derivatives up to the second."""
    z1, a, b, c, d, e, f, g, h = form
    away, fall = (a - k) - b * k, 1.0 + b
    bend = away * away + c * k + d * k * k
    bend_k = -2.0 * fall * away + c + 2.0 * d * k
    drag, side = g * z + h, z + z1 * k
    return Terms(
        z * bend + e * k + f * k * k + 4.0 * z * side * drag,
        z * bend_k + e + 2.0 * f * k + 4.0 * z * z1 * drag,
        bend + 4.0 * (side * drag + z * drag + z * side * g),
        z * (2.0 * fall * fall + 2.0 * d) + 2.0 * f,
        bend_k + 4.0 * z1 * (drag + z * g),
        8.0 * (drag + g * side + g * z),
    )


def evaluate_denominator(
    primary_damping: np.ndarray, mass_ratio: np.ndarray, k: np.ndarray, z: np.ndarray
) -> Terms:
    """Hurwitz' determinant of D over 4, m^2 z^2 + z1 times a form, with its derivatives."""
    z1, m = primary_damping, mass_ratio
    zero, square = np.zeros_like(m), m * m
    inner = evaluate(
        Form(z1, m, zero, zero, m * (2.0 + m), zero, square * z1, 1.0 + m, z1 * m), k, z
    )
    scaled = Terms(*(z1 * part for part in inner))
    return scaled._replace(
        value=scaled.value + square * z * z,
        by_z=scaled.by_z + 2.0 * square * z,
        by_zz=scaled.by_zz + 2.0 * square,
    )
