"""Claim: springs, rings, gaps and oils agree with energies, integrals, limits and many digits."""

import math

import mpmath as mp
import numpy as np
import pytest

from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    Walther,
    dynamic_viscosity,
    film_factor,
    gap_damping,
    gap_shares,
    kinematic_viscosity,
    nearest_oils,
    oil_damping,
    oil_density,
    published_shares,
    right_temperature,
    spread,
    stock_array,
    temperature_for,
    viscosity_for_damping,
    warming,
)
from vibecalc.absorber.hardware.rods_and_springs import (
    Springs,
    axial_torsional_stiffness,
    bending_stiffness,
    coaxial_coupling,
    couple_stiffness,
    coupled_frequencies,
    inner_radius_for,
    largest_extension,
    mass_per_length,
    nearest_springs,
    rank,
    rate_for_couple,
    ring_inertia,
    shear_stress,
    spring_rate,
    tension_stiffness,
    torsional_stiffness,
    turns_for_rate,
)
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.numerics.rounding import WithError

LINE = Walther((313.15, 373.15), (86e-6, 13.8e-6))
THICK = Oil("VG 680", Walther((313.15, 373.15), (680e-6, 36e-6)), 900.0)
MULTIGRADE = Oil("10W-40", LINE, 870.0)
THIN = Oil("VG 32", Walther((313.15, 373.15), (32e-6, 5.4e-6)), 860.0)
GAP = RingGap(0.14834, 0.100, 0.007, 0.00052, 0.00052)


def hessian(energy):
    """Second derivatives of an energy of (z, t) at rest, by differences in 60 digits."""
    with mp.workdps(60):
        step = mp.mpf(10) ** -12

        def at(i, j):
            return energy(i * step, j * step)

        zz = (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / step**2
        tt = (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / step**2
        zt = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * step**2)
        return np.array([[float(zz), float(zt)], [float(zt), float(tt)]])


def spring_energy(rate, first, second, angle, rise, tension):
    values = [mp.mpf(float(v)) for v in (rate, first, second, angle, rise, tension)]
    k, a, b, d, h, f = values

    def length(z, t):
        return mp.sqrt(a * a + b * b - 2 * a * b * mp.cos(d + t) + (h + z) ** 2)

    def energy(z, t):
        rest = length(0, 0)
        return k * (length(z, t) - rest) ** 2 / 2 + f * (length(z, t) - rest)

    return energy


def test_two_projections_are_what_the_energy_of_a_spring_gives():
    """A slack spring whose line makes the angle A with the tangent at its hook: K R^2 cos^2 A."""
    rate, radius, tilt, length = 342.0, 0.138, math.radians(20.0), 0.09
    hook = np.array([radius, 0.0])
    other = hook + length * np.array([math.sin(tilt), math.cos(tilt)])
    exact = hessian(
        spring_energy(rate, math.hypot(*other), radius, math.atan2(other[1], other[0]), 0.0, 0.0)
    )[1, 1]
    both = couple_stiffness(rate, 1, radius, tilt)
    assert both.value == pytest.approx(exact, rel=1e-12)
    assert exact / (rate * radius**2 * math.cos(tilt)) == pytest.approx(math.cos(tilt), rel=1e-12)
    assert rate_for_couple(4.0 * exact, 4, radius, tilt).value == pytest.approx(rate, rel=1e-12)


def test_tension_adds_the_product_of_the_two_distances_from_the_foot():
    lever, near, far, tension = 0.11, -0.03, 0.06, 25.0
    angle = math.atan2(far, lever) - math.atan2(near, lever)
    exact = hessian(
        spring_energy(0.0, math.hypot(lever, near), math.hypot(lever, far), angle, 0.0, tension)
    )[1, 1]
    found = tension_stiffness(tension, 1, near, far)
    assert found.value == pytest.approx(exact, rel=1e-12)
    assert found.value < 0.0 < tension_stiffness(tension, 1, 0.02, 0.06).value


def test_axial_and_torsional_stiffness_is_the_hessian_of_the_energy():
    rng = np.random.default_rng(3)
    shape = (5, 4)
    springs = Springs(
        rng.uniform(100.0, 900.0, shape), rng.uniform(0.08, 0.16, shape),
        rng.uniform(0.08, 0.16, shape), rng.uniform(-0.8, 0.8, shape),
        rng.uniform(-0.03, 0.03, shape), rng.uniform(-5.0, 40.0, shape),
    )  # fmt: skip
    found = axial_torsional_stiffness(springs)
    for case in range(shape[0]):
        exact = sum(hessian(spring_energy(*(p[case, i] for p in springs))) for i in range(4))
        np.testing.assert_array_less(np.abs(found.value[case] - exact), found.error[case] + 1e-11)
        assert np.max(found.error[case] / np.abs(found.value[case])) < 1e-12


def test_springs_in_a_plane_do_not_couple_and_tilted_ones_do():
    plane = Springs(*(np.full(4, v) for v in (342.0, 0.14, 0.138, 0.6, 0.0, 12.0)))
    assert axial_torsional_stiffness(plane).value[0, 1] == 0.0
    tilted = plane._replace(axial_offset=np.full(4, 0.01))
    both = axial_torsional_stiffness(tilted)
    assert both.value[0, 1] > 1e3 * both.error[0, 1]
    pairs = plane._replace(axial_offset=np.array([0.01, -0.01, 0.01, -0.01]))
    found = axial_torsional_stiffness(pairs)
    assert abs(found.value[0, 1]) <= found.error[0, 1]
    frequency = coupled_frequencies(both.value, 7.0, 0.077)
    exact = np.sqrt(np.linalg.eigvalsh(both.value / np.sqrt(np.outer([7.0, 0.077], [7.0, 0.077]))))
    np.testing.assert_allclose(frequency.value, exact, rtol=1e-12)


def test_a_close_coil_is_the_spring_rate_and_its_inverse_the_energy_of_the_wire():
    close = coaxial_coupling(79e9, 205e9, 0.004, 0.04, 8.0, 1e-9)
    assert close.value[0, 0] == pytest.approx(spring_rate(79e9, 0.004, 0.04, 8.0).value, rel=1e-12)
    shear, elastic, wire, coil, turns, pitch = 79e9, 205e9, 0.004, 0.04, 8.0, 0.2
    found = coaxial_coupling(shear, elastic, wire, coil, turns, pitch)
    area = math.pi * wire**4 / 64.0
    radius, length = coil / 2.0, math.pi * turns * coil / math.cos(pitch)
    arms = np.array([[radius * math.cos(pitch), math.sin(pitch)],
                     [-radius * math.sin(pitch), math.cos(pitch)]])  # fmt: skip
    flexible = length * arms.T @ np.diag([0.5 / (shear * area), 1.0 / (elastic * area)]) @ arms
    np.testing.assert_allclose(found.value @ flexible, np.eye(2), atol=1e-12)


def test_rods_springs_and_rings_invert():
    assert turns_for_rate(79e9, 1.37e-3, 0.01443, 342.0).value == pytest.approx(33.85, abs=0.01)
    turns = turns_for_rate(79e9, 1.37e-3, 0.01443, 342.0).value
    assert spring_rate(79e9, 1.37e-3, 0.01443, turns).value == pytest.approx(342.0, rel=1e-14)
    travel = largest_extension(342.0, 1.37e-3, 0.01443, 700e6, 5.0).value
    stress = shear_stress(342.0 * travel + 5.0, 1.37e-3, 0.01443).value
    assert stress == pytest.approx(700e6, rel=1e-13)
    assert largest_extension(342.0, 1.37e-3, 0.01443, 700e6, 1e4).value == 0.0
    ring = ring_inertia(7850.0, 0.14834, 0.1, 0.03)
    assert inner_radius_for(ring.polar.value, 7850.0, 0.14834, 0.03).value == pytest.approx(0.1)
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
    damping = gap_damping(gap, 0.2)
    assert viscosity_for_damping(gap, damping.value).value == pytest.approx(0.2, rel=1e-14)


@pytest.mark.parametrize("clearance", [1e-3, 1e-4, 1e-5])
def test_the_published_formula_is_the_thin_limit_of_a_full_disc(clearance):
    disc = RingGap(0.14834, 0.0, 0.03, clearance, clearance)
    ratio = gap_shares(disc).total.value / published_shares(0.14834, 0.03, clearance).value
    rim_share = 0.03 / (0.03 + 0.5 * 0.14834)
    assert ratio - 1.0 == pytest.approx(1.5 * rim_share * clearance / 0.14834, rel=1e-2)


@pytest.mark.parametrize("square", [1e-6, 1e-2, 0.049999, 0.050001, 1.0, 50.0, 399.0, 801.0, 1e6])
def test_film_factor(square):
    found = film_factor(square, 1.0, 1.0)
    with mp.workdps(40):
        root = mp.sqrt(mp.mpc(0, square))
        exact = complex(root * mp.coth(root))
    assert abs(complex(found.damping, found.inertia) - exact) <= found.error
    assert found.error <= 1e-14 * abs(exact)


def test_the_film_of_the_rig_follows_at_once():
    """12.5 Hz, .52 mm, 224.6 cSt: .02 per cent more damping; a third of the film moves along."""
    found = film_factor(78.4, 0.00052, 224.6e-6)
    ratio = 78.4 * 0.00052**2 / 224.6e-6
    assert found.damping == pytest.approx(1.0 + ratio**2 / 45.0, abs=1e-6)
    assert 1e-4 < found.damping - 1.0 < 3e-4
    assert found.inertia == pytest.approx(ratio / 3.0, rel=1e-3)


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
    back = temperature_for(LINE, found.value)
    np.testing.assert_array_less(np.abs(back.value - warm), back.error + 1e-11)


def test_spread_is_the_derivative_by_the_measured_points():
    warm = np.array([283.15, 293.15, 350.0])
    off = (0.5e-6, 0.05e-6)
    step = 1e-5
    total = np.zeros(3)
    for i in (0, 1):
        points = [list(LINE.viscosity), list(LINE.viscosity)]
        points[0][i] += step * off[i]
        points[1][i] -= step * off[i]
        high, low = (kinematic_viscosity(LINE._replace(viscosity=tuple(p)), warm) for p in points)
        total += np.abs(high.value - low.value) / (2.0 * step)
    np.testing.assert_allclose(spread(LINE, warm, off), total, rtol=1e-5)


def test_density_falls_by_its_expansion():
    assert oil_density(870.0, 288.15).value == 870.0
    slope = (oil_density(870.0, 288.16).value - oil_density(870.0, 288.14).value) / 0.02
    assert slope == pytest.approx(-0.6278, rel=1e-5)
    assert oil_density(970.0, 373.15, 9.4e-4).value == pytest.approx(970.0 * 0.9203, rel=2e-3)


def test_oils_by_damping_and_the_temperature_at_which_one_is_right():
    stock = [THIN, THICK, MULTIGRADE]
    wanted = float(oil_damping(MULTIGRADE, GAP, 313.15).value) * 1.1
    found = nearest_oils(stock, GAP, wanted, 313.15)
    assert [stock[i].name for i in found.order] == ["10W-40", "VG 32", "VG 680"]
    assert found.ratio[0] == pytest.approx(1.0 / 1.1, rel=1e-14)
    place = right_temperature(MULTIGRADE, GAP, wanted)
    assert oil_damping(MULTIGRADE, GAP, place.value).value == pytest.approx(wanted, rel=1e-12)
    assert 308.0 < place.value < 313.15 and place.error < 1e-10
    table = stock_array(stock, GAP, [313.15, 353.15])
    assert table.shape == (3, 2) and np.all(table[:, 0] > table[:, 1])
    assert dynamic_viscosity(MULTIGRADE, 288.15).value == pytest.approx(
        870.0 * kinematic_viscosity(LINE, 288.15).value, rel=1e-15
    )


def test_an_oil_outside_its_line_stands_last():
    """VG 32 is thinner than 2 mm^2/s at 180 C."""
    found = nearest_oils([THIN, THICK], GAP, 1.0, 453.15)
    assert found.order[-1] == 0 and found.ratio[-1] == 0.0


def test_nearest_parts_by_ratio():
    found = rank([1.0, 4.0, 2.1, 0.0], 2.0)
    np.testing.assert_array_equal(found.order, [2, 0, 1, 3])
    springs = nearest_springs([342.0, 2900.0, 4500.0], 192.57, 4, 0.138, math.radians(20.0))
    assert springs.order[0] == 1


def test_warming_follows_the_oil_and_meets_the_optimum_on_the_way():
    """Row L of the rig with its optimal spring: as the oil thins, the peak falls, then rises."""
    stiffness, inertia, mass, spring = 1925.7, 0.599, 0.129, 0.1
    scale = 2.0 * math.sqrt(stiffness * inertia)

    def peak_of(damping):
        found = peaks(Absorber(0.01, mass, spring, damping))
        return WithError(found.largest, found.largest_error)

    warm = np.linspace(293.15, 373.15, 17)
    found = warming(warm, lambda t: oil_damping(THICK, GAP, t), stiffness, inertia, peak_of, 3.8)
    assert np.all(np.diff(found.secondary_damping.value) < 0.0)
    best = int(np.argmin(found.peak.value))
    assert 0 < best < 16
    np.testing.assert_allclose(found.damping.value, found.secondary_damping.value * scale)
    direct = peaks(Absorber(0.01, mass, spring, found.secondary_damping.value[best])).largest
    assert found.peak.value[best] == direct
    assert np.all(found.peak.error < 1e-10 * found.peak.value)
    np.testing.assert_allclose(found.penalty, found.peak.value / 3.8 - 1.0)


def test_an_oil_scales_with_the_units_at_its_own_points_only():
    """Length, mass and time times 2, 3 and 5: the damping goes with m L^2 / T. Between the points
    the line is a fit in mm^2/s, and without an expansion so is the density in kg/m^3."""
    length, mass, time = 2.0, 3.0, 5.0
    gap = RingGap(*(length * part for part in GAP[:5]))

    def ratio(temperature, expansion):
        plain = Oil("plain", LINE, 870.0, expansion)
        viscosities = tuple(length**2 / time * one for one in LINE.viscosity)
        other = Oil(
            "scaled", Walther(LINE.temperature, viscosities), 870.0 * mass / length**3, expansion
        )
        both = (oil_damping(plain, GAP, temperature), oil_damping(other, gap, temperature))
        return float(both[1].value / both[0].value) / (mass * length**2 / time)

    assert ratio(313.15, 7e-4) == pytest.approx(1.0, rel=1e-13)
    assert abs(ratio(293.15, 7e-4) - 1.0) > 1e-3
    assert abs(ratio(313.15, None) - 1.0) > 1e-3
