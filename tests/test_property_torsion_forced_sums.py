"""Claim: sums over orders have their true ends, powers balance, resonances and barred ranges lie
where closed forms put them.
"""

import numpy as np
import pytest

from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.maxima import by_values
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.critical_speeds import barred_ranges
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.section_loads import (
    ROWS,
    largest_half_range,
)


def test_both_ends_of_half_order_sums_are_found_and_attained():
    generator = np.random.default_rng(2)
    order = np.arange(0.0, 12.5, 0.5)
    decay = 10.0 ** -generator.uniform(0, 6, (200, 25)) * 10.0 ** generator.uniform(-9, 9, (200, 1))
    parts = generator.normal(size=(2, 200, 25)) * decay
    amplitude = parts[0] + 1j * parts[1]
    found = synthesis(order, amplitude)
    grid = np.linspace(0.0, 4.0 * np.pi, 6001)
    mean = np.where(order == 0.0, amplitude.real, amplitude)
    scan = (mean @ np.exp(1j * np.multiply.outer(order, grid))).real
    rounding = 1e-14 * found.upper_bound
    assert np.all(found.highest >= scan.max(axis=1) - rounding)
    assert np.all(found.lowest <= scan.min(axis=1) + rounding)
    for end, angle in ((found.highest, found.highest_angle), (found.lowest, found.lowest_angle)):
        at = np.sum(mean * np.exp(1j * order * angle[:, None]), axis=1).real
        np.testing.assert_allclose(at, end, rtol=0, atol=5e-14 * np.max(found.upper_bound))
        assert np.all(np.abs(at - end) <= 5e-14 * found.upper_bound)
        assert np.all((angle >= 0.0) & (angle < 4.0 * np.pi))
    other = cycle_peak(mean, (2 * order).astype(int))
    assert np.all(np.abs(found.peak - other.value) <= found.error + other.error)
    assert np.all(found.half_range == 0.5 * (found.highest - found.lowest))
    assert np.all(found.peak <= found.upper_bound * (1 + 1e-15))


@pytest.mark.parametrize("orders", [np.arange(1.0, 31.0), np.arange(1, 49) / 2, [0, 2, 5.5, 60]])
def test_both_ends_of_sums_whose_peaks_are_hard_to_tell(orders):
    # all at the angle zero, saw teeth, few orders, alike peaks, far below the first order
    generator, order = np.random.default_rng(7), np.asarray(orders, dtype=float)
    shape = (40, len(order))
    size = generator.uniform(0.5, 1.0, shape)
    few = size * (generator.uniform(size=shape) < 0.2)
    faint = np.where(np.arange(len(order)) > 0, 1e-7 * size, 1.0)
    kinds = [size, 1j * size / (1.0 + order), few * np.exp(1j * few), np.round(3.0 * few), faint]
    amplitude = np.concatenate(kinds).astype(complex)
    found = synthesis(order, amplitude)
    number = (2 * order).astype(int)
    mean = np.where(order == 0.0, amplitude.real, amplitude)
    raised = np.concatenate([mean, found.upper_bound[:, None]], axis=1)
    for sign, end in ((1.0, found.highest), (-1.0, -found.lowest)):
        # a mean as large as all the rest makes the highest value the peak
        raised[:, :-1] = sign * mean
        other = cycle_peak(raised, np.append(number, 0))
        allowed = found.error + other.error
        assert np.all(np.abs(end + found.upper_bound - other.value) <= allowed)


def test_sums_of_known_ends():
    # cos a + cos 2 a: 2 at 0, -9/8 at cos a = -1/4; alone, a half order has the cycle of two turns
    found = synthesis([1.0, 2.0], [[1.0, 1.0], [0.0, 0.0]])
    assert found.highest.tolist() == pytest.approx([2.0, 0.0], abs=1e-15)
    assert found.lowest.tolist() == pytest.approx([-1.125, 0.0], abs=1e-15)
    assert np.cos(found.lowest_angle[0]) == pytest.approx(-0.25, abs=1e-7)
    half = synthesis([0.5], [2.0j])
    assert (half.half_range, half.highest_angle) == pytest.approx((2.0, 3.0 * np.pi))
    mean = synthesis([0.0, 1.0], [-5.0 + 1j, 1.0])
    assert (mean.peak, mean.half_range) == pytest.approx((6.0, 1.0))


def oscillator(ratio: float) -> Line:
    """Natural frequency 5, shaft to a station held fast by a ground spring of enormous inertia."""
    none = np.zeros(2)
    return Line(
        np.array([1.0, 1e12]), none, none, np.array([0]), np.array([1]),
        np.array([25.0]), np.array([2.0 * ratio * 5.0]), np.zeros(1),
    )  # fmt: skip


def half_range(line: Line, speeds, orders):
    """Of the first element (s, 1), for a torque of one of every order at the first station."""
    drive = np.ones((len(orders), 1))
    return largest_half_range(line, orders, lambda s: drive, [0], np.ones(1), speeds)[0][:, None]


def test_resonances_of_two_orders_lie_at_the_closed_form():
    ratio, orders = 0.03, np.array([1.0, 2.5])
    speeds = np.linspace(1.0, 8.0, 301)
    damping = 1 + (2 * ratio * speeds / 5) ** 2
    closed = np.sqrt(damping / ((1 - (speeds / 5) ** 2) ** 2 + damping - 1))
    found = half_range(oscillator(ratio), speeds, orders[:1])
    np.testing.assert_allclose(found[:, 0], closed, rtol=1e-10)

    def curve(at):
        return half_range(oscillator(ratio), at, orders[:1])

    # the maximum of the transmissibility: r^2 = (sqrt(1 + 8 z^2) - 1) / (4 z^2)
    true = 5.0 * np.sqrt((np.sqrt(1 + 8 * ratio**2) - 1) / (4 * ratio**2))
    # the station that is held fast moves by 1e-12, more than the speed found is off
    true *= np.sqrt(1.0 + 1e-12)
    found = refined(curve, np.linspace(2.0, 8.0, 61))
    assert len(found.row) == 1
    assert abs(found.place.value[0] - true) <= found.place.error[0] <= 1e-9 * true

    def both(at):
        return half_range(oscillator(ratio), at, orders)

    pair = refined(both, speeds)
    assert pair.place.value * orders[::-1] == pytest.approx([5.0, 5.0], rel=2e-3)
    step = 1e-5 * pair.place.value
    for offset in (-step, step):
        assert np.all(both(pair.place.value + offset)[:, 0] < pair.height.value)


def refined(curve, speeds):
    """Maxima of one curve, each of those among the speeds refined by itself."""
    seen = curve(speeds)[:, 0]
    place = np.flatnonzero((seen[1:-1] > seen[:-2]) & (seen[1:-1] >= seen[2:])) + 1
    return by_values(
        lambda _, at: curve(at.ravel())[:, 0].reshape(at.shape),
        np.arange(len(place)), speeds[place - 1], speeds[place], speeds[place + 1],
    )  # fmt: skip


def test_barred_ranges_end_where_the_closed_form_crosses_its_limit():
    def excess(speed):
        return 1.0 / np.abs(speed - 3.0) - 4.0

    with np.errstate(divide="ignore"):
        found = barred_ranges(excess, np.linspace(0.0, 6.0, 25))
    assert (found.start[0], found.end[0]) == pytest.approx((2.75, 3.25), rel=1e-15)
    assert found.start_crosses.all() and found.end_crosses.all()
    open_ = barred_ranges(lambda speed: np.cos(speed), np.linspace(0.0, 5.0, 40))
    assert open_.start.tolist() == pytest.approx([0.0, 1.5 * np.pi], rel=1e-15)
    assert open_.end.tolist() == pytest.approx([0.5 * np.pi, 5.0], rel=1e-15)
    assert open_.start_crosses.tolist() == [False, True]
    assert open_.end_crosses.tolist() == [True, False]
    assert len(barred_ranges(lambda speed: speed - 9.0, np.linspace(0, 5, 9)).start) == 0


def test_a_masked_speed_has_an_infinite_peak_and_work_is_by_blocks():
    line, asked = chain(np.ones(2), np.array([2.0])), []

    def torque(speed):
        asked.append(len(speed))
        return np.ones((1, 1))

    speeds = np.append(np.linspace(1.0, 1.9, ROWS), [2.0, 3.0])
    value, error = largest_half_range(line, np.ones(1), torque, [0], np.ones(1), speeds)
    assert asked == [ROWS, 2] and np.isinf(value).tolist() == [*[False] * ROWS, True, False]
    assert error[ROWS] == 0.0
