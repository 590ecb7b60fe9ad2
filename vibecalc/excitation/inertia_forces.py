"""Inertia forces of pistons and unbalances on the body, and torque of the pistons, by order."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, Summed
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Forces and couples per order, with their error estimates: the sum that every part enters.
# ----------------------------------------------------------------------------

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


def with_terms(found: Bounded, rounding: ArrayLike | None = None) -> Summed:
    """A sum with the size of its terms, which its `rounding` tells: all of its error, if None."""
    known = found.error if rounding is None else rounding
    return Summed(found.value, found.error, size_of_terms(known))


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


def as_loads(excitation: Excitation) -> Bounded:
    """Forces and couples (..., orders, 6): x, y, z, then the couples about them."""
    force, couple, force_error, couple_error = np.broadcast_arrays(*excitation)
    return Bounded(
        np.concatenate([force, couple], axis=-1),
        np.concatenate([force_error, couple_error], axis=-1),
    )


# ----------------------------------------------------------------------------
# Inertia forces of the pistons on the body, per order and per crank speed squared.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# Forces of unbalances that turn at constant speed, per crank speed squared.
# ----------------------------------------------------------------------------


def rotating_excitation(
    *,
    unbalance: ArrayLike,
    speed_ratio: ArrayLike,
    phase: ArrayLike,
    position: ArrayLike,
    origin: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
    highest_order: int,
) -> Excitation:
    """Forces and couples of m unbalances U for the orders 1 .. highest_order.

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
    Excitation
        Forces (..., highest_order, 3) in kg m, couples in kg m^2, errors of both.
    """
    ratio = np.asarray(speed_ratio)
    sense = np.sign(ratio)
    strength = np.asarray(unbalance, dtype=float) * ratio**2
    angle = sense * np.asarray(phase, dtype=float)
    pull = strength * (np.cos(angle) + 1j * np.sin(angle))

    stroke, across = np.asarray(stroke, dtype=float), np.asarray(across, dtype=float)
    turning = stroke + 1j * sense[..., None] * across
    centre = np.asarray(origin, dtype=float) + np.asarray(position, dtype=float)
    centre_size = np.abs(origin) + np.abs(position)
    arm, arm_size = np.cross(centre, turning), cross_magnitude(centre_size, turning)

    orders = np.arange(1, highest_order + 1)
    at_order = (np.abs(ratio)[..., None, :] == orders[:, None]).astype(float)
    pulls = at_order * pull[..., None, :]
    sizes = at_order * np.abs(strength)[..., None, :]
    return Excitation(
        pulls @ turning,
        pulls @ arm,
        3.0 * EPSILON * (sizes @ np.abs(turning)),
        4.0 * EPSILON * (sizes @ arm_size),
    )


# ----------------------------------------------------------------------------
# The torque of the pistons on the crankshaft, and what of it reaches the body.
# ----------------------------------------------------------------------------


class TorqueHarmonics(NamedTuple):
    """Orders 0 .. n (..., n + 1) of the inertia torque over m R^2 w^2; order 0 is zero."""

    harmonics: Complex
    error: Real


def inertia_torque(
    motion_harmonics: ArrayLike,
    highest_order: int,
    *,
    dropped_acceleration: ArrayLike = 0.0,
    motion_error: ArrayLike = 0.0,
) -> TorqueHarmonics:
    """Harmonics of -s' s'', the torque of one piston on the crank over m R^2 w^2.

    At constant speed the kinetic energy m s'^2 w^2 / 2 changes at the rate of the torque the crank
    gives away, hence T = -m w^2 s' s''. The product of two series is a convolution of their
    coefficients, taken over all motion harmonics that are given: (ab)_n is half the sum of
    a_j b_k over j + k = n, of a_j conj(b_k) over j - k = n and of conj(a_j) b_k over k - j = n.

    Parameters
    ----------
    motion_harmonics
        C_n (..., h + 1) of s / R from order 0, with h >= highest_order.
    dropped_acceleration
        Sum of n^2 |C_n| over the orders above h that the motion has and the array has not. An
        order above h meets only partners above h - n, whence the bound on what is cut.
    motion_error
        Absolute errors (..., h + 1) of the harmonics; zero takes them as exact.

    Raises
    ------
    ValueError
        If there are fewer motion harmonics than orders asked for.
    """
    motion = np.asarray(motion_harmonics, dtype=complex)
    highest = motion.shape[-1] - 1
    if highest_order > highest:
        raise ValueError(f"order {highest_order} of the torque needs as many motion harmonics")
    index = np.arange(highest + 1)
    slip = np.broadcast_to(np.asarray(motion_error, dtype=float), motion.shape)
    velocity, acceleration = 1j * index * motion, -(index**2) * motion
    speed, force = np.abs(velocity), np.abs(acceleration)
    speed_slip, force_slip = index * slip, index**2 * slip
    dropped = np.asarray(dropped_acceleration, dtype=float)

    harmonics = np.zeros((*motion.shape[:-1], highest_order + 1), dtype=complex)
    error = np.zeros(harmonics.shape)
    for order in range(1, highest_order + 1):
        low, high = slice(None, highest + 1 - order), slice(order, None)
        up, down = slice(None, order + 1), slice(order, None, -1)
        total = (
            (velocity[..., up] * acceleration[..., down]).sum(-1)
            + (velocity[..., high] * acceleration[..., low].conj()).sum(-1)
            + (velocity[..., low].conj() * acceleration[..., high]).sum(-1)
        )
        harmonics[..., order] = -0.5 * total
        rounding = sum(
            (speed[..., a] * (4.0 * EPSILON * force[..., b] + force_slip[..., b])).sum(-1)
            + (speed_slip[..., a] * force[..., b]).sum(-1)
            for a, b in ((up, down), (high, low), (low, high))
        )
        tail = slice(max(0, highest + 1 - order), None)
        partner_speed = np.maximum(speed[..., tail].max(-1), dropped / (highest + 1))
        partner_force = np.maximum(force[..., tail].max(-1), dropped)
        cut = dropped * (partner_speed + partner_force / (highest + 1))
        error[..., order] = 0.5 * rounding + cut
    return TorqueHarmonics(harmonics, error)


def mean_inertia(
    motion_harmonics: ArrayLike, crank_radius: ArrayLike, reciprocating_mass: ArrayLike
) -> Real:
    """Mean over a turn (...) of what the pistons add to the inertia at the crank, kg m^2.

    That is the sum of m s'^2 over the cylinders: m R^2 sum n^2 |C_n|^2 / 2 each. Arrays as in
    `torque_reaction`, `motion_harmonics` (..., h + 1) from order 0.
    """
    motion = np.asarray(motion_harmonics)
    velocity = np.arange(motion.shape[-1]) * np.abs(motion)
    square = 0.5 * np.square(velocity).sum(-1) * np.square(np.asarray(crank_radius, dtype=float))
    return np.asarray(np.asarray(reciprocating_mass, dtype=float).sum(-1) * square)


def rotor_share(rotor_inertia: ArrayLike, moving_inertia: ArrayLike) -> Real:
    """Share of the torque at constant speed that reaches a rotor of finite inertia.

    The rotor follows J phi'' = T - m phi'', m the mean inertia of what moves with the pistons: it
    takes T J / (J + m), and the body has minus that. What the fluctuation of the speed mixes
    between the orders is of relative size m / J and left out.
    """
    rotor = np.asarray(rotor_inertia, dtype=float)
    return np.asarray(rotor / (rotor + np.asarray(moving_inertia, dtype=float)))


def torque_reaction(
    torque: TorqueHarmonics,
    *,
    crank_radius: ArrayLike,
    reciprocating_mass: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
) -> Excitation:
    """Couple on the body about the crankshaft by the torque of its masses.

    The side thrusts of the pistons turn the body with -T, in addition to r x F. T goes into the
    speed of a large rotor, whose angular momentum changes by it; a stator that gives a constant
    torque adds nothing that alternates, wherever it stands.

    Arrays as in `reciprocating_excitation`; (..., n, 3) per crank speed squared, without force.
    """
    harmonics = Bounded(torque.harmonics, torque.error)[..., 1:]
    orders = np.arange(1, harmonics.shape[-1] + 1)
    square = np.asarray(crank_radius, dtype=float)[..., None] ** 2
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    phasor = Bounded(*order_phasors(angle, orders))
    mass = np.asarray(reciprocating_mass, dtype=float)[..., None, :]
    turn = mass * (square * harmonics)[..., None] * phasor
    couple = -turn.sum()[..., None] * np.asarray(axis, dtype=float)
    none = np.zeros(couple.shape)
    return Excitation(none.astype(complex), couple.value, none, couple.error)
