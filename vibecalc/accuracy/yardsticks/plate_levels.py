"""The motion of a plate from levels: second moments, least squares from anywhere, phases by hand.

Levels leave a common phase and the sign of all phases open. Every way here ends with the motion
whose signal is real at the place that phases refer to, and turned to the side that vibecalc takes.
"""

from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.machine.measurement import Harmonic
from vibecalc.measurement.choosing import choose
from vibecalc.measurement.cone_ends import counted_ends
from vibecalc.measurement.level_fit import refine
from vibecalc.measurement.level_motions import NEEDED, level_motions, lines
from vibecalc.measurement.rigid_plate import scaled, span_of
from vibecalc.numerics.typing import ComplexArray, FloatArray

#: systems that the line of second moments takes: a point of it and its direction
_LINE = 2
#: dB; a sum of squares of residuals below it is that of a motion which has all levels
_MET = 1e-3
_DECIBEL = 20.0 / np.log(10.0)
_SEED, _DIGITS = 1977, 40
_SMALL = 1e-300


class Levels(NamedTuple):
    """Rows (r, 3), amplitudes and half widths (r,) to solve; rows and amplitudes to choose by.

    `moments_work` is that of the way by moments, counted beforehand so that it takes no time in it.
    """

    rows: FloatArray
    amplitudes: FloatArray
    half_widths: FloatArray
    others: FloatArray
    heights: FloatArray
    reference: FloatArray
    moments_work: float


class Solved(NamedTuple):
    """Motion (3,) and what it took: evaluations of all readings, or systems of that size."""

    motion: ComplexArray
    work: float


def levels_of(harmonic: Harmonic, reference: FloatArray) -> Levels:
    """What one harmonic reads in levels."""
    solving = harmonic.solving
    others = [read for read in harmonic.reads if read.use == "choose" and read.phase is None]
    rows = np.array([read.row for read in solving])
    amplitudes = np.array([read.amplitude for read in solving])
    half_widths = np.array([read.half_width for read in solving])
    return Levels(
        rows,
        amplitudes,
        half_widths,
        np.array([read.row for read in others]).reshape(-1, 3),
        np.array([read.amplitude for read in others]),
        reference,
        _moments_work(rows, amplitudes, half_widths),
    )


def by_moments(given: Levels) -> Solved:
    """All motions that the levels leave, chosen among as a run does."""
    found = level_motions(
        given.rows, given.amplitudes, given.half_widths, given.reference, given.half_widths
    )
    widths = np.full(len(given.others), float(np.max(given.half_widths)))
    ranking = choose(found, given.others, given.heights, widths).ranking
    return Solved(_turned(given, found[ranking[0]].motion), given.moments_work)


def by_least_squares(given: Levels, starts: int, tolerance: float) -> Solved:
    """scipy's least squares of the residuals in dB from random starts; the best of what it finds.

    Motions that meet the levels alike are told apart by the choosing readings.
    """
    from scipy.optimize import least_squares

    span, size = span_of(given.rows), float(np.max(given.amplitudes))
    units = size / np.array([1.0, span, span])
    draw = np.random.default_rng(_SEED)

    def off(x: FloatArray) -> FloatArray:
        signal = np.abs(given.rows @ ((x[:3] + 1j * x[3:]) * units))
        level = _DECIBEL * np.log(np.maximum(signal, _SMALL) / given.amplitudes)
        return np.asarray(level / given.half_widths)

    kept: list[tuple[float, float, ComplexArray]] = []
    work = 0.0
    for _ in range(starts):
        found = least_squares(
            off, draw.standard_normal(6), ftol=tolerance, xtol=tolerance, gtol=tolerance
        )
        # the derivatives by differences are not in scipy's count
        work += float(found.nfev + 6 * (found.njev or 0))
        motion = (found.x[:3] + 1j * found.x[3:]) * units
        kept.append((float(found.cost), _missed(given, motion), motion))
    least = min(cost for cost, _, _ in kept)
    equal = [row for row in kept if row[0] <= 2.0 * least + _MET]
    _, _, best = min(equal, key=lambda row: (row[1], row[0]))
    return Solved(_turned(given, best), work)


def by_cosines(given: Levels) -> Solved:
    """Phases of two points against a third from the levels of the differences, as published.

    Raises NumericalFailure where the levels contradict each other. `suits_cosines` says for which
    readings this works.
    """
    places = _arranged(given.rows)
    if places is None:
        raise NumericalFailure("not three points and the differences to one of them")
    first, one, other, to_one, to_other = places
    a = given.amplitudes
    turns = []
    for point, difference in ((one, to_one), (other, to_other)):
        cosine = (a[first] ** 2 + a[point] ** 2 - a[difference] ** 2) / (2 * a[first] * a[point])
        if abs(cosine) > 1.0:
            raise NumericalFailure(f"the cosine of a phase is {cosine:.4g}: no plate moves so")
        turns.append(float(np.arccos(cosine)))
    rows, candidates = given.rows[[first, one, other]], []
    for sign in (1.0, -1.0):
        phases = np.exp(1j * np.array([0.0, turns[0], sign * turns[1]]))
        motion = np.asarray(np.linalg.solve(rows, a[[first, one, other]] * phases), dtype=complex)
        candidates.append((_missed(given, motion), motion))
    best = min(candidates, key=lambda row: row[0])[1]
    return Solved(_turned(given, best), 2.0)


def suits_cosines(given: Levels) -> bool:
    """Whether three points and the differences of two of them to the third are read."""
    return _arranged(given.rows) is not None


def in_digits(given: Levels, near: ComplexArray) -> ComplexArray | None:
    """The motion that has five levels exactly, by Newton's method in 40 digits; None for more."""
    if len(given.rows) != NEEDED:
        return None
    import mpmath as mp

    with mp.workdps(_DIGITS):
        rows = [[mp.mpf(float(x)) for x in row] for row in given.rows]
        squares = [mp.mpf(float(a)) ** 2 for a in given.amplitudes]
        reference = [mp.mpf(float(x)) for x in given.reference]
        x = [mp.mpf(float(v)) for v in (*near.real, *near.imag)]
        for _ in range(6):
            matrix, right = _equations(mp, rows, squares, reference, x)
            step = mp.lu_solve(matrix, right)
            x = [value - change for value, change in zip(x, step, strict=True)]
        return np.array([complex(x[k], x[k + 3]) for k in range(3)])


def _moments_work(rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray) -> float:
    """Of each line its making and its ends, and of each end every look of its refinement."""
    plain, heights = scaled(rows, span_of(rows)), amplitudes / float(np.max(amplitudes))
    work = 0
    for line in lines(plain, heights):
        found = counted_ends(line)
        work += _LINE + found.solved
        for motion in found.motions:
            try:
                work += refine(plain, heights, half_widths, motion).looks
            except NumericalFailure:
                continue
    return float(work)


def _equations(mp: Any, rows: Any, squares: Any, reference: Any, x: Any) -> tuple[Any, Any]:
    """Jacobian (6, 6) and values (6): five squared amplitudes, and no phase at the reference."""
    matrix, right = mp.matrix(6, 6), mp.matrix(6, 1)
    for place, (row, square) in enumerate(zip(rows, squares, strict=True)):
        real = sum(c * v for c, v in zip(row, x[:3], strict=True))
        imaginary = sum(c * v for c, v in zip(row, x[3:], strict=True))
        right[place] = (real**2 + imaginary**2) / square - 1
        for k, c in enumerate(row):
            matrix[place, k], matrix[place, k + 3] = (
                2 * c * real / square,
                2 * c * imaginary / square,
            )
    right[5] = sum(c * v for c, v in zip(reference, x[3:], strict=True))
    for k, c in enumerate(reference):
        matrix[5, k + 3] = c
    return matrix, right


def _missed(given: Levels, motion: ComplexArray) -> float:
    """Largest residual at the choosing readings, dB; zero without any."""
    if not len(given.others):
        return 0.0
    size = np.maximum(np.abs(given.others @ motion), _SMALL)
    return float(np.max(np.abs(_DECIBEL * np.log(size / given.heights))))


def _turned(given: Levels, motion: ComplexArray) -> ComplexArray:
    """Real at the reference; of a motion and its mirror image the one whose roll leads."""
    signal = complex(given.reference @ motion)
    turned = motion * np.conj(signal / abs(signal))
    sides = turned.imag[[1, 2, 0]]
    told = np.flatnonzero(np.abs(sides) > 1e-12 * np.max(np.abs(turned)))
    mirrored = bool(told.size and sides[told[0]] < 0.0)
    return np.asarray(np.conj(turned) if mirrored else turned)


def _arranged(rows: FloatArray) -> tuple[int, ...] | None:
    """Places of a point, of two others, and of the differences between them and it."""
    points = [k for k, row in enumerate(rows) if row[0] == 1.0]
    differences = [k for k, row in enumerate(rows) if row[0] == 0.0]
    if len(points) != 3 or len(differences) != 2:
        return None
    for first, one, other in permutations(points):
        for to_one, to_other in permutations(differences):
            if _between(rows, first, one, to_one) and _between(rows, first, other, to_other):
                return first, one, other, to_one, to_other
    return None


def _between(rows: FloatArray, first: int, second: int, difference: int) -> bool:
    way = rows[second] - rows[first]
    size = 1e-12 * float(np.max(np.abs(way)))
    return any(np.max(np.abs(sign * way - rows[difference])) <= size for sign in (1.0, -1.0))
