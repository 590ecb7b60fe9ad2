"""The torques that a case gives at stations of its line, as harmonics of the crank."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.shaft_line_tables import Layout
from vibecalc.torsion.speed_damping import SpeedLaw
from vibecalc.torsion.station_torques import (
    Harmonic,
    HarmonicOrder,
    Law,
    Orders,
    columns,
    record_harmonics,
    rounded_order,
)

if TYPE_CHECKING:
    from vibecalc.schema import Case
    from vibecalc.torsion.line_part_tables import StationExcitation
    from vibecalc.torsion.model import ShaftLineModel
    from vibecalc.torsion.shaft_line_tables import ShaftLine

# ----------------------------------------------------------------------------
# [[machine.shaft_line.excitations]] as harmonics.
# ----------------------------------------------------------------------------


def _orders_by_entry(line: "ShaftLine") -> list[list[HarmonicOrder]]:
    layout, found = Layout(line), []
    for one in line.excitations:
        station = layout.at[one.on]
        counted = 1.0 if one.of == "crankshaft" else abs(layout.ratio[station])
        if one.frequencies:
            found.append([HarmonicOrder(station, 0.0, w, w, counted) for w in one.frequencies])
        else:
            orders = [(own, rounded_order(own * counted)) for own in orders_of(one)]
            found.append([HarmonicOrder(station, q, 0.0, own, counted) for own, q in orders])
    return found


def all_orders(case: "Case", engine: ArrayLike) -> Orders:
    """Orders of a validated case: those (m,) of its engine, and those of torques at stations."""
    line = case.machine.shaft_line
    assert line is not None
    given = [order for orders in _orders_by_entry(line) for order in orders]
    return columns(np.asarray(engine, dtype=float), given, case.machine.speed)


def given_harmonics(
    case: "Case", shaft: "ShaftLineModel", engine_mean: Callable[[FloatArray], FloatArray]
) -> list[Harmonic]:
    """All of a validated case; `engine_mean` (s,) is the referred mean torque of the cylinders."""
    line, speed = case.machine.shaft_line, case.machine.speed
    assert line is not None
    found = []
    for one, orders in zip(line.excitations, _orders_by_entry(line), strict=True):
        station = orders[0].station
        amplitude = _amplitudes(one, float(abs(shaft.station_ratio[station])))
        law = _law(one, shaft, station, speed, engine_mean)
        found += [
            Harmonic(order, complex(each), law)
            for order, each in zip(orders, amplitude.tolist(), strict=True)
        ]
    return found


def orders_of(given: "StationExcitation") -> list[float]:
    """Orders of the shaft whose turns count, or frequencies in rad/s."""
    if given.record is not None:
        turns = round((given.record.angle[-1] - given.record.angle[0]) / (2.0 * np.pi))
        return [number / turns for number in range(1, given.harmonics + 1)]
    wheel = given.blades or given.teeth
    if wheel is not None:
        return [float(wheel * (k + 1)) for k in range(len(given.torques or given.shares))]
    return list(given.orders or given.frequencies)


def _amplitudes(given: "StationExcitation", ratio: float) -> np.ndarray:
    """Complex (h,), referred: of torques in N m, of shares over the referred mean torque."""
    if given.record is not None:
        return ratio * record_harmonics(given.record.angle, given.record.torque, orders_of(given))
    size = np.array(given.shares) if given.shares else ratio * np.array(given.torques)
    phases = np.array(given.phases) if given.phases else np.zeros(len(size))
    return np.asarray(size * np.exp(1j * phases))


def _law(
    given: "StationExcitation",
    shaft: "ShaftLineModel",
    station: int,
    operating: float,
    engine_mean: Callable[[FloatArray], FloatArray],
) -> Law:
    if given.over_speed is not None:
        entry, factor = np.array(given.over_speed.speed), np.array(given.over_speed.factor)
        return SpeedLaw(1.0, entry=entry, factor=factor)
    if not given.shares:
        return SpeedLaw(1.0, operating, given.exponent)
    ratio = float(np.abs(shaft.station_ratio[station]))
    here = np.flatnonzero(shaft.taken_station == station)
    if station != shaft.load_station and len(here) == 1:
        law = shaft.taken_laws[int(here[0])]
        return law._replace(value=abs(law.value) * ratio)
    return _MeanTorque(shaft, station, here, engine_mean)


class _MeanTorque(NamedTuple):
    """Magnitude of the mean torque that a station takes, referred, in N m."""

    shaft: "ShaftLineModel"
    station: int
    here: np.ndarray
    engine_mean: Callable[[FloatArray], FloatArray]

    def at(self, speed: FloatArray) -> FloatArray:
        """At crank speeds (s,) in rad/s."""
        taken = self.shaft.taken(speed)
        carried = taken[:, self.here].sum(axis=1)
        if self.station == self.shaft.load_station:
            carried = carried + self.engine_mean(speed) - taken.sum(axis=1)
        return np.asarray(np.abs(carried))
