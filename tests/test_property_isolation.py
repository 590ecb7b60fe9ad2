"""What must hold for any body on any mounts: reciprocity, power, weight, limits, honest errors."""

import mpmath
import numpy as np
import pytest
from isolation_machines import (
    INERTIA,
    ORDERS,
    Body,
    exact,
    exact_matrices,
    exact_response,
    exact_transform,
    gibson,
    gibson_body,
    random_body,
)

from vibecalc.isolation.pitch import (
    angle_harmonics,
    pitch_model,
    pitch_static,
    support_force,
    transmissibility,
)
from vibecalc.isolation.pitch import support_displacement as pitch_displacement
from vibecalc.isolation.rigid_body import displacement, mount_force, static_deflection
from vibecalc.numerics.bounded import bounded
from vibecalc.parts.matrices import assemble
from vibecalc.response.forced import dynamics, response
from vibecalc.response.modal_damping import damping_ratio, energy_fraction
from vibecalc.response.modes import Modes, modes

SEEDS = range(30)


def frequency_of(shapes: Modes, generator: np.random.Generator) -> float:
    """On, next to or away from a natural frequency."""
    factor = generator.choice([0.1, 0.5, 1.0, 1.0 + 1e-7, 3.0, 10.0])
    return float(shapes.natural_frequency[generator.integers(6)] * factor)


def complex_force(generator: np.random.Generator) -> np.ndarray:
    force: np.ndarray = generator.normal(size=(1, 6)) + 1j * generator.normal(size=(1, 6))
    return force


@pytest.mark.parametrize("seed", SEEDS)
def test_response_is_reciprocal(seed: int) -> None:
    """Force a, motion read along b, equals force b, motion read along a."""
    body, generator = random_body(seed), np.random.default_rng(seed)
    frequency = np.array([frequency_of(modes(body.matrices), generator)])
    system = dynamics(body.matrices, frequency)
    first, second = complex_force(generator), complex_force(generator)
    one = response(system, first, np.zeros((1, 6)))
    other = response(system, second, np.zeros((1, 6)))
    there, back = one.value @ second.T, other.value @ first.T
    allowed = one.error @ np.abs(second.T) + other.error @ np.abs(first.T)
    assert abs(complex((there - back).item())) <= float(allowed.item())


@pytest.mark.parametrize("seed", SEEDS)
def test_power_put_in_is_dissipated_in_the_mounts(seed: int) -> None:
    """Mean power Re(i w X . conj F) / 2 against that of every mount's force at its end."""
    body, generator = random_body(seed), np.random.default_rng(seed)
    frequency = np.array([frequency_of(modes(body.matrices), generator)])
    force = complex_force(generator)
    motion = response(dynamics(body.matrices, frequency), force, np.zeros((1, 6)))
    at_mounts = displacement(motion, body.mounts.position)
    on_ground = mount_force(at_mounts, frequency, *body.mounts[1:])
    put_in = np.sum((1j * frequency[0] * motion.value * force.conj()).real)
    dissipated = np.sum((1j * frequency[0] * at_mounts.value * on_ground.value.conj()).real)
    spread = np.sum(at_mounts.error * np.abs(on_ground.value))
    spread = spread + np.sum(on_ground.error * np.abs(at_mounts.value))
    spread = spread + np.sum(motion.error * np.abs(force))
    assert abs(put_in - dissipated) <= frequency[0] * spread
    assert dissipated > 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_on_the_ground_add_up_to_force_minus_inertia(seed: int) -> None:
    body, generator = random_body(seed), np.random.default_rng(seed)
    frequency = np.array([frequency_of(modes(body.matrices), generator)])
    force = complex_force(generator)
    motion = response(dynamics(body.matrices, frequency), force, np.zeros((1, 6)))
    at_mounts = displacement(motion, body.mounts.position)
    on_ground = mount_force(at_mounts, frequency, *body.mounts[1:])
    inertial = frequency[0] ** 2 * body.mass_matrix @ motion.value[0]
    allowed = np.sum(on_ground.error, axis=(0, 2))
    allowed = allowed + (frequency[0] ** 2 * np.abs(body.mass_matrix) @ motion.error[0])[:3]
    off = np.abs(np.sum(on_ground.value, axis=(0, 2)) - (force[0] + inertial)[:3])
    assert np.all(off <= allowed + 1e-15 * np.abs(force[0, :3]))


@pytest.mark.parametrize("seed", SEEDS)
def test_static_forces_balance_weight_and_moment(seed: int) -> None:
    body = random_body(seed)
    up = np.random.default_rng(seed).normal(size=3)
    up = up / np.linalg.norm(up)
    rest = static_deflection(
        body.matrices, body.mounts.position, body.mounts.stiffness, body.mass, body.centre, 9.81, up
    )
    weight = body.mass * 9.81
    allowed = np.sum(rest.force_error, axis=0) + 1e-14 * weight
    assert np.all(np.abs(np.sum(rest.force, axis=0) + weight * up) <= allowed)
    moment = np.sum(np.cross(body.mounts.position, rest.force), axis=0)
    size = np.abs(body.mounts.position).sum(axis=1) @ rest.force_error.sum(axis=1)
    expected = np.cross(body.centre, -weight * up)
    assert moment == pytest.approx(expected, abs=float(size) + 1e-13 * weight)
    assert float(np.sum(rest.share)) == pytest.approx(weight, rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_energy_fractions_sum_to_one_whatever_the_sign_and_scale(seed: int) -> None:
    body = random_body(seed)
    shapes = modes(body.matrices)
    share = energy_fraction(body.matrices, shapes)
    assert np.sum(share.value, axis=1) == pytest.approx(np.ones(6), abs=1e-14)
    factor = np.random.default_rng(seed).normal(size=6) * 1e3
    stretched = shapes._replace(shape=shapes.shape * factor)
    again = energy_fraction(body.matrices, stretched).value
    assert again == pytest.approx(share.value, abs=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_modes_are_mass_orthonormal_and_largest_component_is_positive(seed: int) -> None:
    body = random_body(seed)
    shapes = modes(body.matrices)
    gram = shapes.shape.T @ body.mass_matrix @ shapes.shape
    assert gram == pytest.approx(np.eye(6), abs=1e-12)
    assert np.all(np.diff(shapes.natural_frequency) >= 0.0)
    weighed = shapes.shape * np.sqrt(np.diagonal(body.mass_matrix))[:, None]
    assert np.all(weighed[np.argmax(np.abs(weighed), axis=0), np.arange(6)] > 0.0)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_modes_do_not_depend_on_the_unit_of_length(factor: float) -> None:
    """Metres exchanged for another unit: frequencies and energy fractions stay."""
    body = random_body(7)
    scale = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    mass_matrix = body.mass_matrix * np.outer(scale, scale)
    other = assemble(mass_matrix, body.mounts.position * factor, *body.mounts[1:])
    plain, scaled = modes(body.matrices), modes(other)
    assert scaled.natural_frequency == pytest.approx(plain.natural_frequency, rel=1e-10)
    energy = energy_fraction(other, scaled).value
    assert energy == pytest.approx(energy_fraction(body.matrices, plain).value, abs=1e-9)


def test_repeated_modes_are_aligned_with_the_coordinates() -> None:
    """Equal stiffness in all directions: three translations at one frequency, none mixed."""
    body = gibson_body()
    shapes = modes(body.matrices)
    share = energy_fraction(body.matrices, shapes)
    repeated = np.isclose(shapes.natural_frequency, 20.0, rtol=1e-12)
    assert np.sum(repeated) == 3
    assert np.max(share.value, axis=1) == pytest.approx(np.ones(6), abs=1e-12)
    assert sorted(np.argmax(share.value, axis=1)) == list(range(6))
    assert np.max(share.error) < 1e-10


def test_modes_of_very_stiff_and_very_soft_directions_keep_their_digits() -> None:
    """Principal stiffnesses from 1 to 1e12: every frequency to 1e-12, which plain eigh loses."""
    level = np.array([1.0, 1e4, 1e12])
    position = np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]])
    stiffness = np.broadcast_to(np.diag(level), (4, 3, 3))
    matrices = assemble(np.eye(6), position, stiffness, 0.0 * stiffness, 0.0 * stiffness)
    squared = np.concatenate([4.0 * level, [2.0 * 1e12, 2.0 * 1e12, 2.0 * (1e4 + 1.0)]])
    shapes = modes(matrices)
    expected = np.sort(np.sqrt(squared))
    assert shapes.natural_frequency == pytest.approx(expected, rel=1e-12)
    assert np.all(np.abs(shapes.natural_frequency - expected) <= shapes.natural_frequency_error)


def test_a_direction_without_stiffness_has_frequency_zero_within_its_error() -> None:
    position = np.array([[1.0, 1.0, 0], [-1.0, 1.0, 0], [1.0, -1.0, 0], [-1.0, -1.0, 0.0]])
    stiffness = np.broadcast_to(np.diag([0.0, 10.0, 10.0]), (4, 3, 3))
    matrices = assemble(np.eye(6), position, stiffness, 0.0 * stiffness, 0.0 * stiffness)
    shapes = modes(matrices)
    assert shapes.natural_frequency[0] <= shapes.natural_frequency_error[0] < 1e-5
    assert shapes.natural_frequency[1] > 1.0


def test_free_body_moves_as_newton_says() -> None:
    """No mounts stiffness: X = -F / (w^2 M)."""
    body = random_body(2)
    none = np.zeros((1, 3, 3))
    matrices = assemble(body.mass_matrix, np.zeros((1, 3)), none, none, none)
    force = complex_force(np.random.default_rng(0))
    motion = response(dynamics(matrices, np.array([7.0])), force, np.zeros((1, 6)))
    expected = -np.linalg.solve(body.mass_matrix, force[0]) / 49.0
    assert motion.value[0] == pytest.approx(expected, rel=1e-11)


def test_limits_of_the_pitch_model() -> None:
    pitch, _ = gibson()
    low = transmissibility(pitch, np.array([1e-9]))
    assert abs(complex(low.value[0]) - 1.0) < 1e-10
    fast = np.array([1e5])
    couple = np.array([3.0 + 4.0j])
    angle = angle_harmonics(pitch, bounded(couple), fast)
    assert angle.value[0] == pytest.approx(-couple[0] / (INERTIA * 1e10), rel=1e-4)


def test_pitch_model_broadcasts_over_leading_axes() -> None:
    """A batch of machines in one call equals one call for each."""
    generator = np.random.default_rng(8)
    x = np.array([-0.4, -0.1, 0.5])
    k, c = generator.uniform(1e3, 1e5, (4, 5, 3)), generator.uniform(1.0, 99.0, (4, 5, 3))
    inertia, rate = generator.uniform(1.0, 9.0, (4, 5)), ORDERS * 77.0
    couple = np.array([1.0, 2.0j])
    batch = pitch_model(inertia, x, k, c, 0.1 * k)
    angle = angle_harmonics(batch, bounded(couple), rate)
    force = support_force(pitch_displacement(angle, x), rate, k, c, 0.1 * k)
    assert force.value.shape == (4, 5, 3, 2)
    single = pitch_model(inertia[2, 3], x, k[2, 3], c[2, 3], 0.1 * k[2, 3])
    alone = angle_harmonics(single, bounded(couple), rate)
    one = support_force(pitch_displacement(alone, x), rate, k[2, 3], c[2, 3], 0.1 * k[2, 3])
    assert force.value[2, 3] == pytest.approx(one.value, rel=1e-14)


def test_static_shares_of_uneven_mounts_balance() -> None:
    generator = np.random.default_rng(4)
    x, k = generator.normal(size=(50, 5)), generator.uniform(1.0, 1e3, (50, 5))
    centre = generator.normal(size=50)
    rest = pitch_static(981.0, centre, x, k)
    assert np.sum(rest.share, axis=1) == pytest.approx(np.full(50, 981.0), rel=1e-12)
    assert np.sum(rest.share * x, axis=1) == pytest.approx(981.0 * centre, rel=1e-9)


def within(error: np.ndarray, estimate: np.ndarray) -> np.ndarray:
    """Estimate over true error; an exact result counts as large."""
    true = np.array([float(value) for value in np.ravel(error)])
    return np.ravel(estimate) / np.maximum(true, 1e-300)


def exact_frequencies(matrices: tuple[mpmath.matrix, ...]) -> np.ndarray:
    mass, stiffness = matrices[:2]
    inverse = mpmath.cholesky(mass) ** -1
    reduced = inverse * stiffness * inverse.T
    values = mpmath.eigsy((reduced + reduced.T) / 2, eigvals_only=True)
    return np.array([mpmath.sqrt(value) for value in values])


def exact_sag(
    matrices: tuple[mpmath.matrix, ...], body: Body, gravity: float, up: np.ndarray
) -> np.ndarray:
    pull = -exact(up) * mpmath.mpf(body.mass) * mpmath.mpf(gravity)
    load = exact_transform(body.centre).T @ pull
    moved = np.array(list(mpmath.lu_solve(matrices[1], mpmath.matrix(load.tolist()))))
    return np.array([-(exact_transform(p) @ moved) @ exact(up) for p in body.mounts.position])


@pytest.mark.parametrize("count", [12, pytest.param(100, marks=pytest.mark.long)])
@mpmath.workdps(35)  # type: ignore[untyped-decorator]
def test_error_estimates_are_honest_on_random_bodies(count: int) -> None:
    """Below a tenth of the true error in at most 1 % of the numbers; the median within 1000."""
    ratios: dict[str, list[np.ndarray]] = {"body": [], "force": [], "sag": [], "frequency": []}
    for seed in range(count):
        body, generator = random_body(seed), np.random.default_rng(1000 + seed)
        shapes, matrices = modes(body.matrices), exact_matrices(body)
        frequency, force = frequency_of(shapes, generator), complex_force(generator)
        rate = np.array([frequency])
        motion = response(dynamics(body.matrices, rate), force, np.zeros((1, 6)))
        true = exact_response(matrices, frequency, force[0])
        ratios["body"].append(within(np.abs(exact(motion.value[0]) - true), motion.error[0]))
        on_ground = mount_force(displacement(motion, body.mounts.position), rate, *body.mounts[1:])
        moved = exact_transform(body.mounts.position[0]) @ true
        lag = exact(body.mounts.structural[0]) + mpmath.mpf(frequency) * exact(
            body.mounts.damping[0]
        )
        pushed = exact(body.mounts.stiffness[0]) @ moved + mpmath.mpc(0, 1) * (lag @ moved)
        off = np.abs(exact(on_ground.value[0, :, 0]) - pushed)
        ratios["force"].append(within(off, on_ground.error[0, :, 0]))
        up = np.eye(3)[seed % 3]
        rest = static_deflection(
            body.matrices, body.mounts.position, body.mounts.stiffness, body.mass, body.centre,
            9.80665, up,
        )  # fmt: skip
        sag = exact_sag(matrices, body, 9.80665, up)
        ratios["sag"].append(within(np.abs(exact(rest.sag) - sag), rest.sag_error))
        if seed < 0.4 * count:
            off = np.abs(exact(shapes.natural_frequency) - exact_frequencies(matrices))
            ratios["frequency"].append(within(off, shapes.natural_frequency_error))
    for name, parts in ratios.items():
        ratio = np.concatenate(parts)
        assert np.mean(ratio < 0.1) <= 0.01, name
        assert np.median(ratio) < 1000.0, name


def test_damping_ratio_of_proportional_damping_is_exact() -> None:
    """C = a K and H = b K: zeta = a w / 2 + b / 2 in every mode."""
    for seed in SEEDS:
        body = random_body(seed, proportional=True)
        shapes = modes(body.matrices)
        ratio = damping_ratio(body.matrices, shapes)
        expected = 0.5 * (1e-3 * shapes.natural_frequency + 0.05)
        assert np.all(np.abs(ratio.value - expected) <= ratio.error)
        assert np.all(ratio.error <= 1e-8 * expected)
