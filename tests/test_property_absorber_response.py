"""Claim: no grid finds a larger response than the exact peaks, for any ratios, limits included."""

import contextlib
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.squared_magnitude import damping_excess
from vibecalc.absorber.transfer import (
    EXCITATIONS,
    RESPONSES,
    Absorber,
    amplitude,
    amplitude_with_error,
    poles,
)
from vibecalc.errors import NumericalFailure

GRID = np.concatenate([[0.0], np.logspace(-5, 5, 4001)])

ratio = st.one_of(st.sampled_from([0.0, np.inf]), st.floats(1e-5, 30.0))


@pytest.mark.long
@settings(max_examples=80, deadline=None)
@given(
    st.one_of(st.sampled_from([0.0, 2**-0.5]), st.floats(1e-9, 2.0)), st.floats(1e-4, 10.0),
    ratio, ratio, st.sampled_from(EXCITATIONS), st.sampled_from(RESPONSES),
)  # fmt: skip
def test_no_grid_exceeds_the_peaks_and_every_hump_is_found(z1, m, k, z2, excitation, response):
    a = Absorber(z1, m, k, z2)
    swings = poles(a).value[poles(a).value.imag > 0.0]
    damped = -swings.real / np.abs(swings)
    if np.any(damped < 5e-14) and (z1 > 0.0 or 0.0 < z2 < np.inf):
        with contextlib.suppress(NumericalFailure):
            peaks(a, excitation, response)
        return  # refused where digits run out
    found = peaks(a, excitation, response)
    curve = np.abs(amplitude(a, GRID, excitation, response))
    assert np.max(curve) <= found.largest * (1.0 + 1e-10) + found.largest_error
    middle = curve[1:-1]
    with np.errstate(invalid="ignore"):
        hump = (middle > curve[:-2] * (1 + 1e-9)) & (middle > curve[2:] * (1 + 1e-9))
    assert np.sum(hump) <= np.sum(found.present)
    for x in GRID[1:-1][hump]:
        assert np.min(np.abs(np.log(found.frequency[found.present] / x))) < 1.2e-2
    assert np.all(np.diff(found.frequency[found.present]) > 0.0)
    inside = found.present & np.isfinite(found.magnitude)
    x = found.frequency[inside]
    near = np.stack([np.nextafter(x, 0.0), x, np.nextafter(x, np.inf)])
    at = amplitude_with_error(a, near, excitation, response)
    # the last bit of x is felt on a sharp peak: one of three neighbours has its height
    wrong = np.min(np.abs(np.abs(at.value) - found.magnitude[inside]) - at.error, axis=0)
    assert np.all(wrong <= 2.0 * found.error[inside] + 1e-8 * found.magnitude[inside])


@settings(max_examples=80, deadline=None)
@given(st.floats(1e-4, 10.0), st.floats(1e-4, 10.0), st.floats(1e-4, 10.0), st.floats(0.01, 50.0))
def test_force_and_motion_are_reciprocal(m, k, z2, x):
    """The force passed on per unit force is the motion passed on per unit motion of the ground."""
    a = Absorber(0.2, m, k, z2)
    one = amplitude(a, x, "force", "transmitted_force")
    assert one == amplitude(a, x, "base", "displacement")


@settings(max_examples=80, deadline=None)
@given(st.integers(-60, 60))
def test_the_distance_to_the_threshold_keeps_its_digits(steps):
    z1 = np.float64(2**-0.5)
    for _ in range(abs(steps)):
        z1 = np.nextafter(z1, np.inf if steps > 0 else 0.0)
    exact = 4 * Fraction(float(z1)) ** 2 - 2
    assert abs(Fraction(float(damping_excess(z1))) - exact) <= 4 * abs(exact) / 2**50
