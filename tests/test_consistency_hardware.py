"""Claim: springs, rings, gaps and oils agree with energies, integrals, limits and many digits, and
bending and whirl of the overhung rod with 40 digits, finite elements and closed forms.
"""

import math
from itertools import product

import mpmath as mp
import numpy as np
import pytest
from long_but import long_but

from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    Walther,
    dynamic_viscosity,
    gap_shares,
    kinematic_viscosity,
    oil_damping,
    right_temperature,
    viscosity_for_damping,
)
from vibecalc.absorber.hardware.overhung import (
    bending_frequencies,
    rayleigh_frequency,
    whirl_frequencies,
)
from vibecalc.absorber.hardware.rods_and_springs import (
    EndBody,
    OverhungRod,
    bending_stiffness,
    couple_stiffness,
    largest_extension,
    mass_per_length,
    rate_for_couple,
    ring_inertia,
    spring_rate,
    torsional_stiffness,
)

LINE = Walther((313.15, 373.15), (86e-6, 13.8e-6))
MULTIGRADE = Oil("10W-40", LINE, 870.0)
GAP = RingGap(0.14834, 0.100, 0.007, 0.00052, 0.00052)


def test_two_projections_are_what_the_energy_of_a_spring_gives():
    """A slack spring whose line makes the angle A with the tangent at its hook: K R^2 cos^2 A."""
    rate, radius, tilt, length = 342.0, 0.138, math.radians(20.0), 0.09
    hook = np.array([radius, 0.0])
    other = hook + length * np.array([math.sin(tilt), math.cos(tilt)])

    def energy(turn):
        far = mp.hypot(other[0] - radius * mp.cos(turn), other[1] - radius * mp.sin(turn))
        return rate * (far - mp.hypot(*(other - hook))) ** 2 / 2

    with mp.workdps(60):
        exact = float(mp.diff(energy, 0, 2))
    both = couple_stiffness(rate, 1, radius, tilt)
    assert both.value == pytest.approx(exact, rel=1e-12)
    assert exact / (rate * radius**2 * math.cos(tilt)) == pytest.approx(math.cos(tilt), rel=1e-12)
    assert rate_for_couple(4.0 * exact, 4, radius, tilt).value == pytest.approx(rate, rel=1e-12)


def test_rods_springs_and_rings():
    assert spring_rate(79e9, 1.37e-3, 0.01443, 33.85).value == pytest.approx(342.0, abs=0.05)
    travel = largest_extension(342.0, 1.37e-3, 0.01443, 700e6, 5.0).value
    index = 0.01443 / 1.37e-3
    wahl = (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index
    stress = wahl * 8.0 * (342.0 * travel + 5.0) * 0.01443 / (math.pi * 1.37e-3**3)
    assert stress == pytest.approx(700e6, rel=1e-13)
    assert largest_extension(342.0, 1.37e-3, 0.01443, 700e6, 1e4).value == 0.0
    ring = ring_inertia(7850.0, 0.14834, 0.1, 0.03)
    disc, hole = ring_inertia(7850.0, 0.14834, 0.0, 0.03), ring_inertia(7850.0, 0.1, 0.0, 0.03)
    for whole, less, left in zip(disc, hole, ring, strict=True):
        assert whole.value - less.value == pytest.approx(left.value, rel=1e-13)
    # a thin tube keeps its digits
    with mp.workdps(40):
        outer, inner = mp.mpf(0.0254), mp.mpf(0.0253999)
        exact = mp.mpf(79e9) * mp.pi / 32 * (outer**4 - inner**4) / mp.mpf(1.6764)
    tube = torsional_stiffness(79e9, 0.0254, 1.6764, 0.0253999)
    assert abs(tube.value - float(exact)) <= tube.error
    assert bending_stiffness(200e9, 0.0254, 0.0253999).value > 0.0
    assert mass_per_length(7850.0, 0.0254, 0.0253999).value > 0.0


def test_gap_shares_are_the_integrals_of_the_shear():
    gap = RingGap(0.148, 0.1, 0.02, 0.0011, 0.0007, 0.0009)
    found = gap_shares(gap)
    with mp.workdps(30):
        outer, inner, wide, rim, side, bore = (mp.mpf(v) for v in gap)
        sides = 2 * mp.quad(lambda r: 2 * mp.pi * r**3 / side, [inner, outer])

        def couette(small, large):
            # torque is the same on every cylinder: 2 pi r^2 b eta r dw/dr
            return 1 / mp.quad(lambda r: 1 / (2 * mp.pi * wide * r**3), [small, large])

        exact = [couette(outer, outer + rim), sides, couette(inner - bore, inner)]
    for value, truth in zip((found.rim, found.sides, found.bore), exact, strict=True):
        assert value == pytest.approx(float(truth), rel=1e-14)
    assert abs(found.total.value - float(sum(exact))) <= found.total.error
    damping = 0.2 * found.total.value
    assert viscosity_for_damping(gap, damping).value == pytest.approx(0.2, rel=1e-14)


def test_viscosity_line_against_many_digits():
    warm = np.array([203.15, 260.0, 293.15, 313.15, 340.0, 373.15, 420.0])
    found = kinematic_viscosity(LINE, warm)
    with mp.workdps(40):
        ends = [mp.log(mp.log(mp.mpf(v) * 10**6 + mp.mpf(7) / 10)) for v in LINE.viscosity]
        first, second = (mp.mpf(t) for t in LINE.temperature)
        for i, t in enumerate(warm):
            share = mp.log(mp.mpf(t) / first) / mp.log(second / first)
            z = mp.exp(mp.exp(ends[0] + (ends[1] - ends[0]) * share))
            exact = float((z - mp.mpf(7) / 10) / 10**6)
            assert abs(found.value[i] - exact) <= found.error[i]
    assert np.all(found.error / found.value < 1e-12)
    assert np.all(np.diff(found.value) < 0.0)


def test_the_temperature_at_which_an_oil_is_right():
    wanted = float(oil_damping(MULTIGRADE, GAP, 313.15).value) * 1.1
    place = right_temperature(MULTIGRADE, GAP, wanted)
    assert oil_damping(MULTIGRADE, GAP, place.value).value == pytest.approx(wanted, rel=1e-12)
    assert 308.0 < place.value < 313.15 and place.error < 1e-10
    assert all(right_temperature(MULTIGRADE, GAP, never).value == 0.0 for never in (1e-6, 1e9))
    assert dynamic_viscosity(MULTIGRADE, 288.15).value == pytest.approx(
        870.0 * kinematic_viscosity(LINE, 288.15).value, rel=1e-15
    )


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
