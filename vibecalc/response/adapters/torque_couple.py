"""Torque of all cylinders of an engine at its speed, and the couple that it is for the body."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_moments, share_of_rotor
from vibecalc.excitation.cylinder_torque import cylinder_torque, inertia_harmonics, phasor
from vibecalc.excitation.gas_tables import card_weights
from vibecalc.excitation.model import firing_angle, gas_of_cylinders
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.parts.firing import is_separate, shakes_with_torque
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.response.stage import orders_of_reaction
from vibecalc.response.torque_reaction import couple_on_body, line_transfer
from vibecalc.schema import Case

Speed: TypeAlias = np.ndarray | float
#: orders (m,) and crank speeds (...) to the couple on the body (..., m, c) for a unit torque
Passing: TypeAlias = Callable[[np.ndarray, Speed], Bounded]


class TorqueLaw(NamedTuple):
    """Torque of the cylinders on the crankshaft, and the couple that it is for the body.

    At the orders (m,), twice as many as `retained`. `gas` (k, c, m) and `mean` (k,) at the `speeds`
    (k,) of the gas cards, linear between them; one for all speeds has none. `inertia` (c, m) per
    speed squared. `share` of the torque turns what is fixed to the crank and, the other way round,
    the body; a shaft line on the body has `passing`. `mean` is what is constant of the couple:
    minus the mean torque, if that leaves the body.
    """

    order: np.ndarray
    retained: int
    speeds: np.ndarray
    gas: Bounded
    mean: Bounded
    inertia: Bounded
    share: float
    passing: Passing | None

    def of_orders(self, part: slice | np.ndarray) -> "TorqueLaw":
        """The law of some of the orders."""
        return self._replace(
            order=self.order[part], gas=self.gas[..., part], inertia=self.inertia[..., part]
        )

    def couple_at(self, speed: np.ndarray | float) -> Bounded:
        """Couple (..., m) about the crankshaft by gas and inertia, at speeds (...)."""
        torque = self._gas_at(speed) + self.inertia * np.square(speed)[..., None, None]
        transfer = None if self.passing is None else self.passing(self.order, speed)
        return couple_on_body(torque, transfer, self.share)

    def lacking_at(self, speed: np.ndarray | float) -> Bounded:
        """What of it the shaking of the crank train does not hold: all that a line passes on."""
        if self.passing is not None:
            return self.couple_at(speed)
        return couple_on_body(self._gas_at(speed), share=self.share)

    def mean_at(self, speed: float) -> Bounded:
        """What is constant of the couple."""
        return _mixed(self.mean, self._weights(speed))

    def _gas_at(self, speed: np.ndarray | float) -> Bounded:
        return _mixed(self.gas, self._weights(speed))

    def _weights(self, speed: np.ndarray | float) -> np.ndarray:
        return card_weights(self.speeds if len(self.speeds) else [0.0], speed)


def torque_law(scene: Scene) -> TorqueLaw:
    """The torque of the cylinders at any speed, with twice the orders that are kept.

    Evenly spaced cylinders leave every c-th order only, of which at least two are beyond.
    """
    case, train = scene.case, scene.parts.crank_train
    kept, rotor, share = orders_of_reaction(case), case.machine.rotor, 1.0
    beyond = max(kept.number, 2 * len(train.names))
    order = kept.lowest * np.arange(1, kept.number + beyond + 1)
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
        order, kept.number, speeds, gas * turned, mean * (-1.0 if is_separate(case) else 0.0),
        inertia * turned, share, None if shakes_with_torque(case) else line_passing(scene),
    )  # fmt: skip


def _mixed(cards: Bounded, weights: np.ndarray) -> Bounded:
    """Values (k, ...) of cards in the shares `weights` (..., k)."""
    value = np.tensordot(weights, cards.value, axes=(-1, 0))
    size = cards.error + 2.0 * EPSILON * np.abs(cards.value)
    return Bounded(value, np.tensordot(weights, size, axes=(-1, 0)))


def _gas(case: Case, geometry: CrankGeometry, count: int) -> tuple[np.ndarray, Bounded, Bounded]:
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


def line_frequencies(scene: Scene, speed: float) -> np.ndarray:
    """Natural frequencies of the shaft line above zero, rad/s, where its torque has resonances."""
    from vibecalc.torsion.model import build_shaft_line
    from vibecalc.torsion.modes import natural_modes

    frequency = natural_modes(build_shaft_line(scene.case).at(speed)).frequency
    return frequency[frequency > 0.0]
