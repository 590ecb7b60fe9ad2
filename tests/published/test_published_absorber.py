"""Claim: the numbers of chapter 2 and Tables 3.1 and 3.2 of Baca Vasquez (2007) come out; where the
source slips, by its slip.

Its "fixed points" are the two peaks; its optimum is Den Hartog's, rounded; the optima of Tables
3.1 and 3.2 come from a grid of .001 in k, eps2 and x, whose valley is flat: row L of Table 3.1 is
that grid's, rows S and M are not reproduced by it and lie next to the true optimum.
"""

import numpy as np
import pytest

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import (
    Absorber,
    amplitude,
    damping_from_own_ratio,
    fixed_points,
    landmarks,
    own_damping_ratio,
)
from vibecalc.absorber.tuning.closed_forms import closed_form
from vibecalc.absorber.tuning.minimax import NO_HELP, minimax
from vibecalc.absorber.tuning.restricted import pure_viscous

MASS, STIFFNESS, RATIO = 0.1, 0.0826, 0.185
GRID_X = np.arange(2001) * 0.001


def source_absorber(e1=0.0, e2=RATIO, mass=MASS, stiffness=STIFFNESS):
    return Absorber(e1, mass, stiffness, damping_from_own_ratio(e2, mass, stiffness))


def grid_minimax(e1, mass, stiffness, ratios):
    """The program of Appendix I on a part of its grid: k, eps2 and the peak it ends at."""
    best = (np.inf, 0.0, 0.0)
    for k in stiffness:
        damping = damping_from_own_ratio(ratios, mass, k)[:, None]
        top = np.max(np.abs(amplitude(Absorber(e1, mass, k, damping), GRID_X)), axis=1)
        i = int(np.argmin(top))
        best = min(best, (float(top[i]), float(k), float(ratios[i])))
    return best[1], best[2], best[0]


def test_figure_2_2_natural_frequencies_and_the_zero():
    marks = landmarks(MASS, STIFFNESS)
    assert round(float(marks.lower), 4) == 0.8144
    # printed 1.1160
    assert float(marks.upper) == pytest.approx(1.1160, abs=1e-4)
    assert round(float(marks.locked), 4) == 0.9535
    # printed .9077 for the point R of Fig. 2.2 and .9088 for that of Fig. 2.14: it is one point
    assert round(float(marks.antiresonance), 4) == 0.9088
    assert abs(amplitude(source_absorber(e2=0.0), marks.antiresonance)) < 1e-15


def test_figure_2_2_points_p_and_q_are_peaks():
    found = peaks(source_absorber())
    assert np.round(found.frequency[:2], 3) == pytest.approx([0.848, 1.059])
    assert round(float(found.largest), 3) == 4.595
    # they are not equal, and the curves of other dampings do not pass through them
    assert found.magnitude[1] - found.magnitude[0] > 0.01
    fixed = fixed_points(MASS, STIFFNESS)
    assert [round(float(x), 4) for x in (fixed.frequency_p, fixed.frequency_q)] == [0.8429, 1.0523]
    apart = np.abs(amplitude(source_absorber(e2=0.3), [0.848, 1.06])) - found.magnitude[:2]
    assert np.all(np.abs(apart) > 0.05)


def test_the_optimum_is_den_hartogs_and_the_true_one_is_lower():
    old = closed_form("den_hartog_brock", MASS)
    assert round(float(old.stiffness_ratio), 4) == STIFFNESS
    tuned = Absorber(0.0, MASS, old.stiffness_ratio, old.secondary_damping)
    assert round(float(own_damping_ratio(tuned)), 3) == RATIO
    true = minimax(0.0, MASS)
    assert float(true.largest) == pytest.approx(4.58917, abs=5e-6)
    assert true.largest < old.largest < peaks(source_absorber()).largest
    # the grid of .001 ends above Den Hartog's closed form
    k, ratio, _ = grid_minimax(0.0, MASS, np.arange(78, 88) * 0.001, np.arange(160, 211) * 0.001)
    assert peaks(source_absorber(e2=ratio, stiffness=k)).largest > old.largest


def test_figure_2_4_a_heavy_secondary():
    found = peaks(source_absorber(mass=1.0))
    assert round(float(found.largest), 3) == 7.831
    # printed 1.035
    assert float(found.where) == pytest.approx(1.035, abs=1e-3)


def test_figures_2_3_and_2_4_print_the_steps_of_a_grid_for_infinite_peaks():
    """5000, 10000 and 12730 stand for infinite peaks: eps2 is a ratio, so k = 0 has no damper."""
    for absorber in (
        Absorber(0.0, MASS, 0.0, damping_from_own_ratio(RATIO, MASS, 0.0)),
        Absorber(0.0, 0.0, STIFFNESS, 0.0), Absorber(0.0, MASS, np.inf, 0.0),
    ):  # fmt: skip
        assert np.isinf(peaks(absorber).largest)
    nearby = abs(amplitude(Absorber(0.0, 0.0, STIFFNESS, 0.0), 1.0001))
    assert nearby == pytest.approx(5000, rel=1e-4)


def test_figure_2_14_with_a_damped_primary():
    found = peaks(source_absorber(0.04, 0.0))
    # the text says eps2 = .04 for eps1
    assert np.round(found.magnitude[:2], 2) == pytest.approx([15.35, 11.21])
    assert np.round(found.frequency[:2], 4) == pytest.approx([0.8144, 1.1160], abs=1e-3)
    locked = peaks(Absorber(0.04, MASS, STIFFNESS, np.inf))
    assert round(float(locked.largest), 2) == 13.12
    # printed .9535, the undamped value; damping moves the peak
    assert float(locked.where) == pytest.approx(0.9521, abs=1e-4)


def test_table_3_1_row_l_is_the_grid_of_appendix_1():
    k, ratio, _ = grid_minimax(0.01, 0.129, np.arange(94, 106) * 0.001, np.arange(190, 236) * 0.001)
    assert (round(k, 3), round(ratio, 3)) == (0.100, 0.217)


@pytest.mark.parametrize(("mass", "k", "ratio"), [(0.246, 0.157, 0.263), (0.179, 0.128, 0.229)])
def test_table_3_1_rows_s_and_m_lie_in_the_flat_valley(mass, k, ratio):
    got = grid_minimax(0.01, mass, np.arange(-6, 7) * 0.001 + k, np.arange(-40, 41) * 0.001 + ratio)
    assert (round(got[0], 3), round(got[1], 3)) != (k, ratio)
    true = minimax(0.01, mass)
    printed = peaks(source_absorber(0.01, ratio, mass, k)).largest
    assert 1.0 < printed / true.largest < 1.02
    assert got[2] < printed * (1.0 + 1e-9)


def test_table_3_2_follows_equation_3_13():
    """c2 = 2 eps2 J2 w1; with J1, as eq. 3.12 says, the ratios would be m times these."""
    mass, printed = np.array([0.451, 0.327, 0.236]), np.array([0.371, 0.399, 0.422])
    true = pure_viscous(0.01, mass)
    np.testing.assert_allclose(true.value / mass, printed, rtol=3e-3)
    at = peaks(Absorber(0.01, mass, 0.0, printed * mass))
    assert np.all(at.largest / true.largest < 1.0 + 1e-5)


def test_the_threshold_is_where_two_grids_see_nothing_left():
    """Section 2.5: k_opt = eps2_opt = 0 "starts when eps1 = .7"; it starts at 1 / sqrt 2."""
    mass = np.array([0.01, 0.1, 1.0])
    at = minimax(0.7, mass)
    assert np.all(at.stiffness_ratio > 0.0) and np.all(at.above_floor < 2e-4)
    assert np.all(minimax(0.7072, mass).outcome == NO_HELP)
    # eq. 2.11 holds to its rounding: peaks between 1 and 2 from m = .6 on, whatever eps1
    e1 = np.linspace(0.0, 1.0, 11)[:, None]
    assert np.max(minimax(e1, [0.6, 0.8, 1.0]).largest) < 2.12
