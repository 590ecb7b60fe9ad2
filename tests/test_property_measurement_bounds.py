"""Claim: the truth lies within the stated bound of a level, at the fold too.

Truth: plates made at random, whose levels are rounded to a tenth of a dB; a dense search of the
rounding; the closed form of three phasors.
"""

from functools import cache
from itertools import product

import numpy as np
import pytest
from plate_readings import random_plate

from vibecalc.measurement.choosing import choose, extremes, reach
from vibecalc.measurement.level_motions import level_motions
from vibecalc.measurement.plate import difference_row, point_row
from vibecalc.numerics.level import DECIBEL

HALF = 0.05 + 1e-9
CORNERS = np.array([(0.6, -0.3), (0.6, 0.3), (-0.6, -0.3), (-0.6, 0.3), (0.05, 0.25), (0.1, -0.2)])
POINTS = point_row(*CORNERS.T)
SETS = (
    np.vstack([POINTS[:3], *(difference_row(CORNERS[:1], CORNERS[n : n + 1]) for n in (1, 2))]),
    POINTS,
    np.vstack([POINTS[:4], difference_row(CORNERS[:1], CORNERS[3:4])]),
    POINTS[:5],
)


def db(signal):
    return DECIBEL * np.log(np.abs(signal))


def made(number):
    """Rows, amplitudes rounded to .1 dB, and the motion of one of a row of plates."""
    random = np.random.default_rng([7, number])
    parts = random.normal(size=(3, 2)) * np.array([[1.0], [3.0], [1.5]])
    motion, rows = parts[:, 0] + 1j * parts[:, 1], SETS[number % 4]
    return rows, np.exp(np.round(db(rows @ motion), 1) / DECIBEL), motion


@cache
def solved(number):
    rows, amplitudes, _ = made(number)
    widths = np.full(len(rows), HALF)
    found = level_motions(rows, amplitudes, widths, rows[0], widths / 3.0**0.5)
    return found, reach(rows, amplitudes, widths)


@pytest.mark.long
@pytest.mark.parametrize(
    ("first", "count"),
    [(0, 4), *((first, 12) for first in range(0, 60, 12))],
)
def test_the_truth_is_within_the_bound_of_a_candidate(first, count):
    """All levels of one candidate hold at once; of every candidate, where they are one family."""
    for number in range(first, first + count):
        motion, (found, bounds) = made(number)[2], solved(number)
        none = np.zeros((0, 3)), np.zeros(0), np.zeros(0)
        decided = choose(found, *none, bounds).decided
        holds = [
            bool(
                np.all(
                    np.abs(db(POINTS @ one.motion) - db(POINTS @ motion))
                    <= bounds.bound(one, POINTS) + 1e-9
                )
            )
            for one in found
        ]
        assert any(holds), number
        if bounds.folded:
            assert all(holds), number
            assert not decided
        if decided:
            assert holds[0], number


def triangle(gap):
    """Three points and two differences; 1, 2 and their difference lack `gap` to be in line."""
    one, two, five = CORNERS[0], CORNERS[1], CORNERS[2]
    rows = np.stack(
        [point_row(*place) for place in (one, two, five)]
        + [difference_row(one, two), difference_row(one, five)]
    )
    return rows, np.array([1.0, 1.4 * (1.0 - gap), 0.9, 0.4, 0.7])


def fourth(sizes):
    """Both amplitudes at the fourth corner by the law of cosines; none where it does not close."""
    first, second, third, across, along = sizes
    cosines = (
        (second**2 - first**2 - across**2) / (2.0 * first * across),
        (third**2 - first**2 - along**2) / (2.0 * first * along),
    )
    if max(map(abs, cosines)) > 1.0:
        return []
    turns = np.arccos(cosines)
    return [
        abs(first + across * np.exp(1j * turns[0]) + side * along * np.exp(1j * s * turns[1]))
        for side, s in ((1.0, 1.0), (1.0, -1.0))
    ]


@pytest.mark.parametrize("gap", [0.0, pytest.param(1e-3, marks=pytest.mark.long), 3e-3])
def test_the_family_is_no_larger_than_it_is(gap):
    """Extremes against a dense search of the rounding."""
    rows, sizes = triangle(gap)
    widths = np.full(5, HALF)
    found = extremes(rows, sizes, widths, POINTS[3:4])
    assert found is not None
    steps = np.linspace(-1.0, 1.0, 5) * HALF / DECIBEL
    seen = [
        size for move in product(steps, repeat=5) for size in fourth(sizes * np.exp(np.array(move)))
    ]
    assert found.low[0] <= min(seen) and max(seen) <= found.high[0]
    assert found.low[0] == pytest.approx(min(seen), rel=2e-3)
    assert found.high[0] == pytest.approx(max(seen), rel=2e-3)
    assert reach(rows, sizes, widths).folded


def test_levels_that_no_motion_has_bound_nothing():
    rows, sizes = triangle(-0.1)
    assert extremes(rows, sizes, np.full(5, HALF), POINTS) is None


def test_away_from_the_fold_the_bound_is_that_of_the_worst_readings():
    """Moved at random within their rounding, five levels stay within it and come near to it."""
    plate = random_plate(3, 5, 0)
    widths = np.full(5, HALF)
    found = level_motions(plate.rows, plate.amplitudes, widths, plate.rows[0], widths)
    bounds = reach(plate.rows, plate.amplitudes, widths)
    assert not bounds.folded
    random = np.random.default_rng(5)
    moves = random.choice([-1.0, 1.0], size=(60, 5)) * random.uniform(0.8, 1.0, (60, 1)) * HALF
    worst = np.zeros((len(found), len(POINTS)))
    for move in moves:
        sizes = plate.amplitudes * np.exp(move / DECIBEL)
        others = level_motions(plate.rows, sizes, widths, plate.rows[0], widths)
        off = np.array(
            [[db(POINTS @ o.motion) - db(POINTS @ f.motion) for o in others] for f in found]
        )
        near = np.argmin(np.max(np.abs(off), axis=2), axis=1)
        worst = np.maximum(worst, np.abs(off[np.arange(len(found)), near]))
    for one, largest in zip(found, worst, strict=True):
        bound = bounds.bound(one, POINTS)
        assert np.all(largest <= bound + 1e-9)
        assert np.all(largest > 0.6 * bound)
