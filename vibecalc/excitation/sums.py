"""Forces and couples per order, with their error estimates: the sum that every part enters."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, WithError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Excitation(NamedTuple):
    """Force and couple on the body for the orders 1 .. n, per crank speed squared or at a speed.

    `force` (..., n, 3) in N and `couple` (..., n, 3) in N m about the body's reference point are
    complex 0-peak amplitudes along x, y, z, positive on the body: f(t) = Re(F exp(i n angle)).
    Per speed squared the units are N s^2 and N m s^2 (kg m and kg m^2). The errors are real,
    absolute, of the same shapes and units; they are estimates of the modulus of the error.
    """

    force: Complex
    couple: Complex
    force_error: Real
    couple_error: Real


def cross_magnitude(first: ArrayLike, second: ArrayLike) -> Real:
    """Sum of the magnitudes (..., 3) that form each component of a cross product (..., 3)."""
    a, b = np.abs(first), np.abs(second)
    after, before = [1, 2, 0], [2, 0, 1]
    return np.asarray(a[..., after] * b[..., before] + a[..., before] * b[..., after])


def add(*parts: Excitation) -> Excitation:
    """Sum of the excitations of one or more parts, all for the same orders."""

    def total(values: list[Complex], errors: list[Real]) -> tuple[Complex, Real]:
        rounding = EPSILON if len(parts) > 1 else 0.0
        error = [e + rounding * np.abs(v) for v, e in zip(values, errors, strict=True)]
        return np.asarray(sum(values[1:], values[0])), np.asarray(sum(error[1:], error[0]))

    force, force_error = total([p.force for p in parts], [p.force_error for p in parts])
    couple, couple_error = total([p.couple for p in parts], [p.couple_error for p in parts])
    return Excitation(force, couple, force_error, couple_error)


def size_of_terms(error: ArrayLike) -> float:
    """Size of the terms of the largest sum, from the errors of sums: three roundings at least.

    No kernel here grants less of each term, few more than twenty.
    """
    return float(np.max(error, initial=0.0)) / (3.0 * EPSILON)


def at_speed(excitation: Excitation, speed: ArrayLike) -> Excitation:
    """From per speed squared to forces and couples at crank speeds (...) in rad/s.

    Inertia forces grow with the square of the speed, so a run-up is this one multiplication:
    speeds (s,) and amplitudes (n, 3) give (s, n, 3).

    Raises
    ------
    NumericalFailure
        If a force or couple is not a finite number.
    """
    speed = np.asarray(speed, dtype=float)
    square = (speed * speed)[..., None, None]
    force, couple = excitation.force * square, excitation.couple * square
    force_error = excitation.force_error * square + EPSILON * np.abs(force)
    couple_error = excitation.couple_error * square + EPSILON * np.abs(couple)
    if not (np.isfinite(force).all() and np.isfinite(couple).all()):
        raise NumericalFailure(
            "the inertia forces are not finite numbers at a crank speed of "
            f"{float(np.max(np.abs(speed))):.6g} rad/s: masses, lengths or speed are out of range"
        )
    return Excitation(force, couple, force_error, couple_error)


def about_point(excitation: Excitation, point: ArrayLike) -> Excitation:
    """The same forces with couples about another point (3,), in m from the reference point."""
    point = np.asarray(point, dtype=float)
    moved = np.cross(point, excitation.force)
    sizes = cross_magnitude(point, excitation.force)
    couple_error = (
        excitation.couple_error
        + cross_magnitude(point, excitation.force_error)
        + EPSILON * (np.abs(excitation.couple) + sizes)
    )
    return excitation._replace(couple=excitation.couple - moved, couple_error=couple_error)


def as_loads(excitation: Excitation) -> WithError:
    """Forces and couples (..., orders, 6): x, y, z, then the couples about them."""
    return WithError(
        np.concatenate([excitation.force, excitation.couple], axis=-1),
        np.concatenate([excitation.force_error, excitation.couple_error], axis=-1),
    )
