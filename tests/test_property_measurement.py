"""Claim: uncertainties bound what they say, and motions turn with the plate and the axes.

Truth: all corners of the readings' rounding, seeded samples, and readings of turned plates.
"""

from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plate_readings import LEVELS, PLACES, apart, random_plate, source_rows

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.choosing import choose, extremes, reach
from vibecalc.measurement.complex_motion import Phasors, complex_motion, growth_of_deviations
from vibecalc.measurement.level_motions import (
    level_gradient,
    level_motions,
    observable,
    phase_gradient,
)
from vibecalc.measurement.plate import (
    Rectangle,
    amplitude_map,
    difference_row,
    grid,
    point_row,
    quietest,
)
from vibecalc.numerics.level import DECIBEL, amplitude_of

HALF = 0.05


def solved(levels, rows, half=HALF):
    widths, deviations = np.full(len(rows), half), np.full(len(rows), 2.0 * half / np.sqrt(12.0))
    return level_motions(rows, amplitude_of(levels, 1e-5), widths, rows[0], deviations)


def nearest(found, motion):
    return min(found, key=lambda one: apart(one.motion, motion))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_bound_against_all_corners_of_the_rounding(order):
    """32 corners, solved one by one: the first-order bound is right to its second order."""
    rows, half = source_rows(), 0.01
    (taken,) = [one for one in solved(LEVELS[order], rows, half) if one.motion[2].imag < 0.0]
    there = point_row(*PLACES["3"])
    bound = float(taken.spread.bound(level_gradient(there, taken.motion)))
    turn = phase_gradient(np.eye(3)[1], taken.motion)
    levels, phases = [], []
    for corner in product((-half, half), repeat=5):
        near = nearest(solved(np.array(LEVELS[order]) + corner, rows, half), taken.motion)
        levels.append(DECIBEL * np.log(abs(there @ near.motion) / abs(there @ taken.motion)))
        phases.append(np.angle(near.motion[1] / taken.motion[1]))
    assert np.max(np.abs(levels)) == pytest.approx(bound, rel=0.1)
    assert np.max(np.abs(phases)) == pytest.approx(float(taken.spread.bound(turn)), rel=0.1)


def _noisy_sets(plate, noise, stated, harmonics, sets=200):
    """Levels of origin, roll, pitch and of a place, and phases of roll and pitch: values and
    stated uncertainties, (sets, results) each, of tables of so many harmonics each.

    `noise` and `stated` are standard deviations of amplitudes (relative) and of phases (rad).
    """
    random = np.random.default_rng(17)
    true = plate.rows @ plate.motion
    rows = np.vstack([np.eye(3), point_row(0.4, -0.2)])
    values, reported = [], []
    for _ in range(sets // harmonics):
        table = []
        for _ in range(harmonics):
            amplitude, turn = (size * random.normal(size=len(true)) for size in noise)
            read = true * np.exp(amplitude + 1j * turn)
            deviations = np.multiply.outer(stated, np.abs(read))
            table.append(Phasors(plate.rows, read, deviations, deviations))
        growth = growth_of_deviations(table)[:, None]
        for one in table:
            fit = complex_motion(one._replace(deviations=one.deviations * growth))
            turns = phase_gradient(np.eye(3)[1:], fit.motion)
            levels = 20.0 * np.log10(np.abs(rows @ fit.motion))
            values.append([*levels, *np.angle(fit.motion[1:])])
            reported.append([
                *fit.spread.deviation(level_gradient(rows, fit.motion)),
                *fit.spread.deviation(turns),
            ])  # fmt: skip
    return np.array(values), np.array(reported)


@pytest.mark.parametrize("harmonics", [1, 10])
@pytest.mark.parametrize(
    "noise",
    [
        pytest.param((0.0345, 0.0344), marks=pytest.mark.long),
        # amplitudes known ten times as well as phases, and the other way round
        (0.004, 0.04),
        (0.04, 0.004),
    ],
)
def test_uncertainties_of_phasors_are_what_the_motion_scatters(noise, harmonics):
    """Over 200 noisy sets of six points."""
    values, reported = _noisy_sets(random_plate(5, 6, 0), noise, noise, harmonics)
    ratio = np.std(values, axis=0) / np.sqrt(np.mean(reported**2, axis=0))
    assert np.all((ratio > 0.85) & (ratio < 1.2)), ratio


@pytest.mark.long
@pytest.mark.parametrize("stated", [(0.00332, 0.000504), ((0.000332, 0.000504))])
def test_the_scatter_tells_where_too_little_is_stated(stated):
    """Last digits of .1 or .01 dB and of .1 deg alone, where .2 dB and 1 deg are off."""
    values, reported = _noisy_sets(random_plate(5, 6, 0), (0.023, 0.0175), stated, 10)
    ratio = np.std(values, axis=0) / np.sqrt(np.mean(reported**2, axis=0))
    assert np.all((ratio > 0.85) & (ratio < 1.2)), ratio


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 4))
def test_the_quietest_place_is_quieter_than_a_grid(seed, harmonics):
    random = np.random.default_rng(seed)
    motions = random.normal(size=(harmonics, 3)) + 1j * random.normal(size=(harmonics, 3))
    motions[:, 0] *= random.choice([0.1, 1.0, 10.0])
    plate = Rectangle(-0.7, 0.4, -0.2, 0.9)
    x, y = grid(plate, 61)
    best = quietest(motions, plate)
    total = np.linalg.norm(amplitude_map(motions, x, y), axis=0)
    assert plate.x_low <= best.x <= plate.x_high and plate.y_low <= best.y <= plate.y_high
    assert best.amplitude <= np.min(total) * (1.0 + 1e-12)
    iy, ix = np.unravel_index(np.argmin(total), total.shape)
    slope = float(np.linalg.norm(motions[:, 1:]))
    reach = np.hypot(x[1] - x[0], y[1] - y[0])
    assert best.amplitude >= total[iy, ix] - slope * reach
    assert best.error < 1e-9


def test_quiet_places_of_single_motions():
    plate = Rectangle(-1.0, 1.0, -0.5, 0.5)
    node = quietest(np.array([[1.0, 4.0j, 2.0 + 0.0j]]), plate)
    assert (node.x, node.y, node.amplitude) == pytest.approx((0.5, 0.0, 0.0), abs=1e-15)
    roll = quietest(np.array([[1.0, 4.0, 0.0]], dtype=complex), plate)
    assert (roll.x, roll.y) == pytest.approx((0.0, -0.25), abs=1e-15)
    still = quietest(np.array([[2.0, 0.0, 0.0]], dtype=complex), plate)
    assert (still.x, still.y, still.amplitude) == (0.0, 0.0, 2.0)


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2.0, 2.0])
def test_points_on_a_line_hide_the_turn_about_it(angle):
    along = np.array([np.cos(angle), np.sin(angle)])
    foot = 0.3 * np.array([-along[1], along[0]])
    places = [foot + t * along for t in (-1.0, 0.1, 0.4, 1.0)]
    rows = np.stack([point_row(*place) for place in places])
    reported = observable(rows)
    assert len(reported.unseen) == 1 and reported.levels == 3
    hidden = reported.unseen[0] / np.array([1.0, reported.span, reported.span])
    # the rotation vector lies along the line, and the points stay
    assert abs(hidden[1] * along[1] - hidden[2] * along[0]) < 1e-12
    assert np.max(np.abs(rows @ hidden)) < 1e-12
    with pytest.raises(NumericalFailure, match="leave a motion of the plate free"):
        complex_motion(Phasors(rows, np.ones(4, dtype=complex), np.ones((2, 4)), np.ones((2, 4))))


# ----------------------------------------------------------------------------
# The truth lies within the bound of a level, at the fold too.
# ----------------------------------------------------------------------------


LAST = 0.05 + 1e-9
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
def candidates(number):
    rows, amplitudes, _ = made(number)
    widths = np.full(len(rows), LAST)
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
        motion, (found, bounds) = made(number)[2], candidates(number)
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
    widths = np.full(5, LAST)
    found = extremes(rows, sizes, widths, POINTS[3:4])
    assert found is not None
    steps = np.linspace(-1.0, 1.0, 5) * LAST / DECIBEL
    seen = [
        size for move in product(steps, repeat=5) for size in fourth(sizes * np.exp(np.array(move)))
    ]
    assert found.low[0] <= min(seen) and max(seen) <= found.high[0]
    assert found.low[0] == pytest.approx(min(seen), rel=2e-3)
    assert found.high[0] == pytest.approx(max(seen), rel=2e-3)
    assert reach(rows, sizes, widths).folded


def test_levels_that_no_motion_has_bound_nothing():
    rows, sizes = triangle(-0.1)
    assert extremes(rows, sizes, np.full(5, LAST), POINTS) is None


def test_away_from_the_fold_the_bound_is_that_of_the_worst_readings():
    """Moved at random within their rounding, five levels stay within it and come near to it."""
    plate = random_plate(3, 5, 0)
    widths = np.full(5, LAST)
    found = level_motions(plate.rows, plate.amplitudes, widths, plate.rows[0], widths)
    bounds = reach(plate.rows, plate.amplitudes, widths)
    assert not bounds.folded
    random = np.random.default_rng(5)
    moves = random.choice([-1.0, 1.0], size=(60, 5)) * random.uniform(0.8, 1.0, (60, 1)) * LAST
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
