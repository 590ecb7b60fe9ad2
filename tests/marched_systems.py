"""Systems to march by the batch Runge-Kutta pair: smooth ones, and ones with kinks at values."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome


class SmoothSystem:
    """A smooth system: `rates(time (b,), state (b, n)) -> (b, n)`; nothing is watched."""

    def __init__(self, rates: Callable[[FloatArray, FloatArray], FloatArray]):
        self.closeness = np.empty(0)
        self._rates = rates

    def rates(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        return self._rates(time, state)

    def watched(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        return np.empty((len(member), 0))

    def borders(self, member: IntArray, interval: IntArray) -> tuple[FloatArray, FloatArray]:
        return np.empty((len(member), 0)), np.empty((len(member), 0))

    def crossed(
        self,
        member: IntArray,
        time: FloatArray,
        state: FloatArray,
        interval: IntArray,
        which: IntArray,
        direction: IntArray,
    ) -> EventOutcome:
        return EventOutcome(state, interval, np.zeros(len(member), dtype=bool))

    def stopped(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> EventOutcome:
        return EventOutcome(state, interval, np.zeros(len(member), dtype=bool))


class Tables(SmoothSystem):
    """Rates with kinks where linear combinations of the states pass given values.

    `rates(time (b,), state (b, n), interval (b, w)) -> (b, n)`, smooth for a fixed one: number i of
    combination k means values[k][i - 1] <= combination[k] @ state <= values[k][i].
    `combination` (w, n); `values` w ascending arrays.
    """

    def __init__(
        self,
        rates: Callable[[FloatArray, FloatArray, IntArray], FloatArray],
        combination: FloatArray,
        values: list[FloatArray],
        closeness: float,
    ):
        self._kinked = rates
        self._combination = combination
        self._edges = [np.concatenate([[-np.inf], row, [np.inf]]) for row in values]
        self.closeness = np.full(len(values), closeness)

    def rates(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        return self._kinked(time, state, interval)

    def watched(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        return np.asarray(state @ self._combination.T)

    def borders(self, member: IntArray, interval: IntArray) -> tuple[FloatArray, FloatArray]:
        below = [edge[interval[:, k]] for k, edge in enumerate(self._edges)]
        above = [edge[interval[:, k] + 1] for k, edge in enumerate(self._edges)]
        return np.stack(below, axis=1), np.stack(above, axis=1)

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

    def intervals_at(self, state: FloatArray) -> IntArray:
        """The intervals (b, w) of the states; a value on a border belongs to the one above it."""
        value = state @ self._combination.T
        columns = [
            np.searchsorted(edge[1:-1], value[:, k], side="right")
            for k, edge in enumerate(self._edges)
        ]
        return np.stack(columns, axis=1).astype(np.int64)
