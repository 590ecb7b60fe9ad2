"""A system to march by the Runge-Kutta pair: smooth, or with kinks at values."""

from collections.abc import Callable, Sequence

import numpy as np

from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome, Interval, State


class System:
    """Rates with kinks where linear combinations of the states pass given values.

    `rates(time (b,), state (b, n), interval (b, w)) -> (b, n)`, smooth for a fixed interval: number
    i of combination k means values[k][i - 1] <= combination[k] @ state <= values[k][i].
    `combination` (w, n); `values` w ascending arrays. Without any it is smooth.
    """

    def __init__(
        self,
        rates: Callable[[FloatArray, FloatArray, IntArray], FloatArray],
        combination: FloatArray | None = None,
        values: tuple[FloatArray, ...] = (),
        closeness: float = 0.0,
    ):
        self._rates = rates
        self._combination = combination
        self._edges = [np.concatenate([[-np.inf], row, [np.inf]]) for row in values]
        self.closeness = [closeness] * len(values)
        self.leading = 0 if combination is None else combination.shape[1]

    def rates(self, time: float, state: State, interval: Interval) -> State:
        pieces = np.array([interval], dtype=np.int64)
        found: State = self._rates(np.array([time]), np.array([state]), pieces)[0].tolist()
        return found

    def watched(self, time: float, state: Sequence[float], interval: Interval) -> list[float]:
        if self._combination is None:
            return []
        found: list[float] = (self._combination @ np.array(state)).tolist()
        return found

    def borders(self, interval: Interval) -> tuple[list[float], list[float]]:
        both = list(zip(self._edges, interval, strict=False))
        return [float(e[k]) for e, k in both], [float(e[k + 1]) for e, k in both]

    def crossed(
        self,
        member: int,
        time: float,
        state: State,
        interval: Interval,
        which: int,
        direction: int,
    ) -> EventOutcome:
        moved = [k + direction * (place == which) for place, k in enumerate(interval)]
        return EventOutcome(state, moved, False)

    def stopped(self, member: int, time: float, state: State, interval: Interval) -> EventOutcome:
        return EventOutcome(state, interval, False)

    def intervals_at(self, state: FloatArray) -> IntArray:
        """The intervals (b, w) of the states; a value on a border belongs to the one above it."""
        value = np.array([self.watched(0.0, row.tolist(), []) for row in state])
        columns = [
            np.searchsorted(edge[1:-1], value[:, k], side="right")
            for k, edge in enumerate(self._edges)
        ]
        return np.stack(columns, axis=1).astype(np.int64)
