"""Torque of one cylinder on the crankshaft, as harmonics of its cycle: gas and inertia.

Positive in the sense of rotation. The angle t is the cylinder's own, from its firing position; the
wrist pin stands at s(t) from the crank axis, so that the gauge pressure p on the piston area A does
the work -p A ds and turns the crank with

    gas:      -p A s'(t),
    inertia:  -(m s' s'' + dJ phi' phi'') w^2,

m the reciprocating mass, phi the rod's angle and dJ what the rod's moment of inertia has beyond its
two point masses. A rotating mass adds to the inertia of the station and has no torque of its own.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.gas_card import GasCard, pressure_at
from vibecalc.excitation.inertia_torque import inertia_torque
from vibecalc.kinematics.dropped_orders import dropped_acceleration, order_for_tolerance
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.kinematics.poles import pole
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.twofold import two_product
from vibecalc.numerics.typing import ComplexArray, FloatArray

#: largest phase of the highest order over one panel, rad, and products formed at a time
PANEL_PHASE = 24.0
BLOCK = 250_000
#: roundings of one integrand: sine, cosine and rod of s', the polynomial, the product, the weight
SAMPLE_ROUNDINGS = 12.0
#: errors without a common sign add as their squares do; this many times the root is not exceeded
INDEPENDENT = 4.0
PARTS = WithError._fields


class CrankGeometry(NamedTuple):
    """Lengths of one cylinder in m: crank radius, rod between centres, wrist pin offset, bore."""

    crank_radius: float
    rod_length: float
    bore: float
    wrist_pin_offset: float = 0.0

    @property
    def piston_area(self) -> float:
        """Area of the piston, m^2."""
        return 0.25 * float(np.pi) * self.bore**2


class CylinderTorque(NamedTuple):
    """Harmonics of one cylinder, 0-to-peak: T(t) = mean + Re sum T_q exp(i q t).

    `order` (m,) are the orders q = 1/2, 1, 3/2 ... (four-stroke) or 1, 2 ... (two-stroke); `gas`
    (..., m) in N m, one entry for each card; `inertia` (m,) in N m per (rad/s)^2, without mean;
    `mean` (...) of the gas in N m. The errors are absolute and real.
    """

    order: FloatArray
    gas: ComplexArray
    gas_error: FloatArray
    inertia: ComplexArray
    inertia_error: FloatArray
    mean: FloatArray
    mean_error: FloatArray


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
    found = [gas_harmonics(card, geometry, order) for card in cards]
    gas = WithError(*(np.stack([getattr(each, part) for each, _ in found]) for part in PARTS))
    mean = WithError(*(np.stack([getattr(each, part) for _, each in found]) for part in PARTS))
    inertia = inertia_harmonics(geometry, reciprocating_mass, rod_inertia_difference, order)
    return CylinderTorque(
        order, gas.value, gas.error, inertia.value, inertia.error, mean.value, mean.error
    )


def weighted(torque: CylinderTorque, weights: ArrayLike) -> CylinderTorque:
    """Torque of cards (c, ...) mixed by weights (..., c), see `gas_card.card_weights`."""
    share = np.asarray(weights, dtype=float)
    size = np.abs(share)
    return torque._replace(
        gas=share @ torque.gas,
        gas_error=size @ (torque.gas_error + 2.0 * EPSILON * np.abs(torque.gas)),
        mean=share @ torque.mean,
        mean_error=size @ (torque.mean_error + 2.0 * EPSILON * np.abs(torque.mean)),
    )


def gas_harmonics(
    card: GasCard, geometry: CrankGeometry, order: ArrayLike
) -> tuple[WithError, WithError]:
    """Harmonics (m,) of the gas torque at the orders (m,), complex, and its mean (), in N m.

    Gauss panels that end at the nodes of the card. They are short against the distance of the poles
    of s' and have points enough that the rest of the quadrature on an ellipse of Bernstein with
    rho = 4 is below rounding (Trefethen 2013, Approximation Theory, theorem 19.3), so the error is
    that of the sums and of the card. The phase at the start of each panel is formed in twofold
    precision: it costs no digits at high orders.
    """
    orders = np.concatenate([[0.0], np.asarray(order, dtype=float)])
    radius, length, offset = geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset
    start, width, piece = _panels(card, geometry, orders[-1] if len(orders) > 1 else 0.0)
    degree = card.coefficient.shape[1] - 1
    phase = 0.5 * orders.max() * width.max()
    rule = gauss_rule(int(np.ceil(15.0 + 0.68 * phase + 0.5 * degree)))
    into = width[:, None] * rule.nodes
    away = (start - card.node[piece])[:, None] + into
    pressure, size = np.zeros_like(away), np.zeros_like(away)
    for power in range(degree, -1, -1):
        row = card.coefficient[piece, power][:, None]
        pressure, size = pressure * away + row, size * away + np.abs(row)
    path = piston_path(start[:, None] + into, radius, length, offset)
    weight = rule.weights * width[:, None] * (geometry.piston_area / card.cycle)
    torque = -pressure * path.velocity * weight
    # a rounded angle moves s' by s'' times its rounding
    angle = np.abs(start)[:, None] + into
    lever = np.abs(path.velocity) + radius * EPSILON
    doubt = weight * size * (SAMPLE_ROUNDINGS * lever + angle * np.abs(path.acceleration)) * EPSILON
    fit = card.error[piece] * np.sum(weight * lever, axis=1)
    magnitude = np.abs(torque).sum()
    local = np.empty((len(start), len(orders)), dtype=complex)
    chunk = max(1, BLOCK // torque.size)
    for low in range(0, len(orders), chunk):
        turn = np.exp(-1j * (into[..., None] * orders[low : low + chunk]))
        local[:, low : low + chunk] = np.matmul(torque[:, None, :], turn)[:, 0, :]
    value = (local * phasor(orders, start).T).sum(axis=0)
    # roundings of samples have no common sign; what a fit misses goes up and down in each panel
    spread = float(np.sqrt(INDEPENDENT**2 * np.sum(doubt**2) + np.sum(fit**2)))
    rounding = EPSILON * (8.0 + orders * width.max()) * magnitude
    error = np.broadcast_to(spread + rounding, value.shape)
    gas = WithError(2.0 * value[1:], 2.0 * error[1:] + 2.0 * EPSILON * np.abs(value[1:]))
    return gas, WithError(np.asarray(value[0].real), np.asarray(error[0]))


def inertia_harmonics(
    geometry: CrankGeometry,
    reciprocating_mass: float,
    rod_inertia_difference: float,
    order: ArrayLike,
) -> WithError:
    """Harmonics (m,) of the inertia torque at the orders (m,), N m per (rad/s)^2.

    Zero at the half orders, and without a mean: at constant speed the masses give back within a
    turn what they have taken.
    """
    orders = np.asarray(order, dtype=float)
    radius, length, offset = geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset
    ratio, shift = radius / length, offset / radius
    highest = max(1, int(np.floor(orders.max(initial=1.0))))
    kept = max(highest, order_for_tolerance(ratio, 0.125 * EPSILON, shift)) + 4
    motion = harmonics_with_error(ratio, kept, shift)
    torque = inertia_torque(
        motion.values,
        highest,
        dropped_acceleration=dropped_acceleration(ratio, kept, shift),
        motion_error=motion.error,
    )
    mass = reciprocating_mass * radius**2
    rod = rod_angle_harmonics(radius, length, offset, highest_order=highest).product
    value = mass * torque.harmonics - rod_inertia_difference * rod.value
    error = mass * torque.error + np.abs(rod_inertia_difference) * rod.error
    error = error + 4.0 * EPSILON * (
        np.abs(mass * torque.harmonics) + np.abs(rod_inertia_difference * rod.value)
    )
    whole = orders == np.floor(orders)
    index = np.where(whole, orders, 0.0).astype(int)
    return WithError(np.where(whole, value[index], 0.0), np.where(whole, error[index], 0.0))


def gas_torque_at(card: GasCard, geometry: CrankGeometry, angle: ArrayLike) -> FloatArray:
    """Gas torque, N m, at the cylinder's own angles in rad: -p A s'."""
    path = piston_path(angle, geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset)
    return np.asarray(-pressure_at(card, angle) * geometry.piston_area * path.velocity)


def inertia_torque_at(
    geometry: CrankGeometry,
    reciprocating_mass: float,
    rod_inertia_difference: float,
    angle: ArrayLike,
) -> FloatArray:
    """Inertia torque at constant speed, N m per (rad/s)^2, at the cylinder's own angles in rad."""
    radius, length, offset = geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset
    path = piston_path(angle, radius, length, offset)
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
    """Starts and widths of the panels, with the piece of the card each lies on."""
    ratio = np.asarray(geometry.crank_radius / geometry.rod_length)
    shift = np.asarray(abs(geometry.wrist_pin_offset) / geometry.crank_radius)
    distance = -float(np.log(pole(ratio, shift).radius))
    longest = min(0.8 * distance, PANEL_PHASE / max(highest, 1.0))
    width = np.diff(card.node)
    parts = np.maximum(1, np.ceil(width / longest)).astype(int)
    piece = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = width[piece] / parts[piece]
    return card.node[piece] + within * share, share, piece
