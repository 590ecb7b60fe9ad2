"""Readings of a case as rows and amplitudes, and whether their places determine the motion."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.measurement.complex_motion import Phasors
from vibecalc.measurement.level_motions import NEEDED, Observable, helpful, observable
from vibecalc.measurement.plate import difference_row, point_row, rotation_row
from vibecalc.measurement.record_orders import record_means
from vibecalc.measurement.tables import Measurement, Reading
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
    peak = _peak(table)
    return References(
        peak * (table.reference_level or 1.0), peak * (table.angular_reference_level or 1.0)
    )


def build_harmonics(table: Measurement) -> tuple[Harmonic, ...]:
    """All readings, under the orders of the table, in the order in which they stand there."""
    reads = [*_readings(table), *_scanned(table), *_spectra(table)]
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


def row_of(reading: Reading, known: dict[str, tuple[float, float]]) -> FloatArray:
    """Row (3,) of an instrument."""
    if reading.at is not None:
        return point_row(*known[reading.at])
    if reading.between is not None:
        return difference_row(known[reading.between[0]], known[reading.between[1]])
    return rotation_row(_AXES[reading.about or "x"])


def name_of(reading: Reading) -> str:
    """How results name an instrument: `1`, `1-2`, `about x`."""
    if reading.at is not None:
        return reading.at
    if reading.between is not None:
        return "-".join(reading.between)
    return f"about {reading.about}"


def _readings(table: Measurement) -> Iterator[tuple[int, InstrumentReading]]:
    known = places(table)
    for reading in table.readings:
        angular = reading.about is not None
        amplitudes = reading.angular_amplitude if angular else reading.amplitude
        for place, order in enumerate(reading.orders or table.orders):
            yield (
                order,
                _read(
                    table,
                    f"{order}: {name_of(reading)}",
                    row_of(reading, known),
                    reading.use,
                    angular,
                    reading.level[place] if reading.level else None,
                    amplitudes[place] if amplitudes else None,
                    reading.phase[place] if reading.phase else None,
                ),
            )


def _scanned(table: Measurement) -> Iterator[tuple[int, InstrumentReading]]:
    scan = table.scan
    if scan is None:
        return
    for place, order in enumerate(scan.order):
        yield (
            order,
            _read(
                table,
                f"{order}: row {place + 1}",
                point_row(scan.x[place], scan.y[place]),
                "solve",
                False,
                scan.level[place] if scan.level else None,
                scan.amplitude[place] if scan.amplitude else None,
                scan.phase[place] if scan.phase else None,
            ),
        )


def recorded(table: Measurement, alone: bool) -> Iterator[tuple[int, InstrumentReading]]:
    """Readings of the channels of records, as uncertain as their blocks scatter.

    `alone` is a record next to which nothing else has phases.
    """
    known, reference = places(table), references(table).linear
    stated = _peak(table) * table.amplitude_uncertainty
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


def _spectra(table: Measurement) -> Iterator[tuple[int, InstrumentReading]]:
    known = places(table)
    for one in table.spectrum:
        row, found = point_row(*known[one.at]), one.found
        assert found is not None  # put there when the file was read
        for order, size, phase in zip(table.orders, found.amplitude, found.phase, strict=True):
            name = f"{order}: {one.at}"
            yield order, _read(table, name, row, one.use, False, None, size, phase)


def _read(
    table: Measurement,
    name: str,
    row: FloatArray,
    use: str,
    angular: bool,
    level: float | None,
    amplitude: float | None,
    phase: float | None,
) -> InstrumentReading:
    reference = references(table)[int(angular)]
    if level is not None:
        size = float(amplitude_of(level, reference))
        half, deviation = _off(table.level_step, table.level_uncertainty)
        unit = size / DECIBEL
    else:
        size = _peak(table) * (amplitude or 0.0)
        step = (table.angular_step if angular else table.amplitude_step) or 0.0
        nearby = table.angular_uncertainty if angular else table.amplitude_uncertainty
        half, deviation = _off(_peak(table) * step, _peak(table) * nearby)
        unit = 1.0
    if phase is None:
        # in dB, of an amplitude too; one of zero has no level
        share = 1.0 if level is not None else DECIBEL / size if size > 0.0 else 0.0
        return InstrumentReading(
            name, row, use, size, phase, half * share, deviation * share, reference
        )
    half, deviation = half * unit, deviation * unit
    # a phase of nothing says nothing: what is not there is not there in any direction
    turn = _off(table.phase_step or 0.0, table.phase_uncertainty)
    across = (size * turn[0], size * turn[1]) if size > 0.0 else (half, deviation)
    return InstrumentReading(name, row, use, size, phase, half, deviation, reference, across)


def _off(step: float, uncertainty: float) -> tuple[float, float]:
    """How far a reading may be off, and its standard uncertainty, from its last digit and what is
    said next to it."""
    return 0.5 * step + COVERAGE * uncertainty, math.hypot(step / math.sqrt(12.0), uncertainty)


def _peak(table: Measurement) -> float:
    return math.sqrt(2.0) if table.amplitude == "rms" else 1.0


# ----------------------------------------------------------------------------
# Do the places of the readings tell the motion of a plate, and if not, which part is hidden?
# ----------------------------------------------------------------------------

TABLE: KeyPath = ("measurement",)
_NAMED = 6
_SMALL = 1e-9


def place_problems(table: Measurement) -> list[Problem]:
    """One problem for each set of places that leaves a motion free, with the harmonics it has."""
    problems = list(_nowhere(table))
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
        problems.append(
            Problem(path=TABLE, message=said, allowed=problem.allowed, hint=problem.hint)
        )
    return problems


def _nowhere(table: Measurement) -> Iterator[Problem]:
    """Differences between two names of one place, which are zero however the plate moves."""
    known = places(table)
    for place, reading in enumerate(table.readings):
        if reading.between is not None and not np.any(row_of(reading, known)):
            yield Problem(
                path=(*TABLE, "readings", place, "between"),
                message="the two positions of a difference are one place",
                found=f"{reading.between[0]!r} and {reading.between[1]!r}",
                allowed="positions some way apart",
            )


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
            message="the readings do not see " + " nor ".join(_words(reported)),
            allowed="three points that are not on a line, or two with a rotation next to them",
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


def _words(reported: Observable) -> list[str]:
    """Each motion that no reading sees, as translation, roll and pitch."""
    if len(reported.unseen) > 1:
        return [f"{len(reported.unseen)} of the three motions translation, roll and pitch"]
    texts = []
    for unseen in reported.unseen:
        translation, roll, pitch = unseen / np.array([1.0, reported.span, reported.span])
        turn = float(np.hypot(roll, pitch))
        if turn <= _SMALL * abs(translation):
            texts.append("translation")
            continue
        roll, pitch, shift = roll / turn, pitch / turn, translation / turn
        if roll < 0.0 or (roll == 0.0 and pitch < 0.0):
            roll, pitch, shift = -roll, -pitch, -shift
        texts.append(_line(roll, pitch, shift, reported.span))
    return texts


def _line(roll: float, pitch: float, shift: float, span: float) -> str:
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
    known = places(table)
    names = list(known)
    further, texts = [], []
    for place, name in enumerate(names):
        further.append(point_row(*known[name]))
        texts.append(f"at {name!r}")
        for other in names[:place]:
            further.append(difference_row(known[other], known[name]))
            texts.append(f"between {other!r} and {name!r}")
    if not further:
        return ""
    telling = [texts[place] for place in helpful(rows, np.stack(further))][:_NAMED]
    return f"it would help to read {', or '.join(telling)}" if telling else ""
