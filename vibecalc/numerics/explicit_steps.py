"""Explicit one-step methods of fixed step: Euler, Heun, Runge and Kutta, Dormand and Prince."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from vibecalc.numerics.runge_kutta import STAGES


class Tableau(NamedTuple):
    """Stage k is taken at `fraction[k]` of the step from the earlier ones by `stage[k]`."""

    order: int
    fraction: tuple[float, ...]
    stage: tuple[tuple[float, ...], ...]
    weight: tuple[float, ...]


#: Euler; Heun (1900); Runge and Kutta (1901); Dormand and Prince (1980), the solution of order 5
METHODS = {
    "euler": Tableau(1, (0.0,), ((),), (1.0,)),
    "heun": Tableau(2, (0.0, 1.0), ((), (1.0,)), (0.5, 0.5)),
    "rk4": Tableau(
        4,
        (0.0, 0.5, 0.5, 1.0),
        ((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
        (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    ),
    "dormand_prince": Tableau(
        5, (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0), ((), *STAGES[:5]), STAGES[5]
    ),
}


def explicit_step(
    method: Tableau,
    rates: Callable[[int, list[Any]], Sequence[Any]],
    state: Sequence[Any],
    length: float,
    first: Sequence[Any] | None = None,
) -> list[Any]:
    """The components of a state, numbers or arrays, after a step of `length`.

    `rates` gives those at a stage and its state; `first` are the ones at the begin, if known.
    """
    slopes = [rates(0, list(state)) if first is None else first]
    for stage, weights in enumerate(method.stage[1:], 1):
        slopes.append(rates(stage, _moved(state, length, weights, slopes)))
    return _moved(state, length, method.weight, slopes)


def _moved(
    state: Sequence[Any], length: float, weights: Sequence[float], slopes: list[Sequence[Any]]
) -> list[Any]:
    moved = list(state)
    for weight, slope in zip(weights, slopes, strict=True):
        moved = [y + length * weight * rate for y, rate in zip(moved, slope, strict=True)]
    return moved
