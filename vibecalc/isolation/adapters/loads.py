"""All that acts on the body at the operating speed, and its steady motion on the mounts."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.firing import torque_reaches_mounts
from vibecalc.response.resonances import Resonances


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
    from vibecalc.isolation.adapters.torque_couple import couples_of
    from vibecalc.isolation.torque_reaction import TAIL, with_shaking

    couples, axis = couples_of(scene, forcing.retained), scene.parts.crank_train.axis
    none = Bounded(shaking.value[..., :0, :], shaking.error[..., :0, :])
    load, torque = (
        with_shaking(couple, couples.order, axis, beside)
        for couple, beside in ((couples.added, shaking), (couples.total, none))
    )
    mean = couple_about(axis, couples.mean)
    return BodyLoads(couples.order, load, couples.retained, TAIL, torque, mean)


def couple_about(axis: np.ndarray, couple: Bounded) -> Bounded:
    """Load (6,) of a couple about an axis (3,)."""
    about = np.concatenate([np.zeros(3), axis])
    return Bounded(couple.value * about, couple.error * np.abs(about))


def steady_motion(
    scene: Scene, system: OnMounts, loads: Bounded, order: np.ndarray
) -> tuple[Bounded, Resonances]:
    """Motion (..., m, f) under loads (..., m, f) at the operating speed, and what orders may meet.

    Raises NumericalFailure where an order drives an undamped mode at its natural frequency.
    """
    speed = scene.case.machine.speed
    resonances = system.checked(loads, order, speed, scene.warn)
    return system.forced(loads, order, speed, resonances), resonances
