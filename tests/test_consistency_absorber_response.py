"""Claim: peaks, poles, landmarks and fixed points of a primary with its secondary are those of the
response in many digits.

That the response follows from full matrices `test_consistency_absorber_band.py` holds.
"""

import numpy as np
import pytest
from exact_tree import peaks as exact_peaks
from exact_tree import response, squared, tree, value_at
from mpmath import mp, mpf
from two_masses import amplitude

from vibecalc.absorber.adapters.response import courses
from vibecalc.absorber.modal import on_one_mode
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import (
    EXCITATIONS,
    RESPONSES,
    Absorber,
    fixed_points,
    landmarks,
    poles,
)
from vibecalc.errors import NumericalFailure

X = np.array([0.03, 0.4, 0.8144, 1.0, 1.37, 6.0])


def of_modes(absorber, x, excitation="force", response="displacement"):
    """H and its error at one place, as curves of a run have them."""
    found, error = courses([on_one_mode(absorber)], np.atleast_1d(x), excitation, response)
    return found[0, 0], error[0, 0]


def test_an_undamped_resonance_is_infinite_and_not_nan():
    a = Absorber(0.0, 3.0, np.inf, 0.0)
    assert np.isinf(of_modes(a, 0.5)[0])
    found = peaks(Absorber(0.0, 0.1, [0.0826, np.inf, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]))
    assert np.all(np.isinf(found.largest)) and list(np.sum(found.present, axis=1)) == [2, 1, 1, 1]
    exact = np.sqrt(np.sort(np.roots([0.1, -(0.1 + 0.0826 * 1.1), 0.0826])))
    np.testing.assert_allclose(found.frequency[0, :2], exact, rtol=1e-14)
    np.testing.assert_allclose(found.frequency[1:, 0], [1.1**-0.5, 1.0, 1.0], rtol=1e-15)


def test_poles_are_roots_and_undamped_ones_are_the_natural_frequencies():
    found = poles(Absorber(0.0, 0.1, 0.0826, 0.0))
    marks = landmarks(0.1, 0.0826)
    np.testing.assert_allclose(
        np.sort(found.value.imag)[2:], [marks.lower, marks.upper], rtol=1e-14
    )
    rng = np.random.default_rng(4)
    a = Absorber(*(10.0 ** rng.uniform(-3, 0.5, (4, 200))))
    found = poles(a)
    assert np.all(found.present) and np.all(found.value.real < 0.0)
    s = found.value
    z1, m, k, z2 = (np.asarray(v)[:, None] for v in a)
    g = k + 2 * z2 * s
    left = (1 + 2 * z1 * s + s * s) * (m * s * s + g) + m * s * s * g
    slope = 4 * m * np.prod(
        np.where(np.eye(4, dtype=bool), 1.0, s[:, :, None] - s[:, None, :]), axis=-1
    ) / 4  # fmt: skip
    assert np.max(np.abs(left / slope) / found.error) < 4.0
    assert np.median(found.error / np.abs(s)) < 1e-12


def test_landmarks_of_extreme_ratios_keep_their_digits():
    mp.dps = 40
    for m, k in ((1e-6, 1e-6), (1e-4, 1e4), (10.0, 1e-9), (0.1, 0.0826)):
        a, b = mpf(m), mpf(k)
        total = 1 + b / a * (1 + a)
        root = mp.sqrt(total**2 - 4 * b / a)
        exact = [float(mp.sqrt((total - root) / 2)), float(mp.sqrt((total + root) / 2))]
        marks = landmarks(m, k)
        assert [marks.lower, marks.upper] == pytest.approx(exact, rel=4e-16)


def test_fixed_points_do_not_depend_on_damping_and_exist_for_an_undamped_primary_only():
    for m, k in ((0.1, 0.0826), (1e-3, 2e-3), (4.0, 0.3)):
        p = fixed_points(m, k)
        for z2 in (0.0, 0.01, 0.3, np.inf):
            got = np.abs(amplitude(Absorber(0.0, m, k, z2), [p.frequency_p, p.frequency_q]))
            np.testing.assert_allclose(got, [p.magnitude_p, p.magnitude_q], rtol=1e-11)
    viscous = fixed_points(0.1, 0.0)
    assert viscous.frequency_p == 0.0 and viscous.magnitude_q == pytest.approx(1.0 + 2.0 / 0.1)
    with pytest.raises(NumericalFailure, match="no fixed points"):
        fixed_points(0.1, 0.08, 0.04)
    # with a damped primary the curves of three dampings have no common point
    curves = np.abs(amplitude(Absorber(0.04, 0.1, 0.0826, [[0.0], [0.02], [0.1]]), X[0] + X * 0.3))
    assert np.all(np.ptp(curves, axis=0) > 0.0)


#: z1, m, k, z2 of absorbers one of whose peaks was once given twice
TWICE = (
    (0.13149114242082516, 0.061297333546748704, 0.029297435736876126, 6.990679771011391e-05),
    (0.2774871804001779, 0.007860098423333147, 0.009202808147693977, 1.0777497281203065e-05),
)


def assert_peaks(a, kind):
    """Each peak once, within its errors; returns the system in many digits and their number."""
    found = peaks(a, *kind)
    exact = tree(a[0], [a.mass_ratio], [a.stiffness_ratio], [a.secondary_damping])
    known = exact_peaks(exact, *kind)
    here = np.flatnonzero(found.present)
    assert len(here) == len(known.frequency)
    for i, x, height in zip(here, known.frequency, known.magnitude, strict=True):
        assert abs(found.magnitude[i] - height) <= found.error[i]
        assert abs(found.frequency[i] / x - 1) < 1e-7
    return exact, len(here)


def test_peaks_are_those_with_many_digits_within_their_errors():
    mp.dps = 40
    rng = np.random.default_rng(12)
    seen = 0
    for kind in ((e, r) for e in EXCITATIONS for r in RESPONSES[:4]):
        for _ in range(2):
            z1 = float(rng.choice([0.0, 0.01, 0.3, 1.2]))
            m = 10 ** rng.uniform(-4, 1)
            a = Absorber(z1, m, m * 10 ** rng.uniform(-1.5, 1), m * 10 ** rng.uniform(-2, 1))
            exact, count = assert_peaks(a, kind)
            seen += count
            x = 10 ** rng.uniform(-2, 2)
            got, error = of_modes(a, x, *kind)
            above, below = (value_at(squared(part), mpf(x) ** 2) for part in response(exact, *kind))
            height = mp.sqrt(above / below)
            assert abs(abs(got) - height) <= error < 1e-11 * height
    assert seen > 15
    mp.dps = 60
    for ratios in TWICE:
        assert_peaks(Absorber(*ratios), ("force", "displacement"))
