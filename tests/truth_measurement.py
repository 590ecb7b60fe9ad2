"""The motion of a plate from its readings next to the truth in many digits, all from the case.

Amplitudes with phases are a linear least-squares problem; levels, least squares in dB, are solved
by Newton's method from the motion found. Without truth are counts and verdicts, and the bounds and
uncertainties of levels, which are ends of linear programs (`test_property_measurement_bounds.py`).
"""

from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
from estimate_counts import Reported, against, checked_run
from mpmath import matrix, mp, mpc, mpf
from random_machines import Table

from vibecalc.core.results.record import Record

DIGITS = 40
ROOT = "measurement"
#: dB; residuals below it are those of levels that are met
_MET = 1e-20
Row = tuple[mpf, mpf, mpf]
PARTS = {
    "standard": (1, 1, 1), "no_roll": (1, 0, 1), "no_pitch": (1, 1, 0), "only_roll": (0, 1, 0),
    "only_pitch": (0, 0, 1), "only_translation": (1, 0, 0),
}  # fmt: skip


def judge_plate(table: Table) -> Reported:
    """Every result that has a truth."""
    _, record = checked_run(table)
    with mpmath.workdps(DIGITS):
        judged = [against(record, *one) for one in truths(table["measurement"], record)]
    return Reported(table, record, judged)


class Plate:
    """Rows, amplitudes and what else the case says, in many digits."""

    def __init__(self, table: Table):
        self.table = table
        self.peak = mp.sqrt(2) if table["amplitude"] == "rms" else mpf(1)
        self.reference = self.peak * mpf(table["reference_level"])
        self.places = {p["name"]: (mpf(p["x"]), mpf(p["y"])) for p in table["positions"]}
        self.origin = self.row(self.places[table["reference_position"]])
        self.is_phased = "phase" in table["readings"][0]
        self.fits: list[Phased] = []

    @staticmethod
    def row(at: tuple[mpf, mpf]) -> Row:
        return mpf(1), at[1], -at[0]

    def rows(self) -> list[Row]:
        found = []
        for reading in self.table["readings"]:
            if "at" in reading:
                found.append(self.row(self.places[reading["at"]]))
            else:
                (x1, y1), (x2, y2) = (self.places[name] for name in reading["between"])
                found.append((mpf(0), y2 - y1, x1 - x2))
        return found

    def sizes(self, place: int) -> list[mpf]:
        if self.is_phased:
            return [self.peak * mpf(r["amplitude"][place]) for r in self.table["readings"]]
        return [
            self.reference * mp.mpf(10) ** (mpf(r["level"][place]) / 20)
            for r in self.table["readings"]
        ]

    def level(self, size: Any, reference: Any = None) -> mpf:
        over = self.reference if reference is None else reference
        return 20 * mp.log10(abs(size) / over) if size != 0 else mp.ninf


def dot(row: Row, motion: list[Any]) -> Any:
    """Signal of an instrument."""
    return sum(c * u for c, u in zip(row, motion, strict=True))


class Phased:
    """Weighted least squares by its normal equations, amplitudes and phases each by their own."""

    def __init__(self, plate: Plate, place: int):
        step, turn = mpf(plate.table["amplitude_step"]), mpf(plate.table["phase_step"])
        self.slopes, self.read, self.stated = [], [], []
        for row, size, reading in zip(
            plate.rows(), plate.sizes(place), plate.table["readings"], strict=True
        ):
            angle = mpf(reading["phase"][place])
            c, s = mp.cos(angle), mp.sin(angle)
            self.slopes += [[*(x * c for x in row), *(x * s for x in row)],
                            [*(-x * s for x in row), *(x * c for x in row)]]  # fmt: skip
            self.read += [size, mpf(0)]
            self.stated += [plate.peak * step / mp.sqrt(12), size * turn / mp.sqrt(12)]
        self.spare = len(self.read) - 6
        self.grow([mpf(1), mpf(1)])

    def grow(self, growth: list[Any]) -> None:
        self.solve([s * growth[i % 2] for i, s in enumerate(self.stated)])

    def solve(self, deviations: list[Any]) -> None:
        table, right = matrix(6, 6), matrix(6, 1)
        for slope, read, deviation in zip(self.slopes, self.read, deviations, strict=True):
            for i in range(6):
                right[i] += slope[i] * read / deviation**2
                for j in range(6):
                    table[i, j] += slope[i] * slope[j] / deviation**2
        self.deviations, self.inverse = deviations, table**-1
        parts = mp.lu_solve(table, right)
        self.parts = [parts[i] for i in range(6)]
        self.motion = [mpc(parts[i], parts[3 + i]) for i in range(3)]

    def over(self, deviations: list[Any]) -> list[Any]:
        """Squared residuals over deviations."""
        found = []
        for slope, read, deviation in zip(self.slopes, self.read, deviations, strict=True):
            shown = sum(a * b for a, b in zip(slope, self.parts, strict=True))
            found.append(((shown - read) / deviation) ** 2)
        return found

    def left(self) -> list[Any]:
        """Degrees of freedom that each number read has left."""
        return [
            1 - self.variance(slope) / deviation**2
            for slope, deviation in zip(self.slopes, self.deviations, strict=True)
        ]

    def variance(self, slope: list[Any]) -> Any:
        return sum(slope[i] * slope[j] * self.inverse[i, j] for i in range(6) for j in range(6))


def phased(plate: Plate, count: int) -> list[Phased]:
    """All harmonics; where they scatter more than stated, with grown deviations."""
    fits, growth = [Phased(plate, place) for place in range(count)], [mpf(1), mpf(1)]
    spare = sum(fit.spare for fit in fits)
    scatter = sum(sum(fit.over(fit.deviations)) for fit in fits)
    if beyond_chance(scatter, spare):
        for _ in range(20 if spare >= 6 else 0):
            over, left = (
                [sum(sum(part[i::2]) for part in parts) for i in range(2)]
                for parts in ([fit.over(fit.deviations) for fit in fits],
                              [fit.left() for fit in fits])
            )  # fmt: skip
            growth = [max(growth[i] * mp.sqrt(over[i] / left[i]), mpf(1)) for i in range(2)]
            for fit in fits:
                fit.grow(growth)
        if spare < 6:
            for fit in fits:
                fit.grow([mp.sqrt(scatter / spare)] * 2)
    for fit in fits:
        own = sum(fit.over(fit.deviations))
        if beyond_chance(own, fit.spare):
            fit.inverse *= own / fit.spare
    return fits


def beyond_chance(squares: Any, spare: int) -> bool:
    """Wilson and Hilferty's 95th percentile of chi squared."""
    bend = mpf(2) / (9 * spare) if spare else mpf(0)
    return spare > 0 and squares > spare * (1 - bend + mpf("1.645") * mp.sqrt(bend)) ** 3


def from_levels(plate: Plate, place: int, start: list[complex]) -> list[Any]:
    """Newton's method on the sum of squared residuals in dB, phase zero at the reference."""
    rows, sizes = plate.rows(), plate.sizes(place)
    unit = 20 / mp.log(10)
    motion = [mpmath.mpmathify(complex(u)) for u in start]
    turned = dot(plate.origin, motion)
    motion = [u * mp.conj(turned) / abs(turned) for u in motion]
    for _ in range(60):
        table, right = matrix(7, 7), matrix(7, 1)
        for row, size in zip(rows, sizes, strict=True):
            signal = dot(row, motion)
            residual = unit * mp.log(abs(signal) / size)
            slope = [unit * c / signal for c in row]
            first = [s.real for s in slope] + [-s.imag for s in slope]
            for i in range(6):
                right[i] -= residual * first[i]
                for j in range(6):
                    bend = -(slope[i % 3] * slope[j % 3]) / unit
                    part = (bend, mpc(0, 1) * bend, -bend)[(i > 2) + (j > 2)].real
                    table[i, j] += first[i] * first[j] + residual * part
        for i in range(3):
            table[6, 3 + i] = table[3 + i, 6] = plate.origin[i]
        right[6] = -dot(plate.origin, motion).imag
        try:
            step = mp.lu_solve(table, right)
        except ZeroDivisionError as error:
            raise ArithmeticError("flat") from error
        motion = [u + mpc(step[i], step[3 + i]) for i, u in enumerate(motion)]
        size = max(abs(u) for u in motion)
        if max(abs(step[i]) for i in range(6)) < size * mpf(10) ** (-0.7 * mp.dps):
            off = max(abs(u - mpmath.mpmathify(complex(s)))
                      for u, s in zip(motion, start, strict=True))  # fmt: skip
            if off > 1e-3 * size:
                raise ArithmeticError("another motion")
            return motion
    raise ArithmeticError("no convergence")


def truths(table: Table, record: Record) -> Iterator[tuple[str, Any, Any]]:
    """Path, values and truth."""
    plate, names = Plate(table), ("translation", "roll", "pitch")
    start = np.array([record[f"{ROOT}/{name}"].values for name in names])
    try:
        count = len(table["orders"])
        plate.fits = phased(plate, count) if plate.is_phased else []
        motions = [fit.motion for fit in plate.fits] or [
            from_levels(plate, place, start[:, place].tolist()) for place in range(count)
        ]
    except ArithmeticError:
        return
    units = [tuple(mpf(int(i == j)) for j in range(3)) for i in range(3)]

    def reported(name: str, truth: Any) -> Iterator[tuple[str, Any, Any]]:
        path = f"{ROOT}/{name}"
        if path in record:
            yield path, record[path].values, truth

    for name, row in zip(names, units, strict=True):
        values = [dot(row, motion) for motion in motions]
        scale = plate.reference if name == "translation" else plate.peak
        yield from reported(name, values)
        yield from reported(f"{name}_level", [plate.level(v, scale) for v in values])
        yield from reported(f"phase/{name}", [_phase(m, row, plate.origin) for m in motions])
        yield from reported(
            f"phase/{name}_to_translation", [_phase(m, row, units[0]) for m in motions]
        )
    rows = [plate.row(place) for place in plate.places.values()]
    for part, kept in PARTS.items():
        cut = [tuple(c * k for c, k in zip(row, kept, strict=True)) for row in rows]
        values = [[dot(row, m) for m in motions] for row in cut]
        yield from reported(f"level/{part}", [[plate.level(v) for v in row] for row in values])
        if part == "standard":
            yield from reported("acceleration", values)
            total = [mp.sqrt(sum(abs(v) ** 2 for v in row)) for row in values]
            yield from reported("level/all_orders", [plate.level(v) for v in total])
    yield from reported("frequency", [n * mpf(table["base_frequency"]) for n in table["orders"]])
    yield from _readings(plate, motions, reported)
    yield from _on_the_plate(record, motions, reported)
    if plate.is_phased:
        yield from _uncertain(plate, motions, rows, reported)
    else:
        yield from _candidates(plate, record, rows, reported)


def _phase(motion: list[Any], row: Row, other: Row) -> mpf:
    return mp.arg(dot(row, motion) * mp.conj(dot(other, motion)))


def _readings(plate: Plate, motions: list[Any], reported: Any) -> Iterator[tuple[str, Any, Any]]:
    read, computed, apart, misfit = [], [], [], []
    for place, motion in enumerate(motions):
        residuals = []
        for row, size in zip(plate.rows(), plate.sizes(place), strict=True):
            signal = dot(row, motion)
            read.append(plate.level(size))
            computed.append(plate.level(signal))
            residuals.append(computed[-1] - read[-1])
        count = len(residuals)
        if plate.is_phased:
            over = plate.fits[place].over(plate.fits[place].stated)
            apart += [mp.sqrt(a + b) for a, b in zip(over[::2], over[1::2], strict=True)]
        if plate.is_phased:
            spare, own = 2 * (count - 3), apart[-count:]
            misfit.append(mp.sqrt(sum(a * a for a in own) / spare) if spare else mpf(0))
        elif max(abs(r) for r in residuals) < _MET:
            misfit.append(mpf(0))
        else:
            half = mpf("0.05")
            squares = sum(r * r for r in residuals)
            misfit.append(squares / half / sum(abs(r) for r in residuals))
    yield from reported("reading/read", read)
    yield from reported("reading/computed", computed)
    yield from reported("reading/residual", [c - r for c, r in zip(computed, read, strict=True)])
    yield from reported("signal/residual", apart)
    yield from reported("fit/misfit", misfit)


def _on_the_plate(
    record: Record, motions: list[Any], reported: Any
) -> Iterator[tuple[str, Any, Any]]:
    shown = record[f"{ROOT}/map/amplitude"]
    y, x = ([mpf(float(v)) for v in axis.values] for axis in shown.axes[1:])
    maps = [[[abs(dot((1, b, -a), m)) for a in x] for b in y] for m in motions]
    yield from reported("map/amplitude", maps)
    total = [
        [mp.sqrt(sum(one[i][j] ** 2 for one in maps)) for j in range(len(x))] for i in range(len(y))
    ]
    yield from reported("map/all_orders", total)
    edge = (x[0], x[-1], y[0], y[-1])
    quiet = [quietest([m], *edge) for m in motions]
    for place, name in enumerate(("x", "y", "amplitude")):
        yield from reported(f"quiet/{name}", [one[place] for one in quiet])
    both = quietest(motions, *edge)
    for place, name in enumerate(("x", "y", "amplitude")):
        yield from reported(f"quiet/all_orders_{name}", both[place])


def quietest(motions: list[Any], x0: mpf, x1: mpf, y0: mpf, y1: mpf) -> tuple[mpf, mpf, mpf]:
    """Where the sum of |a_0 + y roll - x pitch|^2 is least within the edges."""

    def square(x: mpf, y: mpf) -> mpf:
        return sum(abs(dot((1, y, -x), m)) ** 2 for m in motions)

    xx, yy = sum(abs(m[2]) ** 2 for m in motions), sum(abs(m[1]) ** 2 for m in motions)
    xy = -sum((m[1] * mp.conj(m[2])).real for m in motions)
    ax = -sum((m[0] * mp.conj(m[2])).real for m in motions)
    ay = sum((m[0] * mp.conj(m[1])).real for m in motions)
    spots = []
    gap = xx * yy - xy * xy
    if gap > 0:
        x, y = (-ax * yy + ay * xy) / gap, (-ay * xx + ax * xy) / gap
        if x0 <= x <= x1 and y0 <= y <= y1:
            spots.append((x, y))
    for x in (x0, x1):
        spots.append((x, min(max(-(ay + xy * x) / yy, y0), y1)))
    for y in (y0, y1):
        spots.append((min(max(-(ax + xy * y) / xx, x0), x1), y))
    x, y = min(spots, key=lambda spot: square(*spot))
    return x, y, mp.sqrt(square(x, y))


def _uncertain(
    plate: Plate, motions: list[Any], rows: list[Row], reported: Any
) -> Iterator[tuple[str, Any, Any]]:
    """First order of linear least squares: covariance of the motion, then of each result."""
    fits = plate.fits

    def level(row: Row, place: int) -> mpf:
        slope = [20 / mp.log(10) * c / dot(row, motions[place]) for c in row]
        return mp.sqrt(fits[place].variance([s.real for s in slope] + [-s.imag for s in slope]))

    every = range(len(motions))
    units = [tuple(mpf(int(i == j)) for j in range(3)) for i in range(3)]
    for name, unit in zip(("translation", "roll", "pitch"), units, strict=True):
        yield from reported(f"uncertainty/{name}_level", [level(unit, place) for place in every])
        turns = []
        for place in every:
            own, other = (dot(row, motions[place]) for row in (unit, plate.origin))
            slope = [c / own - d / other for c, d in zip(unit, plate.origin, strict=True)]
            across = [s.imag for s in slope] + [s.real for s in slope]
            turns.append(mp.sqrt(fits[place].variance(across)))
        yield from reported(f"uncertainty/{name}_phase", turns)
    yield from reported(
        "uncertainty/level", [[level(row, place) for place in every] for row in rows]
    )


def _candidates(
    plate: Plate, record: Record, rows: list[Row], reported: Any
) -> Iterator[tuple[str, Any, Any]]:
    found = {
        key.removeprefix(f"{ROOT}/candidate/"): q.values
        for key, q in record.items() if key.startswith(f"{ROOT}/candidate/")
    }  # fmt: skip
    motions = []
    orders = list(plate.table["orders"])
    for which, order in enumerate(found["order"]):
        start = []
        for name in ("translation", "roll", "pitch"):
            scale = plate.reference if name == "translation" else plate.peak
            size = float(scale) * 10.0 ** (found[f"{name}_level"][which] / 20.0)
            start.append(complex(size * np.exp(1j * found[f"{name}_phase"][which])))
        try:
            motions.append(from_levels(plate, orders.index(int(order)), start))
        except ArithmeticError:
            return
    units = [tuple(mpf(int(i == j)) for j in range(3)) for i in range(3)]
    for name, unit in zip(("translation", "roll", "pitch"), units, strict=True):
        scale = plate.reference if name == "translation" else plate.peak
        levels = [plate.level(dot(unit, m), scale) for m in motions]
        yield from reported(f"candidate/{name}_level", levels)
        yield from reported(
            f"candidate/{name}_phase", [_phase(m, unit, plate.origin) for m in motions]
        )
    yield from reported(
        "candidate/level", [[plate.level(dot(r, m)) for r in rows] for m in motions]
    )
    worst = []
    for motion, order in zip(motions, found["order"], strict=True):
        sizes = plate.sizes(orders.index(int(order)))
        levels = [
            plate.level(dot(r, motion)) - plate.level(s)
            for r, s in zip(plate.rows(), sizes, strict=True)
        ]
        worst.append(max(abs(x) for x in levels))
    yield from reported("candidate/worst_residual", worst)
    yield from _further(plate, record, motions, found, reported)


def _further(
    plate: Plate, record: Record, motions: list[Any], found: dict[str, Any], reported: Any
) -> Iterator[tuple[str, Any, Any]]:
    apart = []
    for words in record[f"{ROOT}/further/difference"].axes[0].values:
        order, name = str(words).split(": ")
        if name.startswith("at "):
            row = plate.row(plate.places[name.removeprefix("at ")])
        else:
            (x1, y1), (x2, y2) = (plate.places[n] for n in name.split()[1::2])
            row = (mpf(0), y2 - y1, x1 - x2)
        own = [m for m, n in zip(motions, found["order"], strict=True) if int(n) == int(order)]
        first, other = (plate.level(dot(row, m)) for m in own[:2])
        apart.append(first - other)
    yield from reported("further/difference", apart)
