"""All that acts on the body at the operating speed, and its steady motion on the mounts."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.firing import torque_reaches_mounts


class BodyLoads(NamedTuple):
    """Forces and couples `load` (..., m, 6) about the reference point at the orders (m,).

    The first `retained` orders count; those beyond the m orders may be `tail` times as much as
    what follows the retained ones. Where the torque of the cylinders reaches the mounts, `torque`
    (m, 6) is the part of it, by gas and by inertia, and `mean` (6,) what is constant of it.
    """

    order: np.ndarray
    load: Bounded
    retained: int
    tail: np.ndarray | float
    torque: Bounded | None = None
    mean: Bounded = Bounded(np.zeros(6), np.zeros(6))


def body_loads(scene: Scene) -> BodyLoads:
    """Shaking of the crank train and, where it reaches the mounts, the torque of the cylinders."""
    forcing: Forcing = scene.handed_on["forcing"]
    shaking = at_speed(forcing.per_speed_squared, scene.case.machine.speed)
    if not torque_reaches_mounts(scene.case):
        return BodyLoads(forcing.order, shaking, forcing.retained, forcing.tail)
    from vibecalc.isolation.adapters.torque_couple import torque_law
    from vibecalc.isolation.torque_reaction import TAIL

    law, speed = torque_law(scene, forcing.retained), scene.case.machine.speed
    axis = scene.parts.crank_train.axis
    load = with_shaking(law.added(speed), law.order, axis, shaking)
    torque = couple_about(axis, law.total(speed))
    mean = couple_about(axis, law.mean_couple(speed))
    return BodyLoads(law.order, load, law.retained, TAIL, torque, mean)


def couple_about(axis: np.ndarray, couple: Bounded) -> Bounded:
    """Loads (..., 6) of couples (...) about an axis (3,)."""
    return couple[..., None] * np.concatenate([np.zeros(3), axis])


def with_shaking(
    couple: Bounded, half_order: np.ndarray, axis: np.ndarray, shaking: Bounded
) -> Bounded:
    """Loads (m, 6) on the body: a couple (m,) about the unit vector `axis`, and what shakes it.

    `shaking` (n, 6) holds forces and couples of the orders 1 .. n at the speed; it enters at the
    whole ones of the orders `half_order` (m,).
    """
    load = couple_about(axis, couple)
    whole = (half_order == np.floor(half_order)) & (half_order <= len(shaking.value))
    few = shaking[half_order[whole].astype(int) - 1]
    load.value[whole] += few.value
    load.error[whole] += few.error + EPSILON * np.abs(load.value[whole])
    return load


def steady_motion(scene: Scene, system: OnMounts, load: Bounded, order: np.ndarray) -> Bounded:
    """Motion (..., m, f) under loads (..., m, 6) at the operating speed.

    Raises NumericalFailure where an order drives an undamped mode at its natural frequency.
    """
    felt, speed = system.felt(load), scene.case.machine.speed
    return system.forced(felt, order, speed, system.checked(felt, order, speed, scene.warn))
