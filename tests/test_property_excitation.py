"""Claim: what cancels in sums of forces does so within its error, the rest is refused in words;
firing orders and banks stand the throws right and say which orders are major.
"""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from crank_trains import ACROSS, STROKE, generator, motion, train
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.balance import residual
from vibecalc.excitation.cylinder_torque import bank_factor, major_orders, order_ranks, phase_sums
from vibecalc.excitation.inertia_forces import (
    at_speed,
    reciprocating_excitation,
    rotating_excitation,
)
from vibecalc.excitation.rod_inertia import rod_couple_peak, split_inertia
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.crank_train import build_crank_train
from vibecalc.parts.firing import CYCLES, angles_in_order, phase_of

RATIO = 0.3
MOTION = motion(RATIO, 8)


def pistons(phases: object, **options: object) -> Bounded:
    return reciprocating_excitation(MOTION, **train(phases, **options))  # type: ignore[arg-type]


def test_a_shaft_above_the_highest_order_is_left_out_as_documented() -> None:
    found = rotating_excitation(
        unbalance=[0.01, 0.02],
        speed_ratio=[1, 2],
        phase=[0.0, 0.0],
        position=np.zeros((2, 3)),
        origin=np.zeros(3),
        stroke=STROKE,
        across=ACROSS,
        highest_order=1,
    )
    assert np.abs(found.value).max() == pytest.approx(0.01, rel=1e-15)


def test_residual_is_the_weighted_norm_and_its_error_covers_a_zero() -> None:
    one = at_speed(pistons([0.3], positions=[0.2]), 100.0)
    value, error = residual(one, force_weight=2.0, couple_weight=0.5, reference_length=0.1).norm()
    force, couple = np.abs(one.value[:, :3]), np.abs(one.value[:, 3:])
    size = math.sqrt(4.0 * np.sum(force**2) + 25.0 * np.sum(couple**2))
    assert value == pytest.approx(size, rel=1e-14)
    assert 0 < error < 1e-13 * value
    # Six in line balances all but orders 6, 12 ..: five orders of it are a zero.
    six = np.radians([0, 120, 240, 240, 120, 0])
    row = reciprocating_excitation(
        MOTION[:6],
        **train(six, positions=np.linspace(-0.25, 0.25, 6)),  # type: ignore[arg-type]
    )
    value, error = residual(row, reference_length=0.1).norm()
    assert 0 < value <= error < 1e-13
    empty = Bounded(np.zeros((2, 6)), np.zeros((2, 6)))
    assert tuple(residual(empty, reference_length=1.0).norm()) == (0.0, 0.0)


def test_numbers_beyond_double_precision_are_refused() -> None:
    words = r"not finite numbers at a crank speed of 1e\+200"
    with np.errstate(all="ignore"), pytest.raises(NumericalFailure, match=words):
        at_speed(pistons([0.0]), 1e200)


def test_cylinders_override_the_masses_of_the_train() -> None:
    train = generator(
        machine__crank_train__cylinders=[
            {"name": "a", "reciprocating_mass": 0.7},
            {"name": "b", "position": 0.1, "rotating_mass": 0.3},
        ],
        machine__crank_train__rotating_mass=0.1,
    ).machine.crank_train
    built = build_crank_train(train)
    assert built.reciprocating_mass.tolist() == [0.7, 0.4]
    assert built.rotating_mass.tolist() == [0.1, 0.3]
    assert built.names == ("a", "b")


shares = st.lists(
    st.tuples(st.floats(1e-3, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=6, unique=True
)


def rod_of(parts, length):
    """Mass, distance of the centre from the crank pin, moment about it."""
    mass, place = np.array(parts).T
    place = length * place
    first = float(mass @ place / mass.sum())
    return float(mass.sum()), first, float(mass @ (place - first) ** 2)


@settings(max_examples=150, deadline=None)
@given(shares, st.floats(0.01, 0.95), st.floats(-0.9, 0.9), st.floats(0.01, 10.0))
def test_bound_holds_for_rods_of_point_masses(parts, ratio, offset, length):
    mass, first, inertia = rod_of(parts, length)
    lengths = (length * ratio * (1.0 - abs(offset)), length, length * offset)
    points = split_inertia(mass, first, length)
    bound = rod_couple_peak(points.value, *lengths)
    rounding = 1e-14 * mass * length**2
    couple = rod_couple_peak(Bounded(inertia - points.value, np.asarray(rounding)), *lengths)
    assert couple.value <= bound.value + couple.error + bound.error
    assert points.value >= inertia - rounding


FOUR_STROKE = CYCLES["four_stroke"]
ORDER = np.arange(1, 25) / 2.0


def angles(order: Sequence[int], cycle: float, intervals: Sequence[float] = ()) -> np.ndarray:
    """Firing angle of each cylinder by its number from 1."""
    found = angles_in_order([str(number) for number in order], intervals, cycle, 0.0)
    return np.array([found[str(number)] for number in sorted(order)])


def test_a_v8_with_shared_pins_is_a_cross_plane() -> None:
    """1-8-4-3-6-5-7-2 in two banks 90 degrees apart: four pins at 0, 90, 270, 180 degrees."""
    firing = angles([1, 8, 4, 3, 6, 5, 7, 2], FOUR_STROKE)
    bank = np.radians([45.0, -45.0] * 4)
    phase = np.array([phase_of(b, f) for b, f in zip(bank, firing, strict=True)])
    pins = np.degrees(phase - phase[0]) % 360.0
    assert pins[::2] == pytest.approx([0.0, 90.0, 270.0, 180.0], abs=1e-12)
    assert pins[1::2] == pytest.approx(pins[::2], abs=1e-12)
    assert np.array_equal(ORDER[major_orders(firing, ORDER)], [4.0, 8.0, 12.0])
    # each bank fires unevenly, and alone it is in phase at the same orders
    assert np.array_equal(ORDER[major_orders(firing, ORDER, bank)], [4.0, 8.0, 12.0])


def test_orders_of_a_v12_of_90_degrees_are_major_by_bank() -> None:
    """A bank fires every 120 degrees; the other one 90 degrees later, or 30 earlier."""
    intervals = np.radians([90.0, 30.0] * 6)
    firing = angles([1, 12, 5, 8, 3, 10, 6, 7, 2, 11, 4, 9], FOUR_STROKE, list(intervals))
    bank = np.repeat([-0.25 * np.pi, 0.25 * np.pi], 6)
    assert np.array_equal(ORDER[major_orders(firing, ORDER)], [12.0])
    assert np.array_equal(ORDER[major_orders(firing, ORDER, bank)], [3.0, 9.0, 12.0])
    factor, error = bank_factor(firing, ORDER, bank)
    for order, by_hand in ((3.0, 0.5**0.5), (6.0, 0.0), (9.0, 0.5**0.5), (12.0, 1.0), (1.5, 0.0)):
        place = int(np.flatnonzero(order == ORDER)[0])
        assert abs(factor[place] - by_hand) <= error[place] + 1e-15
    rigid = phase_sums(np.ones((1, 12)), firing, ORDER)
    rank = order_ranks(rigid.relative, rigid.error)[0]
    assert [ORDER[rank == place].tolist() for place in (1, 2)] == [[12.0], [3.0, 9.0]]
    assert np.count_nonzero(rank) == 3


def test_a_twin_on_one_pin_fires_unevenly() -> None:
    """Banks of 45 degrees: 315 and 405 degrees between firings, in line at multiples of 8."""
    firing = angles([1, 2], FOUR_STROKE, list(np.radians([315.0, 405.0])))
    assert np.degrees(firing) == pytest.approx([0.0, 315.0])
    bank = np.radians([22.5, -22.5])
    assert np.ptp([phase_of(b, f) for b, f in zip(bank, firing, strict=True)]) < 1e-14
    assert np.array_equal(ORDER[major_orders(firing, ORDER)], [8.0])


@pytest.mark.parametrize(("cylinders", "cycle"), [(3, 2), (5, 4), (6, 4), (7, 2), (12, 4)])
def test_even_firing_leaves_a_rigid_mode_its_major_orders_only(cylinders: int, cycle: int) -> None:
    order = np.arange(1, 61) * (2.0 / cycle)
    shuffled = np.random.default_rng(cylinders).permutation(cylinders) + 1
    firing = angles(shuffled.tolist(), cycle * np.pi)
    assert np.diff(np.sort(firing)) == pytest.approx(cycle * np.pi / cylinders, rel=1e-13)
    sums = phase_sums(np.ones((1, cylinders)), firing, order)
    major = order % (cylinders * 2.0 / cycle) == 0.0
    assert np.array_equal(major_orders(firing, order), major)
    assert sums.relative[0] == pytest.approx(major.astype(float), abs=2e-14)
