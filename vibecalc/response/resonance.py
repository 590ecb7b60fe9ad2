"""Where an order may meet a natural frequency, and how close it may come."""

from typing import NamedTuple

import numpy as np

_NONE = np.zeros(0)


class Resonances(NamedTuple):
    """Natural frequencies with what decides whether an order may stand on them.

    `frequency`, `damping_ratio` (modes,): rad/s and 1. `half_width` (modes,): relative distance
    from the frequency within which fewer than four digits of an undamped response remain.
    `idle` (orders, modes): the order does not drive the mode, its modal force is zero to rounding.
    `moved_frequency`, `moved_ratio` (any,): resonances that strong damping puts elsewhere.
    """

    frequency: np.ndarray
    damping_ratio: np.ndarray
    half_width: np.ndarray
    idle: np.ndarray
    moved_frequency: np.ndarray = _NONE
    moved_ratio: np.ndarray = _NONE

    def exposed(self) -> np.ndarray:
        """Relative half width (modes,) of the forbidden zone; zero where damping closes it."""
        squared = np.square(self.half_width) - np.square(self.damping_ratio)
        width: np.ndarray = np.sqrt(np.maximum(squared, 0.0))
        return width

    def sought(self) -> "Resonances":
        """All resonances that a search of speeds has to look at, those moved by damping too."""
        count = len(self.moved_frequency)
        if count == 0:
            return self
        return Resonances(
            np.concatenate([self.frequency, self.moved_frequency]),
            np.concatenate([self.damping_ratio, self.moved_ratio]),
            np.concatenate([self.half_width, np.zeros(count)]),
            np.pad(self.idle, ((0, 0), (0, count))),
        )
