"""Topics of the measurement: the motion of a plate from its readings, as signals at its places."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks import plate_levels as levels
from vibecalc.accuracy.yardsticks import plate_phases as phases
from vibecalc.machine.measurement import Harmonic, build_harmonics, position_rows, reference_row
from vibecalc.measurement.complex_motion import Phasors, growth_of_deviations
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene

#: starts of least squares while its tolerance is stepped, and its tolerance while starts are
_STARTS, _TOLERANCE = 4, 1e-8
#: a line, three eigenproblems and a look at either motion, over two small systems
_EXTRA = 4.0
#: corners at which a plate without named positions is looked at, m
_CORNERS = np.array([[1.0, 0.5, 0.5], [1.0, -0.5, 0.5], [1.0, 0.5, -0.5]])


def topics(scene: Scene) -> list[Topic]:
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
    given = [levels.levels_of(one, reference) for one in harmonics]

    def each(solve: Callable[[levels.Levels], levels.Solved]) -> Answer:
        found = [solve(one) for one in given]
        values = np.stack([rows @ one.motion for one in found], axis=-1)
        return Answer(values, sum(one.work for one in found))

    ladders = [
        Ladder(
            "second moments",
            "all motions that the levels leave, as ends of a line, each refined; as a run does",
            "", NOTHING_TO_SET, lambda _: each(levels.by_moments), default=NOTHING_TO_SET[0],
            citation="docs/theory_measurement.md",
        ),
        Ladder(
            "least squares, more starts", "scipy least_squares from random motions",
            "starts", (1.0, 2.0, 4.0, 8.0),
            lambda starts: each(lambda one: levels.by_least_squares(one, int(starts), _TOLERANCE)),
        ),
        Ladder(
            "least squares, closer", f"the same from {_STARTS} motions, to a closer tolerance",
            "tolerance", (1e-1, 1e-2, 1e-4, 1e-8, 1e-12),
            lambda tolerance: each(
                lambda one: levels.by_least_squares(one, _STARTS, tolerance)
            ),
        ),
    ]  # fmt: skip
    if all(levels.suits_cosines(one) for one in given):
        ladders.append(
            Ladder(
                "phases by cosines", "three points and two differences, as published",
                "", NOTHING_TO_SET, lambda _: each(levels.by_cosines),
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
        ladders=tuple(ladders),
        default_extra=_EXTRA,
        default_why="a line of second moments with both its ends, where three points and two "
        "differences leave two cosines: it takes any instruments, and finds every motion that five "
        "or more levels leave, or says that none has them",
    )


def _levels_reference(given: list[levels.Levels], rows: FloatArray) -> Reference:
    exact: list[ComplexArray] = []
    apart = 0.0
    for one in given:
        near = levels.by_moments(one).motion
        found = levels.in_digits(one, near)
        if found is None:
            found = near
            other = levels.by_least_squares(one, 2 * _STARTS, 1e-15).motion
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
        ("singular values", "weighted least squares; as a run does", phases.by_singular_values),
        ("numpy.linalg.lstsq", "the same by LAPACK, unscaled", phases.by_lstsq),
        ("normal equations", "A' W A u = A' W y", phases.by_normal_equations),
    )
    return Topic(
        stage="measurement",
        name="motion from phasors",
        words=f"signals at {len(rows)} places of the motion fitted to complex amplitudes",
        quantity="measurement/acceleration",
        unit="m/s^2",
        work="solved systems",
        reference=lambda: Reference(
            each(phases.in_digits).values, 16.0 * EPSILON, "normal equations in 40 digits"
        ),
        ladders=tuple(
            Ladder(
                name, words, "", NOTHING_TO_SET, lambda _, way=way: each(way),  # type: ignore[misc]
                default=NOTHING_TO_SET[0] if way is phases.by_singular_values else None,
            )
            for name, words, way in ways
        ),
    )  # fmt: skip
