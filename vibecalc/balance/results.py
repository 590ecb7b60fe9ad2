"""Results of the weights sought for the least force and couple."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, q
from vibecalc.core.results.record import CHECK, PEAK, SEARCHED, TURN, Headline


class WeightsFound(Group):
    """Size and place of each weight."""

    ROOT: ClassVar[str] = "balance/weight"
    unbalance: Any = q(
        "weight", "kg*m", "mass times radius of a weight",
        headline=Headline(
            "balance weight", "g*mm", pick="each", words="vibecalc.balance.report:angle_of"
        ),
    )  # fmt: skip
    phase: Any = q(
        "weight", "rad", "angle by which it leads the stroke at crank angle zero", circle=TURN
    )
    position: Any = q(
        "weight direction", "m", "of a weight, from the train's origin", exempt=SEARCHED
    )
    speed_ratio: Any = q("weight", "", "of its shaft over the crank speed")
    mass: Any = q("balance_radius", "kg", "of a weight at its radius")
    utilisation: Any = q("balance_bound", "", "unbalance over the largest of the weight")


class Shaking(Group):
    """What acts by order, and of all orders together."""

    force: Any = q("order", "N", "largest force over a turn, {how}", PEAK)
    couple: Any = q("order", "N*m", "largest couple across the crankshaft over a turn, {how}", PEAK)
    roll_couple: Any = q("order", "N*m", "couple about the crankshaft, {how}", PEAK)
    residual: Any = q("order", "N", "residual unbalance of the order, {how}", PEAK)
    all_orders: Any = lead("", "N", "residual unbalance, {how}")
    force_peak: Any = lead("", "N", "shaking force, {how}", PEAK, about="all orders, peak")
    couple_peak: Any = lead("", "N*m", "shaking couple, {how}", PEAK, about="all orders, peak")


class Before(Shaking):
    """As the machine is."""

    ROOT = "balance/before"
    WORDS: ClassVar = {"how": "without the weights"}


class After(Shaking):
    """As the weights leave it."""

    ROOT = "balance/after"
    WORDS: ClassVar = {"how": "with the weights"}


class Left(Group):
    """What the weights leave, and whether others could leave less."""

    ROOT: ClassVar[str] = "balance"
    force: Any = q("order direction", "N", "remaining force with the weights", PEAK)
    couple: Any = q("order direction", "N*m", "remaining couple with the weights", PEAK)
    residual_before: Any = q(
        "", "N", "residual unbalance of the orders that count, without the weights", PEAK
    )
    residual: Any = q(
        "", "N", "residual unbalance of the orders that count, with the weights", PEAK
    )
    gap: Any = q("", "N", "residual unbalance above its proven lower bound", exempt=CHECK)
    free_directions: Any = q(
        "balanced_order", "", "unknowns of the weights that do not change the residual"
    )


AXES = {
    "weight": ("", "weight on the crankshaft or on a balance shaft"),
    "balance_radius": ("", "weight of which the radius is given"),
    "balance_bound": ("", "weight of which the largest unbalance is given"),
    "balanced_order": ("", "order at which weights turn"),
}
ENTRIES = tuple(entries_of(WeightsFound, Before, After, Left))
