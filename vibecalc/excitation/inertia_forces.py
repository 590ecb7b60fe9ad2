"""Inertia forces of pistons and unbalances on the body, and torque of the pistons, by order."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import (
    Bounded,
    Operand,
    Summed,
    bounded,
    concatenate,
    pair,
    reshaped,
    rounded,
    stack,
)
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Loads on the body (..., n, 6) at the orders 1 .. n, per crank speed squared or at a speed: forces
# along x, y, z in N, then couples about them in N m about the body's reference point. They are
# complex 0-peak amplitudes, positive on the body: f(t) = Re(F exp(i n angle)). Per speed squared
# the units are N s^2 and N m s^2 (kg m and kg m^2).
# ----------------------------------------------------------------------------

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def forces_of(loads: Bounded) -> Bounded:
    """Forces (..., 3) of loads (..., 6)."""
    return loads[..., :3]


def couples_of(loads: Bounded) -> Bounded:
    """Couples (..., 3) of loads (..., 6)."""
    return loads[..., 3:]


def cross(first: Operand, second: Operand) -> Bounded:
    """Product first x second (..., 3) of vectors."""
    a, b = bounded(first), bounded(second)
    after, before = [1, 2, 0], [2, 0, 1]
    return a[..., after] * b[..., before] - a[..., before] * b[..., after]


def size_of_terms(error: ArrayLike) -> float:
    """Size of the terms of the largest of sums, at most: of three roundings in its error.

    No kernel here grants less of each term, few more than twenty.
    """
    return float(np.max(error, initial=0.0)) / (3.0 * EPSILON)


def with_terms(found: Bounded, rounding: ArrayLike | None = None) -> Summed:
    """A sum with the size of its terms, which its `rounding` tells: all of its error, if None."""
    known = found.error if rounding is None else rounding
    return Summed(found.value, found.error, size_of_terms(known))


def at_speed(loads: Bounded, speed: ArrayLike) -> Bounded:
    """From per speed squared to loads at crank speeds (...) in rad/s.

    Inertia forces grow with the square of the speed, so a run-up is this one multiplication:
    speeds (s,) and amplitudes (n, 6) give (s, n, 6).

    Raises
    ------
    NumericalFailure
        If a force or couple is not a finite number.
    """
    found: Bounded = loads * np.square(np.asarray(speed, dtype=float))[..., None, None]
    if not np.isfinite(found.value).all():
        raise NumericalFailure(
            "the inertia forces are not finite numbers at a crank speed of "
            f"{float(np.max(np.abs(speed))):.6g} rad/s: masses, lengths or speed are out of range"
        )
    return found


def about_point(loads: Bounded, point: ArrayLike) -> Bounded:
    """The same forces with couples about another point (..., 3), m from the reference point."""
    force = forces_of(loads)
    return _together(force, couples_of(loads) - cross(point, force))


def _together(force: Bounded, couple: Bounded) -> Bounded:
    """Loads (..., 6) of forces and couples (..., 3) that broadcast."""
    shape = np.broadcast_shapes(force.shape, couple.shape)
    wide = (Bounded(*(np.broadcast_to(one, shape) for one in part)) for part in (force, couple))
    return concatenate(list(wide))


# ----------------------------------------------------------------------------
# Inertia forces of the pistons on the body, per order and per crank speed squared.
# ----------------------------------------------------------------------------


def phasors(angle: Operand) -> Bounded:
    """exp(i angle) of angles (...) in rad, which are rounded products or differences."""
    turn, off = pair(angle)
    return Bounded(np.cos(turn) + 1j * np.sin(turn), off + EPSILON * (1.0 + np.abs(turn)))


def order_phasors(angle: ArrayLike, orders: ArrayLike) -> Bounded:
    """exp(i n angle) (..., n, c) for angles (..., c) and orders (n,).

    The product n angle is rounded, which costs n |angle| eps at most, the angle being a rounded
    difference itself.
    """
    return phasors(np.asarray(orders)[:, None] * np.asarray(angle, dtype=float)[..., None, :])


def pull_along(place: Operand, direction: Operand) -> Bounded:
    """Loads (..., 6) of a unit force along directions (..., 3) at places (..., 3)."""
    return _together(bounded(direction), cross(place, direction))


def reciprocating_excitation(
    motion_harmonics: Operand,
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
) -> Bounded:
    """Loads of c pistons for the orders 1 .. n, per crank speed squared.

    Cylinder i stands at the local angle a_i = angle + crank_phase - bank_angle. Its mass m pushes
    the body with -m d2s/dt2 outwards (d'Alembert), so order n is m R n^2 C_n exp(i n a_i) along
    the cylinder; the couple is r x F with r on the line of action, which an offset moves sideways.
    The crank turns right-handed about `axis`, so a quarter of a turn takes it from `stroke` to
    `axis x stroke = -across`, and a bank angle tilts a cylinder in that sense.

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

    Returns
    -------
    Bounded
        (..., n, 6) in kg m and kg m^2.
    """
    harmonics = bounded(motion_harmonics)[..., 1:]
    orders = np.arange(1, harmonics.shape[-1] + 1)
    unit = np.asarray(crank_radius, dtype=float)[..., None] * orders**2
    bank, mass = (
        np.asarray(one, dtype=float)[..., None] for one in (bank_angle, reciprocating_mass)
    )
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    push = (rounded(unit, 2) * harmonics)[..., None] * order_phasors(angle, orders)

    stroke, across = np.asarray(stroke, dtype=float), np.asarray(across, dtype=float)
    tilt = phasors(bank)
    outward = tilt.real * stroke - tilt.imag * across
    sideways = -(tilt.imag * stroke + tilt.real * across)
    along = np.asarray(position, dtype=float)[..., None] * np.asarray(axis, dtype=float)
    offset = np.asarray(wrist_pin_offset, dtype=float)[..., None, None]
    place = rounded(along, 2) + np.asarray(origin, dtype=float) + offset * sideways
    found: Bounded = push @ (pull_along(place, outward) * mass)
    return found


# ----------------------------------------------------------------------------
# Forces of unbalances that turn at constant speed, per crank speed squared.
# ----------------------------------------------------------------------------


def rotating_excitation(
    *,
    unbalance: Operand,
    speed_ratio: ArrayLike,
    phase: Operand,
    position: ArrayLike,
    origin: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
    highest_order: int,
) -> Bounded:
    """Loads of m unbalances U for the orders 1 .. highest_order, per crank speed squared.

    A shaft at `speed_ratio` q has its unbalance at the angle `phase + q * crank angle` from the
    stroke, in the crank's sense of rotation, and pulls the body with U q^2 outwards: a vector that
    turns, stroke + i across at order q, or stroke - i across with the phase reversed at order -q.
    At constant speed its angular momentum about its own axis is constant, so that the couple is
    r x F with r on that axis. A shaft faster than `highest_order` is left out, as are the pistons'
    harmonics above it.

    Parameters
    ----------
    unbalance, speed_ratio, phase
        (..., m) in kg m, integers other than zero, rad.
    position
        (..., m, 3) in m from the train's origin along x, y, z.
    origin, stroke, across
        (3,) the train's origin from the body's reference point in m, and unit vectors.

    Returns
    -------
    Bounded
        (..., highest_order, 6) in kg m and kg m^2.
    """
    ratio = np.asarray(speed_ratio)
    sense = np.sign(ratio)
    pull = bounded(unbalance) * ratio**2 * phasors(bounded(phase) * sense)
    turning = np.asarray(stroke) + 1j * sense[..., None] * np.asarray(across)
    place = rounded(position, 2) + np.asarray(origin, dtype=float)
    orders = np.arange(1, highest_order + 1)
    at_order = (np.abs(ratio)[..., None, :] == orders[:, None]).astype(float)
    found: Bounded = (at_order * pull[..., None, :]) @ pull_along(place, turning)
    return found


# ----------------------------------------------------------------------------
# The torque of the pistons on the crankshaft, and what of it reaches the body.
# ----------------------------------------------------------------------------


def inertia_torque(
    motion_harmonics: Operand, highest_order: int, *, dropped_acceleration: ArrayLike = 0.0
) -> Bounded:
    """Harmonics (..., highest_order + 1) of -s' s'', the torque of one piston over m R^2 w^2.

    At constant speed the kinetic energy m s'^2 w^2 / 2 changes at the rate of the torque the crank
    gives away, hence T = -m w^2 s' s''; its order 0 is zero. The product of two series is a
    convolution of their two-sided coefficients, taken over all motion harmonics that are given.

    Parameters
    ----------
    motion_harmonics
        C_n (..., h + 1) of s / R from order 0, with h >= highest_order.
    dropped_acceleration
        Sum of n^2 |C_n| over the orders above h that the motion has and the array has not. An
        order above h meets only partners above h - n, whence the bound on what is cut.

    Raises
    ------
    ValueError
        If there are fewer motion harmonics than orders asked for.
    """
    motion = bounded(motion_harmonics)
    highest = motion.shape[-1] - 1
    if highest_order > highest:
        raise ValueError(f"order {highest_order} of the torque needs as many motion harmonics")
    index = np.arange(highest + 1)
    one_sided = (1j * index * motion, -(index**2) * motion)
    velocity, acceleration = (
        concatenate([reshaped(one, lambda part: np.conj(part[..., :0:-1])), one])
        for one in one_sided
    )
    dropped = np.asarray(dropped_acceleration, dtype=float)[..., None]
    # the largest partner, of the last 1, 2, 3 ... orders
    partner_speed, partner_force = (
        np.maximum.accumulate(np.abs(one.value[..., ::-1]), axis=-1)[..., :highest_order]
        for one in one_sided
    )
    cut = dropped * (
        np.maximum(partner_speed, dropped / (highest + 1))
        + np.maximum(partner_force, dropped) / (highest + 1)
    )
    sums = [
        (velocity[..., order:] * acceleration[..., : order - 1 : -1]).sum()
        for order in range(1, highest_order + 1)
    ]
    torque = -0.5 * stack(sums)
    none = np.zeros((*torque.shape[:-1], 1))
    return concatenate([Bounded(none, none), Bounded(torque.value, torque.error + cut)])


def couple_about_axis(
    harmonics: Operand,
    moment: Operand,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
) -> Bounded:
    """Loads (..., n, 6) of couples about the crankshaft that have the same course in c cylinders.

    Parameters
    ----------
    harmonics
        (..., n) of one cylinder at the orders 1 .. n of its own angle.
    moment
        (..., c) what they are multiplied by.
    crank_phase, bank_angle
        (..., c) in rad; cylinder i stands at angle + crank_phase - bank_angle.
    axis
        (3,) unit vector along the crankshaft.
    """
    each, size = bounded(harmonics), bounded(moment)
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    turned = each[..., None] * order_phasors(angle, np.arange(1, each.shape[-1] + 1))
    return turned @ size[..., None] * np.concatenate([np.zeros(3), axis])
