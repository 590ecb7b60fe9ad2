"""Dampings of a shaft line that follow the speed: laws, those of a case, the line with them."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.line import Line

if TYPE_CHECKING:
    from vibecalc.torsion.line_part_tables import EngineDamping, OverSpeed
    from vibecalc.torsion.shaft_line_tables import Layout, Load, ShaftLine

# ----------------------------------------------------------------------------
# One damping against the speed of the crankshaft.
# ----------------------------------------------------------------------------

#: (rad/s) per rpm
RPM = math.pi / 30.0
#: a of Archer's a T / n, n in rpm, where the case says none
ARCHER = 30.0


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

    def times(self, factor: float) -> "SpeedLaw":
        """So many times as much at every speed."""
        return self._replace(value=self.value * factor)

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
# The dampings of a case and the torques of its loads as laws of their own shafts.
# ----------------------------------------------------------------------------


def _law(given: "OverSpeed | None", value: float, ratio: float) -> SpeedLaw:
    """A damping that follows the speed as a case says, `ratio` own speed over crank speed."""
    if given is None:
        return SpeedLaw(value)
    per_crank = abs(ratio) if given.of == "own" else 1.0
    if given.table is not None:
        entries = np.array(given.table.speed) / per_crank
        return SpeedLaw(value, entry=entries, factor=np.array(given.table.factor))
    assert given.reference is not None and given.exponent is not None  # no table, says the form
    return SpeedLaw(value, given.reference / per_crank, given.exponent)


def load_law(load: "Load", operating_speed: float) -> SpeedLaw:
    """Torque in N m, on its own shaft, positive braking, against the crank speed."""
    if load.curve is not None:
        entry, torque = (np.array(one) for one in (load.curve.speed, load.curve.torque))
        return SpeedLaw(1.0, entry=entry, factor=torque)
    assert load.torque is not None  # one of the two, says the form
    return SpeedLaw(load.torque, operating_speed, load.exponent)


def _engine_damping(
    given: "EngineDamping", inertia: float, natural: Callable[[], FloatArray]
) -> float:
    """Damping in N m s/rad of a station of an inertia in kg m^2.

    `natural` gives the undamped natural frequencies (m,) in rad/s. Of a magnifier M, Lehr's ratio D
    or a loss factor d the dashpot is J w / M, 2 D J w or d J w at the frequency w of the mode: were
    every inertia of a line damped so, that mode would have the magnifier M = 1 / (2 D) = 1 / d.

    Raises NumericalFailure where the mode is a rigid one.
    """
    if given.damping is not None:
        return given.damping
    frequency = natural()
    some = frequency[frequency > 0.0] if given.mode is None else frequency[given.mode - 1 :]
    w = float(some[0]) if len(some) else 0.0
    if w <= 0.0:
        which = f"mode {given.mode} of the shaft line does not vibrate"
        which = "the line has no elastic mode" if given.mode is None else which
        raise NumericalFailure(
            f"engine damping: {which}, and a magnifier or damping ratio needs one"
        )
    loss = given.loss_factor or 2.0 * (given.damping_ratio or 0.0)
    return inertia * w * (loss if given.magnifier is None else 1.0 / given.magnifier)


def station_laws(
    line: "ShaftLine",
    layout: "Layout",
    inertia: Sequence[float] | FloatArray,
    operating_speed: float,
    natural: Callable[[], FloatArray],
) -> tuple[tuple[SpeedLaw, ...], ...]:
    """Absolute dampings of each station (s,), on its own shaft: their sum acts."""
    engine, ratio = line.engine_damping, layout.ratio
    laws = []
    for place, one in enumerate(line.stations):
        found = [_law(one.over_speed, one.absolute_damping, ratio[place])]
        if engine is not None and one.turned_by:
            value = _engine_damping(engine, float(inertia[place]), natural)
            found.append(_law(engine.over_speed, value, ratio[place]))
        laws.append(found)
    for load in line.absorbed_torques:
        given = load.propeller_damping
        if given is not None:
            multiple = load.exponent if given.method == "slope" else given.coefficient or 0.0
            if given.method == "archer":
                multiple = archer_multiple(given.coefficient or ARCHER)
            place = layout.at[load.on]
            law = propeller_law(multiple, load_law(load, operating_speed), ratio[place])
            laws[place].append(law)
    return tuple(tuple(one for one in several if one.value) for several in laws)


def element_laws(line: "ShaftLine", layout: "Layout", own: FloatArray) -> tuple[SpeedLaw, ...]:
    """Dashpots or loss factors (e,) of elements, shafts first, on their own shafts."""
    laws = [SpeedLaw(value) for value in own.tolist()]
    for place, (shaft, (first, _)) in enumerate(zip(line.shafts, layout.ends, strict=True)):
        ratio = layout.ratio[layout.at[first]]
        laws[place] = _law(shaft.over_speed, laws[place].value, ratio)
    return tuple(laws)


# ----------------------------------------------------------------------------
# All of a line, referred to the crankshaft.
# ----------------------------------------------------------------------------

Laws = dict[int, list[SpeedLaw]]


class SpeedDamping(NamedTuple):
    """What of the damping of a line follows the speed: places in the line, with their laws.

    The absolute damping of a `freedom` is the sum of its laws, in N m s/rad; an `element` has a
    dashpot, one that is `lossy` a loss factor. All are referred.
    """

    freedom: Laws
    element: Laws
    lossy: Laws

    def on(self, line: Line, speed: FloatArray | float) -> Line:
        """The line at crank speeds (...) in rad/s; what follows them gets their leading axes."""
        at = np.asarray(speed, dtype=float)

        def put(values: FloatArray, laws: Laws) -> FloatArray:
            if not laws:
                return values
            found = np.array(np.broadcast_to(values, (*at.shape, len(values))))
            for place, several in laws.items():
                found[..., place] = sum(one.at(at) for one in several)
            return found

        return line._replace(
            absolute_damping=put(line.absolute_damping, self.freedom),
            damping=put(line.damping, self.element),
            loss_factor=put(line.loss_factor, self.lossy),
        )


def turning(
    line: Line,
    damping: SpeedDamping | None,
    speed_stiffness: FloatArray,
    speed: FloatArray | float,
) -> Line:
    """The line at crank speeds (...) in rad/s, with `speed_stiffness` (e,) times their squares."""
    line = line if damping is None else damping.on(line, speed)
    if not np.any(speed_stiffness):
        return line
    square = np.square(np.asarray(speed, dtype=float))[..., None]
    return line._replace(stiffness=line.stiffness + square * speed_stiffness)


def referred(
    station: Sequence[Sequence[SpeedLaw]],
    freedom: Sequence[int],
    ratio: FloatArray,
    dashpot: Sequence[SpeedLaw],
    loss: Sequence[SpeedLaw],
    element_ratio: FloatArray,
) -> SpeedDamping | None:
    """Of own values: laws of stations (s,) on freedoms (s,), dashpots and loss factors (e,).

    None where nothing follows the speed.
    """
    of_freedom: Laws = {}
    for laws, place, own in zip(station, freedom, ratio, strict=True):
        of_freedom.setdefault(place, []).extend(one.times(float(own) ** 2) for one in laws)
    found = SpeedDamping(
        {n: laws for n, laws in of_freedom.items() if any(one.follows for one in laws)},
        {n: [one.times(float(element_ratio[n]) ** 2)] for n, one in enumerate(dashpot)
         if one.follows},
        {n: [one] for n, one in enumerate(loss) if one.follows},
    )  # fmt: skip
    return found if any(found) else None
