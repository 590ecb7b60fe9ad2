"""Can these weights change what counts, and is each of them told from the others?"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from vibecalc.balance.model import Sought, orders_of_weights, orders_that_count, sought_weights
from vibecalc.balance.tables import Balance
from vibecalc.balance.weights import Places
from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.parts.body import DIRECTIONS, build_frame
from vibecalc.parts.tables import CrankTrain
from vibecalc.schema import Case

BALANCE: KeyPath = ("balance",)
#: m and rad, within which two places or angles are one
_SAME = 1e-9


@listing
def balance_problems(case: Case) -> Iterator[Problem]:
    """Problems of orders, places and shafts."""
    given, train = case.balance, case.machine.crank_train
    if given is None or train is None or train.axis == train.stroke_axis:  # reported with the train
        return
    sought = sought_weights(given, train)
    yield from _orders(case, given, sought)
    yield from _shafts(train, given)
    yield from _places(sought)
    yield from _levers(train, given, sought.places)


def _orders(case: Case, given: Balance, sought: Sought) -> Iterator[Problem]:
    turning, counting = orders_of_weights(given), orders_that_count(given)
    for order in sorted({*counting} - {*turning}):
        yield Problem(
            path=(*BALANCE, "orders"),
            message=f"no weight of [balance] turns at order {order}: it cannot be balanced",
            allowed=f"orders of its weights: {', '.join(map(str, turning))}",
            hint="weights on the crankshaft and shafts at +-1 act on order 1, those at +-2 on "
            "order 2; higher orders are listed with them",
        )
    for order in sorted({*turning} - {*counting}):
        first = int(np.flatnonzero(np.abs(sought.places.speed_ratio) == order)[0])
        yield Problem(
            path=(*BALANCE, *sought.paths[first]),
            message=f"weights turn at order {order}, which does not count",
            allowed=f"orders = {[*counting, order]}, or no such weights",
            also=(*BALANCE, "orders"),
        )
    kept = None if case.excitation is None else case.excitation.orders
    if kept is not None and kept < turning[-1]:
        yield Problem(
            path=("excitation", "orders"),
            message=f"[balance] has weights at order {turning[-1]}, and that order is not kept",
            found=f"orders = {kept}",
            allowed=f">= {turning[-1]}",
            also=BALANCE,
        )


def _shafts(train: CrankTrain, given: Balance) -> Iterator[Problem]:
    """Where along the crankshaft its weights stand, the weights of a shaft say."""
    along = DIRECTIONS.index(train.axis)
    for i, shaft in enumerate(given.shafts):
        if shaft.position[along] != 0.0:
            yield Problem(
                path=(*BALANCE, "shafts", i, "position", along),
                message="the position of a balance shaft is that of its axis, across the "
                "crankshaft",
                found=f"{shaft.position[along]:.6g} m along the crankshaft",
                allowed=f"0 along {DIRECTIONS[along]}",
                hint="where its weights stand along the crankshaft, position or between of each "
                "says",
            )


def _places(sought: Sought) -> Iterator[Problem]:
    """Two weights at one place are one: only their sum counts."""
    names, (ratio, start, end, phase, _) = sought.names, sought.places
    given = np.all(start == end, axis=1)
    near = np.abs(start[:, None] - start).max(axis=-1) <= _SAME
    apart = np.abs(np.sin(phase[:, None] - phase)) > _SAME  # not where a phase is free
    same = given & given[:, None] & (ratio == ratio[:, None]) & near & ~apart
    for k, i in combinations(range(len(names)), 2):
        path, also = ((*BALANCE, *sought.paths[place]) for place in (i, k))
        if same[i, k] and not np.any(same[i, :k]):
            yield Problem(
                path=path,
                message=f"{names[i]!r} and {names[k]!r} are at the same place on shafts of the "
                "same speed: only their sum is determined",
                allowed="different positions, or given phases that differ",
                also=also,
            )
        elif names[i] == names[k]:
            yield Problem(
                path=path,
                message=f"two weights of [balance] are named {names[i]!r}",
                hint="a weight on a shaft has the name of the shaft; of two each has its own with "
                "it, or its number",
                also=also,
            )


def _levers(train: CrankTrain, given: Balance, places: Places) -> Iterator[Problem]:
    """Without forces a weight counts by its couple: along the crankshaft, or off its axis."""
    if given.force_weight:
        return
    axis = build_frame(train.axis, train.stroke_axis).axis
    ends = np.stack([places.start, places.end]) + np.array(train.origin)
    along = ends @ axis
    aside = np.linalg.norm(ends - along[..., None] * axis, axis=-1)
    couples = given.couple_weight * np.abs(along) + given.roll_weight * aside
    acting = np.abs(places.speed_ratio)[np.any(couples > _SAME, axis=0)]
    for order in orders_of_weights(given):
        if order not in acting:
            yield Problem(
                path=(*BALANCE, "force_weight"),
                message=f"forces do not count, and where the weights of order {order} stand they "
                "have no couple that does",
                found=f"force_weight = 0, couple_weight = {given.couple_weight:.6g}, roll_weight = "
                f"{given.roll_weight:.6g}",
                allowed="force_weight above zero, or weights away from the body's reference point "
                "along the crankshaft",
                hint="couples count about that point; origin of [machine.crank_train] is the place "
                "of the train from there",
            )
