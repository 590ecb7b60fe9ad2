"""A centrifugal pendulum from its case, and the order that it is tuned to at any swing."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber import tables as parts
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, floats
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# A mass that a rotor carries along a path: geometry, kinetic energy, equations of motion.
#
# Seen from the rotor, the mass centre runs on a path that crosses a radius at right angles, at the
# distance c from the axis, with radius of curvature r there. Its place is shown by the angle p by
# which the tangent has turned; the radius of curvature is r cos(q p) with a constant q (Denman
# 1992, Journal of Sound and Vibration 159): q = 0 is a circle, 1 a cycloid, between them lie
# epicycloids. On the way the moment of the unit tangent about the axis, `reach`, is the solution of
# g'' + g = r cos(q p) with g(0) = c, g'(0) = 0, and the distance from the axis is sqrt(g^2 + g'^2).
#
# Two equal rollers in equal cutouts (a bifilar mount) keep the mass parallel to the rotor. They go
# half its way, and turn by -s/d against the rotor, s the way of the mass and d their diameter. The
# mass of an arm turns with the arm instead: `swing_inertia`.
#
# With the angle T of the rotor, L = A T'^2 / 2 + B T' p' + C p'^2 / 2 and no gravity:
#
#     A T'' + B p'' + A_p p' T' + B_p p'^2 = torque
#     B T'' + C p'' + C_p p'^2 / 2 - A_p T'^2 / 2 = - damping p'
# ----------------------------------------------------------------------------


class Pendulum(NamedTuple):
    """One pendulum, or several equal ones that move together with their masses added. SI, radians.

    `vertex_distance` c and `path_radius` r in m (for a circle r is the arm, and c - r the distance
    of its centre from the axis); `path_exponent` q; `swing_inertia` in kg m^2, of the mass about
    its own centre, only where it turns with an arm (q = 0). Rollers: mass of all, mean distance of
    their centres from the axis across the vertex, diameter, inertia of all about their own axes.
    """

    mass: ArrayLike
    vertex_distance: ArrayLike
    path_radius: ArrayLike
    path_exponent: ArrayLike = 0.0
    swing_inertia: ArrayLike = 0.0
    roller_mass: ArrayLike = 0.0
    roller_distance: ArrayLike = 0.0
    roller_diameter: ArrayLike = 1.0
    roller_inertia: ArrayLike = 0.0


class Path(NamedTuple):
    """Radius of curvature and reach, each with its derivative by the angle of the tangent, m."""

    radius: FloatArray
    radius_slope: FloatArray
    reach: FloatArray
    pull: FloatArray


class EnergyTerms(NamedTuple):
    """Coefficients of the kinetic energy in kg m^2, `..._slope` their derivatives by the angle.

    `carried` is A without the inertia of the rotor, of which own inertias of a mass that stays
    parallel to the rotor are a part.
    """

    carried: FloatArray
    carried_slope: FloatArray
    coupling: FloatArray
    coupling_slope: FloatArray
    swing: FloatArray
    swing_slope: FloatArray


def path(pendulum: Pendulum, angle: FloatArray) -> Path:
    """The path at angles that broadcast with the pendulum; angles may be complex."""
    far, near, bend = (np.asarray(value) for value in pendulum[1:4])
    # (cos qp - cos p) / (1 - q^2) and its derivative, whole at q = 1
    lean, sum_angle = 0.5 * (1.0 + bend) * angle, 0.5 * (1.0 - bend) * angle
    sine, cosine, over = np.sin(angle), np.cos(angle), _sinc(sum_angle)
    between = 0.5 * angle * angle * _sinc(lean) * over
    change = (sine + bend * angle * np.cos(lean) * over) / (1.0 + bend)
    return Path(
        radius=near * np.cos(bend * angle),
        radius_slope=-near * bend * np.sin(bend * angle),
        reach=far * cosine + near * between,
        pull=near * change - far * sine,
    )


def terms(pendulum: Pendulum, angle: FloatArray) -> EnergyTerms:
    """Coefficients of the kinetic energy at angles that broadcast with the pendulum."""
    mass, far, _, _, inertia, rolling, across, diameter, roller_inertia = (
        np.asarray(value) for value in pendulum
    )
    track = path(pendulum, angle)
    radius, slope = track.radius, track.radius_slope
    # the centre of a roller: half the travel of the mass, from another vertex
    nearby = across - 0.5 * far
    reach = nearby * np.cos(angle) + 0.5 * track.reach
    pull = -nearby * np.sin(angle) + 0.5 * track.pull
    moved = mass + 0.25 * rolling + roller_inertia / (diameter * diameter)
    lever = mass * track.reach + 0.5 * rolling * reach - roller_inertia / diameter
    force = mass * track.pull + 0.5 * rolling * pull
    square = track.reach * track.reach + track.pull * track.pull
    return EnergyTerms(
        carried=mass * square + rolling * (reach * reach + pull * pull) + roller_inertia + inertia,
        carried_slope=2.0 * radius * force,
        coupling=radius * lever + inertia,
        coupling_slope=slope * lever + radius * force,
        swing=moved * radius * radius + inertia,
        swing_slope=2.0 * moved * radius * slope,
    )


def _sinc(half: FloatArray) -> FloatArray:
    """sin x / x."""
    return np.asarray(np.sinc(half / np.pi))


# ----------------------------------------------------------------------------
# The order to which a pendulum is tuned, and how to tune it.
#
# For small swings p'' + n^2 W^2 p = 0 at a rotor speed W: the frequency is n times the speed, at
# any speed. A point on an arm r about a centre at R has n^2 = R / r. Rollers of mass M (centres of
# their cutouts at the mean distance R' of the axis, inertia I about their own axes, diameter d) add
# to the pull and to the motion, and so does an inertia that turns with the arm:
#
#     n^2 = r (m R + M R' / 2) / ((m + M / 4 + I / d^2) r^2 + swing inertia).
#
# A solid roller has I / d^2 = M / 8. In a bifilar mount r is the diameter of the cutouts less that
# of the roller, and both cutouts must be equal, or the rollers slide.
# ----------------------------------------------------------------------------

#: names of paths whose exponent does not depend on the pendulum
_FIXED = {"circular": 0.0, "cycloidal": 1.0}

#: paths by name
PATHS = (*_FIXED, "epicycloidal")


def tuning_order(pendulum: Pendulum) -> Bounded:
    """n, of small swings. Broadcasts.

    Raises NumericalFailure where nothing pulls the mass back (centre of the path at the axis or
    beyond it).
    """
    mass, far, near, _, inertia, rolling, across, diameter, roller_inertia = floats(*pendulum)
    pull = near * (mass * (far - near) + 0.5 * rolling * (across - 0.5 * near))
    if np.any(pull <= 0.0):
        raise NumericalFailure(
            "nothing pulls the pendulum outwards: the centre of curvature of its path has to lie "
            "between the axis and the mass"
        )
    moved = (mass + 0.25 * rolling + roller_inertia / diameter**2) * near**2 + inertia
    value = np.sqrt(pull / moved)
    lost = near * (mass * (far + near) + 0.5 * rolling * (across + 0.5 * near)) / pull
    return Bounded(value, (8.0 + 4.0 * lost) * UNIT_ROUNDOFF * value)


def radius_for_order_with_rollers(pendulum: Pendulum, order: ArrayLike) -> Bounded:
    """Path radius in m that tunes a pendulum with rollers or a swing inertia to an order.

    `path_radius` of the pendulum is not examined; vertex distances of mass and rollers stay. The
    radius solves a quadratic, of which the larger root is taken. Raises NumericalFailure where
    there is none: the swing inertia is too large for the order.
    """
    mass, far, _, _, inertia, rolling, across, diameter, roller_inertia = floats(*pendulum)
    square = np.square(np.asarray(order, dtype=float))
    heavy = mass + 0.25 * rolling
    a = heavy + square * (heavy + roller_inertia / diameter**2)
    b = mass * far + 0.5 * rolling * across
    room = b * b - 4.0 * a * square * inertia
    if np.any(room <= 0.0):
        raise NumericalFailure(
            "the inertia that turns with the arm is too large: no arm tunes it to this order"
        )
    value = (b + np.sqrt(room)) / (2.0 * a)
    return Bounded(value, UNIT_ROUNDOFF * value * (12.0 + 8.0 * b * b / room))


def path_exponent(path: str, pendulum: Pendulum) -> np.ndarray:
    """Exponent q of a path by name; "epicycloidal" is the one of equal times for this pendulum.

    On it the force along the path grows with the way: 1 - q^2 = r / (c + M b / (2 m + M / 2)) with
    b the distance from the axis of the rollers' centres less c / 2; without rollers
    q^2 = n^2 / (1 + n^2). Raises NumericalFailure for an unknown name, and for a path of equal
    times where a swing inertia forbids it.
    """
    if path in _FIXED:
        return np.asarray(_FIXED[path])
    if path not in PATHS:
        raise NumericalFailure(f"no path {path!r} of a pendulum; paths: {', '.join(PATHS)}")
    mass, far, near, _, inertia, rolling, across, _, _ = floats(*pendulum)
    if np.any(inertia != 0.0):
        raise NumericalFailure("a mass that turns with an arm runs on a circle, not a cycloid")
    centre = far + 0.5 * rolling * (across - 0.5 * far) / (mass + 0.25 * rolling)
    return np.asarray(np.sqrt((centre - near) / centre))


def detuning_coefficient(pendulum: Pendulum) -> Bounded:
    """e in n(P) = n (1 + e P^2 + ...) for swings of angle +-P of the tangent.

    e = -(1 - q^2 / q0^2) / 16, q0 the exponent of equal times: a circle softens by P^2 / 16, a
    cycloid hardens by P^2 / (16 n^2) without rollers.
    """
    bend = np.asarray(pendulum.path_exponent, dtype=float)
    if np.any((bend != 0.0) & (np.asarray(pendulum.swing_inertia) != 0.0)):
        raise NumericalFailure("a mass that turns with an arm runs on a circle, not a cycloid")
    even = path_exponent("epicycloidal", pendulum._replace(swing_inertia=0.0))
    share = np.square(bend / even)
    return Bounded(-(1.0 - share) / 16.0, UNIT_ROUNDOFF * (1.0 + 16.0 * share / even**2))


def largest_swing(pendulum: Pendulum) -> np.ndarray:
    """Angle (rad) of the tangent at which the path ends: a cusp at pi / (2 q), at most pi."""
    bend = np.asarray(pendulum.path_exponent, dtype=float)
    return np.asarray(math.pi / np.maximum(2.0 * bend, 1.0))


# ----------------------------------------------------------------------------
# The order that a pendulum keeps while it swings far: its exact period at a constant rotor speed.
#
# The equation of the swing has the first integral C p'^2 = W^2 (A(p) - A(P)), P the largest angle.
# With p = P sin u the period is
#
#     4 / W * integral from 0 to pi/2 of sqrt(C / D) du,    D = (A(p) - A(P)) / (P^2 - p^2),
#
# whose integrand is periodic and smooth, so that the midpoint rule converges geometrically. D is a
# mean of -A'(x) / 2 x over x^2 between p^2 and P^2, which a Gauss rule takes without cancellation.
# For a circle the period is 4 K(sin(P/2)) / (n W), K the complete elliptic integral, and
# n(P) = n AGM(1, cos(P/2)) with Gauss's arithmetic-geometric mean, whose steps square the error.
# ----------------------------------------------------------------------------

_INNER = 20
_FIRST, _MOST = 16, 4096

#: relative change from half the points at which doubling them ends
_SETTLED = 1e-13

#: below this angle the order is that of small swings to rounding, and A'(p) / p is taken here
_SMALL = 1e-7

#: so near (rad) to half a turn a mass on a circle all but stands still at the ends of its swing
_STANDS = 2e-5

#: relative difference of two numbers whose mean is the arithmetic-geometric one to rounding
_ALIKE = 1e-8

_TOO_NEAR = (
    "the period of a swing of {:.9g} rad is not found: it is too near to the end of the path"
)


def order_of_swing(pendulum: Pendulum, swing: ArrayLike) -> Bounded:
    """n(P): frequency over rotor speed of free swings between -P and P (rad). Broadcasts.

    Raises NumericalFailure for swings that leave the path (its cusp, or half a turn of a circle),
    and where the swing is so near to that that the period is not found.
    """
    far = np.abs(np.asarray(swing, dtype=float))
    if np.any(far >= largest_swing(pendulum)):
        raise NumericalFailure(
            f"a swing of {float(np.max(far)):.6g} rad leaves the path, which ends at "
            f"{float(np.min(largest_swing(pendulum))):.6g} rad"
        )
    small = tuning_order(pendulum)
    if np.all(np.asarray(pendulum.path_exponent) == 0.0):
        if np.all(far <= np.pi - _STANDS):
            return _on_circle(small, far)
        raise NumericalFailure(_TOO_NEAR.format(float(np.max(far))))
    largest = np.maximum(far, _SMALL)
    points, before = _FIRST, _mean(pendulum, largest, _FIRST)
    while points < _MOST:
        points *= 2
        after = _mean(pendulum, largest, points)
        change = np.abs(after - before) / after
        if np.all(change <= _SETTLED):
            value = 1.0 / after
            error = value * (change + 40.0 * UNIT_ROUNDOFF) + small.error
            return Bounded(value, error)
        before = after
    raise NumericalFailure(_TOO_NEAR.format(float(np.max(far))))


def _on_circle(small: Bounded, swing: FloatArray) -> Bounded:
    """n AGM(1, cos(P/2)).

    The mean grows by a smaller share than cos(P/2) does, so that roundings of P/2 and of the cosine
    come through with (P/2) tan(P/2) at most. Each step adds two roundings.
    """
    mean, root = np.ones_like(swing), np.cos(0.5 * swing)
    lost = 0.5 * swing * np.tan(0.5 * swing) * UNIT_ROUNDOFF
    steps = np.zeros_like(swing)
    # each swing ends by itself, so that its last bit does not depend on the others
    while np.any(apart := mean - root > _ALIKE * mean):
        between, product = 0.5 * (mean + root), np.sqrt(mean * root)
        mean, root = np.where(apart, between, mean), np.where(apart, product, root)
        steps = steps + apart
    # numbers so much alike are joined by one step more
    mean = 0.5 * (mean + root)
    value = small.value * mean
    error = value * (lost + (2.0 * steps + 4.0) * UNIT_ROUNDOFF) + small.error * mean
    return Bounded(value, error)


def _mean(pendulum: Pendulum, largest: FloatArray, points: int) -> FloatArray:
    """Mean of sqrt(C / D) over the quarter swing: 1 / n(P)."""
    rule = gauss_rule(_INNER)
    around = (np.arange(points) + 0.5) * (0.5 * np.pi / points)
    outer = Pendulum(*(np.asarray(value, dtype=float)[..., None] for value in pendulum))
    inner = Pendulum(*(np.asarray(value)[..., None] for value in outer))
    top = largest[..., None]
    angle = top * np.sin(around)
    lost = np.square(top * np.cos(around))
    place = np.sqrt(np.square(angle)[..., None] + lost[..., None] * rule.nodes)
    fall = -terms(inner, place).carried_slope / (2.0 * place)
    share = fall @ rule.weights
    if np.any(share <= 0.0):
        raise NumericalFailure("the pendulum is not driven back on the whole of its swing")
    return np.asarray(np.mean(np.sqrt(terms(outer, angle).swing / share), axis=-1))


# ----------------------------------------------------------------------------
# Pendulums of a validated case as the kernels of `response.pendulum` take them.
# ----------------------------------------------------------------------------

#: inertia of a solid roller over mass times squared diameter
_SOLID = 0.125


@dataclass(frozen=True, kw_only=True)
class PendulumParts:
    """Pendulums that swing together, with the rotor that carries them. SI, radians.

    `pendulum` has the masses of all of them; `damping` in N m s/rad acts on their common angle.
    `is_tuned` where the path follows from the order; `torque` is None where none is given.
    """

    pendulum: Pendulum
    order: float
    is_tuned: bool
    path: str
    count: int
    rotor_inertia: float
    rotor_stiffness: float
    speed: float
    damping: float
    torque: float | None
    swings: np.ndarray


def build_pendulum(case: Case) -> PendulumParts:
    """Pendulums and rotor of a case.

    Raises ValueError for a case without pendulums, and NumericalFailure where nothing pulls them
    back or no path tunes them; the checks refuse both.
    """
    given = case.machine.pendulum
    assert given is not None
    pendulum = placed(given)
    swinging = float(terms(pendulum, np.zeros(())).swing)
    inertia = float(tuning_order(pendulum).value) * given.speed
    points = np.linspace(0.0, given.swings.to, given.swings.points) if given.swings else np.zeros(0)
    return PendulumParts(
        pendulum=pendulum,
        order=given.order,
        is_tuned=given.path_radius is None,
        path=given.path,
        count=given.count,
        rotor_inertia=given.rotor_inertia,
        rotor_stiffness=given.rotor_stiffness,
        speed=given.speed,
        damping=2.0 * given.damping_ratio * inertia * swinging,
        torque=given.torque,
        swings=points,
    )


def placed(given: parts.Pendulum) -> Pendulum:
    """The pendulum with its path: as given, or tuned to the order.

    Raises NumericalFailure where no path tunes it.
    """
    far, near = _place(given)
    number, rollers = given.count, given.rollers
    inertia = {}
    if rollers is not None:
        solid = _SOLID * rollers.mass * rollers.diameter**2
        inertia = {
            "roller_mass": number * rollers.mass,
            "roller_distance": rollers.distance,
            "roller_diameter": rollers.diameter,
            "roller_inertia": number * (solid if rollers.inertia is None else rollers.inertia),
        }
    pendulum = Pendulum(
        mass=number * given.mass,
        vertex_distance=far,
        path_radius=near if near is not None else far,
        swing_inertia=number * given.swing_inertia,
        **inertia,
    )
    if near is None:
        tuned = float(radius_for_order_with_rollers(pendulum, given.order).value)
        pendulum = pendulum._replace(path_radius=tuned)
    tuning_order(pendulum)  # refuses what nothing pulls back, before a root of it is taken
    return pendulum._replace(path_exponent=float(path_exponent(given.path, pendulum)))


def _place(given: parts.Pendulum) -> tuple[float, float | None]:
    """Distance of the vertex from the axis, and radius of the path there if it is known."""
    near = given.path_radius
    if given.vertex_distance is not None:
        return given.vertex_distance, near
    assert given.arm_radius is not None
    if near is None:  # a point on an arm: n^2 = R / r
        near = given.arm_radius / given.order**2
    return given.arm_radius + near, near
