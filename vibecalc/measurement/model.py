"""Readings of a case as rows and amplitudes, and whether their places determine the motion."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.measurement.complex_motion import Phasors
from vibecalc.measurement.level_motions import NEEDED, Observable, helpful, observable
from vibecalc.measurement.plate import difference_row, point_row, rotation_row
from vibecalc.measurement.record_orders import record_means
from vibecalc.measurement.tables import Measurement
from vibecalc.numerics.level import DECIBEL, amplitude_of
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# Readings of a case as rows, amplitudes and how far each may be off, harmonic by harmonic.
# ----------------------------------------------------------------------------

#: what an uncertainty next to the last digit adds to how far a reading may be off
COVERAGE = 2.0
_AXES = {"x": (1.0, 0.0), "y": (0.0, 1.0)}


class InstrumentReading(NamedTuple):
    """One number that an instrument shows; amplitudes are 0-to-peak, in m/s^2 or rad/s^2.

    `half_width` and `deviation` are how far the amplitude may be off and its standard
    uncertainty: in dB of a level alone, in the unit of the amplitude where there is a phase.
    `across` has both for what an error of the phase moves, in the unit of the amplitude; zeros
    without a phase. `reference` is the 0-to-peak amplitude of 0 dB.
    """

    name: str
    row: FloatArray
    use: str
    amplitude: float
    phase: float | None
    half_width: float
    deviation: float
    reference: float
    across: tuple[float, float] = (0.0, 0.0)


class Harmonic(NamedTuple):
    """What is read of one order. Phases among `solve` make the motion a linear problem."""

    order: int
    reads: tuple[InstrumentReading, ...]

    @property
    def is_complex(self) -> bool:
        """Whether the motion comes from complex amplitudes."""
        return any(read.phase is not None for read in self.reads if read.use == "solve")

    @property
    def solving(self) -> tuple[InstrumentReading, ...]:
        """The readings that the motion is found from; levels next to phases only compare."""
        found = (read for read in self.reads if read.use == "solve")
        return tuple(read for read in found if (read.phase is not None) is self.is_complex)

    @property
    def phasors(self) -> Phasors:
        """The same of a complex harmonic, as its least squares takes them."""
        reads = self.solving
        return Phasors(
            np.array([read.row for read in reads]),
            np.array([read.amplitude * np.exp(1j * (read.phase or 0.0)) for read in reads]),
            np.array([(read.half_width, read.across[0]) for read in reads]).T,
            np.array([(read.deviation, read.across[1]) for read in reads]).T,
        )


class References(NamedTuple):
    """0-to-peak amplitudes of 0 dB, m/s^2 and rad/s^2."""

    linear: float
    angular: float


def references(table: Measurement) -> References:
    """What levels refer to, with the factor from effective values where levels are of these."""
    peak = math.sqrt(2.0) if table.amplitude == "rms" else 1.0
    return References(
        peak * (table.reference_level or 1.0), peak * (table.angular_reference_level or 1.0)
    )


def build_harmonics(table: Measurement) -> tuple[Harmonic, ...]:
    """All readings, under the orders of the table, in the order in which they stand there."""
    reads = [*_stated(table)]
    alone = len(table.record) == 1 and all(read.phase is None for _, read in reads)
    reads += recorded(table, alone)
    return tuple(
        Harmonic(order, tuple(read for number, read in reads if number == order))
        for order in table.orders
    )


def places(table: Measurement) -> dict[str, tuple[float, float]]:
    """Coordinates of the named positions, m."""
    return {position.name: (position.x, position.y) for position in table.positions}


def position_rows(table: Measurement) -> FloatArray:
    """Rows (p, 3) of the named positions."""
    x = [position.x for position in table.positions]
    y = [position.y for position in table.positions]
    return point_row(np.array(x), np.array(y))


def reference_row(table: Measurement) -> FloatArray:
    """Row (3,) of the place where phases are zero."""
    known = places(table)
    name = table.reference_position
    if name is None:
        channels = [one for record in table.record for one in record.channels]
        every: tuple[Any, ...] = (*table.readings, *channels, *table.spectrum)
        pointed: list[str | None] = [one.at for one in every if one.use == "solve"]
        name = next((at for at in pointed if at is not None), None)
    if name is not None:
        return point_row(*known[name])
    if table.scan is not None:
        return point_row(table.scan.x[0], table.scan.y[0])
    return point_row(0.0, 0.0)


class _Shown(NamedTuple):
    """What one instrument shows: numbers of each of some orders, of levels or amplitudes.

    `positions` are that of an accelerometer, the two of a difference, or none.
    """

    name: str
    row: FloatArray
    use: str
    angular: bool
    orders: Sequence[int]
    level: Sequence[float]
    amplitude: Sequence[float]
    phase: Sequence[float]
    positions: tuple[str, ...] = ()


def _shown(table: Measurement) -> Iterator[_Shown]:
    """Readings, rows of the scan and spectra."""
    known, scan = places(table), table.scan
    for reading in table.readings:
        angular = reading.about is not None
        if reading.at is not None:
            name, row = reading.at, point_row(*known[reading.at])
        elif reading.between is not None:
            name = "-".join(reading.between)
            row = difference_row(*(known[at] for at in reading.between))
        else:
            name, row = f"about {reading.about}", rotation_row(_AXES[reading.about or "x"])
        amplitude = reading.angular_amplitude if angular else reading.amplitude
        orders = reading.orders or table.orders
        positions = reading.between or (() if reading.at is None else (reading.at,))
        numbers = (reading.level, amplitude, reading.phase)
        # a case that checks refuse for numbers that are missing is planned with those there are
        orders = orders[: min(len(one) for one in (orders, *numbers) if one)]
        yield _Shown(name, row, reading.use, angular, orders, *numbers, positions)
    for place, order in enumerate(() if scan is None else scan.order):
        assert scan is not None
        one = slice(place, place + 1)
        row = point_row(scan.x[place], scan.y[place])
        numbers = (scan.level[one], scan.amplitude[one], scan.phase[one])
        yield _Shown(f"row {place + 1}", row, "solve", False, (order,), *numbers)
    for spectrum in table.spectrum:
        found = spectrum.found
        assert found is not None  # put there when the file was read
        row, at = point_row(*known[spectrum.at]), spectrum.at
        numbers = ((), found.amplitude, found.phase)
        yield _Shown(at, row, spectrum.use, False, table.orders, *numbers, (at,))


def _size(one: _Shown, place: int, table: Measurement) -> float:
    """The amplitude of a reading, 0-to-peak."""
    if one.level:
        return float(amplitude_of(one.level[place], references(table)[int(one.angular)]))
    return (math.sqrt(2.0) if table.amplitude == "rms" else 1.0) * one.amplitude[place]


def _stated(table: Measurement) -> Iterator[tuple[int, InstrumentReading]]:
    """What they read of each order."""
    peak = math.sqrt(2.0) if table.amplitude == "rms" else 1.0
    shown = tuple(_shown(table))
    at_ends = {
        (order, one.positions[0]): _size(one, place, table)
        for one in shown
        if len(one.positions) == 1
        for place, order in enumerate(one.orders)
    }
    turn = _off(table.phase_step or 0.0, table.phase_uncertainty)
    for one in shown:
        reference = references(table)[int(one.angular)]
        step = (table.angular_step if one.angular else table.amplitude_step) or 0.0
        nearby = table.angular_uncertainty if one.angular else table.amplitude_uncertainty
        for place, order in enumerate(one.orders):
            size = _size(one, place, table)
            if one.level:
                half, deviation = _off(table.level_step, table.level_uncertainty)
                # in the unit of the amplitude, and in dB
                unit, decibel = size / DECIBEL, 1.0
            else:
                half, deviation = _off(peak * step, peak * nearby)
                # an amplitude of zero has no level
                unit, decibel = 1.0, DECIBEL / size if size > 0.0 else 0.0
            phase, across = one.phase[place] if one.phase else None, (0.0, 0.0)
            unit = decibel if phase is None else unit
            half, deviation = half * unit, deviation * unit
            if phase is not None:
                # a phase of nothing says nothing: what is not there is not there in any direction
                across = (size * turn[0], size * turn[1]) if size > 0.0 else (half, deviation)
            if len(one.positions) == 2 and table.has_mismatch:
                first, second = (at_ends.get((order, at), 0.0) for at in one.positions)
                off = table.sensitivity_mismatch, table.phase_mismatch
                more = mismatch(size, first, second, *off)
                along = more.along * (DECIBEL / size if phase is None else 1.0)
                half, deviation = _with((half, deviation), along)
                across = across if phase is None else _with(across, more.across)
            yield (
                order,
                InstrumentReading(
                    f"{order}: {one.name}",
                    one.row,
                    one.use,
                    size,
                    phase,
                    half,
                    deviation,
                    reference,
                    across,
                ),
            )


def recorded(table: Measurement, alone: bool) -> Iterator[tuple[int, InstrumentReading]]:
    """Readings of the channels of records, as uncertain as their blocks scatter.

    `alone` is a record next to which nothing else has phases.
    """
    known, reference = places(table), references(table).linear
    stated = table.amplitude_uncertainty * (math.sqrt(2.0) if table.amplitude == "rms" else 1.0)
    for one in record_means(table):
        row, sizes = point_row(*known[one.at]), np.abs(one.mean.amplitudes)
        for place, order in enumerate(table.orders):
            size = float(sizes[place])
            floor = float(one.error[place]) + 8.0 * EPSILON * size
            along = math.hypot(float(one.mean.along[place]), stated, floor)
            # all phases of a record are off together, which none of them shows against another
            together = 0.0 if alone else float(one.zero[place])
            turn = size * math.hypot(table.phase_uncertainty, together)
            across = math.hypot(float(one.mean.across[place]), turn, floor)
            yield (
                order,
                InstrumentReading(
                    f"{order}: {one.at}",
                    row,
                    one.use,
                    size,
                    float(np.angle(one.mean.amplitudes[place])),
                    COVERAGE * along,
                    along,
                    reference,
                    (COVERAGE * across, across),
                ),
            )


class Mismatch(NamedTuple):
    """Standard uncertainty of a difference along its phasor and across it, in its own unit."""

    along: float
    across: float


def mismatch(
    difference: float, first: float, second: float, sensitivity: float, phase: float
) -> Mismatch:
    """What two accelerometers that are not alike make of their difference, of these amplitudes.

    With the relative mismatch d = sensitivity + i phase it is off by d m, m the mean of both
    signals a and b. From the three amplitudes alone the parallelogram of a and b has its other
    diagonal, 4 |m|^2 = 2 |a|^2 + 2 |b|^2 - |b - a|^2, and the angle of both, whose cosine is
    (|b|^2 - |a|^2) / (2 |m| |b - a|).
    """
    mean = 0.5 * math.sqrt(max(2.0 * (first**2 + second**2) - difference**2, 0.0))
    if not mean * difference > 0.0:
        either = mean * math.hypot(sensitivity, phase)
        return Mismatch(either, either)
    cosine = min(abs(second**2 - first**2) / (2.0 * mean * difference), 1.0)
    sine = math.sqrt(1.0 - cosine**2)
    return Mismatch(
        mean * math.hypot(sensitivity * cosine, phase * sine),
        mean * math.hypot(sensitivity * sine, phase * cosine),
    )


def _with(off: tuple[float, float], more: float) -> tuple[float, float]:
    """How far a reading may be off, and its standard uncertainty, with another one."""
    return off[0] + COVERAGE * more, math.hypot(off[1], more)


def _off(step: float, uncertainty: float) -> tuple[float, float]:
    """How far a reading may be off, and its standard uncertainty, from its last digit and what is
    said next to it."""
    return 0.5 * step + COVERAGE * uncertainty, math.hypot(step / math.sqrt(12.0), uncertainty)


# ----------------------------------------------------------------------------
# Do the places of the readings tell the motion of a plate, and if not, which part is hidden?
# ----------------------------------------------------------------------------

TABLE: KeyPath = ("measurement",)
_NAMED = 6
_SMALL = 1e-9


def place_problems(table: Measurement) -> list[Problem]:
    """One problem for each set of places that leaves a motion free, with the harmonics it has."""
    known = places(table)
    problems = [
        Problem(
            path=(*TABLE, "readings", place, "between"),
            message="the two positions of a difference coincide",
            found=f"{reading.between[0]!r} and {reading.between[1]!r}",
            allowed="two different positions",
        )
        for place, reading in enumerate(table.readings)
        if reading.between is not None and len({known[at] for at in reading.between}) == 1
    ]
    if problems:
        return problems
    found: dict[str, tuple[Problem, list[int]]] = {}
    for harmonic in build_harmonics(table):
        problem = _problem(harmonic, table)
        if problem is not None:
            found.setdefault(problem.message, (problem, []))[1].append(harmonic.order)
    for problem, orders in found.values():
        which = "harmonic" if len(orders) == 1 else "harmonics"
        said = f"{which} {', '.join(map(str, orders))}: {problem.message}"
        problems.append(problem._replace(message=said))
    return problems


def _problem(harmonic: Harmonic, table: Measurement) -> Problem | None:
    rows = [read.row for read in harmonic.solving]
    if not rows:
        return Problem(
            path=TABLE,
            message="there is no reading to find the motion from",
            allowed='readings with use = "solve"',
        )
    stacked = np.stack(rows)
    reported = observable(stacked)
    if len(reported.unseen):
        return Problem(
            path=TABLE,
            message=f"the readings do not determine {_unseen(reported)}",
            allowed="three points not on a line, or two points and a rotation",
            hint=_further(stacked, table),
        )
    if harmonic.is_complex or reported.levels >= NEEDED:
        return None
    return Problem(
        path=TABLE,
        message=f"the levels determine {reported.levels} of the {NEEDED} numbers of a motion "
        "(three amplitudes and two phases)",
        allowed=f"{NEEDED} independent levels, such as three points and two differences; "
        "or phases next to the levels",
        hint=_further(stacked, table),
    )


def _unseen(reported: Observable) -> str:
    """The motion that no reading sees, as translation, roll and pitch."""
    if len(reported.unseen) > 1:
        return f"{len(reported.unseen)} of the three motions translation, roll and pitch"
    translation, roll, pitch = reported.unseen[0] / np.array([1.0, reported.span, reported.span])
    turn = float(np.hypot(roll, pitch))
    if turn <= _SMALL * abs(translation):
        return "translation"
    if roll < 0.0 or (roll == 0.0 and pitch < 0.0):
        turn = -turn
    return _line(roll / turn, pitch / turn, translation / turn)


def _line(roll: float, pitch: float, shift: float) -> str:
    """A rotation about a line on which all points of the readings lie."""
    if abs(pitch) <= _SMALL:
        return f"roll about the line y = {-shift / roll + 0.0:.4g} m, on which the points lie"
    if abs(roll) <= _SMALL:
        return f"pitch about the line x = {shift / pitch + 0.0:.4g} m, on which the points lie"
    at = shift * np.array([pitch, -roll])
    return (
        f"rotation about the line on which the points lie, through ({at[0]:.4g}, {at[1]:.4g}) m: "
        f"{roll:.3g} of roll with {pitch:.3g} of pitch"
    )


def _further(rows: FloatArray, table: Measurement) -> str:
    """Readings at the named positions that would tell more."""
    further = further_readings(table)
    told = helpful(rows, np.array([row for _, row in further]).reshape(-1, 3))[:_NAMED]
    names = [reading_name([repr(at) for at in further[place][0]]) for place in told]
    return f"it would help to read {', or '.join(names)}" if names else ""


def further_readings(table: Measurement) -> list[tuple[list[str], FloatArray]]:
    """All readings at a named position and between two of them: positions and row."""
    known = places(table)
    found = []
    for place, name in enumerate(known):
        found.append(([name], point_row(*known[name])))
        for other in list(known)[:place]:
            found.append(([other, name], difference_row(known[other], known[name])))
    return found


def reading_name(positions: Sequence[str]) -> str:
    """`at a`, `between a and b`."""
    return f"{'at' if len(positions) == 1 else 'between'} {' and '.join(positions)}"
