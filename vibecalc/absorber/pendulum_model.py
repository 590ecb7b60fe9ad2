"""Pendulums of a validated case as the kernels of `response.pendulum` take them."""

from dataclasses import dataclass

import numpy as np

from vibecalc.absorber import tables as parts
from vibecalc.absorber.pendulum_order import (
    Pendulum,
    path_exponent,
    radius_for_order_with_rollers,
    terms,
    tuning_order,
)
from vibecalc.schema import Case

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
    if given is None:
        raise ValueError("the case has no pendulum")
    pendulum = placed(given)
    swinging = float(terms(pendulum, np.zeros(())).swing)
    own = float(tuning_order(pendulum).value) * given.speed
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
        damping=2.0 * given.damping_ratio * own * swinging,
        torque=given.torque,
        swings=points,
    )


def placed(given: parts.Pendulum) -> Pendulum:
    """The pendulum with its path: as given, or tuned to the order.

    Raises NumericalFailure where no path tunes it.
    """
    far, near = _place(given)
    number, rollers = given.count, given.rollers
    own = {}
    if rollers is not None:
        solid = _SOLID * rollers.mass * rollers.diameter**2
        own = {
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
        **own,
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
    if given.arm_radius is None:
        raise ValueError("a pendulum needs vertex_distance or arm_radius")
    if near is None:  # a point on an arm: n^2 = R / r
        near = given.arm_radius / given.order**2
    return given.arm_radius + near, near
