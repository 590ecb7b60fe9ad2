"""Explicit one-step methods of fixed step, as their tables."""

from typing import NamedTuple


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
        5,
        (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
        (
            (),
            (1 / 5,),
            (3 / 40, 9 / 40),
            (44 / 45, -56 / 15, 32 / 9),
            (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
            (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        ),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    ),
}
