"""Claim: symmetries, limits and refusals of the slider-crank hold for any machine."""

import numpy as np
import pytest

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import (
    dropped_acceleration,
    harmonics_with_error,
    motion_harmonics,
    order_for_tolerance,
)


def machines(count, seed=1):
    generator = np.random.default_rng(seed)
    ratio = generator.uniform(0.01, 0.97, count)
    offset = generator.uniform(-1, 1, count) * 0.95 * (1 / ratio - 1)
    return ratio, offset


def test_a_zero_offset_changes_no_bit():
    ratio, _ = machines(40)
    plain = harmonics_with_error(ratio, 60)
    for zero in (0.0, -0.0, np.zeros(40)):
        other = harmonics_with_error(ratio, 60, zero)
        assert np.array_equal(plain.values, other.values)
        assert np.array_equal(plain.error, other.error)
    mixed = motion_harmonics(np.repeat(ratio, 2), 60, np.tile([0.0, 0.01], 40))
    assert np.array_equal(mixed[::2], plain.values)
    assert not np.array_equal(mixed[1::2], plain.values)


@pytest.mark.parametrize("offset_ratio", [0.0, 0.4])
@pytest.mark.parametrize("rod_ratio", [0.05, 0.2105, 0.3, 0.7])
@pytest.mark.parametrize("rtol", [1e-2, 1e-6, 1e-12])
def test_the_order_for_a_tolerance_is_the_smallest_that_meets_it(rod_ratio, offset_ratio, rtol):
    order = order_for_tolerance(rod_ratio, rtol, offset_ratio)
    amplitude = np.abs(motion_harmonics(rod_ratio, 400, offset_ratio, derivative=2))
    largest = np.max(amplitude)
    assert dropped_acceleration(rod_ratio, order, offset_ratio) <= rtol * largest * (1 + 1e-12)
    assert dropped_acceleration(rod_ratio, order - 1, offset_ratio) > rtol * largest
    np.testing.assert_allclose(
        dropped_acceleration(rod_ratio, order, offset_ratio),
        np.sum(amplitude[:order:-1]),
        rtol=1e-12,
    )


@pytest.mark.parametrize(
    ("rod_ratio", "offset_ratio", "found"),
    [
        (1.0, 0.0, "R/L = 1 with e/R = 0"),
        (1.2, 0.0, "R/L = 1.2"),
        (0.0, 0.0, "R/L = 0 with"),
        (-0.3, 0.0, "R/L = -0.29"),
        (0.5, 1.0, "e/R = 1;"),
        (0.5, -1.5, "R/L = 0.5 with e/R = 1.5"),
        (float("nan"), 0.0, "R/L = nan"),
    ],
)
def test_a_crank_that_cannot_turn_is_refused_in_words(rod_ratio, offset_ratio, found):
    with pytest.raises(NumericalFailure) as failure:
        motion_harmonics([0.3, rod_ratio], 4, [0.0, offset_ratio])
    assert found in str(failure.value)
    assert "R + |e| below L" in str(failure.value)


def test_too_many_orders_for_a_tolerance_are_refused_in_words():
    with pytest.raises(NumericalFailure, match=r"more than 16384 harmonics .* choose the highest"):
        order_for_tolerance(1.0 - 1e-8, 1e-12)


def test_chosen_orders_hold_where_no_number_of_orders_is_enough():
    crank = {
        "crank_radius": 0.5,
        "rod_length": 0.5000005,
        "reciprocating_mass": 1.0,
        "cylinders": [{"name": "A"}],
    }
    table = {
        "schema": 1,
        "title": "a rod hardly longer than its crank",
        "machine": {"kind": "compressor", "speed": 30.0, "crank_train": crank},
        "kinematics": {},
        "excitation": {"orders": 200},
    }
    found = run_case(validate(table))["kinematics/acceleration_harmonics"]
    expected = motion_harmonics(0.5 / 0.5000005, 200, 0.0)
    unit = 0.5 * 30.0**2 * np.arange(201) ** 2
    assert np.all(np.abs(found.values + unit * expected) <= 1e-12 * unit * np.abs(expected))
    assert len(found.values) == 201
