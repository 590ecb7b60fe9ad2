"""Claim: modes, damper, Rayleigh damping and critical speeds of chapter 4 of Baca Vasquez (2007)
come out; three frequencies belong to another damper and one critical speed has its digits swapped.
"""

import engine_source as source
import numpy as np
import pytest
from engine_page import line_modes

from vibecalc.torsion.line import chain
from vibecalc.torsion.modes import natural_modes


@pytest.mark.parametrize(
    ("freedoms", "published", "digits", "truncated", "count"),
    [(7, source.SHAPE_7, 5, 2, 42), (8, source.SHAPE_8, 4, 17, 56)],
)
def test_shapes_are_rounded_or_cut_off(freedoms, published, digits, truncated, count):
    _, shape = line_modes(freedoms)
    exact, printed, unit = shape[1:], np.array(published[1:]), 10.0**-digits
    assert printed.size == count
    assert np.abs(exact - printed).max() < unit
    # towards zero: some are cut off after the last digit, the rest agree with their rounding
    cut = np.abs(np.trunc(exact / unit) * unit - printed) < 1e-9
    rounded = np.abs(np.round(exact, digits) - printed) < 1e-9
    assert np.all(cut | rounded) and np.sum(~rounded) == truncated


def test_shape_of_the_program():
    # not to the last digit of the program, whose frequency was searched less closely
    assert line_modes(8)[1][1] == pytest.approx(np.array(source.APPENDIX_VI_SHAPE), abs=2e-12)


def test_damper_inertia_and_stiffness():
    inertia = source.DAMPER_MASS_RATIO * 6 * source.CYLINDER_INERTIA
    assert inertia == pytest.approx(27.5126, abs=5e-5)
    # printed formula: six springs in series; its value: a sixth of one throw
    ratio = source.DAMPER_STIFFNESS_RATIO
    assert ratio / sum(1.0 / k for k in source.STIFFNESS) == pytest.approx(578989.0, abs=0.5)
    assert ratio * source.THROW_STIFFNESS / 6.0 == pytest.approx(5.9712e5, abs=5.0)


def test_captions_name_frequencies_of_another_damper():
    frequency, _ = line_modes(8)
    for (_, mode), old in source.OLD_FREQUENCY.items():
        # the critical speeds printed next to them are those of the new frequencies
        first = source.CRITICAL_SPEED[8, mode][0]
        assert abs(first - 2.0 * frequency[mode - 1]) < 0.11 < abs(first - 2.0 * old)
    # a softer spring brings the first and lowers the other two, which are printed higher
    soft = (0.9 * source.DAMPER_STIFFNESS, *source.STIFFNESS)
    softer = natural_modes(chain(source.DAMPED_INERTIA, soft)).frequency
    assert softer[1] < source.OLD_FREQUENCY[8, 2] < frequency[1]
    for mode in (3, 4):
        assert softer[mode - 1] < frequency[mode - 1] < source.OLD_FREQUENCY[8, mode]


@pytest.mark.parametrize(("freedoms", "mode"), source.CRITICAL_SPEED)
def test_critical_speeds(freedoms, mode):
    frequency, _ = line_modes(freedoms)
    order = np.array(source.CRITICAL_W) / 2.0
    found = frequency[mode - 1] / order
    printed = np.array(source.CRITICAL_SPEED[freedoms, mode])
    # of the frequency, or of the printed one rounded once more (135.049, 135.05, 135.1)
    twice = (source.FREQUENCY_7 if freedoms == 7 else source.FREQUENCY_8)[mode - 1]
    rounded = np.round(twice + 1e-9, 1) / order
    right = (np.abs(found - printed) < 0.0501) | (np.abs(rounded - printed) < 0.0501)
    # one slip of the keyboard: 89.9 for 98.9
    swapped = (freedoms, mode) == (7, 4)
    assert printed[~right].tolist() == ([89.9] if swapped else [])
    assert np.round(found[~right], 1).tolist() == ([98.9] if swapped else [])
