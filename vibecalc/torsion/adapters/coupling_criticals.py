"""Critical speeds and poles of a line whose couplings follow speed and frequency."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.poles import refined_pole

# ----------------------------------------------------------------------------
# Where the modes meet the orders: the line is that of the critical speed itself.
#
# Outside the speeds that a case asks for, loads and heat are nobody's: near them those at the
# nearest end count, farther away the modes of the operating speed.
# ----------------------------------------------------------------------------

#: secant steps, by how much a first guess may lie outside the range, what counts as met
_ROUNDS, _NEAR, _MET = 30, 0.1, 1e-12


def asked_range(setup: Setup) -> tuple[float, float]:
    """Lowest and highest crank speed that a case asks for, rad/s."""
    speeds = setup.torsion.speeds
    every = [setup.speed] if speeds is None else [setup.speed, speeds.start, speeds.stop]
    return min(every), max(every)


def met_criticals(setup: Setup) -> Bounded:
    """Critical speeds (m, q) of modes and orders, infinite for modes near which nothing peaks."""
    modes, order, (first, last) = setup.natural(), setup.drive.order, asked_range(setup)
    low, high = first * (1.0 - _NEAR), last * (1.0 + _NEAR)
    speed = modes.frequency[:, None] / order
    error = modes.frequency_error[:, None] / order
    speed[modes.silent & (modes.frequency > 0.0)] = np.inf
    pairs = np.argwhere((speed >= low) & (speed <= high)).tolist()
    due = {(mode, place): _Secant(setup, mode, float(order[place])) for mode, place in pairs}
    for _ in range(_ROUNDS):
        if not due:
            break
        # their conditions are found together
        setup.model.at(np.array([one.at for one in due.values()]))
        for key, one in list(due.items()):
            if one.step(low, high):
                continue
            del due[key]
            if one.error >= 0.0:
                speed[key], error[key] = one.at, one.error
    return Bounded(speed, np.where(np.isfinite(speed), error, 0.0))


class _Secant:
    """The search for the speed at which a mode meets an order; its error is below 0 in vain."""

    def __init__(self, setup: Setup, mode: int, order: float):
        modes = setup.natural()
        self.setup, self.mode, self.order = setup, mode, order
        self.pole = complex(modes.pole[mode])
        self.at = float(modes.frequency[mode]) / order
        self.last: tuple[float, float] | None = None
        self.error = -1.0

    def step(self, low: float, high: float) -> bool:
        """Go on; False once it is over."""
        at, order = self.at, self.order
        try:
            frequency, uncertainty = self._frequency()
        except NumericalFailure:
            return False
        left, slope = frequency - order * at, -order
        if self.last is not None and at != self.last[0]:
            slope = (left - self.last[1]) / (at - self.last[0])
        if slope >= 0.0:
            return False
        if abs(left) <= max(4.0 * uncertainty, _MET * frequency):
            assert self.setup.model.couplings is not None
            off = 0.5 * frequency * self.setup.model.couplings.spread()
            self.error = (uncertainty + abs(left) + off) / -slope + 4.0 * EPSILON * at
            return False
        self.last, self.at = (at, left), at - left / slope
        return low <= self.at <= high

    def _frequency(self) -> tuple[float, float]:
        """Of the mode at the present speed and at the frequency of its order, and the error."""
        line = self.setup.model.at(self.at, self.order * self.at)
        if self.setup.natural().damped:
            self.pole, error = refined_pole(line, self.pole)
            return abs(self.pole), error
        found = natural_modes(line)
        return float(found.frequency[self.mode]), float(found.frequency_error[self.mode])
