"""Claim: a motor's curve goes through its table, is odd, continuous, and keeps its peak."""

import numpy as np
import pytest
from roll_machines import columns

from vibecalc.excitation.slip_torque import (
    SlipCurve,
    breakdown,
    interval_of,
    linear_motor,
    slip_curve,
    slip_torque,
)

SLIP, TORQUE = columns("roll_motor.csv")
#: tables of one and two rows beyond zero, one that falls at once, and one with uneven steps
KINDS = ("linear", "parabola", "monotone")
TABLES = {
    "source": (SLIP, TORQUE),
    "two": (np.array([0.0, 5.0]), np.array([0.0, 80.0])),
    "falling": (np.array([0.0, 1.0, 4.0]), np.array([0.0, 90.0, 30.0])),
    "uneven": (np.array([0.0, 0.1, 7.0, 7.5, 30.0]), np.array([0.0, 9.0, 80.0, 95.0, 94.0])),
}


def value(curve: SlipCurve, slip: np.ndarray) -> np.ndarray:
    return slip_torque(curve, np.asarray(slip)).value


@pytest.fixture(params=[(t, k) for t in TABLES for k in KINDS], ids="-".join)
def drawn(request: pytest.FixtureRequest) -> tuple[np.ndarray, np.ndarray, SlipCurve, str]:
    table, kind = request.param
    slip, torque = TABLES[table]
    return slip, torque, slip_curve(slip, torque, kind), kind


def test_through_the_nodes_on_both_sides(drawn) -> None:
    slip, torque, curve, _ = drawn
    largest = np.max(torque)
    np.testing.assert_allclose(value(curve, slip), torque, rtol=0, atol=1e-14 * largest)
    np.testing.assert_allclose(value(curve, -slip), -torque, rtol=0, atol=1e-14 * largest)
    assert curve.largest == slip[-1]


def test_continuous_at_every_threshold(drawn) -> None:
    _, torque, curve, kind = drawn
    above = interval_of(curve, curve.threshold)
    upper = slip_torque(curve, curve.threshold, above)
    lower = slip_torque(curve, curve.threshold, above - 1)
    np.testing.assert_allclose(upper.value, lower.value, rtol=0, atol=1e-13 * np.max(torque))
    if kind == "monotone":
        inner = slice(1, -1)
        size = np.max(np.abs(upper.slope))
        np.testing.assert_allclose(
            upper.slope[inner], lower.slope[inner], rtol=0, atol=1e-13 * size
        )


def test_slope_is_the_derivative(drawn) -> None:
    slip, _, curve, _ = drawn
    middles = np.concatenate([0.5 * (slip[1:] + slip[:-1]), -0.3 * slip[1:] - 0.7 * slip[:-1]])
    interval = interval_of(curve, middles)
    away = (middles - curve.base[interval]) + 1e-30j
    rows = curve.coefficient[interval]
    truth = np.imag(sum(rows[:, k] * away**k for k in range(rows.shape[1]))) / 1e-30
    np.testing.assert_allclose(slip_torque(curve, middles).slope, truth, rtol=1e-13)


def test_beyond_the_table_the_last_torque_is_kept(drawn) -> None:
    slip, torque, curve, _ = drawn
    for sign in (1.0, -1.0):
        found = slip_torque(curve, sign * np.array([slip[-1] * 1.01, slip[-1] * 50.0]))
        np.testing.assert_array_equal(found.value, sign * torque[-1])
        np.testing.assert_array_equal(found.slope, 0.0)


def test_monotone_between_nodes() -> None:
    for slip, torque in TABLES.values():
        curve = slip_curve(slip, torque, "monotone")
        for low, high, a, b in zip(slip, slip[1:], torque, torque[1:], strict=False):
            inside = value(curve, np.linspace(low, high, 201))
            step = np.diff(inside) * np.sign(b - a)
            assert np.min(step) > -1e-12 * np.max(torque)


@pytest.mark.parametrize("kind", KINDS)
def test_breakdown_is_the_peak(kind: str) -> None:
    for slip, torque in TABLES.values():
        curve = slip_curve(slip, torque, kind)
        at, peak = breakdown(curve)
        assert value(curve, np.array([at]))[0] == pytest.approx(peak, rel=1e-13)
        every = value(curve, np.linspace(0.0, slip[-1], 200001))
        assert peak >= np.max(every) * (1.0 - 1e-14)
        assert peak == pytest.approx(np.max(every), rel=1e-6)
        if kind != "parabola":
            assert (at, peak) == (pytest.approx(slip[np.argmax(torque)]), torque.max())


def test_linear_motor_has_no_peak() -> None:
    curve = linear_motor(203.4)
    found = slip_torque(curve, np.array([-5.0, 0.0, 1e3]))
    np.testing.assert_allclose(found.value, [-1017.0, 0.0, 203400.0], rtol=1e-15)
    np.testing.assert_array_equal(found.slope, 203.4)
    assert breakdown(curve) == (np.inf, np.inf)
