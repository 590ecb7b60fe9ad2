"""Torques given at stations of a shaft line: harmonics of the crank, and how they follow speed."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.numerics.synthesis import Cycles
from vibecalc.torsion.shaft_line_tables import Layout
from vibecalc.torsion.speed_damping import SpeedLaw

if TYPE_CHECKING:
    from vibecalc.schema import Case
    from vibecalc.torsion.line_part_tables import StationExcitation
    from vibecalc.torsion.model import ShaftLineModel
    from vibecalc.torsion.shaft_line_tables import ShaftLine

# ----------------------------------------------------------------------------
# Harmonics that act on a station next to the torques of cylinders.
#
# A harmonic is A cos(n phi + alpha) on the station's own shaft, phi the angle that this shaft, or
# the crank, has turned through, in its own sense; with the ratio r of speeds its order of the crank
# is n |r|. What does not follow the speed is A cos(f t + alpha).
# ----------------------------------------------------------------------------

#: orders as close as this to a multiple of 1/2 are one: ratios of gears are rounded
SAME = 1e-9
#: of an amplitude with its phase and its law
ROUNDINGS = 16.0
#: orders of a line that nothing excites but a step in time
ALONE = np.ones(1)


class Law(Protocol):
    """What a torque is over its amplitude, such as a `SpeedLaw`."""

    def at(self, speed: FloatArray) -> FloatArray:
        """At crank speeds (s,) in rad/s."""
        ...


class HarmonicOrder(NamedTuple):
    """Of one harmonic on a station: its order of the crank, or a frequency in rad/s.

    `order` is 0 where a `frequency` does not follow the speed; `own` and `ratio` are the order and
    the speed ratio of the shaft whose turns count.
    """

    station: int
    order: float
    frequency: float
    own: float
    ratio: float


class Harmonic(NamedTuple):
    """One harmonic: `amplitude` referred to the crankshaft, complex, 0-to-peak, over its `law`."""

    of: HarmonicOrder
    amplitude: complex
    law: Law


class Orders(NamedTuple):
    """Columns (m,) of what excites a line, by rising order at the operating speed.

    `order` is of the crank; a column with a `fixed` frequency in rad/s does not follow the speed,
    and its order is that at the operating speed. `cycles` say which of them repeat together.
    """

    order: FloatArray
    fixed: FloatArray
    cycles: Cycles

    def column(self, of: HarmonicOrder) -> int:
        """Which of the columns is that of a harmonic."""
        same = (self.fixed == of.frequency) & ((self.order == of.order) | (self.fixed > 0.0))
        return int(np.argmax(same))


def given_torque(
    given: Sequence[tuple[int, int, Harmonic]], speed: FloatArray, columns: int, places: int
) -> Bounded:
    """Referred torques (s, m, k) in N m of harmonics, by column and place, at speeds (s,)."""
    total = np.zeros((len(speed), columns, places), dtype=np.complex128)
    size = np.zeros(total.shape)
    for column, place, harmonic in given:
        one = harmonic.amplitude * harmonic.law.at(speed)
        total[:, column, place] += one
        size[:, column, place] += np.abs(one)
    return Bounded(total, ROUNDINGS * EPSILON * size)


def rounded_order(order: float) -> float:
    """An order of the crank, a multiple of 1/2 where it is one up to the rounding of ratios."""
    half = round(2.0 * order) / 2.0
    return half if abs(order - half) <= SAME * max(order, 1.0) else order


def columns(engine: FloatArray, harmonics: Sequence[HarmonicOrder], speed: float) -> Orders:
    """Orders of an engine (multiples of 1/2) and of harmonics, each once.

    Orders that are no multiples of 1/2 of the crank repeat with the turns of their shaft, as those
    of one shaft do together, or, where they are none of these either, alone.
    """
    found: dict[tuple[float, float], tuple[float, float, tuple[float, ...]]] = {
        (order, 0.0): (order, order, (0.0,)) for order in engine.tolist()
    }
    bases: list[float] = []
    for one in harmonics:
        key = (one.order, one.frequency)
        if key in found:
            continue
        if one.frequency:
            base = next((b for b in bases if _half(one.frequency / b)), one.frequency)
            bases.append(base)
            found[key] = (one.frequency / speed, rounded_order(one.frequency / base), (2.0, base))
        elif _half(one.order):
            found[key] = (one.order, one.order, (0.0,))
        elif _half(one.own):
            found[key] = (one.order, rounded_order(one.own), (1.0, abs(one.ratio)))
        else:
            found[key] = (one.order, 1.0, (1.5, one.order))
    keys = sorted(found, key=lambda key: found[key][0])
    names = sorted({found[key][2] for key in keys})
    return Orders(
        order=np.array([found[key][0] for key in keys]),
        fixed=np.array([key[1] for key in keys]),
        cycles=Cycles(
            np.array([found[key][1] for key in keys]),
            np.array([names.index(found[key][2]) for key in keys], dtype=np.int64),
        ),
    )


def _half(number: float) -> bool:
    """Whether a number is a multiple of 1/2, above 0."""
    found = rounded_order(number)
    return found > 0.0 and 2.0 * found == round(2.0 * found)


# ----------------------------------------------------------------------------
# Harmonics of a record over the angle, straight between its rows.
# ----------------------------------------------------------------------------


def record_harmonics(angle: ArrayLike, torque: ArrayLike, order: ArrayLike) -> np.ndarray:
    """Complex amplitudes (m,) of a torque (k,) over angles (k,) in rad, straight between them.

    T(phi) = mean + Re sum X_n exp(i n phi) at the orders n (m,) of the shaft; the angles span whole
    turns of which the orders are multiples. Two integrations by parts leave the jumps of the slope:
    X_n = -2 / (P n^2) sum_j (s_j - s_(j-1)) exp(-i n phi_j), P the span, s_j the slope after row j.
    """
    phi, values = np.asarray(angle, dtype=float), np.asarray(torque, dtype=float)
    n = np.asarray(order, dtype=float)[:, None]
    slope = np.diff(values) / np.diff(phi)
    jump = slope - np.roll(slope, 1)
    span = phi[-1] - phi[0]
    return np.asarray(-2.0 / (span * n[:, 0] ** 2) * (np.exp(-1j * n * phi[:-1]) @ jump))


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
    own = np.asarray(engine, dtype=float)
    return columns(own if len(own) or given else ALONE, given, case.machine.speed)


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
