"""Claim: firing orders and banks stand the throws right and say which orders are major."""

from collections.abc import Sequence

import numpy as np
import pytest

from vibecalc.excitation.cylinder_torque import bank_factor, major_orders, order_ranks, phase_sums
from vibecalc.parts.firing import CYCLES, angles_in_order, phase_of

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
