"""The weights of a case as arrays: names, shafts, where they may stand."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.balance.weights import Places
from vibecalc.parts.body import build_frame
from vibecalc.parts.tables import CrankTrain

if TYPE_CHECKING:
    from vibecalc.balance.tables import Balance, Weight


class Sought(NamedTuple):
    """m weights: their names, the keys of their tables below [balance], where each may stand, and
    the radii (m,) of their mass centres in m, nan where not given.
    """

    names: tuple[str, ...]
    paths: tuple[tuple[str | int, ...], ...]
    places: Places
    radius: np.ndarray


def sought_weights(balance: "Balance", train: CrankTrain) -> Sought:
    """Weights on the crankshaft, then those of the shafts."""
    axis = build_frame(train.axis, train.stroke).axis
    throws = {cylinder.name: cylinder.position for cylinder in train.cylinders}
    names, ratios, ends = [], [], []
    paths: list[tuple[str | int, ...]] = []
    weights: list[Weight] = [*balance.counterweights]
    for i, weight in enumerate(balance.counterweights):
        place = throws[weight.throw] if weight.throw is not None else weight.position
        names.append(weight.name)
        paths.append(("counterweights", i))
        ratios.append(1)
        ends.append(_ends(weight, place)[:, None] * axis)
    for i, shaft in enumerate(balance.shafts):
        weights += shaft.weights
        for k, one in enumerate(shaft.weights):
            single = len(shaft.weights) == 1
            names.append(shaft.name if single else f"{shaft.name}, {one.name or k + 1}")
            paths.append(("shafts", i, "weights", k))
            ratios.append(shaft.speed_ratio)
            ends.append(np.array(shaft.position) + _ends(one, one.position)[:, None] * axis)
    phase, largest, radius = (
        np.array([other if one is None else one for one in values])
        for values, other in (
            ([one.phase for one in weights], np.nan),
            ([one.largest_unbalance for one in weights], np.inf),
            ([one.radius for one in weights], np.nan),
        )
    )
    start, end = np.moveaxis(np.array(ends), 1, 0)
    places = Places(np.array(ratios), start, end, phase, largest)
    return Sought(tuple(names), tuple(paths), places, radius)


def _ends(weight: "Weight", place: float | None) -> np.ndarray:
    """From where to where (2,) along the crankshaft a weight may stand."""
    return np.array(weight.between if place is None else (place, place))


def orders_that_count(balance: "Balance") -> tuple[int, ...]:
    """Those of the case, or those at which weights turn, ascending."""
    if balance.orders is not None:
        return tuple(sorted(balance.orders))
    return orders_of_weights(balance)


def orders_of_weights(balance: "Balance") -> tuple[int, ...]:
    """Orders at which weights turn, ascending."""
    on_crank = {1} if balance.counterweights else set()
    return tuple(sorted(on_crank | {abs(shaft.speed_ratio) for shaft in balance.shafts}))
