"""Sums over banks against closed forms of the textbooks: V engines, boxers, radial engines.

Source: Biezeno and Grammel, Technische Dynamik, 2nd ed. 1953, ch. XI; Taylor, The Internal
Combustion Engine in Theory and Practice, vol. 2, ch. 8 (V-twin and radial engines).
"""

import numpy as np
import pytest

from vibecalc.excitation.balance import bank_sums

STROKE, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
ORDERS = np.array([1, 2, 4, 6])


def sums(phase: list[float], bank: list[float], place: list[float] | None = None):  # type: ignore[no-untyped-def]
    return bank_sums(
        ORDERS,
        crank_phase=np.array(phase),
        bank_angle=np.array(bank),
        position=np.zeros(len(phase)) if place is None else np.array(place),
        stroke=STROKE,
        across=ACROSS,
    )


@pytest.mark.parametrize("half", np.radians([15.0, 30.0, 45.0, 36.0, 60.0]).tolist())
def test_v_twin_on_one_throw(half: float) -> None:
    """Along the middle 2 cos b cos n b, across 2 sin b sin n b, a quarter of a period apart."""
    found = sums([0.0, 0.0], [half, -half])
    along = 2.0 * np.cos(half) * np.cos(ORDERS * half)
    across = 2.0 * np.sin(half) * np.sin(ORDERS * half)
    assert found["sum"].value[:, 2] == pytest.approx(along, abs=1e-14)
    assert found["sum"].value[:, 1] == pytest.approx(1j * across, abs=1e-14)
    assert found["rotating"].value == pytest.approx(0.5 * np.abs(along + across), abs=1e-14)
    assert found["counter_rotating"].value == pytest.approx(0.5 * np.abs(along - across), abs=1e-14)
    assert np.all(found["sum"].error < 1e-13)


def test_ninety_degrees_leave_order_1_turning_and_order_2_sideways() -> None:
    found = sums([0.0, 0.0], np.radians([45.0, -45.0]).tolist())
    assert found["rotating"].value[0] == pytest.approx(1.0)
    assert found["counter_rotating"].value[0] <= found["counter_rotating"].error[0]
    assert abs(found["sum"].value[1, 2]) <= found["sum"].error[1, 2]
    assert abs(found["sum"].value[1, 1]) == pytest.approx(np.sqrt(2.0))


@pytest.mark.parametrize("count", [3, 5, 7, 9])
def test_radial_engine_on_one_throw(count: int) -> None:
    """Order n turns with the crank if count divides n - 1, against it if it divides n + 1."""
    found = sums([0.0] * count, (2.0 * np.pi * np.arange(count) / count).tolist())
    ahead = np.where((ORDERS - 1) % count == 0, 0.5 * count, 0.0)
    back = np.where((ORDERS + 1) % count == 0, 0.5 * count, 0.0)
    assert found["rotating"].value == pytest.approx(ahead, abs=1e-12)
    assert found["counter_rotating"].value == pytest.approx(back, abs=1e-12)


def test_boxer_with_opposite_throws_has_couples_alone() -> None:
    found = sums([0.0, np.pi], [0.0, np.pi], [-0.02, 0.02])
    assert np.abs(found["sum"].value).max() < 1e-14
    assert np.abs(found["position_sum"].value[:, 2]) == pytest.approx(np.full(4, 0.04))
