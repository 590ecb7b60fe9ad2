"""Claim: forces and couples obey the laws of balancing, of statics and of energy.

What cancels does so within the error estimate of the sum, and the estimate is round-off small.
"""

import math

import numpy as np
import pytest
from crank_trains import AXIS, motion, train, turning
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.balance import balance_table, residual
from vibecalc.excitation.inertia_forces import (
    Excitation,
    about_point,
    add,
    at_speed,
    inertia_torque,
    reciprocating_excitation,
    rotating_excitation,
    torque_reaction,
)

RATIO = 0.3
MOTION = motion(RATIO, 8)
MASS, RADIUS = 0.4, 0.06
PULL = MASS * RADIUS  # primary force of one cylinder per speed squared
angles = st.floats(-7.0, 7.0)
lengths = st.floats(-0.5, 0.5)


def pistons(phases: object, **options: object) -> Excitation:
    return reciprocating_excitation(MOTION, **train(phases, **options))  # type: ignore[arg-type]


def vanishes(values: np.ndarray, errors: np.ndarray, scale: float) -> bool:
    return bool(np.all(np.abs(values) <= errors) and np.all(errors < 1e-12 * scale))


def test_one_cylinder_pushes_outwards_at_top_dead_centre() -> None:
    one = pistons([0.0])
    acceleration = one.force[:, 2].sum().real  # angle zero: all harmonics in phase
    assert acceleration == pytest.approx(PULL * (1 + RATIO), rel=1e-4)  # R (1 + R/L) w^2 m
    assert vanishes(one.force[:, :2], one.force_error[:, :2], PULL)
    assert not one.couple.any()


@given(st.integers(2, 9), angles)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_equal_spacing_leaves_only_multiples_of_the_number(count: int, start: float) -> None:
    phases = start + 2 * math.pi * np.arange(count) / count
    force, _, error, _ = pistons(phases)
    for order in range(1, 9):
        row, slip = force[order - 1], error[order - 1]
        if order % count:
            assert vanishes(row, slip, count * PULL)
        else:
            alone = pistons([start]).force[order - 1]
            assert np.all(np.abs(row - count * alone) <= 2 * slip)


@given(st.lists(st.tuples(angles, lengths), min_size=1, max_size=6))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_mirrored_train_has_no_couple(half: list[tuple[float, float]]) -> None:
    phases = [phase for phase, _ in half] * 2
    positions = [place for _, place in half] + [-place for _, place in half]
    both = pistons(phases, positions=positions)
    assert np.all(np.abs(both.couple) <= both.couple_error)
    assert both.couple_error.max() < 1e-12


@given(angles, angles, lengths, st.floats(-0.02, 0.02))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_turning_throw_and_cylinder_turns_the_force(
    phase: float, turn: float, place: float, offset: float
) -> None:
    """Cylinder and throw turned together are the same cylinder seen from turned axes."""
    harmonics = motion(RATIO, 8, offset / RADIUS)
    options = {"positions": [place], "offset": offset}
    upright = reciprocating_excitation(harmonics, **train([phase], **options))  # type: ignore[arg-type]
    tilted = reciprocating_excitation(
        harmonics,
        **train([phase + turn], banks=[turn], **options),  # type: ignore[arg-type]
    )
    c, s = math.cos(turn), math.sin(turn)
    rotate = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])  # right-handed about x
    assert np.abs(tilted.force - upright.force @ rotate.T).max() < 1e-13
    assert np.abs(tilted.couple - upright.couple @ rotate.T).max() < 1e-13


def test_boxer_leaves_a_couple_only() -> None:
    pair = pistons([0.0, math.pi], banks=[0.0, math.pi], positions=[-0.02, 0.02])
    assert vanishes(pair.force, pair.force_error, PULL)
    # Opposite pushes 0.04 m apart: the couple about y is minus the sum of z times force.
    assert pair.couple[0, 1] == pytest.approx(0.04 * PULL * MOTION[1].real, rel=1e-12)
    assert vanishes(pair.couple[:, [0, 2]], pair.couple_error[:, [0, 2]], PULL)


def test_v_twin_of_90_degrees_with_a_counterweight_has_no_primary_force() -> None:
    twin = pistons([0.0, 0.0], banks=[-math.pi / 4, math.pi / 4])
    weight = rotating_excitation(**turning(PULL, 1, math.pi, highest=8))
    both = add(twin, weight)
    assert np.abs(twin.force[0]).max() > 0.9 * PULL
    assert np.all(np.abs(both.force[0]) <= both.force_error[0] + 1e-13 * PULL)
    # The secondary force that stays acts across the V, sqrt(2) times that of one cylinder.
    second = math.sqrt(2) * abs(4 * MOTION[2]) * PULL
    assert abs(both.force[1, 1]) == pytest.approx(second, rel=1e-12)
    assert abs(both.force[1, 2]) < 1e-13 * PULL


def test_lanchester_shafts_take_the_secondary_force_of_a_four() -> None:
    four = pistons([0.0, math.pi, math.pi, 0.0], positions=[-0.15, -0.05, 0.05, 0.15])
    shaft = PULL * MOTION[2].real * 4 / 2  # each carries half of 4 x 4 C_2, at twice the speed
    place = [(0.0, -0.1, 0.05), (0.0, 0.1, 0.05)]
    shafts = rotating_excitation(
        **turning([shaft, shaft], [2, -2], math.pi, position=place, highest=8)
    )
    both = add(four, shafts)
    assert abs(four.force[1, 2]) > PULL
    assert vanishes(both.force[:3], both.force_error[:3], 4 * PULL)
    assert vanishes(both.couple[:3], both.couple_error[:3], 4 * PULL)
    # At different heights their sideways forces make a couple that rolls the body.
    staggered = rotating_excitation(
        **turning([shaft, shaft], [2, -2], math.pi, position=[(0, -0.1, 0.05), (0, 0.1, -0.05)])
    )
    assert abs(staggered.couple[1, 0]) == pytest.approx(0.1 * 4 * shaft, rel=1e-12)


@given(angles, st.sampled_from([1, -1, 2, -2]), st.floats(0.0, 6.28))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_an_unbalance_points_where_its_angle_says(phase: float, ratio: int, crank: float) -> None:
    force = rotating_excitation(**turning(0.01, ratio, phase)).force
    now = sum((force[n - 1] * np.exp(1j * n * crank)).real for n in range(1, 5))
    where = phase + ratio * crank  # right-handed about x, from z: z goes to -y
    expected = 0.01 * ratio**2 * np.array([0.0, -math.sin(where), math.cos(where)])
    assert now == pytest.approx(expected, abs=1e-15)


def test_a_shaft_above_the_highest_order_is_left_out_as_documented() -> None:
    result = rotating_excitation(**turning([0.01, 0.02], [1, 2], highest=1))
    assert np.abs(result.force).max() == pytest.approx(0.01, rel=1e-15)


@given(st.tuples(lengths, lengths, lengths), st.tuples(lengths, lengths, lengths), angles)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_moving_the_origin_adds_r_cross_f(
    origin: tuple[float, ...], shift: tuple[float, ...], phase: float
) -> None:
    options = {"positions": [0.1, -0.2, 0.3], "banks": [0.2, -0.4, 0.0], "offset": 0.004}
    phases = [phase, 1.0, 2.0]
    here = pistons(phases, origin=origin, **options)
    there = pistons(phases, origin=np.add(origin, shift), **options)
    assert np.abs(there.couple - here.couple - np.cross(shift, here.force)).max() < 1e-15
    # Seen from a point that moved with the train nothing has changed.
    followed = about_point(there, shift)
    assert np.all(np.abs(followed.couple - here.couple) <= 2 * followed.couple_error + 1e-17)
    assert followed.couple_error.max() < 1e-15


def test_torque_is_the_rate_of_kinetic_energy() -> None:
    torque = inertia_torque(motion(RATIO, 40), 8)
    angle = 2 * np.pi * np.arange(512) / 512
    n = np.arange(41)
    speed = ((1j * n * motion(RATIO, 40)) * np.exp(1j * np.outer(angle, n))).real.sum(-1)
    energy = np.fft.rfft(speed**2 / 2)[:9] * 2 / 512
    assert np.abs(torque.harmonics + 1j * np.arange(9) * energy).max() < 1e-14
    assert torque.harmonics[0] == 0.0


def test_classic_torque_amplitudes() -> None:
    """First terms in powers of R/L as in Den Hartog, Mechanical Vibrations, section 5.2."""
    lam = 1e-3
    torque = inertia_torque(np.array([0.0, 1.0, lam / 4, 0.0]), 3).harmonics
    # T / (m R^2 w^2) = lam/4 sin a - 1/2 sin 2a - 3 lam/4 sin 3a; sin is -i in Re(T exp(i a)).
    assert torque[1:] == pytest.approx([-0.25j * lam, 0.5j, 0.75j * lam], abs=1e-18)


def test_separate_machine_puts_a_couple_about_the_shaft_only() -> None:
    phases = np.radians([120.0, 0.0, 240.0])
    arguments = train(phases)
    names = ("crank_radius", "reciprocating_mass", "crank_phase", "bank_angle", "axis")
    torque = inertia_torque(motion(RATIO, 40), 8)
    reaction = torque_reaction(torque, **{name: arguments[name] for name in names})
    assert not reaction.force.any()
    assert not reaction.couple[:, 1:].any()
    # Three equal cylinders leave the multiples of three.
    kept = -3 * MASS * RADIUS**2 * torque.harmonics[[3, 6]]
    assert reaction.couple[[2, 5], 0] == pytest.approx(kept, rel=1e-12)
    rest = [0, 1, 3, 4, 6, 7]
    assert vanishes(reaction.couple[rest, 0], reaction.couple_error[rest, 0], MASS * RADIUS**2)


def test_leading_axes_broadcast() -> None:
    phases = np.random.default_rng(5).uniform(0, 6, (7, 3))
    options = {"positions": [-0.3, 0.0, 0.3]}
    ratios = np.stack([motion(r, 4) for r in np.linspace(0.1, 0.5, 7)])
    stacked = reciprocating_excitation(ratios, **train(phases, **options))  # type: ignore[arg-type]
    assert stacked.force.shape == (7, 4, 3)
    for k in range(7):
        alone = reciprocating_excitation(ratios[k], **train(phases[k], **options))  # type: ignore[arg-type]
        for many, one in zip(stacked, alone, strict=True):
            assert np.abs(many[k] - one).max() <= 1e-16
    table = balance_table(
        [1, 2], crank_phase=phases, bank_angle=np.zeros(3), position=[-0.3, 0.0, 0.3]
    )
    assert table.sine.shape == (7, 2, 3)
    speeds = at_speed(pistons(phases[0], **options), np.array([0.0, 10.0, 500.0]))
    assert speeds.force.shape == (3, 8, 3)
    assert not speeds.force[0].any()
    size = residual(speeds, reference_length=0.1)
    assert size.value[2] == pytest.approx(2500.0 * size.value[1], rel=1e-14)


def test_residual_is_the_weighted_norm_and_its_error_covers_a_zero() -> None:
    one = at_speed(pistons([0.3], positions=[0.2]), 100.0)
    value, error = residual(one, force_weight=2.0, couple_weight=0.5, reference_length=0.1)
    size = math.sqrt(4.0 * np.sum(np.abs(one.force) ** 2) + 25.0 * np.sum(np.abs(one.couple) ** 2))
    assert value == pytest.approx(size, rel=1e-14)
    assert 0 < error < 1e-13 * value
    # Six in line balances all but orders 6, 12 ..: five orders of it are a zero.
    six = np.radians([0, 120, 240, 240, 120, 0])
    row = reciprocating_excitation(
        MOTION[:6],
        **train(six, positions=np.linspace(-0.25, 0.25, 6)),  # type: ignore[arg-type]
    )
    value, error = residual(row, reference_length=0.1)
    assert 0 < value <= error < 1e-13
    empty = Excitation(*(np.zeros((2, 3)) for _ in range(4)))
    assert tuple(residual(empty, reference_length=1.0)) == (0.0, 0.0)


def test_numbers_beyond_double_precision_are_refused() -> None:
    words = r"not finite numbers at a crank speed of 1e\+200"
    with np.errstate(all="ignore"), pytest.raises(NumericalFailure, match=words):
        at_speed(pistons([0.0]), 1e200)


def test_bank_angle_shifts_the_balance_table() -> None:
    table = balance_table([2], crank_phase=[0.5], bank_angle=[0.2], position=[2.0])
    assert table.sine[0, 0] == pytest.approx(math.sin(0.6), rel=1e-14)
    assert table.position_cosine[0, 0] == pytest.approx(2 * math.cos(0.6), rel=1e-14)
    assert AXIS.tolist() == [1.0, 0.0, 0.0]
