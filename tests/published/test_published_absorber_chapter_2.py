"""Claim: the numbers of chapter 2 of Baca Vasquez (2007) come out; where it slips, by its slip.

Each printed number is a row of `absorber_numbers`: fixed points that are maxima, rounded tunings,
a coarse grid.
"""

import math

import numpy as np
import pytest
from absorber_numbers import damped, optima, tables_3_1_and_3_2, thousandths, undamped
from absorber_page import assert_verdict
from two_masses import amplitude

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber, damping_from_own_ratio
from vibecalc.absorber.tuning.minimax import minimax


def printed(value, digits):
    return np.round(np.asarray(value, dtype=float), digits)


def test_the_peak_of_the_rounded_tuning():
    assert_verdict(undamped, "with the slip", "2.3.1, least peak")


def test_the_maxima_are_taken_for_the_fixed_points():
    assert_verdict(undamped, "with the slip", "Fig. 2.2, P", "Fig. 2.2, Q")


def test_the_antiresonance():
    """.9088 in section 2.3.2; .9077 in section 2.3.1 is no digit of it."""
    assert_verdict(undamped, "misprint", "2.3.1, R")
    assert_verdict(damped, "reproduced", "2.3.2, R")


def test_figure_2_3_and_2_4():
    assert_verdict(undamped, "reproduced", "Fig. 2.4, mu = 1, peak")
    assert_verdict(undamped, "with the slip", "Fig. 2.4, mu = 1, at")


def test_damping_moves_the_maxima():
    """Figure 2.14: heights come out; the frequencies are those of the undamped primary."""
    heights = ("Fig. 2.14, lower peak", "Fig. 2.14, upper peak", "Fig. 2.14, locked, peak")
    assert_verdict(damped, "reproduced", *heights)
    assert_verdict(damped, "with the slip", "Fig. 2.14, lower, at", "Fig. 2.14, locked, at")


def test_table_3_1_row_l_on_the_grid():
    assert_verdict(tables_3_1_and_3_2, "with the slip", "Table 3.1, L, eps2")


def test_equation_2_11_and_the_ranges_of_the_figures():
    assert_verdict(optima, "reproduced", "eq. 2.11, least", "Fig. 2.30, largest k")
    assert_verdict(optima, "compatible", "eq. 2.11, largest")


@pytest.mark.parametrize(
    ("stiffness", "source", "where"), [(0.0, 5000.0, 1.0), (np.inf, 12730.0, 0.9535)]
)
def test_heights_at_a_resonance_are_those_of_the_nearest_frequency(stiffness, source, where):
    """5000, 12730 and 10000 stand for infinity: 1 / (2 |x - x0|) of a step that is not printed."""
    system = Absorber(0.0, 0.1, stiffness, 0.0)
    assert np.isinf(peaks(system).largest)
    mass = 1.0 if stiffness == 0.0 else 1.0 + 0.1
    resonance = 1.0 / math.sqrt(mass)
    # the distance in frequency that gives the printed height
    near = 1.0 / (2.0 * mass * resonance * source)
    value = abs(complex(amplitude(system, resonance - near)))
    assert value == pytest.approx(source, rel=1e-3)
    assert near < 1.5e-4 and resonance == pytest.approx(where, abs=5e-5)


@pytest.mark.parametrize(
    ("mass", "given"), [(0.246, (0.157, 0.263)), (0.179, (0.128, 0.229))], ids="SM"
)
def test_table_3_1_rows_s_and_m(mass, given):
    """Neither the optimum nor that of the grid; the printed tuning costs less than one per cent."""
    size = {0.246: "S", 0.179: "M"}[mass]
    places = f"Table 3.1, {size}, k", f"Table 3.1, {size}, eps2"
    assert_verdict(tables_3_1_and_3_2, "not reproducible", *places)
    z2 = damping_from_own_ratio(given[1], mass, given[0])
    best = minimax(0.01, mass)
    cost = float(peaks(Absorber(0.01, mass, given[0], z2)).largest / best.largest) - 1.0
    assert 0.001 < cost < 0.01


def test_figure_2_12_has_its_high_peaks_near_one():
    mass = thousandths(1, 1000)
    found = peaks(Absorber(0.0, mass, 0.0826, damping_from_own_ratio(0.185, mass, 0.0826)))
    high = found.where[found.largest > 5.0]
    assert (printed(high.min(), 3), printed(high.max(), 3)) == (0.859, 1.060)


def test_figures_2_7_to_2_16_are_as_the_text_says():
    """The curves of cases/absorber_damping.toml and cases/absorber_stiffness.toml."""
    x, own = np.linspace(0.5, 1.5, 2001), np.linspace(0.0, 0.6, 61)[:, None]
    inside = {}
    for primary in (0.0, 0.04):
        drag = damping_from_own_ratio(own, 0.1, 0.0826)
        size = np.abs(amplitude(Absorber(primary, 0.1, 0.0826, drag), x))
        locked = np.abs(amplitude(Absorber(primary, 0.1, np.inf, 0.0), x))
        low, high = np.minimum(size[0], locked), np.maximum(size[0], locked)
        between = (low * (1.0 - 1e-9) <= size) & (size <= high * (1.0 + 1e-9))
        inside[primary] = bool(np.all(between))
    # figure 2.7 against section 2.3.2
    assert inside == {0.0: True, 0.04: False}
    # figure 2.15: R keeps its place
    at = math.sqrt(0.0826 / 0.1)
    assert printed(at, 4) == 0.9088
    assert abs(complex(amplitude(Absorber(0.04, 0.1, 0.0826, 0.0), at))) < 1e-12
    # figures 2.9 and 2.16: best below .1; without damping of the primary bound by no number
    spring = np.linspace(0.0, 0.3, 301)
    for primary, best, top in ((0.0, 0.083, np.inf), (0.04, 0.080, 12.51)):
        found = peaks(Absorber(primary, 0.1, spring, damping_from_own_ratio(0.185, 0.1, spring)))
        assert spring[np.argmin(found.largest)] == pytest.approx(best)
        assert found.largest.max() == pytest.approx(top, rel=1e-4)
