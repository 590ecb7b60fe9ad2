"""Claim: both ends of a line of second moments are found from any five levels, to rounding.

Ends are held against roots of the determinant in 40 digits, on random planes and on those whose
two ends nearly meet. Where the line misses the semidefinite matrices the nearest approach is found.
"""

import mpmath
import numpy as np
import pytest
from plate_readings import source_rows

from vibecalc.measurement.plate import scaled
from vibecalc.measurement.second_moments import Line, ends, least_determined
from vibecalc.numerics.rounding import EPSILON


def moments(motion: np.ndarray) -> np.ndarray:
    return np.real(np.outer(motion, np.conj(motion)))


def rows_of(draw: np.random.Generator, number: int) -> np.ndarray:
    """Every fourth time the instruments of the source, else any."""
    rows = scaled(source_rows(), 0.3) if number % 4 == 0 else draw.standard_normal((5, 3))
    return np.asarray(rows)


def root_nearby(line: Line, place: float) -> float:
    """Distance to the root of det(G_0 + t N) next to a place, by Newton's method in 40 digits."""
    with mpmath.workdps(40):
        at, step = mpmath.mpf(place), mpmath.mpf(1)
        g, n = ([[mpmath.mpf(x) for x in row] for row in part.tolist()] for part in line)
        for _ in range(6):
            m = [[g[i][j] + at * n[i][j] for j in range(3)] for i in range(3)]
            cofactor = [
                [
                    m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
                    - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
                    for j in range(3)
                ]
                for i in range(3)
            ]
            value = sum(m[0][j] * cofactor[0][j] for j in range(3))
            slope = sum(n[i][j] * cofactor[i][j] for i in range(3) for j in range(3))
            step = value / slope
            at -= step
            if abs(step) < mpmath.mpf(10) ** -30 * abs(at):
                break
        return float(abs(at - mpmath.mpf(place)))


def place_of(line: Line, motion: np.ndarray) -> float:
    return float(np.sum((moments(motion) - line.origin) * line.direction))


def missed(line: Line, motion: np.ndarray) -> float:
    """How far the moments of a motion are off the line, over their size."""
    at = line.origin + place_of(line, motion) * line.direction
    return float(np.max(np.abs(moments(motion) - at)) / np.max(np.abs(at)))


@pytest.mark.parametrize(
    ("planes", "every"), [(500, 10), pytest.param(2000, 1, marks=pytest.mark.long)]
)
def test_ends_are_roots_in_forty_digits(planes: int, every: int) -> None:
    """On random planes, every so many held against 40 digits, which take most of the time."""
    draw = np.random.default_rng(1977)
    for number in range(planes):
        rows = rows_of(draw, number)
        motion = draw.standard_normal(3) + 1j * draw.standard_normal(3)
        line = least_determined(rows, np.abs(rows @ motion))
        found = ends(line)
        assert len(found) == 2
        for one in found:
            assert missed(line, one) < 64.0 * EPSILON
            values, vectors = np.linalg.eigh(moments(one))
            slope = abs(vectors[:, 0] @ line.direction @ vectors[:, 0])
            size = abs(values[2]) + abs(place_of(line, one))
            if number % every == 0:
                assert root_nearby(line, place_of(line, one)) < 64.0 * EPSILON * size / slope
        # one of them is the motion that the levels are those of
        apart = min(np.max(np.abs(moments(one) - moments(motion))) for one in found)
        assert apart < 1e-7 * np.max(np.abs(moments(motion)))


@pytest.mark.parametrize("aside", [1e-2, 1e-4, 1e-6, 1e-8, 0.0])
def test_ends_that_nearly_meet(aside: float) -> None:
    """Of a motion that is nearly in line: both ends within their levels, however close."""
    draw = np.random.default_rng(5)
    for number in range(40):
        rows = rows_of(draw, number)
        motion = draw.standard_normal(3) + 1j * aside * draw.standard_normal(3)
        amplitudes = np.abs(rows @ motion)
        line = least_determined(rows, amplitudes)
        found = ends(line)
        assert len(found) == 2 or aside < 1e-4
        for one in found:
            # where the line misses by rounding, as squares of what is aside are below it
            assert missed(line, one) < 64.0 * EPSILON or (len(found) == 1 and aside < 1e-4)
        apart = min(np.max(np.abs(moments(one) - moments(motion))) for one in found)
        # a double root moves by the root of rounding
        assert apart < 1e-5 * np.max(np.abs(line.origin)) * max(1.0, np.max(np.abs(motion)) ** 2)


@pytest.mark.parametrize("aside", [1e-6, 1e-8, 0.0])
def test_the_last_bits_of_a_line_do_not_decide_whether_its_ends_are_found(aside: float) -> None:
    """As other processors round otherwise: near a double root every end stays within its levels."""
    draw = np.random.default_rng(104)
    for number in range(60):
        rows = rows_of(draw, number)
        motion = draw.standard_normal(3) + 1j * aside * draw.standard_normal(3)
        line = least_determined(rows, np.abs(rows @ motion))
        bits = np.triu(draw.integers(-2, 3, (3, 3)))
        moved = line._replace(origin=line.origin * (1.0 + EPSILON * (bits + np.triu(bits, 1).T)))
        found = ends(moved)
        assert all(missed(moved, one) < 64.0 * EPSILON for one in found) or len(found) == 1


def test_a_line_that_misses_ends_in_its_nearest_approach() -> None:
    draw, misses = np.random.default_rng(9), 0
    for number in range(120):
        rows = rows_of(draw, number)
        motion = draw.standard_normal(3) + 1j * draw.standard_normal(3)
        read = np.abs(rows @ motion) * np.exp(0.6 * draw.standard_normal(5))
        line = least_determined(rows, read)
        found = ends(line)
        size = np.linalg.norm(line.origin)
        places = size * np.tan(np.linspace(-1.5, 1.5, 801))
        lowest = np.linalg.eigvalsh(line.origin + places[:, None, None] * line.direction)[:, 0]
        if len(found) == 2:
            middle = 0.5 * sum(place_of(line, one) for one in found)
            inside = np.linalg.eigvalsh(line.origin + middle * line.direction)
            assert inside[0] > 0.0
            continue
        misses += 1
        assert np.max(lowest) <= 1e-12 * size
        # the motion is the nearest one to the matrix with the largest lowest eigenvalue
        best = line.origin + places[np.argmax(lowest)] * line.direction
        top = np.linalg.eigvalsh(best)
        assert np.max(np.abs(moments(found[0]) - best)) < 0.05 * size + 2.0 * abs(top[0])
    assert 20 < misses < 115
