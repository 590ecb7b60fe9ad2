"""Dampings and loads of a shaft line as a case gives them, as laws over the speed."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.shaft_line_tables import Load, ShaftLine, shaft_ends
from vibecalc.torsion.speed_damping import SpeedLaw, archer_multiple, propeller_law

if TYPE_CHECKING:
    from vibecalc.torsion.damping_tables import EngineDamping, OverSpeed

# ----------------------------------------------------------------------------
# The dampings of a case and the torques of its loads as laws of their own shafts.
# ----------------------------------------------------------------------------


def follows(given: "OverSpeed | None", value: float, ratio: float) -> SpeedLaw:
    """A damping that follows the speed as a case says, `ratio` own speed over crank speed."""
    if given is None:
        return SpeedLaw(value)
    per_crank = abs(ratio) if given.of == "own" else 1.0
    if given.exponent is not None and given.reference is not None:
        return SpeedLaw(value, given.reference / per_crank, given.exponent)
    assert given.table is not None  # one of the two, says the form
    entries = np.array(given.table.speed, dtype=float) / per_crank
    return SpeedLaw(value, entry=entries, factor=np.array(given.table.factor, dtype=float))


def load_law(load: Load, operating_speed: float) -> SpeedLaw:
    """Torque in N m, on its own shaft, positive braking, against the crank speed."""
    if load.curve is not None:
        entry, torque = (np.array(one) for one in (load.curve.speed, load.curve.torque))
        return SpeedLaw(1.0, entry=entry, factor=torque)
    assert load.torque is not None  # one of the two, says the form
    return SpeedLaw(load.torque, operating_speed, load.exponent)


def propeller_damping(load: Load, torque: SpeedLaw, ratio: float) -> SpeedLaw | None:
    """That of a load, in N m s/rad on its own shaft; None where it has none."""
    given = load.propeller_damping
    if given is None:
        return None
    if given.method == "archer":
        from vibecalc.torsion.damping_tables import ARCHER

        multiple = archer_multiple(given.coefficient or ARCHER)
    else:
        multiple = load.exponent if given.method == "slope" else given.coefficient or 0.0
    return propeller_law(multiple, torque, ratio)


def engine_value(
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
        which = "the line has no elastic mode" if given.mode is None else f"mode {given.mode} of "
        which += "" if given.mode is None else "the shaft line does not vibrate"
        raise NumericalFailure(
            f"engine damping: {which}, and a magnifier or damping ratio needs one"
        )
    if given.magnifier is not None:
        return inertia * w / given.magnifier
    if given.damping_ratio is not None:
        return 2.0 * given.damping_ratio * inertia * w
    return (given.loss_factor or 0.0) * inertia * w


def station_laws(
    line: ShaftLine,
    at: Mapping[str, int],
    ratio: Sequence[float] | FloatArray,
    inertia: Sequence[float] | FloatArray,
    operating_speed: float,
    natural: Callable[[], FloatArray],
) -> tuple[tuple[SpeedLaw, ...], ...]:
    """Absolute dampings of each station (s,), on its own shaft: their sum acts."""
    laws = [
        [follows(one.over_speed, one.absolute_damping, ratio[place])]
        for place, one in enumerate(line.stations)
    ]
    engine = line.engine_damping
    for place, station in enumerate(line.stations):
        if engine is not None and (station.cylinder is not None or station.cylinders):
            value = engine_value(engine, float(inertia[place]), natural)
            laws[place].append(follows(engine.over_speed, value, ratio[place]))
    for load in line.loads:
        place = at[load.on]
        torque = load_law(load, operating_speed)
        found = propeller_damping(load, torque, ratio[place])
        if found is not None:
            laws[place].append(found)
    return tuple(tuple(one for one in several if one.value) for several in laws)


def element_laws(
    line: ShaftLine, at: Mapping[str, int], ratio: Sequence[float] | FloatArray,
    dashpot: Sequence[float], loss: Sequence[float],
) -> tuple[tuple[SpeedLaw, ...], tuple[SpeedLaw, ...]]:  # fmt: skip
    """Dashpots and loss factors (e,) of elements, shafts first, on their own shafts."""
    given: list[tuple[OverSpeed | None, float]] = [
        (shaft.over_speed, float(ratio[at[first]]))
        for shaft, (first, _) in zip(line.shafts, shaft_ends(line), strict=True)
    ]
    given += [(None, 1.0)] * (len(dashpot) - len(given))
    dashpots, losses = (
        tuple(follows(law, value, own) for (law, own), value in zip(given, values, strict=True))
        for values in (dashpot, loss)
    )
    return dashpots, losses
