"""Claim: sums over orders have their true ends, barred ranges lie where closed forms put them;
errors of shapes hold, and are small, where a mode fades; a gear without load counts the lower one
of its torques.
"""

import mpmath
import numpy as np
import pytest
from random_lines import random_line

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.critical_speeds import barred_ranges
from vibecalc.torsion.forced import ROWS, largest_half_range
from vibecalc.torsion.line import chain, stiffness_matrix
from vibecalc.torsion.modes import natural_modes


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


def test_barred_ranges_end_where_the_closed_form_crosses_its_limit():
    def excess(speed):
        return 1.0 / np.abs(speed - 3.0) - 4.0

    with np.errstate(divide="ignore"):
        found = barred_ranges(excess, np.linspace(0.0, 6.0, 25))
    assert (found.start[0], found.end[0]) == pytest.approx((2.75, 3.25), rel=1e-15)
    open_ = barred_ranges(lambda speed: np.cos(speed), np.linspace(0.0, 5.0, 40))
    assert open_.start.tolist() == pytest.approx([0.0, 1.5 * np.pi], rel=1e-15)
    assert open_.end.tolist() == pytest.approx([0.5 * np.pi, 5.0], rel=1e-15)
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


def test_errors_of_a_shape_that_fades() -> None:
    inertia = np.array([1.0, 1.1, 0.9, 1.0, 1.2, 40.0, 3.0, 0.01])
    line = chain(inertia, np.array([1e6, 1.1e6, 0.9e6, 1e6, 1e6, 3e5, 2e6]))
    modes = natural_modes(line)
    shape = with_errors(lambda one: natural_modes(one).shape, line)
    with mpmath.workdps(40):
        root = [mpmath.sqrt(mpmath.mpf(j)) for j in inertia.tolist()]
        matrix = mpmath.matrix(stiffness_matrix(line).tolist())
        for a in range(8):
            for b in range(8):
                matrix[a, b] /= root[a] * root[b]
        _, vectors = mpmath.eigsy(matrix)
        true = [[vectors[a, m] / root[a] for a in range(8)] for m in range(8)]
        rows = []
        for own, angle in zip(true, modes.shape.tolist(), strict=True):
            top = int(np.argmax(np.abs(angle)))
            rows.append(
                [float(x / own[top] * angle[top] - y) for x, y in zip(own, angle, strict=True)]
            )
    error, reported = np.abs(rows)[1:], shape.error[1:]
    assert np.all(error <= 10.0 * reported)
    # the first station all but stands still in the highest mode
    assert abs(modes.shape[-1, 0]) < 1e-9
    assert reported[-1, 0] < 0.01 * modes.shape_error[-1]
    twist = with_errors(lambda one: natural_modes(one).shape @ [1.0, -1.0, *6 * [0.0]], line)
    off = float(twist.error[-1])
    assert abs(rows[-1][0] - rows[-1][1]) <= 10.0 * off < 0.1 * modes.shape_error[-1]


def test_a_gear_without_load_counts_the_lower_torque() -> None:
    table = random_line(11)
    table["response"]["torsion"].pop("speeds", None)
    record = run_case(validate(table))
    place = "response/torsion/gear/"
    mean, half, least = (
        record[place + name] for name in ("mean_torque", "alternating_torque", "minimum_torque")
    )
    loaded, *idle = range(len(mean.values))
    assert abs(mean.values[loaded]) > 1e3 * mean.error_estimate
    assert idle and np.all(np.abs(mean.values[idle]) <= mean.error_estimate)
    # the lower one of both ends is at least half a range below zero
    assert np.all(least.values[idle] <= -half.values[idle] + least.error_estimate)
