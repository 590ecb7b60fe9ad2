"""Torque of all cylinders of an engine at its speed, and the couple that it is for the body."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_moments, share_of_rotor
from vibecalc.excitation.cylinder_torque import cylinder_torque, inertia_harmonics, phasor
from vibecalc.excitation.gas_tables import card_weights
from vibecalc.excitation.model import firing_angle, gas_of_cylinders
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.stage import orders_of_reaction
from vibecalc.isolation.torque_reaction import (
    Part,
    couple_by_differences,
    couple_on_body,
    line_transfer,
    linear_couple,
)
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.parts.firing import is_separate, shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.parts.geometry import CrankGeometry
    from vibecalc.schema import Case

Speed: TypeAlias = np.ndarray | float
#: orders (m,) and crank speeds (...) to the couple on the body (..., m, c) for a unit torque
Passing: TypeAlias = Callable[[np.ndarray, Speed], Bounded]


@dataclass(frozen=True, eq=False, kw_only=True)
class TorqueLaw:
    """Torque of the cylinders on the crankshaft against its speed, at the orders (m,).

    `gas` (k, c, m) and `mean` (k,) at the `speeds` (k,) of the gas cards, linear between them; one
    for all speeds has none. `inertia` (c, m) per speed squared. Twice as many orders as `retained`.

    The couples on the body about the crankshaft (..., m) at speeds (...) follow by a shaft line,
    which is `passing` it on, or else as minus a `share` of the torque: that which turns what is
    fixed to the crank and, the other way round, the body. `stays`: the body gives the mean back.
    """

    order: np.ndarray
    retained: int
    speeds: np.ndarray
    gas: Bounded
    mean: Bounded
    inertia: Bounded
    share: float
    passing: Passing | None
    stays: bool

    def total(self, speed: Speed, part: Part = slice(None)) -> Bounded:
        """Couple of gas and inertia at some of the orders."""
        torque = self._at(self.gas, speed) + self.inertia * np.square(speed)[..., None, None]
        by_line = None if self.passing is None else self.passing(self.order[part], speed)
        return couple_on_body(torque[..., part], by_line, self.share)

    def added(self, speed: Speed, part: Part = slice(None)) -> Bounded:
        """What the shaking of the crank train lacks of it: what a line passes on, or the gas."""
        if self.passing is not None:
            return self.total(speed, part)
        return couple_on_body(self._at(self.gas, speed)[..., part], share=self.share)

    def added_between(self, low: float, high: float, part: Part) -> HarmonicsAt:
        """The same over the speeds between two gas cards."""
        by_speed = partial(self.added, part=part)
        law = linear_couple if self.passing is None else couple_by_differences
        return law(by_speed, low, high)

    def mean_couple(self, speed: float) -> Bounded:
        """What is constant of the couple: minus the mean torque, if that leaves the body."""
        if self.stays:
            return Bounded(np.zeros(()), np.zeros(()))
        return -self._at(self.mean, speed)

    def _at(self, cards: Bounded, speed: Speed) -> Bounded:
        """Values (k, ...) of the cards at speeds (...)."""
        weights = card_weights(self.speeds if len(self.speeds) else [0.0], speed)
        value = np.tensordot(weights, cards.value, axes=(-1, 0))
        size = cards.error + 2.0 * EPSILON * np.abs(cards.value)
        return Bounded(value, np.tensordot(weights, size, axes=(-1, 0)))


def torque_law(scene: Scene, shaking_orders: int) -> TorqueLaw:
    """The torque of the cylinders, with all orders up to `shaking_orders` or more in steps of the
    engine's cycle, and as many again.

    Evenly spaced cylinders leave every c-th order only, of which at least two are beyond.
    """
    case = scene.case
    kept, train = orders_of_reaction(case, shaking_orders), scene.parts.crank_train
    beyond = max(kept.number, 2 * len(train.names))
    order = kept.lowest * np.arange(1, kept.number + beyond + 1)
    rotor, share = case.machine.rotor, 1.0
    moments = rod_moments(train, case.machine.crank_train.rod)
    if rotor is not None:
        motion = scene.handed_on["motion"]
        share = float(share_of_rotor(train, motion, rotor.inertia, moments))
    geometry = crank_geometry(case.machine.crank_train)
    speeds, gas, mean = _gas(case, geometry, len(order))
    # the shaking of the masses counts from crank phase zero
    turned = rounded(phasor(order, firing_angle(case.machine)).T, 12)
    inertia = train.reciprocating_mass[:, None] * inertia_harmonics(geometry, 1.0, 0.0, order)
    if moments is not None:
        inertia = inertia + moments[:, None] * inertia_harmonics(geometry, 0.0, 1.0, order)
    return TorqueLaw(
        order=order, retained=kept.number, speeds=speeds, gas=gas * turned, mean=mean,
        inertia=inertia * turned, share=share, stays=not is_separate(case),
        passing=None if shakes_with_torque(case) else line_passing(scene),
    )  # fmt: skip


def _gas(
    case: "Case", geometry: "CrankGeometry", count: int
) -> tuple[np.ndarray, Bounded, Bounded]:
    """Speeds of the cards, gas torque of every cylinder and mean of all at each, as `TorqueLaw`."""
    speeds, groups = gas_of_cylinders(case)
    names, unit = case.machine.crank_train.cylinders, 2.0 / np.sqrt(np.pi)  # bore of 1 m^2
    none = np.zeros((max(len(speeds), 1), len(names), count))
    gas, mean = Bounded(none, none), Bounded(none[..., 0].sum(-1), np.zeros(()))
    for cards, area in groups:
        one = cylinder_torque(
            cards, geometry._replace(bore=unit), reciprocating_mass=0.0, harmonics=count
        )
        gas = gas + one.gas[:, None] * rounded(area, 8)[:, None]
        mean = mean + (one.mean[:, None] * rounded(area, 8)).sum()
    return speeds, gas, mean


def line_passing(scene: Scene) -> Passing:
    """Couple on the body (..., m, c) for a unit torque of each cylinder, by the shaft line.

    A function of the orders (m,) and of the crank speeds (...).
    """
    from vibecalc.torsion.model import build_shaft_line, spin_inertia

    built = build_shaft_line(scene.case)
    spin = spin_inertia(scene.case, built)
    cylinders = built.cylinder_freedom
    ratio = built.station_ratio[built.cylinder_station]

    def passing(order: np.ndarray, speed: Speed) -> Bounded:
        crank = np.asarray(speed, dtype=float)[..., None]
        return line_transfer(built.at(crank), spin, order * crank)[..., cylinders] * ratio

    return passing
