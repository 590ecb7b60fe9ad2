"""Speeds of a run-up that were looked at, so that none is computed twice."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.typing import FloatArray

#: arrays (speeds, ...) at speeds (speeds,)
Looks = Callable[[FloatArray], tuple[FloatArray, ...]]


class Looked:
    """A function of the speed that remembers what it gave at each of them.

    `add` gives it what is known from elsewhere.
    """

    def __init__(self, look: Looks) -> None:
        self._look = look
        self._speed = np.zeros(0)
        self._values: tuple[FloatArray, ...] = ()

    @property
    def speed(self) -> FloatArray:
        """The speeds looked at, ascending."""
        return self._speed

    def add(self, speed: FloatArray, *values: FloatArray) -> None:
        """Values (speeds, ...) at speeds (speeds,); of doubles the first counts."""
        if len(self._speed):
            speed = np.concatenate([self._speed, speed])
            values = tuple(map(np.concatenate, zip(self._values, values, strict=True)))
        order = np.argsort(speed, kind="stable")
        ascending = speed[order]
        order = order[np.concatenate([[True], np.diff(ascending) > 0.0])]
        self._speed, self._values = speed[order], tuple(one[order] for one in values)

    def __call__(self, speed: FloatArray) -> tuple[FloatArray, ...]:
        """Values at ascending speeds without doubles, from memory where they are there."""
        place = np.searchsorted(self._speed, speed)
        if len(self._speed):
            known = self._speed[np.minimum(place, len(self._speed) - 1)] == speed
        else:
            known = np.zeros(len(speed), dtype=bool)
        if not np.all(known):
            self.add(speed[~known], *self._look(speed[~known]))
            place = np.searchsorted(self._speed, speed)
        return tuple(one[place] for one in self._values)
