"""Torque of cylinders on the crankshaft: of one, of unequal ones, summed by order."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import GasCard, fitted_card, pressure_at
from vibecalc.excitation.inertia_forces import inertia_torque
from vibecalc.kinematics.harmonics import (
    dropped_acceleration,
    harmonics_with_error,
    order_for_tolerance,
    pole,
)
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.kinematics.slider_crank import piston_path, top_dead_centre
from vibecalc.numerics.bounded import Bounded, rounded, stack, where
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    distinct,
    two_product,
)
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# Torque of one cylinder on the crankshaft, as harmonics of its cycle: gas and inertia.
#
# Positive in the sense of rotation. The angle t is the cylinder's own, from its firing position;
# the wrist pin stands at s(t) from the crank axis, so that the gauge pressure p on the piston area
# A does the work -p A ds and turns the crank with
#
#     gas:      -p A s'(t),
#     inertia:  -(m s' s'' + dJ phi' phi'') w^2,
#
# m the reciprocating mass, phi the rod's angle and dJ what the rod's moment of inertia has beyond
# its two point masses. A rotating mass adds to the inertia of the station and has no torque of its
# own.
# ----------------------------------------------------------------------------

#: largest phase of the highest order over one panel, rad, and products formed at a time
PANEL_PHASE = 24.0
BLOCK = 250_000
#: roundings of one integrand: sine, cosine and rod of s', the polynomial, the product, the weight
SAMPLE_ROUNDINGS = 12.0
#: errors without a common sign add as their squares do; this many times the root is not exceeded
INDEPENDENT = 4.0


class CylinderTorque(NamedTuple):
    """Harmonics of one cylinder, 0-to-peak: T(t) = mean + Re sum T_q exp(i q t).

    `order` (m,) are the orders q = 1/2, 1, 3/2 ... (four-stroke) or 1, 2 ... (two-stroke); `gas`
    (..., m) in N m, one entry for each card; `inertia` (m,) in N m per (rad/s)^2, without mean;
    `mean` (...) of the gas in N m.
    """

    order: FloatArray
    gas: Bounded
    inertia: Bounded
    mean: Bounded


def cylinder_torque(
    cards: Sequence[GasCard],
    geometry: CrankGeometry,
    *,
    reciprocating_mass: float,
    rod_inertia_difference: float = 0.0,
    harmonics: int,
) -> CylinderTorque:
    """The first `harmonics` orders of one cylinder for c cards of the same cycle: gas (c, m).

    Raises
    ------
    NumericalFailure
        The crank does not turn over, or R/L is too close to 1 for its harmonics.
    """
    order = np.arange(1, harmonics + 1, dtype=np.float64) * float(2.0 * np.pi / cards[0].cycle)
    gas, mean = zip(*(gas_harmonics(card, geometry, order) for card in cards), strict=True)
    inertia = inertia_harmonics(geometry, reciprocating_mass, rod_inertia_difference, order)
    return CylinderTorque(order, stack(gas, axis=0), inertia, stack(mean, axis=0))


def weighted(torque: CylinderTorque, weights: ArrayLike) -> CylinderTorque:
    """Torque of cards (c, ...) mixed by weights (..., c), see `gas_card.card_weights`."""
    share = rounded(weights, 2)
    return torque._replace(gas=share @ torque.gas, mean=share @ torque.mean)


def gas_harmonics(
    card: GasCard, geometry: CrankGeometry, order: ArrayLike
) -> tuple[Bounded, Bounded]:
    """Harmonics (m,) of the gas torque at the orders (m,), complex, and its mean (), in N m.

    Gauss panels that end at the nodes of the card. They are short against the distance of the poles
    of s' and have points enough that the rest of the quadrature on an ellipse of Bernstein with
    rho = 4 is below rounding (Trefethen 2013, Approximation Theory, theorem 19.3), so the error is
    that of the sums and of the card. The phase at the start of each panel is formed in twofold
    precision: it costs no digits at high orders.
    """
    orders = np.concatenate([[0.0], np.asarray(order, dtype=float)])
    radius, length, offset = geometry.lengths
    start, width, interval = _panels(card, geometry, orders[-1] if len(orders) > 1 else 0.0)
    degree = card.coefficient.shape[1] - 1
    phase = 0.5 * orders.max() * width.max()
    rule = gauss_rule(int(np.ceil(15.0 + 0.68 * phase + 0.5 * degree)))
    into = width[:, None] * rule.nodes
    away = (start - card.node[interval])[:, None] + into
    pressure, size = np.zeros_like(away), np.zeros_like(away)
    for power in range(degree, -1, -1):
        row = card.coefficient[interval, power][:, None]
        pressure, size = pressure * away + row, size * away + np.abs(row)
    path = piston_path(start[:, None] + into, radius, length, offset)
    weight = rule.weights * width[:, None] * (geometry.piston_area / card.cycle)
    torque = -pressure * path.velocity * weight
    # a rounded angle moves s' by s'' times its rounding
    angle = np.abs(start)[:, None] + into
    lever = np.abs(path.velocity) + radius * EPSILON
    uncertainty = (
        weight * size * (SAMPLE_ROUNDINGS * lever + angle * np.abs(path.acceleration)) * EPSILON
    )
    fit = card.error[interval] * np.sum(weight * lever, axis=1)
    magnitude = np.abs(torque).sum()
    local = np.empty((len(start), len(orders)), dtype=complex)
    chunk = max(1, BLOCK // torque.size)
    for low in range(0, len(orders), chunk):
        turn = np.exp(-1j * (into[..., None] * orders[low : low + chunk]))
        local[:, low : low + chunk] = np.matmul(torque[:, None, :], turn)[:, 0, :]
    value = (local * phasor(orders, start).T).sum(axis=0)
    # roundings of samples have no common sign; what a fit misses goes up and down in each panel
    spread = float(np.sqrt(INDEPENDENT**2 * np.sum(uncertainty**2) + np.sum(fit**2)))
    rounding = EPSILON * (8.0 + orders * width.max()) * magnitude
    error = np.broadcast_to(spread + rounding, value.shape)
    gas = Bounded(2.0 * value[1:], 2.0 * error[1:] + 2.0 * EPSILON * np.abs(value[1:]))
    return gas, Bounded(np.asarray(value[0].real), np.asarray(error[0]))


def inertia_harmonics(
    geometry: CrankGeometry,
    reciprocating_mass: float,
    rod_inertia_difference: float,
    order: ArrayLike,
) -> Bounded:
    """Harmonics (m,) of the inertia torque at the orders (m,), N m per (rad/s)^2.

    Zero at the half orders, and without a mean: at constant speed the masses give back within a
    turn what they have taken.
    """
    orders = np.asarray(order, dtype=float)
    radius, length, offset = geometry.lengths
    highest = max(1, int(np.floor(orders.max(initial=1.0))))
    torque, rod = _of_unit_masses(float(radius), float(length), float(offset), highest)
    mass, moment = rounded(reciprocating_mass * radius**2, 4), rounded(rod_inertia_difference, 2)
    found: Bounded = mass * torque - moment * rod
    whole = orders == np.floor(orders)
    index = np.where(whole, orders, 0.0).astype(int)
    return Bounded(
        np.where(whole, found.value[index], 0.0), np.where(whole, found.error[index], 0.0)
    )


#: orders of the motion in a torque where no number of them would be enough
MOST_ORDERS = 4096


@lru_cache(maxsize=16)
def _of_unit_masses(
    radius: float, length: float, offset: float, highest: int
) -> tuple[Bounded, Bounded]:
    """Torque of a piston over m R^2 w^2, and what a rod's moment of inertia is multiplied with.

    A machine asks for the same crank drive with several masses.
    """
    ratio, shift = radius / length, offset / radius
    try:
        enough = int(order_for_tolerance(ratio, 0.125 * EPSILON, shift))
    except NumericalFailure:  # close to R/L = 1: what is left out stands in the error
        enough = MOST_ORDERS
    used = max(highest, enough) + 4
    motion = harmonics_with_error(ratio, used, shift)
    torque = inertia_torque(
        Bounded(motion.values, motion.error),
        highest,
        dropped_acceleration=dropped_acceleration(ratio, used, shift),
    )
    return torque, rod_angle_harmonics(radius, length, offset, highest_order=highest).product


def gas_torque_at(card: GasCard, geometry: CrankGeometry, angle: ArrayLike) -> FloatArray:
    """Gas torque, N m, at the cylinder's own angles in rad: -p A s'."""
    path = piston_path(angle, *geometry.lengths)
    return np.asarray(-pressure_at(card, angle) * geometry.piston_area * path.velocity)


def inertia_torque_at(
    geometry: CrankGeometry,
    reciprocating_mass: float,
    rod_inertia_difference: float,
    angle: ArrayLike,
) -> FloatArray:
    """Inertia torque at constant speed, N m per (rad/s)^2, at the cylinder's own angles in rad."""
    radius, _, offset = geometry.lengths
    path = piston_path(angle, *geometry.lengths)
    sine, cosine = np.sin(angle), np.cos(angle)
    turning = radius * cosine / path.rod
    # cos phi phi'' = sin phi phi'^2 - (R/L) sin t, with cos phi = rod / L
    bending = ((radius * sine - offset) * turning**2 - radius * sine) / path.rod
    return np.asarray(
        -reciprocating_mass * path.velocity * path.acceleration
        - rod_inertia_difference * turning * bending
    )


def phasor(order: ArrayLike, angle: ArrayLike) -> ComplexArray:
    """exp(-i q angle) (m, ...) of orders (m,) and angles (...) in rad, within 3 EPSILON.

    The product is carried in two parts, so that nothing is lost where q times the angle is large.
    """
    angles = np.asarray(angle, dtype=float)
    orders = np.asarray(order, dtype=float).reshape(-1, *(1,) * angles.ndim)
    turn, low = two_product(orders, angles)
    return np.asarray(np.exp(-1j * turn) * (1.0 - 1j * low))


def _panels(
    card: GasCard, geometry: CrankGeometry, highest: float
) -> tuple[FloatArray, FloatArray, np.ndarray]:
    """Starts and widths of the panels, with the interval of the card each lies on."""
    ratio = np.asarray(geometry.crank_radius / geometry.rod_length)
    shift = np.asarray(abs(geometry.wrist_pin_offset) / geometry.crank_radius)
    distance = -float(np.log(pole(ratio, shift).radius))
    longest = min(0.8 * distance, PANEL_PHASE / max(highest, 1.0))
    width = np.diff(card.node)
    parts = np.maximum(1, np.ceil(width / longest)).astype(int)
    interval = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(len(interval)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = width[interval] / parts[interval]
    return card.node[interval] + within * share, share, interval


# ----------------------------------------------------------------------------
# Cylinders that do not do their share: imbalance, misfire, lost pistons.
#
# Each cylinder has a pressure scale (1 for a healthy one) and may misfire in one of two ways, which
# the result names: "no_gas", no gauge pressure at all (a valve stuck open), or "motored",
# compression and expansion without combustion (no fuel). Its masses go on moving unless it is lost.
# ----------------------------------------------------------------------------

PI = float(np.pi)


def cylinder_gas(
    torque: CylinderTorque,
    pressure_scale: ArrayLike,
    *,
    misfiring: ArrayLike = False,
    motored: CylinderTorque | None = None,
) -> tuple[Bounded, Bounded]:
    """Gas torque (..., c, m) of every cylinder and its mean (..., c) from that of a healthy one.

    Each is from its own firing, in N m.

    Parameters
    ----------
    torque
        Of a healthy cylinder, gas (..., m).
    pressure_scale
        (c,) factors on the gauge pressure, zero for no gas.
    misfiring
        (c,) true for a cylinder that misfires; it has the gas torque of `motored`, times its scale,
        or without `motored` none.
    motored
        Of a cylinder without combustion, gas of the same shape.
    """
    scale = np.asarray(pressure_scale, dtype=float)
    out = np.broadcast_to(np.asarray(misfiring, dtype=bool), scale.shape)
    gas = 0.0 if motored is None else motored.gas[..., None, :]
    mean = 0.0 if motored is None else motored.mean[..., None]
    return (
        where(out[:, None], gas, torque.gas[..., None, :]) * scale[:, None],
        where(out, mean, torque.mean[..., None]) * scale,
    )


def motored_card(
    card: GasCard, geometry: CrankGeometry, exhaust_opens: float = float(np.radians(130.0))
) -> GasCard:
    """A card without combustion, from one with it: the charge expands as it was compressed.

    From 180 degrees before firing to top dead centre the card stays as it is, then it runs back
    through the same pressures at the same places of the piston until the exhaust opens (rad,
    between 0 and pi), and passes over to the card's own pressure at 180 degrees. What has burnt
    before the top in the card given comes along, so the peak is somewhat high.

    The wrist pin at (s, e) sees the crank at equal angles on both sides of the line to it, hence
    the partner of the angle t at 2 arctan(e / s) - t.
    """
    radius, length, offset = geometry.lengths
    top = float(top_dead_centre(radius, length, offset).angle)

    def partner(angle: FloatArray) -> FloatArray:
        place = piston_path(angle, radius, length, offset).position
        return np.asarray(2.0 * np.arctan2(offset, place) - angle)

    def pressure(angle: FloatArray) -> FloatArray:
        direct = pressure_at(card, angle)
        back = pressure_at(card, partner(angle))
        share = np.clip((angle - exhaust_opens) / (PI - exhaust_opens), 0.0, 1.0)
        share_ahead = share * share * (3.0 - 2.0 * share)
        mirrored = (1.0 - share_ahead) * back + share_ahead * pressure_at(card, np.asarray(PI))
        return np.where((angle > top) & (angle < PI), mirrored, direct)

    first = -PI
    inside = np.mod(card.node[:-1] - first, card.cycle) + first
    back = partner(inside[inside < top])
    ends = {first, top, exhaust_opens, PI, first + card.cycle}
    before, after = inside[inside < top], inside[inside > PI]
    points = np.array(sorted({*before, *back[(back > top) & (back < PI)], *after, *ends}))
    # nodes that differ by rounding only would make pieces without width
    keep = np.concatenate([[True], np.diff(points) > 1e-9])
    keep[-1] = True
    return fitted_card(pressure, [float(v) for v in points[keep]], card.cycle)


# ----------------------------------------------------------------------------
# How the cylinders of an engine add up in each mode, order by order.
# ----------------------------------------------------------------------------

#: a sum that lacks less than this of all vectors in line counts as one of all in line
IN_LINE = 1e-9


class PhaseSums(NamedTuple):
    """Sums over the cylinders of shape times exp(-i q firing angle), per mode and order (k, m).

    `relative` is their size over the sum of all magnitudes: 1 for vectors in line, 0 where they
    cancel (and where no cylinder moves). `error` is that of `value`.
    """

    value: ComplexArray
    relative: FloatArray
    error: FloatArray


def phase_sums(shape: ArrayLike, firing_angle: ArrayLike, order: ArrayLike) -> PhaseSums:
    """Vector sums of c cylinders that fire at the angles (c,), in rad, at the orders (m,).

    `shape` (k, c) is the amplitude of every mode at each cylinder's station, real or complex, times
    what scales the cylinder if it is not one of equals.
    """
    amplitude = np.asarray(shape)
    turned = phasor(order, firing_angle)
    value = amplitude @ turned.T
    size = np.abs(amplitude).sum(axis=-1, keepdims=True)
    error = np.broadcast_to((3.0 + amplitude.shape[-1]) * EPSILON * size, value.shape)
    relative = np.abs(value) / np.where(size > 0.0, size, 1.0)
    return PhaseSums(value, np.minimum(relative, 1.0), error)


def bank_sums(firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike) -> ComplexArray:
    """Phase vectors of the c cylinders of each of b banks added up, (b, m); `bank` (c,) says which.

    Angles in rad; cylinders are of one bank where `bank`, as their bank angle, is the same.
    """
    banks = np.broadcast_to(np.asarray(bank, dtype=float), np.shape(firing_angle))
    member = banks == distinct(banks)[:, None]
    return np.asarray(member.astype(float) @ phasor(order, firing_angle).T)


def bank_factor(
    firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """What the bank angle leaves of an order (m,): sum of the banks over that of their magnitudes.

    For two banks of even firing |cos(q d / 2)|, with d the angle between the firings of the two; 1
    for one bank, 0 where each bank cancels in itself. The second value is its error.
    """
    sums = bank_sums(firing_angle, order, bank)
    count = np.size(firing_angle)
    whole = np.abs(sums).sum(axis=0)
    some = whole > IN_LINE * count
    safe = np.where(some, whole, 1.0)
    found = np.where(some, np.abs(sums.sum(axis=0)) / safe, 0.0)
    error = np.where(some, 2.0 * (3.0 + count) * EPSILON * count / safe, 0.0)
    return np.minimum(found, 1.0), error


def major_orders(firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike = 0.0) -> BoolArray:
    """Which orders (m,) find the cylinders of each bank in phase, and the banks not against it.

    With even firing these are the multiples of the firings of a bank in one turn, 3, 6, 9 ... for
    six cylinders in four-stroke, but for those that the bank angle cancels (`bank_factor` 0).
    """
    banks = np.broadcast_to(np.asarray(bank, dtype=float), np.shape(firing_angle))
    count = np.array([np.count_nonzero(banks == one) for one in sorted(set(banks.tolist()))])
    sums = np.abs(bank_sums(firing_angle, order, banks))
    in_phase = np.all(sums > (1.0 - IN_LINE) * count[:, None], axis=0)
    return np.asarray(in_phase & (bank_factor(firing_angle, order, banks)[0] > IN_LINE))


def order_ranks(vector_sum: ArrayLike, error: ArrayLike) -> IntArray:
    """Place of each order (k, m) in its mode by the size of its vector sum, 1 for the largest.

    Sums that differ by no more than `IN_LINE` and their errors share a place; where a sum is zero
    to within that the place is 0.
    """
    size = np.abs(np.asarray(vector_sum))
    off = np.broadcast_to(error, size.shape) + IN_LINE
    rank = np.zeros(size.shape, dtype=np.int64)
    for sizes, uncertainty, places in zip(size, off, rank, strict=True):
        last, number = np.inf, 0
        for count, place in enumerate(np.argsort(-sizes, kind="stable").tolist(), start=1):
            if sizes[place] <= uncertainty[place]:
                break
            if sizes[place] < last - uncertainty[place]:
                last, number = sizes[place], count
            places[place] = number
    return rank
