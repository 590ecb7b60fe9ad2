"""Claim: what cancels in sums of forces does so within its error; the rest is refused in words."""

import math

import numpy as np
import pytest
from crank_trains import ACROSS, STROKE, generator, motion, train
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.balance import residual
from vibecalc.excitation.inertia_forces import (
    at_speed,
    reciprocating_excitation,
    rotating_excitation,
)
from vibecalc.excitation.rod_inertia import rod_couple_peak, split_inertia
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.crank_train import build_crank_train

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
