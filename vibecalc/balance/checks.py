"""Can these weights change what counts, and is each of them told from the others?"""

import math
from collections.abc import Iterator

import numpy as np

from vibecalc.balance.model import Sought, orders_of_weights, orders_that_count, sought_weights
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.body import DIRECTIONS, build_frame
from vibecalc.schema import Case

BALANCE: KeyPath = ("balance",)
#: m and rad, within which two places or angles are one
_SAME = 1e-9


def balance_problems(case: Case) -> list[Problem]:
    """Problems of orders, places and shafts."""
    if case.balance is None or case.machine.crank_train is None:
        return []
    if case.machine.crank_train.axis == case.machine.crank_train.stroke:
        return []  # reported with the crank train
    return [*_orders(case), *_shafts(case), *_places(case), *_levers(case)]


def _orders(case: Case) -> list[Problem]:
    given = case.balance
    assert given is not None
    turning, counting = orders_of_weights(given), orders_that_count(given)
    words = ", ".join(map(str, turning))
    problems = [
        Problem(
            path=(*BALANCE, "orders"),
            message=f"no weight of [balance] turns at order {order}: nothing can change what is "
            "left of it",
            allowed=f"orders of its weights: {words}",
            hint="weights on the crankshaft and shafts at +-1 act on order 1, those at +-2 on "
            "order 2; higher orders are listed with them",
        )
        for order in counting
        if order not in turning
    ]
    for order in turning:
        if order not in counting:
            where = (
                next(
                    (BALANCE[0], "shafts", i, "speed_ratio")
                    for i, shaft in enumerate(given.shafts)
                    if abs(shaft.speed_ratio) == order
                )
                if order == 2 or not given.counterweights
                else (*BALANCE, "counterweights")
            )
            problems.append(
                Problem(
                    path=where,
                    message=f"weights turn at order {order}, which does not count",
                    allowed=f"orders = {[*counting, order]}, or no such weights",
                    also=(*BALANCE, "orders"),
                )
            )
    kept = None if case.excitation is None else case.excitation.orders
    if kept is not None and kept < turning[-1]:
        problems.append(
            Problem(
                path=("excitation", "orders"),
                message=f"[balance] has weights at order {turning[-1]}, and that order is not kept",
                found=f"orders = {kept}",
                allowed=f">= {turning[-1]}",
                also=BALANCE,
            )
        )
    return problems


def _shafts(case: Case) -> list[Problem]:
    """Where along the crankshaft its weights stand, the weights of a shaft say."""
    assert case.balance is not None
    along = DIRECTIONS.index(case.machine.crank_train.axis)
    return [
        Problem(
            path=(*BALANCE, "shafts", i, "position", along),
            message="the position of a balance shaft is that of its axis, across the crankshaft",
            found=f"{shaft.position[along]:.6g} m along the crankshaft",
            allowed=f"0 along {DIRECTIONS[along]}",
            hint="where its weights stand along the crankshaft, position or between of each says",
        )
        for i, shaft in enumerate(case.balance.shafts)
        if shaft.position[along] != 0.0
    ]


def _places(case: Case) -> list[Problem]:
    """Two weights at one place are one: only their sum counts."""
    assert case.balance is not None
    sought = sought_weights(case.balance, case.machine.crank_train)
    problems = []
    for i, one in enumerate(sought):
        for other in sought[:i]:
            if _same(one, other):
                problems.append(
                    Problem(
                        path=(*BALANCE, *one.path),
                        message=f"{one.name!r} and {other.name!r} stand at one place on shafts of "
                        "one speed, so that only their sum can be told",
                        allowed="different positions, or given phases that differ",
                        also=(*BALANCE, *other.path),
                    )
                )
                break
            if one.name == other.name:
                problems.append(
                    Problem(
                        path=(*BALANCE, *one.path),
                        message=f"two weights of [balance] are named {one.name!r}",
                        hint="a weight of two on a shaft has the name of the shaft with its own, "
                        "or its number",
                        also=(*BALANCE, *other.path),
                    )
                )
                break
    return problems


def _levers(case: Case) -> Iterator[Problem]:
    """Without forces a weight counts by its couple: along the crankshaft, or off its axis."""
    given, train = case.balance, case.machine.crank_train
    assert given is not None
    if given.force_weight:
        return
    axis, origin = build_frame(train.axis, train.stroke).axis, np.array(train.origin)
    sought = sought_weights(given, train)
    for order in orders_of_weights(given):
        counts = False
        for one in sought:
            ends = np.array([one.start, one.end]) + origin
            along = ends @ axis
            aside = np.linalg.norm(ends - along[:, None] * axis, axis=1)
            couples = given.couple_weight * np.abs(along) + given.roll_weight * aside
            counts |= abs(one.speed_ratio) == order and bool(np.any(couples > _SAME))
        if not counts:
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


def _same(one: Sought, other: Sought) -> bool:
    if one.speed_ratio != other.speed_ratio:
        return False
    if np.any(one.start != one.end) or np.any(other.start != other.end):
        return False
    if float(np.max(np.abs(one.start - other.start))) > _SAME:
        return False
    if math.isnan(one.phase) or math.isnan(other.phase):
        return True
    return abs(math.sin(one.phase - other.phase)) <= _SAME
