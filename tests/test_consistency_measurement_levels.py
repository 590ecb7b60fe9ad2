"""Claim: all motions that levels allow are found, whatever the places, and no other.

Truth: motions drawn at random and read; scipy's least squares from many starts; mpmath.
"""

import numpy as np
import pytest
from long_but import long_but
from plate_readings import apart, random_plate, source_rows
from scipy.optimize import least_squares

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.level_motions import level_motions
from vibecalc.numerics.level import DECIBEL

HALF = 0.05


def motions_of(plate, half=HALF, rows=slice(None)):
    own = plate.rows[rows]
    widths = np.full(len(own), half)
    return level_motions(own, plate.amplitudes[rows], widths, own[0], widths / 3.0)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(("points", "differences"), [(3, 2), (5, 0), (4, 1)])
def test_five_levels_leave_the_motion_and_one_more(seed, points, differences):
    plate = random_plate(seed, points, differences)
    found = motions_of(plate)
    assert 1 <= len(found) <= 2
    assert min(apart(plate.motion, one.motion) for one in found) < 1e-9
    for one in found:
        np.testing.assert_allclose(np.abs(plate.rows @ one.motion), plate.amplitudes, rtol=1e-11)
        assert not one.clipped


@pytest.mark.parametrize("seed", long_but(range(4), 0))
def test_no_motion_is_overlooked(seed):
    """Least squares of scipy from 12 random starts end at no further motion."""
    plate = random_plate(100 + seed, 4, 1)
    found = motions_of(plate)
    random = np.random.default_rng(seed)

    def misses(parts):
        signal = plate.rows @ (parts[:3] + 1j * parts[3:])
        return np.abs(signal) ** 2 - plate.amplitudes**2

    met = []
    for _ in range(12):
        end = least_squares(misses, random.normal(size=6), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if np.max(np.abs(end.fun)) < 1e-9:
            met.append(min(apart(end.x[:3] + 1j * end.x[3:], one.motion) for one in found))
    assert len(met) >= 3
    assert max(met) < 1e-4


@pytest.mark.parametrize("seed", long_but(range(6), 0, 5))
def test_a_sixth_level_singles_out_the_motion(seed):
    plate = random_plate(200 + seed, 6, 0)
    best = motions_of(plate)[0]
    assert apart(best.motion, plate.motion) < 1e-9
    assert best.misfit < 1e-9
    others = motions_of(plate)[1:]
    # another may lie within the rounding, but none has these very levels
    assert all(other.misfit > 1e-6 for other in others)


@pytest.mark.parametrize("seed", long_but(range(4), 0))
def test_redundant_levels_with_scatter_are_least_squares(seed):
    """Against scipy from the true motion; no local minimum of it has a lower cost."""
    plate = random_plate(300 + seed, 6, 3)
    random = np.random.default_rng(seed)
    read = plate.amplitudes * np.exp(random.normal(scale=0.3, size=9) / DECIBEL)
    widths = np.full(9, HALF)
    best = level_motions(plate.rows, read, widths, plate.rows[0], widths)[0]

    def residuals(parts):
        signal = np.abs(plate.rows @ (parts[:3] + 1j * parts[3:]))
        return DECIBEL * np.log(signal / read) / HALF

    for start in (plate.motion, *(random.normal(size=(3, 3)) + 1j * random.normal(size=(3, 3)))):
        end = least_squares(residuals, np.concatenate([start.real, start.imag]), xtol=1e-14)
        assert 2.0 * end.cost >= best.cost * (1.0 - 1e-9)
    true = least_squares(residuals, np.concatenate([plate.motion.real, plate.motion.imag]))
    assert best.cost == pytest.approx(2.0 * true.cost, rel=1e-6)


@pytest.mark.parametrize("excess", [1e-3, 0.02, 0.03])
def test_a_contradiction_within_the_rounding_is_clipped_and_sized(excess):
    """A_2 a little louder than A_1 and A_12 in phase: the three have to share the excess."""
    rows = source_rows()
    first, across = 1.0, 0.4
    sizes = np.array([first, first + across, 0.9, across, 0.7])
    sizes[1] *= np.exp(3.0 * excess / DECIBEL)
    widths = np.full(5, HALF)
    (one,) = level_motions(rows, sizes, widths, rows[0], widths)
    assert one.clipped
    # the least possible worst residual: all three move, A_2 down and the others up, by as much,
    # which is half of what A_2 is too loud by
    low, high = 0.0, 3.0 * excess
    for _ in range(60):
        middle = 0.5 * (low + high)
        closes = sizes[1] * np.exp(-middle / DECIBEL) <= (first + across) * np.exp(middle / DECIBEL)
        low, high = (low, middle) if closes else (middle, high)
    assert one.misfit * HALF == pytest.approx(high, rel=1e-3)
    assert high == pytest.approx(1.5 * excess, rel=1e-2)
    turned = one.motion[1] / (rows[0] @ one.motion)
    assert abs(np.imag(turned)) < 1e-6 * abs(turned)


def test_a_contradiction_beyond_the_rounding_is_refused_in_db():
    rows = source_rows()
    sizes = np.array([1.0, 2.0, 0.9, 0.5, 0.7])
    widths = np.full(5, HALF)
    with pytest.raises(NumericalFailure, match=r"contradict each other.*off by 1\.\d dB or more"):
        level_motions(rows, sizes, widths, rows[0], widths)
    granted = np.full(5, 2.0)
    (one,) = level_motions(rows, sizes, granted, rows[0], granted)
    assert one.clipped and one.misfit < 1.0


def test_phasors_exactly_in_line():
    """All phases 0 or 180 degrees: the two motions are one, and it is found."""
    rows = source_rows()
    motion = np.array([1.0, 2.0, -0.5], dtype=complex)
    widths = np.full(5, HALF)
    found = level_motions(rows, np.abs(rows @ motion), widths, rows[0], widths)
    assert min(apart(motion, one.motion) for one in found) < 1e-6
    # levels see a phase near 0 or 180 degrees by its cosine only
    assert all(abs(np.imag(one.motion[1])) < 1e-3 for one in found)


def test_too_few_levels_are_refused():
    plate = random_plate(3, 4, 0)
    with pytest.raises(NumericalFailure, match="determine 4 of the 5 numbers"):
        motions_of(plate)
