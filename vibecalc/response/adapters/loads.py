"""All that acts on a body, at the operating speed and at any other, and its steady motion."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.firing import with_torque
from vibecalc.response.system import MountedBody
from vibecalc.response.torque_reaction import SLOWEST, TAIL

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
    """All that acts on a body over a range of crank speeds, at the orders (m,).

    `shaking` (m, 6) is per speed squared; the torque of the cylinders, if it acts, follows a `law`
    about the `axis` (3,) of the crankshaft, which has kinks at some of the `speeds` (k,): both ends
    of the range, and those of gas cards between them. `line` (...) are natural frequencies in rad/s
    of a shaft line that passes the torque on. `retained` and `tail` as of `BodyLoads`.
    """

    order: np.ndarray
    retained: int
    tail: np.ndarray | float
    shaking: Bounded
    axis: np.ndarray
    law: "TorqueLaw | None"
    speeds: np.ndarray
    line: np.ndarray

    def at(self, speed: np.ndarray) -> Bounded:
        """Loads (s, m, 6) at speeds (s,) in rad/s."""
        square: np.ndarray = np.square(speed)[:, None, None]
        load = self.shaking * square
        return load if self.law is None else load + self._lacking(speed)

    def some(self, part: slice = slice(None)) -> list[Bounded]:
        """Loads (..., 6) of some of the orders, of which all between the speeds are made."""
        alone = self.shaking[part]
        at_speeds = () if self.law is None else self.speeds
        return [alone, *(self._lacking(max(speed, SLOWEST))[part] for speed in at_speeds)]

    def _lacking(self, speed: np.ndarray | float) -> Bounded:
        assert self.law is not None
        return couple_about(self.axis, self.law.lacking_at(speed))


def loads_over_speed(scene: Scene, table: str, first: float, last: float) -> LoadsOverSpeed:
    """What acts on the body of a table, [isolation] or [response], over a range of speeds."""
    forcing: Forcing = scene.handed_on["forcing"]
    law, axis = torque_of(scene, table), scene.parts.crank_train.axis
    ends, none = np.array([first, last]), np.zeros(0)
    if law is None:
        few, tail = few_orders(forcing)
        chosen = np.concatenate([np.arange(forcing.retained), few])
        shaking, order = forcing.per_speed_squared[chosen], forcing.order[chosen]
        return LoadsOverSpeed(order, forcing.retained, tail, shaking, axis, None, ends, none)
    from vibecalc.response.adapters.torque_couple import line_frequencies

    shaking = shaking_at(law.order, forcing.per_speed_squared)
    within = law.speeds[(law.speeds > first) & (law.speeds < last)]
    speeds = np.insert(ends, 1, within)
    line = none if law.passing is None else line_frequencies(scene, last)
    return LoadsOverSpeed(law.order, law.retained, TAIL, shaking, axis, law, speeds, line)


def steady_motion(
    scene: Scene, system: MountedBody, loads: Bounded, order: np.ndarray, by_modes: bool = False
) -> Bounded:
    """Motion (..., m, f) under loads (..., m, f) at the operating speed.

    Raises NumericalFailure where an order drives an undamped mode at its natural frequency.
    """
    speed = scene.case.machine.speed
    resonances = system.checked(order, speed, scene.warn, loads)
    solve = system.summed_up if by_modes else system.forced
    return solve(loads, order, speed, resonances)
