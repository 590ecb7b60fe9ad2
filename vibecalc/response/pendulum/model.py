"""A mass that a rotor carries along a path: geometry, kinetic energy, equations of motion.

Seen from the rotor, the mass centre runs on a path that crosses a radius at right angles, at the
distance c from the axis, with radius of curvature r there. Its place is told by the angle p by
which the tangent has turned; the radius of curvature is r cos(q p) with a constant q (Denman 1992,
Journal of Sound and Vibration 159): q = 0 is a circle, 1 a cycloid, between them lie epicycloids.
On the way the moment of the unit tangent about the axis, `reach`, is the solution of
g'' + g = r cos(q p) with g(0) = c, g'(0) = 0, and the distance from the axis is sqrt(g^2 + g'^2).

Two equal rollers in equal cutouts (a bifilar mount) keep the mass parallel to the rotor. They go
half its way, and turn by -s/d against the rotor, s the way of the mass and d their diameter. The
mass of an arm turns with the arm instead: `swing_inertia`.

With the angle T of the rotor, L = A T'^2 / 2 + B T' p' + C p'^2 / 2 and no gravity:

    A T'' + B p'' + A_p p' T' + B_p p'^2 = torque
    B T'' + C p'' + C_p p'^2 / 2 - A_p T'^2 / 2 = - damping p'
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.typing import FloatArray


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


class Terms(NamedTuple):
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
    lean, rest = 0.5 * (1.0 + bend) * angle, 0.5 * (1.0 - bend) * angle
    sine, cosine = np.sin(angle), np.cos(angle)
    between = 0.5 * angle * angle * _sinc(lean) * _sinc(rest)
    change = (sine + bend * angle * np.cos(lean) * _sinc(rest)) / (1.0 + bend)
    return Path(
        radius=near * np.cos(bend * angle),
        radius_slope=-near * bend * np.sin(bend * angle),
        reach=far * cosine + near * between,
        pull=near * change - far * sine,
    )


def terms(pendulum: Pendulum, angle: FloatArray) -> Terms:
    """Coefficients of the kinetic energy at angles that broadcast with the pendulum."""
    mass, far, _, _, own, rolling, across, diameter, roller_own = (
        np.asarray(value) for value in pendulum
    )
    way = path(pendulum, angle)
    radius, slope = way.radius, way.radius_slope
    # the centre of a roller: half the way of the mass, from another vertex
    beside = across - 0.5 * far
    reach = beside * np.cos(angle) + 0.5 * way.reach
    pull = -beside * np.sin(angle) + 0.5 * way.pull
    moved = mass + 0.25 * rolling + roller_own / (diameter * diameter)
    lever = mass * way.reach + 0.5 * rolling * reach - roller_own / diameter
    force = mass * way.pull + 0.5 * rolling * pull
    square = way.reach * way.reach + way.pull * way.pull
    return Terms(
        carried=mass * square + rolling * (reach * reach + pull * pull) + roller_own + own,
        carried_slope=2.0 * radius * force,
        coupling=radius * lever + own,
        coupling_slope=slope * lever + radius * force,
        swing=moved * radius * radius + own,
        swing_slope=2.0 * moved * radius * slope,
    )


def rates(
    pendulum: Pendulum,
    rotor_inertia: ArrayLike,
    state: FloatArray,
    torque: ArrayLike = 0.0,
    damping: ArrayLike = 0.0,
) -> FloatArray:
    """Time derivative of states (..., 4): rotor angle, swing angle, rotor speed, swing speed.

    Torque on the rotor in N m; damping in N m s/rad, torque on the swing angle per swing speed.
    """
    swung, speed, swinging = state[..., 1], state[..., 2], state[..., 3]
    term = terms(pendulum, swung)
    rotor = np.asarray(rotor_inertia) + term.carried
    first = (
        np.asarray(torque)
        - term.carried_slope * swinging * speed
        - term.coupling_slope * swinging * swinging
    )
    second = (
        0.5 * term.carried_slope * speed * speed
        - 0.5 * term.swing_slope * swinging * swinging
        - np.asarray(damping) * swinging
    )
    whole = rotor * term.swing - term.coupling * term.coupling
    rotor_rate = (term.swing * first - term.coupling * second) / whole
    swing_rate = (rotor * second - term.coupling * first) / whole
    return np.stack(np.broadcast_arrays(speed, swinging, rotor_rate, swing_rate), axis=-1)


def _sinc(half: FloatArray) -> FloatArray:
    """sin x / x."""
    return np.asarray(np.sinc(half / np.pi))
