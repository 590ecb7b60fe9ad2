"""A shaft line whose couplings are taken under the conditions that they are in."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.couplings import Coupling, modes_at_own_frequency
from vibecalc.torsion.line import Line
from vibecalc.torsion.modes import Modes, natural_modes

# ----------------------------------------------------------------------------
# The line at a speed and a frequency, under the conditions that its couplings are in.
# ----------------------------------------------------------------------------


class Moved(NamedTuple):
    """What errors of conditions may move: angles (s, m, n), twists, torques (s, m, e), heat (s, e).

    Referred, as the solution itself.
    """

    angle: FloatArray
    twist: FloatArray
    torque: FloatArray
    heat: FloatArray


#: of couplings at speeds (3, ..., c), own: mean torque in N m, temperature in K, and half range of
#: the torque in N m
Conditions = FloatArray


class CouplingStates(NamedTuple):
    """Couplings (c,) that vary, and what gives their conditions (u, c) at ascending speeds (u,).

    Formed once: `critical`, the critical speeds (m, q) of the line, and `spread`, the largest
    relative error that those of the conditions make in a stiffness or loss factor. `moved` is what
    these errors make of the solution at speeds (s,); None where the conditions are given.
    """

    couplings: tuple[Coupling, ...]
    conditions: Callable[[FloatArray], Conditions]
    critical: Callable[[], Bounded]
    spread: Callable[[], float] = float
    moved: Callable[[FloatArray], Moved] | None = None

    @property
    def by_frequency(self) -> bool:
        """Whether some coupling depends on the frequency."""
        return any(one.frequency is not None for one in self.couplings)

    def modes(self, line_at: Callable[[float], Line]) -> Modes:
        """Undamped ones of what `line_at` gives at a frequency in rad/s, each at its own."""
        return modes_at_own_frequency(line_at) if self.by_frequency else natural_modes(line_at(0.0))

    def on(self, line: Line, speed: FloatArray | float, frequency: FloatArray | float) -> Line:
        """The line with its couplings at speeds and frequencies (...) in rad/s that broadcast."""
        speed, frequency = np.asarray(speed, dtype=float), np.asarray(frequency, dtype=float)
        shape = np.broadcast_shapes(speed.shape, frequency.shape)
        at, place = np.unique(speed, return_inverse=True)
        found, place = self.conditions(at), place.reshape(speed.shape)
        whole = (*shape, len(line.first))
        stiffness, loss = (
            np.array(np.broadcast_to(one, whole)) for one in (line.stiffness, line.loss_factor)
        )
        for c, one in enumerate(self.couplings):
            mean, temperature, amplitude = (part[place, c] for part in found)
            own, eta = one.values(mean, temperature, frequency, amplitude)
            stiffness[..., one.element] = one.ratio**2 * own
            loss[..., one.element] = eta
        return line._replace(stiffness=stiffness, loss_factor=loss)
