"""The weights of a case as arrays: names, shafts, where they may stand."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.parts.body import build_frame
from vibecalc.parts.tables import CrankTrain

if TYPE_CHECKING:
    from vibecalc.balance.tables import Balance, Weight


class Sought(NamedTuple):
    """One weight: its name, speed ratio, the ends (3,) of where it may stand from the train's
    origin in m, its phase in rad (nan: free), largest unbalance in kg m (inf: none), its radius in
    m (nan: not given), and the keys of its table below [balance].
    """

    name: str
    speed_ratio: int
    start: np.ndarray
    end: np.ndarray
    phase: float
    largest: float
    radius: float
    path: tuple[str | int, ...]


def sought_weights(balance: "Balance", train: CrankTrain) -> list[Sought]:
    """Weights on the crankshaft, then those of the shafts."""
    axis = build_frame(train.axis, train.stroke).axis
    throws = {cylinder.name: cylinder.position for cylinder in train.cylinders}
    found = []
    for i, weight in enumerate(balance.counterweights):
        place = throws[weight.throw] if weight.throw is not None else weight.position
        keys = ("counterweights", i)
        found.append(_sought(weight.name, weight, 1, place, axis, np.zeros(3), keys))
    for i, shaft in enumerate(balance.shafts):
        for k, one in enumerate(shaft.weights):
            name = shaft.name if len(shaft.weights) == 1 else f"{shaft.name}, {one.name or k + 1}"
            path = ("shafts", i, "weights", k)
            centre = np.array(shaft.position)
            found.append(_sought(name, one, shaft.speed_ratio, one.position, axis, centre, path))
    return found


def _sought(
    name: str,
    weight: "Weight",
    ratio: int,
    place: float | None,
    axis: np.ndarray,
    centre: np.ndarray,
    path: tuple[str | int, ...],
) -> Sought:
    ends = (place, place) if place is not None else weight.between
    assert ends is not None
    return Sought(
        name=name,
        speed_ratio=ratio,
        start=centre + ends[0] * axis,
        end=centre + ends[1] * axis,
        phase=math.nan if weight.phase is None else weight.phase,
        largest=math.inf if weight.largest_unbalance is None else weight.largest_unbalance,
        radius=math.nan if weight.radius is None else weight.radius,
        path=path,
    )


def orders_that_count(balance: "Balance") -> tuple[int, ...]:
    """Those of the case, or those at which weights turn, ascending."""
    if balance.orders is not None:
        return tuple(sorted(balance.orders))
    return orders_of_weights(balance)


def orders_of_weights(balance: "Balance") -> tuple[int, ...]:
    """Orders at which weights turn, ascending."""
    on_crank = {1} if balance.counterweights else set()
    return tuple(sorted(on_crank | {abs(shaft.speed_ratio) for shaft in balance.shafts}))
