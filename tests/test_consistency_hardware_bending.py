"""Claim: bending and whirl of the overhung rod are those of 40 digits, of finite elements and of
closed forms; their error estimates hold."""

import math
from itertools import product

import mpmath as mp
import numpy as np
import pytest
from long_but import long_but

from vibecalc.absorber.hardware.overhung import (
    bending_frequencies,
    element_frequencies,
    rayleigh_frequency,
    whirl_frequencies,
)
from vibecalc.absorber.hardware.rods_and_springs import EndBody, OverhungRod

ROD = OverhungRod(200e9 * 2.0432e-8, 6.7 / 1.7, 1.6, 0.1)
MASS, POLAR = np.array([13.8, 23.5, 37.3]), np.array([0.179, 0.297, 0.465])


def exact_determinant(rod, body, spin, w):
    """Eight conditions on the eight constants of two plain beams, without any of our functions."""
    stiff, line, span, over = (mp.mpf(float(v)) for v in rod)
    mass, diametral, polar, offset = (mp.mpf(float(v)) for v in body)
    b = (line * w * w / stiff) ** mp.mpf("0.25")
    beam = [mp.sin, mp.cos, mp.sinh, mp.cosh]

    def row(x, order):
        """Derivatives of sin, cos, sinh, cosh at b x, over b^order."""
        steps = [
            (mp.sin, mp.cos, lambda z: -mp.sin(z), lambda z: -mp.cos(z)),
            (mp.cos, lambda z: -mp.sin(z), lambda z: -mp.cos(z), mp.sin),
            (mp.sinh, mp.cosh, mp.sinh, mp.cosh),
            (mp.cosh, mp.sinh, mp.cosh, mp.sinh),
        ]
        return [step[order](b * x) for step in steps]

    none = [mp.mpf(0)] * len(beam)
    load = mass * w * w / (stiff * b**3)
    turn = (diametral * w * w - polar * mp.mpf(float(spin)) * w) / (stiff * b)
    arm = offset * b
    end = [row(over, k) for k in range(4)]
    moved = [load * (p + arm * q) for p, q in zip(end[0], end[1], strict=True)]
    matrix = mp.matrix([
        row(0, 0) + none,
        row(0, 2) + none,
        row(span, 0) + none,
        none + row(0, 0),
        row(span, 1) + [-v for v in row(0, 1)],
        row(span, 2) + [-v for v in row(0, 2)],
        none + [end[2][i] - turn * end[1][i] - arm * moved[i] for i in range(4)],
        none + [end[3][i] + moved[i] for i in range(4)],
    ])  # fmt: skip
    return mp.det(matrix)


BODIES = (
    EndBody(13.8),
    EndBody(37.3, 0.2325, 0.465, -0.08),
    EndBody(37.3, 0.2325, 0.465, 0.08),
    EndBody(1e4, 3.0),
    EndBody(0.0),
    EndBody(0.01, 1e-7),
)
QUICK = ((BODIES[1], 1.3), (BODIES[3], 1e-4), (BODIES[4], 1.3))


@pytest.mark.parametrize("rod_end", long_but(product(BODIES, (0.0, 1e-4, 0.1, 1.3)), *QUICK))
def test_frequencies_against_forty_digits(rod_end):
    body, overhang = rod_end
    rod = ROD._replace(overhang=overhang)
    found = bending_frequencies(rod, body, 4)
    assert np.all(np.diff(found.value) > 0.0)
    with mp.workdps(40):
        for value, error in zip(found.value, found.error, strict=True):
            root = mp.findroot(
                lambda w: exact_determinant(rod, body, 0.0, w),
                (mp.mpf(value) * (1 - mp.mpf("1e-9")), mp.mpf(value) * (1 + mp.mpf("1e-9"))),
            )
            assert abs(float(root - mp.mpf(value))) <= error
            assert error <= 1e-11 * value


def test_whirl_against_forty_digits_and_both_ways():
    body = EndBody(23.5, 0.1485, 0.297, -0.03)
    found = whirl_frequencies(ROD, body, 150.0, 3)
    with mp.workdps(40):
        for spin, part in ((150.0, found.forward), (-150.0, found.backward)):
            for value, error in zip(part.value, part.error, strict=True):
                near = mp.mpf(value) * (1 + mp.mpf("1e-9"))
                root = mp.findroot(
                    lambda w, s=spin: exact_determinant(ROD, body, s, w), (mp.mpf(value), near)
                )
                assert abs(float(root - mp.mpf(value))) <= error
    rest = bending_frequencies(ROD, body, 3).value
    assert np.all(found.forward.value > rest) and np.all(found.backward.value < rest)


def test_no_modes_are_lost():
    """As many roots below a frequency as elements have, light and heavy, short and long."""
    body = EndBody(np.array([0.0, 0.5, 300.0])[:, None], np.array([0.0, 0.5]))
    found = bending_frequencies(ROD._replace(overhang=0.3), body, 6)
    elements, _ = element_frequencies(ROD._replace(overhang=0.3), body, 0.0, 40, 12)
    np.testing.assert_allclose(elements[..., :6], found.value, rtol=2e-4)
    assert np.all(elements[..., :6] > found.value * (1.0 - 1e-9))


def test_elements_converge_with_the_fourth_power():
    body = EndBody(13.8, 0.0895, 0.179)
    exact = bending_frequencies(ROD, body, 2).value
    off = [
        element_frequencies(ROD, body, 0.0, n, max(n // 8, 1))[0][:2] / exact - 1.0
        for n in (8, 16, 32)
    ]
    rate = np.log2(np.array(off[:-1]) / np.array(off[1:]))
    np.testing.assert_allclose(rate, 4.0, atol=0.15)


def test_a_rod_without_overhang_is_a_pinned_beam():
    found = bending_frequencies(ROD._replace(overhang=0.0), EndBody(37.3), 6)
    exact = (np.arange(1, 7) * math.pi / 1.6) ** 2 * math.sqrt(
        ROD.bending_stiffness / ROD.mass_per_length
    )
    np.testing.assert_array_less(np.abs(found.value - exact), found.error + 4e-16 * exact)


def test_a_heavy_mass_on_a_light_rod_is_a_spring():
    """Static stiffness at the end of an overhang: 3 E I / (a^2 (L + a))."""
    light = ROD._replace(mass_per_length=1e-9, overhang=0.4)
    found = bending_frequencies(light, EndBody(50.0), 1).value[0]
    stiffness = 3.0 * light.bending_stiffness / (0.4**2 * 2.0)
    assert found == pytest.approx(math.sqrt(stiffness / 50.0), rel=1e-8)


def test_rayleigh_is_its_integrals_and_lies_above_the_beam():
    body = EndBody(MASS, 0.5 * POLAR, POLAR, np.array([-0.08, 0.0, 0.05]))
    found = rayleigh_frequency(ROD, body)
    for i in range(3):
        with mp.workdps(30):
            wave, end = mp.pi / mp.mpf(1.6), mp.mpf(1.6) + mp.mpf(0.1)
            square = mp.quad(lambda x, w=wave: mp.sin(w * x) ** 2, mp.linspace(0, end, 5))
            rise, tilt = mp.sin(wave * end), wave * mp.cos(wave * end)
            moved = rise + mp.mpf(float(body.offset[i])) * tilt
            kinetic = (
                mp.mpf(ROD.mass_per_length) * square
                + mp.mpf(float(MASS[i])) * moved**2
                + mp.mpf(float(0.5 * POLAR[i])) * tilt**2
            )
            exact = mp.sqrt(mp.mpf(ROD.bending_stiffness) * wave**4 * square / kinetic)
        assert abs(found.value[i] - float(exact)) <= found.error[i]
    assert np.all(found.value > bending_frequencies(ROD, body, 1).value[:, 0])
