"""Both ends of a curve over all angles of a balance weight, by grids."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import Answer
from vibecalc.accuracy.yardsticks.grids import Highest, cyclic_parabola_maximum, grid_maximum
from vibecalc.response.accuracy.combinations import Combination

TURN = 2.0 * np.pi

#: energies (k,) at angles (k,) of the weight
Curve = Callable[[np.ndarray], np.ndarray]


def words_of(one: Combination, kind: str) -> str:
    """What is asked of the "mean" or "peak" energy."""
    return (
        f"lowest and highest {kind} kinetic energy of operation {one.operation!r} with balance "
        f"{one.balance!r} over all angles of the weight"
    )


def whole_turn(curve: Curve, points: int) -> Highest:
    """The highest of `points` angles of one turn."""
    return grid_maximum(curve, 0.0, TURN * (points - 1) / points, points)


def with_parabola(curve: Curve, points: int) -> Highest:
    """The same with a parabola through the best and its neighbours."""
    return cyclic_parabola_maximum(curve, TURN, points)


def both_ends(curve: Curve, points: float, search: Callable[[Curve, int], Highest]) -> Answer:
    """Lowest and highest value as `search` finds them on the same `points`."""
    high = search(curve, int(points))
    low = search(lambda phase: -curve(phase), int(points))
    return Answer(np.array([-low.value, high.value]), points)
