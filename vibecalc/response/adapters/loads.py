"""All that acts on a body, at the operating speed and at any other, and its steady motion."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.firing import with_torque
from vibecalc.response.resonances import Resonances
from vibecalc.response.system import MountedBody
from vibecalc.response.torque_reaction import TAIL

if TYPE_CHECKING:
    from vibecalc.response.adapters.torque_couple import TorqueLaw


class BodyLoads(NamedTuple):
    """Forces and couples `load` (..., m, 6) about the reference point at the orders (m,).

    The first `retained` orders count; those beyond the m orders may be `tail` times as much as
    what follows the retained ones. Where the torque of the cylinders acts, `torque` (m, 6) is the
    part of it, by gas and by inertia, and `mean` (6,) what is constant of it.
    """

    order: np.ndarray
    load: Bounded
    retained: int
    tail: np.ndarray | float
    torque: Bounded | None = None
    mean: Bounded = Bounded(np.zeros(6), np.zeros(6))


def body_loads(scene: Scene, table: str = "isolation") -> BodyLoads:
    """Shaking of the crank train and, if [isolation] or [response] has it, torque of the cylinders.

    At the operating speed; `table` is the one whose `loads` count.
    """
    forcing: Forcing = scene.handed_on["forcing"]
    speed = scene.case.machine.speed
    shaking = at_speed(forcing.per_speed_squared, speed)
    law = torque_of(scene, table)
    if law is None:
        return BodyLoads(forcing.order, shaking, forcing.retained, forcing.tail)
    axis = scene.parts.crank_train.axis
    torque, lacking, mean = (
        couple_about(axis, couple)
        for couple in (law.couple_at(speed), law.lacking_at(speed), law.mean_at(speed))
    )
    load = shaking_at(law.order, shaking) + lacking
    return BodyLoads(law.order, load, law.retained, TAIL, torque, mean)


def torque_of(scene: Scene, table: str) -> "TorqueLaw | None":
    """Torque of the cylinders, where it acts on the body of this table."""
    if table not in with_torque(scene.case):
        return None
    from vibecalc.response.adapters.torque_couple import torque_law

    return torque_law(scene)


def couple_about(axis: np.ndarray, couple: Bounded) -> Bounded:
    """Loads (..., 6) of couples (...) about an axis (3,)."""
    about = np.concatenate([np.zeros(3), axis])
    return Bounded(couple.value[..., None] * about, couple.errors[..., None] * np.abs(about))


def shaking_at(order: np.ndarray, shaking: Bounded) -> Bounded:
    """Loads (m, 6) at orders (m,), of which some are halves, from those (n, 6) of orders 1 .. n."""
    value = np.zeros((len(order), 6), dtype=complex)
    error = np.zeros(value.shape)
    whole = (order == np.floor(order)) & (order <= len(shaking.value))
    place = order[whole].astype(int) - 1
    value[whole], error[whole] = shaking.value[place], shaking.errors[place]
    return Bounded(value, error)


class LoadsOverSpeed(NamedTuple):
    """All that acts on a body from one crank speed to another, at the orders (m,).

    `at` takes speeds (s,) in rad/s to loads (s, m, 6), of which `shaking` (m, 6) is per speed
    squared and `couples`, each (m, 6), what else there is at the `speeds` (k,): both ends, and
    those of gas cards between them. `line` (...) are natural frequencies in rad/s of a shaft line
    that passes the torque on. `retained` and `tail` as of `BodyLoads`.
    """

    order: np.ndarray
    retained: int
    tail: np.ndarray | float
    at: Callable[[np.ndarray], Bounded]
    shaking: Bounded
    couples: tuple[Bounded, ...]
    speeds: np.ndarray
    line: np.ndarray


def loads_over_speed(scene: Scene, first: float, last: float) -> LoadsOverSpeed:
    """What acts on the body of [response] over a range of speeds."""
    forcing: Forcing = scene.handed_on["forcing"]
    law, none = torque_of(scene, "response"), np.zeros(0)
    if law is None:
        few, tail = few_orders(forcing)
        chosen = np.concatenate([np.arange(forcing.retained), few])
        load = forcing.per_speed_squared[chosen]
        return LoadsOverSpeed(
            forcing.order[chosen], forcing.retained, tail,
            lambda speed: load * np.square(speed)[:, None, None], load, (), none, none,
        )  # fmt: skip
    from vibecalc.response.adapters.torque_couple import line_frequencies

    shaking = shaking_at(law.order, forcing.per_speed_squared)
    axis, cards = scene.parts.crank_train.axis, law.speeds
    speeds = np.array([first, *cards[(cards > first) & (cards < last)], last])

    def at(speed: np.ndarray) -> Bounded:
        lacking = couple_about(axis, law.lacking_at(speed))
        return shaking * np.square(speed)[:, None, None] + lacking

    couples = tuple(
        couple_about(axis, law.lacking_at(max(speed, 1e-3 * last))) for speed in speeds.tolist()
    )
    line = none if law.passing is None else line_frequencies(scene, last)
    return LoadsOverSpeed(law.order, law.retained, TAIL, at, shaking, couples, speeds, line)


def steady_motion(
    scene: Scene, system: MountedBody, loads: Bounded, order: np.ndarray
) -> tuple[Bounded, Resonances]:
    """Motion (..., m, f) under loads (..., m, f) at the operating speed, and what orders may meet.

    Raises NumericalFailure where an order drives an undamped mode at its natural frequency.
    """
    speed = scene.case.machine.speed
    resonances = system.checked(order, speed, scene.warn, loads)
    return system.forced(loads, order, speed, resonances), resonances
