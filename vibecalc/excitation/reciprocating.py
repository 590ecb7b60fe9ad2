"""Inertia forces of the pistons on the body, per order and per crank speed squared."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.sums import Complex, Excitation, Real, cross_magnitude
from vibecalc.numerics.rounding import EPSILON


class CylinderAxes(NamedTuple):
    """Unit vectors (..., c, 3): `outward` along a cylinder, `sideways` 90 degrees ahead of it.

    The sizes are sums of the magnitudes that form each component; a turn of the cylinder by its
    own rounding moves `outward` by `slip`.
    """

    outward: Real
    sideways: Real
    outward_size: Real
    sideways_size: Real
    slip: Real


def cylinder_axes(bank_angle: ArrayLike, stroke: ArrayLike, across: ArrayLike) -> CylinderAxes:
    """Axes of cylinders tilted by `bank_angle` (..., c) in the sense of rotation.

    The crank turns right-handed about `axis`, so a quarter of a turn takes it from `stroke` to
    `axis x stroke = -across`.
    """
    bank = np.asarray(bank_angle, dtype=float)[..., None]
    stroke, across = np.asarray(stroke, dtype=float), np.asarray(across, dtype=float)
    up, side = np.cos(bank), np.sin(bank)
    outward_size = np.abs(up * stroke) + np.abs(side * across)
    sideways_size = np.abs(side * stroke) + np.abs(up * across)
    return CylinderAxes(
        up * stroke - side * across,
        -side * stroke - up * across,
        outward_size,
        sideways_size,
        EPSILON * (outward_size + np.abs(bank) * sideways_size),
    )


def order_phasors(angle: ArrayLike, orders: ArrayLike) -> tuple[Complex, Real]:
    """exp(i n angle) (..., n, c) for angles (..., c) and orders (n,), and its error.

    The product n angle is rounded, which costs n |angle| eps at most, the angle being a rounded
    difference itself.
    """
    turn = np.asarray(orders)[:, None] * np.asarray(angle, dtype=float)[..., None, :]
    return np.cos(turn) + 1j * np.sin(turn), EPSILON * (1.0 + np.abs(turn))


def reciprocating_excitation(
    motion_harmonics: ArrayLike,
    *,
    crank_radius: ArrayLike,
    reciprocating_mass: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    position: ArrayLike,
    origin: ArrayLike,
    axis: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
    motion_error: ArrayLike = 0.0,
) -> Excitation:
    """Forces and couples of c pistons for the orders 1 .. n, per crank speed squared.

    Cylinder i stands at the local angle a_i = angle + crank_phase - bank_angle. Its mass m pushes
    the body with -m d2s/dt2 outwards (d'Alembert), so order n is m R n^2 C_n exp(i n a_i) along
    the cylinder; the couple is r x F with r on the line of action, which an offset moves sideways.

    Parameters
    ----------
    motion_harmonics
        C_n (..., n + 1) of s / R = Re sum C_n exp(i n a), from order 0.
    crank_radius, wrist_pin_offset
        In m, scalars or of the leading axes.
    reciprocating_mass, crank_phase, bank_angle, position
        (..., c) in kg, rad, rad and m along the crankshaft from the train's origin.
    origin, axis, stroke, across
        (3,) the train's origin from the body's reference point in m, and unit vectors.
    motion_error
        Absolute errors (..., n + 1) of the harmonics; zero takes them as exact.

    Returns
    -------
    Excitation
        Forces (..., n, 3) in kg m, couples in kg m^2, errors of both.
    """
    harmonics = np.asarray(motion_harmonics, dtype=complex)
    orders = np.arange(1, harmonics.shape[-1])
    radius = np.asarray(crank_radius, dtype=float)[..., None]
    offset = np.asarray(wrist_pin_offset, dtype=float)[..., None, None]
    slip = np.broadcast_to(np.asarray(motion_error, dtype=float), harmonics.shape)[..., 1:]

    amplitude = radius * orders**2 * harmonics[..., 1:]
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    phasor, phasor_error = order_phasors(angle, orders)
    mass = np.asarray(reciprocating_mass, dtype=float)[..., None, :]
    push = mass * amplitude[..., None] * phasor
    push_error = (
        np.abs(push) * (3.0 * EPSILON + phasor_error)
        + mass * (radius * orders**2 * slip)[..., None]
    )

    axes = cylinder_axes(bank_angle, stroke, across)
    along = np.asarray(position, dtype=float)[..., None] * np.asarray(axis, dtype=float)
    lever = np.asarray(origin, dtype=float) + along + offset * axes.sideways
    lever_size = np.abs(origin) + np.abs(along) + np.abs(offset) * axes.sideways_size
    arm = np.cross(lever, axes.outward)
    arm_size = cross_magnitude(lever_size, axes.outward_size)
    arm_slip = cross_magnitude(lever_size, axes.slip)
    return Excitation(
        push @ axes.outward,
        push @ arm,
        push_error @ axes.outward_size + np.abs(push) @ axes.slip,
        (push_error + EPSILON * np.abs(push)) @ arm_size + np.abs(push) @ arm_slip,
    )
