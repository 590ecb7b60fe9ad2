"""Accuracy of the motion of a plate from its readings, against other ways to solve for it."""

from collections.abc import Callable
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.measurement.choosing import choose
from vibecalc.measurement.complex_motion import (
    Phasors,
    along_and_across,
    complex_motion,
    growth_of_deviations,
)
from vibecalc.measurement.level_motions import NEEDED, level_motions, lines, refine
from vibecalc.measurement.model import Harmonic, build_harmonics, position_rows, reference_row
from vibecalc.measurement.plate import scaled, span_of
from vibecalc.measurement.second_moments import counted_ends
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# The motion of a plate from levels: second moments, least squares from anywhere, phases by hand.
#
# Levels leave a common phase and the sign of all phases open. Every way here ends with the motion
# whose signal is real at the place that phases refer to, and turned to the side that vibecalc
# takes.
# ----------------------------------------------------------------------------

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

    Motions that meet the levels alike are distinguished by the choosing readings.
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


def levels_in_digits(given: Levels, near: ComplexArray) -> ComplexArray | None:
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
                work += refine(plain, heights, half_widths, motion).evaluations
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
    reported = np.flatnonzero(np.abs(sides) > 1e-12 * np.max(np.abs(turned)))
    mirrored = bool(reported.size and sides[reported[0]] < 0.0)
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


# ----------------------------------------------------------------------------
# The motion of a plate from complex amplitudes: weighted least squares, done in several ways.
# ----------------------------------------------------------------------------

_PHASES_DIGITS = 40


def by_singular_values(given: Phasors) -> ComplexArray:
    """As a run does: scaled by the largest lever, by singular values."""
    return complex_motion(given).motion


def by_lstsq(given: Phasors) -> ComplexArray:
    """numpy's least squares, one unit next to another."""
    return _motion(np.linalg.lstsq(*_weighed(given), rcond=None)[0])


def by_normal_equations(given: Phasors) -> ComplexArray:
    """The textbook's way, which squares the condition number."""
    left, right = _weighed(given)
    return _motion(np.linalg.solve(left.T @ left, left.T @ right))


def _weighed(given: Phasors) -> tuple[FloatArray, FloatArray]:
    """Rows (2 r, 6) on the parts of the motion, and what is read, both over deviations."""
    weights = 1.0 / np.ravel(given.deviations)
    read = np.concatenate([np.abs(given.readings), np.zeros(len(given.rows))])
    return along_and_across(given.rows, given.readings) * weights[:, None], read * weights


def _motion(parts: NDArray[np.floating[Any]]) -> ComplexArray:
    return np.asarray(parts[:3] + 1j * parts[3:])


def phases_in_digits(given: Phasors) -> ComplexArray:
    """The same in 40 digits, of which the squares may well take half."""
    import mpmath as mp

    with mp.workdps(_PHASES_DIGITS):
        left, right = mp.matrix(6, 6), mp.matrix(6, 1)
        for row, reading, deviations in zip(
            given.rows, given.readings, given.deviations.T, strict=True
        ):
            phasor = mp.mpc(complex(reading))
            unit = phasor / abs(phasor) if phasor else mp.mpf(1)
            entries = [mp.mpf(float(c)) for c in row]
            along = [c * unit.real for c in entries] + [c * unit.imag for c in entries]
            across = [-c * unit.imag for c in entries] + [c * unit.real for c in entries]
            for slopes, read, deviation in (
                (along, abs(phasor), deviations[0]), (across, mp.mpf(0), deviations[1]),
            ):  # fmt: skip
                weight = 1 / mp.mpf(float(deviation)) ** 2
                for i, c in enumerate(slopes):
                    right[i] += weight * c * read
                    for j, d in enumerate(slopes):
                        left[i, j] += weight * c * d
        found = mp.lu_solve(left, right)
        return np.array([complex(found[k] + 1j * found[3 + k]) for k in range(3)])


# ----------------------------------------------------------------------------
# Topics of the measurement: the motion of a plate from its readings, as signals at its places.
# ----------------------------------------------------------------------------

#: starts of least squares while its tolerance is stepped, and its tolerance while starts are
_STARTS, _TOLERANCE = 4, 1e-8
#: a line, three eigenproblems and a look at either motion, over two small systems
_EXTRA = 4.0
#: corners at which a plate without named positions is examined, m
_CORNERS = np.array([[1.0, 0.5, 0.5], [1.0, -0.5, 0.5], [1.0, 0.5, -0.5]])


def measurement_topics(scene: Scene) -> list[Topic]:
    """What [measurement] asks, harmonics with levels and with phases apart; none without it."""
    table = scene.case.measurement
    if table is None:
        return []
    reference = reference_row(table)
    rows = position_rows(table) if table.positions else _CORNERS
    harmonics = build_harmonics(table)
    plain = tuple(one for one in harmonics if not one.is_complex)
    complex_ = tuple(one for one in harmonics if one.is_complex)
    found = [_of_levels(plain, reference, rows)] if plain else []
    return found + ([_of_phases(complex_, rows)] if complex_ else [])


def _of_levels(harmonics: tuple[Harmonic, ...], reference: FloatArray, rows: FloatArray) -> Topic:
    given = [levels_of(one, reference) for one in harmonics]

    def each(solve: Callable[[Levels], Solved]) -> Answer:
        found = [solve(one) for one in given]
        values = np.stack([rows @ one.motion for one in found], axis=-1)
        return Answer(values, sum(one.work for one in found))

    solvers = [
        Solver(
            "second moments",
            "all motions that the levels leave, as ends of a line, each refined; as a run does",
            "", NOTHING_TO_SET, lambda _: each(by_moments), default=NOTHING_TO_SET[0],
            citation="docs/theory_measurement.md",
        ),
        Solver(
            "least squares, more starts", "scipy least_squares from random motions",
            "starts", (1.0, 2.0, 4.0, 8.0),
            lambda starts: each(lambda one: by_least_squares(one, int(starts), _TOLERANCE)),
        ),
        Solver(
            "least squares, closer", f"the same from {_STARTS} motions, to a closer tolerance",
            "tolerance", (1e-1, 1e-2, 1e-4, 1e-8, 1e-12),
            lambda tolerance: each(
                lambda one: by_least_squares(one, _STARTS, tolerance)
            ),
        ),
    ]  # fmt: skip
    if all(suits_cosines(one) for one in given):
        solvers.append(
            Solver(
                "phases by cosines", "three points and two differences, as published",
                "", NOTHING_TO_SET, lambda _: each(by_cosines),
                citation="Herold (1977), equations 20 to 33",
            )
        )  # fmt: skip
    return Topic(
        stage="measurement",
        name="motion from levels",
        words=f"signals at {len(rows)} places of the motion that the levels leave",
        quantity="measurement/acceleration",
        unit="m/s^2",
        work="evaluations of all readings of a motion, or systems as small",
        reference=lambda: _levels_reference(given, rows),
        solvers=tuple(solvers),
        default_extra=_EXTRA,
        default_why="a line of second moments with both its ends, where three points and two "
        "differences leave two cosines: it takes any instruments, and finds every motion that five "
        "or more levels leave, or says that none has them",
    )


def _levels_reference(given: list[Levels], rows: FloatArray) -> Reference:
    exact: list[ComplexArray] = []
    apart = 0.0
    for one in given:
        near = by_moments(one).motion
        found = levels_in_digits(one, near)
        if found is None:
            found = near
            other = by_least_squares(one, 2 * _STARTS, 1e-15).motion
            apart = max(apart, float(np.max(np.abs(rows @ (other - near)))))
        exact.append(found)
    values = np.stack([rows @ motion for motion in exact], axis=-1)
    largest = float(np.max(np.abs(values)))
    words = "Newton's method on the squares of the levels in 40 digits"
    if apart > 0.0:
        words += "; with more than five levels scipy least_squares to 1e-15"
    return Reference(values, max(apart / largest, 16.0 * EPSILON), words)


def _of_phases(harmonics: tuple[Harmonic, ...], rows: FloatArray) -> Topic:
    given = [one.phasors for one in harmonics]
    growth = growth_of_deviations(given)[:, None]
    given = [one._replace(deviations=one.deviations * growth) for one in given]

    def each(solve: Callable[[Phasors], ComplexArray]) -> Answer:
        values = np.stack([rows @ solve(one) for one in given], axis=-1)
        return Answer(values, float(len(given)))

    ways = (
        ("singular values", "weighted least squares; as a run does", by_singular_values),
        ("numpy.linalg.lstsq", "the same by LAPACK, unscaled", by_lstsq),
        ("normal equations", "A' W A u = A' W y", by_normal_equations),
    )
    return Topic(
        stage="measurement",
        name="motion from phasors",
        words=f"signals at {len(rows)} places of the motion fitted to complex amplitudes",
        quantity="measurement/acceleration",
        unit="m/s^2",
        work="solved systems",
        reference=lambda: Reference(
            each(phases_in_digits).values, 16.0 * EPSILON, "normal equations in 40 digits"
        ),
        solvers=tuple(
            Solver(
                name, words, "", NOTHING_TO_SET, lambda _, way=way: each(way),  # type: ignore[misc]
                default=NOTHING_TO_SET[0] if way is by_singular_values else None,
            )
            for name, words, way in ways
        ),
    )  # fmt: skip
