"""The stage of the weights sought for the least force and couple."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Entries, Stage, Subject, Unit, Work, below
from vibecalc.kinematics.stage import orders_given, orders_of_motion, orders_words

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_balance(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [balance]; the checks have seen to the rest."""
    balance = case.balance
    if balance is None:
        return
    weights, on_crank = balance.weights, len(balance.counterweights)
    absent = tuple(
        f"weight/{name}"
        for name, key in (("mass", "radius"), ("utilisation", "largest_unbalance"))
        if all(getattr(one, key) is None for one in weights)
    )
    yield Stage(
        name="balance",
        adapter="vibecalc.balance.adapter:run_balance",
        why="[balance] is in the case",
        parts=("crank_train",),
        orders=orders_words(case),
        cost=f"least squares within bounds: {on_crank} weights on the crank, "
        f"{len(weights) - on_crank} on shafts",
        quantities=below("balance/", absent),
        is_last=True,
        harmonics=orders_of_motion,
        work=_work,
    )


def _work(case: "Case", orders: int) -> Work:
    weights = case.balance.weights if case.balance is not None else []
    places = sum(one.between is not None for one in weights)
    return ((len(weights), "sought_weight"), (places, "free_place"))


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    if axis == "balanced_order" and case.balance is not None:
        from vibecalc.balance.model import orders_that_count

        return Entries(orders_that_count(case.balance), "orders at which weights of [balance] turn")
    return orders_given(case, axis)


def _names(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    if case.balance is None:
        return {}
    from vibecalc.balance.model import sought_weights

    return sought_weights(case.balance, case.machine.crank_train).axes


SUBJECT = Subject(
    stages=(plan_balance,),
    concerns=lambda case: case.balance is not None,
    units={
        "sought_weight": Unit(1.0e-3, "weights sought"),
        "free_place": Unit(0.3, "free positions of weights", library="scipy.optimize"),
    },
    entries=_entries,
    names=_names,
    checks=("vibecalc.balance.checks:balance_problems",),
    sections=("vibecalc.balance.report:balance",),
    leads=True,
    pictures={
        "balance_orders": "vibecalc.balance.pictures:BALANCE_ORDERS",
        "balance_weights": "vibecalc.balance.pictures:draw_weights",
    },
    assumes=("Weights are points on rigid throws; the shaft does not bend.",),
)
