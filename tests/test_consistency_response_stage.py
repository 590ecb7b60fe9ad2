"""Claim: both methods give one motion of a compressor, also where plain formulas break down.

A body that nothing holds, an order on or next to an undamped natural frequency, run-ups past it.
That the motion of any compressor is right `test_consistency_random_machines.py` shows.
"""

from typing import Any

import numpy as np
import pytest
from random_machines import Table
from response_machines import bare, run, si_matrix

from vibecalc.core.results.record import Record
from vibecalc.errors import NumericalFailure


def six(record: Record, first: str = "translation_harmonics", second: str = "rotation_harmonics"):
    """Amplitudes (orders, 6) of a pair of results."""
    return np.hstack([record[f"response/{first}"].values, record[f"response/{second}"].values])


def solved(table: Table, load: np.ndarray, speed: float, harder: np.ndarray | float = 1.0):
    """X (orders, 6) of loads (orders, 6) without damping, by one solve per order."""
    mass = si_matrix(table, "body", "mass_matrix")
    stiffness = si_matrix(table, "mounts", "stiffness_matrix") * harder
    rate = np.arange(1, len(load) + 1) * speed
    rows = [np.linalg.solve(stiffness - w**2 * mass, f) for w, f in zip(rate, load, strict=True)]
    return np.array(rows)


def six_load(record: Record) -> np.ndarray:
    return np.hstack([record["excitation/force"].values, record["excitation/couple"].values])


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_a_body_that_nothing_holds_in_one_direction(method: str) -> None:
    table = bare(method=method, run_up={"from": 0.0, "to": 400.0})
    table["excitation"] = {"working": ["A"], "driven_machine": "cancels_torque"}
    values = table["machine"]["mounts"]["stiffness_matrix"]["values"]
    free = 1
    for n in range(6):
        values[free][n] = values[n][free] = 0.0
    record = run(table)
    natural = record["response/modes/natural_frequency"]
    assert natural.values[0] <= natural.error_estimate
    assert np.all(natural.values[1:] > 50.0)
    assert "response/modes/damping_ratio" not in record
    want = solved(table, six_load(record), 361.0)
    assert six(record) == pytest.approx(want, abs=1e-12 * np.abs(want).max())
    assert np.abs(record["response/ground_force"].values[:, free]).max() == 0.0
    curve = record["response/run_up/kinetic_energy"]
    assert curve.axes[0].values[0] == 0.0 and curve.values[0] == 0.0
    speed, load = float(curve.axes[0].values[1]), six_load(record) / 361.0**2
    slow, mass = solved(table, speed**2 * load, speed), si_matrix(table, "body", "mass_matrix")
    rates = speed * np.arange(1, len(slow) + 1)[:, None] * slow
    assert curve.values[1] == pytest.approx(
        np.sum((rates.conj() * (rates @ mass)).real) / 4.0, rel=1e-9
    )


def diagonal(order: int, coordinate: int, away: float = 0.0, **response: Any) -> Table:
    """A body whose mode along one coordinate is where an order is at 100 rad/s times 1 + away."""
    table = bare(**response)
    table["machine"]["speed"] = 100.0 * (1.0 + away)
    table["excitation"] = {"working": ["A"], "driven_machine": "cancels_torque"}
    mass = np.array([4.0, 4.0, 4.0, 0.5, 0.5, 0.5])
    natural = np.array([310.0, 330.0, 350.0, 370.0, 390.0, 415.0])
    natural[coordinate] = 100.0 * order
    table["machine"]["body"] = {"mass_matrix": {"values": np.diag(mass).tolist()}}
    stiffness = np.diag(mass * natural**2)
    table["machine"]["mounts"] = {"stiffness_matrix": {"values": stiffness.tolist()}}
    return table


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_an_order_on_an_undamped_natural_frequency_is_refused_by_name(method: str) -> None:
    with pytest.raises(NumericalFailure) as failure:
        run(diagonal(2, 1, method=method))
    words = str(failure.value)
    assert "order 2 at 954.93 rpm" in words and "mode 1, 31.831 Hz" in words
    assert failure.value.exit_code == 3
    with_operations = diagonal(2, 1, method=method)
    with_operations["response"]["operations"] = [{"name": "A", "working": ["A"]}]
    with_operations["excitation"] = {"working": ["A"], "idle": "unloaded"}
    with pytest.raises(NumericalFailure, match=r"order 2 at 954\.93 rpm"):
        run(with_operations)


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_a_mode_that_is_met_and_not_driven_is_a_warning(method: str) -> None:
    table = diagonal(2, 2, method=method, run_up={"from": 50.0, "to": 150.0})
    record = run(table)
    (warning,) = [text for text in record.warnings if "order 2 at 954.93 rpm" in text]
    assert "does not drive it" in warning and "mode 1" in warning
    assert np.abs(record["response/translation_harmonics"].values[:, 2]).max() < 1e-25
    # that the mode is held twice as hard makes it no resonance, and nothing else moves by it
    want = solved(table, six_load(record), 100.0, np.where(np.arange(6) == 2, 2.0, 1.0))
    assert six(record) == pytest.approx(want, abs=1e-12 * np.abs(want).max())


def test_the_order_next_to_a_mode() -> None:
    record = run(diagonal(2, 1, 1e-3))
    natural = record["response/modes/natural_frequency"].values
    nearest = record["response/modes/nearest_order"].values
    orders = np.array([1, *range(2, 12, 2)])  # one cylinder with its throw: 1 and the even ones
    ratio = orders * 100.1 / natural[:, None]
    best = np.argmin(np.abs(np.log(ratio)), axis=1)
    assert np.array_equal(nearest, orders[best])
    assert record["response/modes/distance"].values == pytest.approx(
        ratio[np.arange(6), best] - 1.0, abs=1e-12
    )


def test_a_run_up_leaves_out_undamped_resonances_and_lists_them() -> None:
    table = diagonal(2, 1, 1e-3, run_up={"from": 60.0, "to": 250.0})
    record = run(table)
    masked = {
        name: record[f"response/resonances_skipped/{name}"].values
        for name in ("low", "centre", "high", "order", "mode")
    }
    listed = set(zip(masked["order"].tolist(), masked["mode"].tolist(), strict=True))
    natural = record["response/modes/natural_frequency"].values
    # the piston drives y and rx, by its lever; the throw x and ry too
    coordinate = np.argmax(record["response/modes/energy_fraction"].values, axis=1)
    expected = {
        (order, mode)
        for order, allowed in {1: (0, 1, 3, 4), 2: (1, 3), 4: (1, 3), 6: (1, 3)}.items()
        for mode in range(1, 7)
        if coordinate[mode - 1] in allowed and 60.0 <= natural[mode - 1] / order <= 250.0
    }
    assert len(expected) == 5 and listed == expected
    assert masked["centre"] == pytest.approx(
        natural[masked["mode"].astype(int) - 1] / masked["order"], rel=1e-12
    )
    speeds = record["response/run_up/kinetic_energy"].axes[0].values
    for low, high in zip(masked["low"], masked["high"], strict=True):
        assert not np.any((speeds > low) & (speeds < high))
        assert low in speeds and high in speeds


def test_orders_that_are_not_kept_are_in_the_error_of_a_run_up() -> None:
    """Kept to the second order, the curve lacks the resonances of the fourth."""
    table = bare(run_up={"from": 10.0, "to": 30.0})
    table["machine"]["mounts"]["modal_damping"] = 0.02
    table["excitation"] = {"working": ["A"], "orders": 2}
    cut = run(table)["response/run_up/kinetic_energy"]
    del table["excitation"]["orders"]
    whole = run(table)["response/run_up/kinetic_energy"]
    there = np.interp(cut.axes[0].values, whole.axes[0].values, whole.values)
    lacking = np.max(np.abs(there - cut.values))
    assert lacking > 1e-3 * np.max(whole.values)
    assert 0.5 * lacking < cut.error_estimate < 5.0 * lacking
