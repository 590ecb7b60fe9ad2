"""A system to march by the batch Runge-Kutta pair: smooth, or with kinks at values."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome


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
        self.closeness = np.full(len(values), closeness)

    def rates(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        return self._rates(time, state, interval)

    def watched(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        if self._combination is None:
            return np.empty((len(state), 0))
        return np.asarray(state @ self._combination.T)

    def borders(self, member: IntArray, interval: IntArray) -> tuple[FloatArray, FloatArray]:
        ends = np.empty((2, len(member), len(self._edges)))
        for k, edge in enumerate(self._edges):
            ends[:, :, k] = edge[interval[:, k]], edge[interval[:, k] + 1]
        return ends[0], ends[1]

    def crossed(
        self,
        member: IntArray,
        time: FloatArray,
        state: FloatArray,
        interval: IntArray,
        which: IntArray,
        direction: IntArray,
    ) -> EventOutcome:
        moved = interval.copy()
        moved[np.arange(len(member)), which] += direction
        return EventOutcome(state, moved, np.zeros(len(member), dtype=bool))

    def stopped(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> EventOutcome:
        return EventOutcome(state, interval, np.zeros(len(member), dtype=bool))

    def intervals_at(self, state: FloatArray) -> IntArray:
        """The intervals (b, w) of the states; a value on a border belongs to the one above it."""
        value = self.watched(np.arange(len(state)), np.zeros(1), state, np.zeros((1, 0), int))
        columns = [
            np.searchsorted(edge[1:-1], value[:, k], side="right")
            for k, edge in enumerate(self._edges)
        ]
        return np.stack(columns, axis=1).astype(np.int64)
