"""Dampings of a shaft line that follow the speed: laws, and the line with them at any speeds."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# One damping against the speed of the crankshaft.
# ----------------------------------------------------------------------------

#: (rad/s) per rpm
RPM = math.pi / 30.0


class SpeedLaw(NamedTuple):
    """value (speed / reference)^exponent times what a table says, at crank speeds in rad/s.

    `entry` (t,) are ascending crank speeds in rad/s with a `factor` (t,) each, straight lines
    between them and level beyond; without entries the factor is 1.
    """

    value: float
    reference: float = 1.0
    exponent: float = 0.0
    entry: FloatArray = np.zeros(0)
    factor: FloatArray = np.zeros(0)

    def at(self, speed: FloatArray | float) -> FloatArray:
        """At crank speeds (...) in rad/s, above 0 where the exponent is below it."""
        found = np.asarray(speed, dtype=float)
        power = (found / self.reference) ** self.exponent if self.exponent else np.ones_like(found)
        if len(self.entry):
            power = power * np.interp(found, self.entry, self.factor)
        return np.asarray(self.value * power)

    @property
    def follows(self) -> bool:
        """Whether it is another one at another speed."""
        return bool(self.value) and (self.exponent != 0.0 or len(self.entry) > 0)


def archer_multiple(coefficient: float) -> float:
    """x in the damping x T / w of a propeller, of Archer's a T / n with n in rpm.

    T is the mean torque in N m and w the angular speed in rad/s at which it is taken; the damping
    a T / n is in N m s/rad, so that x = a pi / 30, and pi for a = 30. S. Archer, Contribution to
    improved accuracy in the calculation and measurement of torsional vibration stresses in marine
    propeller shafting, Proc. Instn. Mech. Engrs. 164 (1951).
    """
    return coefficient * RPM


def propeller_law(multiple: float, torque: SpeedLaw, ratio: float) -> SpeedLaw:
    """Damping x T / w in N m s/rad, on its own shaft, of a load with torque T against crank speed.

    w is the speed of its own shaft, |ratio| times that of the crankshaft. For a load c w^e the
    slope dT/dw is that with x = e.
    """
    value = multiple * torque.value / (abs(ratio) * torque.reference)
    return torque._replace(value=value, exponent=torque.exponent - 1.0)


# ----------------------------------------------------------------------------
# All of a line, referred to the crankshaft.
# ----------------------------------------------------------------------------


class SpeedDamping(NamedTuple):
    """What of the damping of a line follows the speed; places in the line and their laws.

    The absolute damping of a `freedom` (f,) is the sum of its laws, in N m s/rad; `element` (e,)
    have a dashpot and `lossy` (l,) a loss factor each. All are referred.
    """

    freedom: tuple[int, ...]
    of_freedom: tuple[tuple[SpeedLaw, ...], ...]
    element: tuple[int, ...]
    of_element: tuple[SpeedLaw, ...]
    lossy: tuple[int, ...]
    of_lossy: tuple[SpeedLaw, ...]

    def on(self, line: Line, speed: FloatArray | float) -> Line:
        """The line at crank speeds (...) in rad/s; what follows them gets their leading axes."""
        return line._replace(
            absolute_damping=_put(line.absolute_damping, self.freedom, self.of_freedom, speed),
            damping=_put(line.damping, self.element, [(one,) for one in self.of_element], speed),
            loss_factor=_put(
                line.loss_factor, self.lossy, [(one,) for one in self.of_lossy], speed
            ),
        )


def _put(
    values: FloatArray,
    places: tuple[int, ...],
    laws: "tuple[tuple[SpeedLaw, ...], ...] | list[tuple[SpeedLaw, ...]]",
    speed: FloatArray | float,
) -> FloatArray:
    """Values (k,) with what the laws say at some places, (..., k); as they are without places."""
    if not places:
        return values
    at = np.asarray(speed, dtype=float)
    found = np.array(np.broadcast_to(values, (*at.shape, len(values))))
    for place, several in zip(places, laws, strict=True):
        found[..., place] = sum(one.at(at) for one in several)
    return found


def referred(
    station: tuple[tuple[SpeedLaw, ...], ...],
    freedom: IntArray,
    ratio: FloatArray,
    dashpot: tuple[SpeedLaw, ...],
    loss: tuple[SpeedLaw, ...],
    element_ratio: FloatArray,
) -> SpeedDamping | None:
    """Of own values: laws of stations (s,) on freedoms (s,), dashpots and loss factors (e,).

    None where nothing follows the speed.
    """
    follow = [n for n, laws in enumerate(station) if any(one.follows for one in laws)]
    freedoms = tuple(dict.fromkeys(int(freedom[n]) for n in follow))
    of_freedom = tuple(
        tuple(
            _times(one, float(ratio[n]) ** 2)
            for n in np.flatnonzero(freedom == place).tolist()
            for one in station[n]
        )
        for place in freedoms
    )
    element = tuple(n for n, one in enumerate(dashpot) if one.follows)
    lossy = tuple(n for n, one in enumerate(loss) if one.follows)
    if not (freedoms or element or lossy):
        return None
    of_element = tuple(_times(dashpot[n], float(element_ratio[n]) ** 2) for n in element)
    return SpeedDamping(
        freedoms, of_freedom, element, of_element, lossy, tuple(loss[n] for n in lossy)
    )


def _times(law: SpeedLaw, factor: float) -> SpeedLaw:
    return law._replace(value=law.value * factor)
