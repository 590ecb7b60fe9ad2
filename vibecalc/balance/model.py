"""The weights of a case as arrays: names, shafts, where they may stand."""

from itertools import compress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.balance.weights import Places
from vibecalc.parts.body import build_frame
from vibecalc.parts.tables import CrankTrain

if TYPE_CHECKING:
    from vibecalc.balance.tables import Balance


class Sought(NamedTuple):
    """m weights: their names, the keys of their tables below [balance], where each may stand, and
    the radii (m,) of their mass centres in m, nan where not given.
    """

    names: tuple[str, ...]
    paths: tuple[tuple[str | int, ...], ...]
    places: Places
    radius: np.ndarray

    @property
    def axes(self) -> dict[str, tuple[str, ...]]:
        """Names of all, of those with a radius, and of those with a largest unbalance."""
        chosen = {
            "weight": np.ones(len(self.names), dtype=bool),
            "balance_radius": np.isfinite(self.radius),
            "balance_bound": np.isfinite(self.places.largest),
        }
        return {axis: tuple(compress(self.names, those)) for axis, those in chosen.items()}


def sought_weights(balance: "Balance", train: CrankTrain) -> Sought:
    """Weights on the crankshaft, then those of the shafts."""
    axis = build_frame(train.axis, train.stroke_axis).axis
    throws = {cylinder.name: cylinder.position for cylinder in train.cylinders}
    rows: list[tuple[str, tuple[str | int, ...], int, np.ndarray]] = []
    for i, weight in enumerate(balance.counterweights):
        foot = np.zeros(3) if weight.throw is None else throws[weight.throw] * axis
        rows.append((weight.name, ("counterweights", i), 1, foot))
    for i, shaft in enumerate(balance.shafts):
        for k, one in enumerate(shaft.weights):
            name = shaft.name
            name += f", {one.name or k + 1}" if len(shaft.weights) > 1 else ""
            path = ("shafts", i, "weights", k)
            rows.append((name, path, shaft.speed_ratio, np.array(shaft.position)))
    names, paths, ratios, feet = zip(*rows, strict=True)
    weights = balance.weights
    between = np.array([one.between or [one.position or 0.0] * 2 for one in weights])
    start, end = (feet + between[:, [i]] * axis for i in range(2))
    phase, largest, radius = (
        np.array([getattr(one, key) for one in weights], dtype=float)
        for key in ("phase", "largest_unbalance", "radius")
    )
    largest = np.where(np.isnan(largest), np.inf, largest)
    places = Places(np.array(ratios), start, end, phase, largest)
    return Sought(names, paths, places, radius)


def orders_that_count(balance: "Balance") -> tuple[int, ...]:
    """Those of the case, or those at which weights turn, ascending."""
    return tuple(sorted(balance.orders)) if balance.orders else orders_of_weights(balance)


def orders_of_weights(balance: "Balance") -> tuple[int, ...]:
    """Orders at which weights turn, ascending."""
    on_crank = {1} if balance.counterweights else set()
    return tuple(sorted(on_crank | {abs(shaft.speed_ratio) for shaft in balance.shafts}))
