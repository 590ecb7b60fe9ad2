"""Claim: energies of harmonic motion, their peaks and their ranges are the true ones, with honest
errors: against 50 digits, against the motion sampled in time, and against laws they must obey.
"""

import mpmath
import numpy as np
import ong_tables as ong
import pytest
from exact_peaks import cycle_peak as exact_peak
from isolation_machines import exact, random_body
from mpmath import mpf

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.response.energies import (
    CycleEnergy,
    energies_over_cycle,
    energy_by_order,
    energy_over_cycle,
    mass_of,
    stiffness_of,
    velocity,
)
from vibecalc.response.forced import dynamics, response
from vibecalc.response.modes import modes

ORDERS = np.array([1, 2, 4, 6])
SEEDS = range(6)


def exactly(value: np.ndarray) -> Bounded:
    return Bounded(value, np.zeros(np.shape(value)))


def motion_of(seed: int) -> tuple[Matrices, Bounded, float]:
    """Six coordinates of four orders of a random body, taken as exact; and its speed."""
    body, generator = random_body(seed), np.random.default_rng(seed)
    speed = float(modes(body.matrices).natural_frequency[2] * generator.uniform(0.3, 2.0))
    force = generator.normal(size=(4, 6)) + 1j * generator.normal(size=(4, 6))
    found = response(dynamics(body.matrices, ORDERS * speed), force, np.zeros((4, 6)))
    return body.matrices, exactly(found.value), speed


def form(weight: np.ndarray, state: list[mpmath.mpc], conjugate: bool) -> mpmath.mpc:
    left = [mpmath.conj(x) if conjugate else x for x in state]
    moved = exact(weight) @ np.array(state, dtype=object)
    return mpmath.fsum(a * b for a, b in zip(left, moved, strict=True))


def judge(value: np.ndarray, error: np.ndarray, truth: list[mpf]) -> list[float]:
    """Estimates over true errors; asserts that no estimate is below the true error."""
    ratios = []
    for v, e, t in zip(np.ravel(value).tolist(), np.ravel(error).tolist(), truth, strict=True):
        off = float(abs(mpf(v) - t))
        assert off <= e, (v, e, off)
        ratios.append(e / max(off, 1e-18 * abs(v)))
    return ratios


@pytest.mark.parametrize("kind", ["kinetic", "potential"])
def test_orders_and_totals_against_fifty_digits(kind: str) -> None:
    ratios: list[float] = []
    with mpmath.workdps(50):
        for seed in SEEDS:
            matrices, motion, speed = motion_of(seed)
            # entries taken as exact, so that only the rounding of the energies is judged
            weight = exactly(matrices.mass if kind == "kinetic" else matrices.stiffness)
            rate = [mpmath.mpc(0, 1) * int(n) * mpf(speed) for n in ORDERS]
            rows = [[mpmath.mpmathify(complex(x)) for x in row] for row in motion.value]
            state = motion
            if kind == "kinetic":
                state = velocity(motion, ORDERS * speed)
                rows = [[r * x for x in row] for r, row in zip(rate, rows, strict=True)]
            means = [form(weight.value, row, True).real / 4 for row in rows]
            turning = [abs(form(weight.value, row, False)) / 4 for row in rows]
            each = energy_by_order(weight, state)
            ratios += judge(each.mean, each.mean_error, means)
            peaks = [m + t for m, t in zip(means, turning, strict=True)]
            ratios += judge(each.peak, each.peak_error, peaks)
            total = energy_over_cycle(weight, state, ORDERS)
            ratios += judge(total.mean, total.mean_error, [mpmath.fsum(means)])
            # the Cholesky factor makes a length of the energy, in another way than the package
            lower = mpmath.cholesky(mpmath.matrix(exact(weight.value).tolist()))
            lengths = [list(lower.T * mpmath.matrix(row)) for row in rows]
            length, _ = exact_peak(list(zip(*lengths, strict=True)), ORDERS.tolist())
            ratios += judge(total.peak, total.peak_error, [length**2 / 2])
    assert np.median(ratios) < 1000.0


@pytest.mark.parametrize("seed", SEEDS)
def test_mean_and_peak_are_those_of_the_motion_in_time(seed: int) -> None:
    matrices, motion, speed = motion_of(seed)
    angles = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    waves = np.exp(1j * np.multiply.outer(ORDERS, angles))
    both = energies_over_cycle(matrices, motion, ORDERS, speed)
    for energy, weight, state in (
        (both.kinetic, matrices.mass, velocity(motion, ORDERS * speed).value),
        (both.potential, matrices.stiffness, motion.value),
    ):
        signal = (state.T @ waves).real
        sampled = 0.5 * np.sum(signal * (weight @ signal), axis=0)
        assert energy.mean == pytest.approx(sampled.mean(), rel=1e-12)
        assert sampled.max() <= energy.peak + energy.peak_error
        assert sampled.max() == pytest.approx(energy.peak, rel=1e-4)
        there = (state.T @ np.exp(1j * ORDERS * energy.angle)).real
        assert 0.5 * there @ weight @ there == pytest.approx(energy.peak, rel=1e-12)


def test_circle_and_line() -> None:
    """A body on a circle has the same energy all the time, one on a line twice its mean."""
    weight = exactly(np.diag([2.0, 2.0, 1.0, 1.0, 1.0, 1.0]))
    circle, line = np.zeros((2, 1, 6), dtype=complex)
    circle[0, :2], line[0, :2] = [1.0, -1j], [1.0, 1.0]
    for state, mean, peak in ((circle, 1.0, 1.0), (line, 1.0, 2.0)):
        energy = energy_by_order(weight, exactly(state))
        assert energy.mean.item() == pytest.approx(mean, rel=1e-15)
        assert energy.peak.item() == pytest.approx(peak, rel=1e-15)
        total = energy_over_cycle(weight, exactly(state), np.array([3]))
        assert total.peak == pytest.approx(peak, rel=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
def test_work_of_the_load_balances_the_energies(seed: int) -> None:
    """Re(X* F) = 4 (mean potential - mean kinetic) at each order, from X* D X."""
    body, generator = random_body(seed), np.random.default_rng(seed)
    frequency = modes(body.matrices).natural_frequency[3] * generator.uniform(0.3, 3.0, size=4)
    force = generator.normal(size=(4, 6)) + 1j * generator.normal(size=(4, 6))
    motion = response(dynamics(body.matrices, frequency), force, np.zeros((4, 6)))
    kinetic = energy_by_order(mass_of(body.matrices), velocity(motion, frequency))
    potential = energy_by_order(stiffness_of(body.matrices), motion)
    work = np.sum(motion.value.conj() * force, axis=-1).real
    spread = np.sum(motion.error * np.abs(force), axis=-1)
    spread = spread + 4.0 * (kinetic.mean_error + potential.mean_error)
    assert np.all(np.abs(work - 4.0 * (potential.mean - kinetic.mean)) <= spread)


def test_energies_do_not_know_the_unit_of_length() -> None:
    """In millimetres, every coordinate and matrix by its own power of ten, the same joules."""
    matrices, motion, speed = motion_of(3)
    unit = np.array([1e3, 1e3, 1e3, 1.0, 1.0, 1.0])
    pair = np.outer(unit, unit)
    scaled = Matrices(*(part / pair for part in matrices))
    here = energies_over_cycle(matrices, motion, ORDERS, speed)
    there = energies_over_cycle(scaled, exactly(motion.value * unit), ORDERS, speed)
    for one, other in zip(here, there, strict=True):
        assert abs(one.peak - other.peak) <= one.peak_error + other.peak_error
        assert abs(one.mean - other.mean) <= one.mean_error + other.mean_error


def test_high_orders_underflow_to_zero_and_keep_their_digits_until_then() -> None:
    """Orders to 240 of a piston: energies go down to 1e-320 and beyond."""
    matrices = ong.si_matrices()
    orders = np.arange(2, 241, 2)
    acceleration = -motion_harmonics(ong.RADIUS / ong.LENGTH, 240, derivative=2)[orders]
    force = acceleration[:, None] * np.array([0.0, 1.0, 0.0, ong.LEVER_A * ong.INCH, 0.0, 0.0])
    rate = orders * ong.SPEED
    motion = response(dynamics(matrices, rate), force, 1e-15 * np.abs(force))
    state = velocity(exactly(motion.value), rate)
    energy = energy_by_order(mass_of(matrices), state)
    assert np.all(np.isfinite(energy.mean)) and np.all(np.isfinite(energy.mean_error))
    assert energy.mean[orders < 150].min() > 1e-308
    assert np.all(energy.mean[orders > 190] == 0.0)
    assert np.all(np.diff(energy.mean) <= 0.0)
    with mpmath.workdps(50):
        seen = 0
        for n, v, error in zip(orders, energy.mean, energy.mean_error, strict=True):
            x = motion.value[n // 2 - 1]
            row = [mpmath.mpmathify(complex(one)) * int(n) * mpf(ong.SPEED) for one in x]
            truth = form(matrices.mass, row, True).real / 4
            assert abs(mpf(float(v)) - truth) <= error
            if v > 1e-300:
                assert error < 1e-13 * v
            seen += 0.0 < v < 2.3e-308
        # some are below the smallest normal double
        assert seen > 1


def test_a_state_below_all_squares_has_no_energy() -> None:
    weight = exactly(np.eye(6))
    tiny = exactly(np.full((2, 6), 1e-300 + 0j))
    total = energy_over_cycle(weight, tiny, np.array([1, 2]))
    assert total.mean == total.peak == 0.0
    assert 0.0 < total.mean_error < 1e-320
    nothing = energy_over_cycle(weight, exactly(np.zeros((2, 6), dtype=complex)), np.array([1, 2]))
    assert (nothing.mean, nothing.peak, nothing.peak_error) == (0.0, 0.0, 0.0)


def totals(kept: int, guard: int, tail: float, ratio: float) -> CycleEnergy:
    """Kinetic energy of cylinder A with orders to `kept` + `guard` at a ratio R/L."""
    matrices = ong.si_matrices()
    highest = kept + guard
    orders = np.array([1, *range(2, highest + 1, 2)])
    acceleration = -motion_harmonics(ratio, highest, derivative=2)[orders]
    force = acceleration[:, None] * np.array([0.0, 1.0, 0.0, ong.LEVER_A * ong.INCH, 0.0, 0.0])
    motion = response(dynamics(matrices, orders * ong.SPEED), force, 1e-15 * np.abs(force))
    used = int(np.count_nonzero(orders <= kept))
    state = velocity(motion, orders * ong.SPEED)
    return energy_over_cycle(mass_of(matrices), state, orders, used, tail)


@pytest.mark.parametrize("ratio", [0.2105, 0.9, 0.999999])
def test_dropped_orders_are_in_the_errors(ratio: float) -> None:
    """Few orders, the next as guards, against many; up to a crank as long as the rod."""
    whole = totals(400, 0, 0.0, ratio)
    for kept in (2, 10, 40):
        cut = totals(kept, 400 - kept, 1.0, ratio)
        assert abs(whole.mean - cut.mean) <= cut.mean_error + whole.mean_error
        assert abs(whole.peak - cut.peak) <= cut.peak_error + whole.peak_error
        blind = totals(kept, 400 - kept, 0.0, ratio)
        assert blind.mean == cut.mean
        if ratio > 0.99 or kept == 2:
            # the difference is real, and without the tail it would be missed
            assert whole.mean - blind.mean > blind.mean_error + whole.mean_error


def test_free_body_stores_nothing_in_its_springs() -> None:
    """Stiffness with free motions: their potential energy is zero to rounding, never less."""
    stiffness = np.array([[1e5, -3e4], [-3e4, 9e3]])
    full = np.zeros((6, 6))
    full[:2, :2] = stiffness
    free = np.zeros((1, 6), dtype=complex)
    free[0, :3] = [0.3, 1.0, 2.0j]
    weight = exactly(full)
    energy = energy_by_order(weight, exactly(free))
    assert 0.0 <= energy.mean.item() <= energy.mean_error.item() < 1e-10
    total = energy_over_cycle(weight, exactly(free), np.array([1]))
    assert 0.0 <= float(total.peak) <= float(total.peak_error) < 1e-8


def test_energy_without_a_lower_bound_is_refused() -> None:
    weight = exactly(np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1e-6]))
    with pytest.raises(NumericalFailure, match="no lower bound"):
        energy_over_cycle(weight, exactly(np.ones((1, 6)) + 0j), np.array([1]))
    pair = np.eye(6)
    pair[0, 1] = pair[1, 0] = 1.0 + 1e-9
    with pytest.raises(NumericalFailure, match="negative eigenvalue"):
        energy_over_cycle(exactly(pair), exactly(np.ones((1, 6)) + 0j), np.array([1]))
