"""Claim: weak and high harmonics are not zero, and what is weak does not count as missed."""

from pathlib import Path

import numpy as np
import pytest
from test_consistency_roll_ways import solved

from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.results.tolerance import reached, tolerance_warning
from vibecalc.roll.results import ROLL as ROOT


@pytest.mark.parametrize("orders", [150, pytest.param(400, marks=pytest.mark.long)])
def test_many_orders_are_those_of_few(tmp_path: Path, orders: int) -> None:
    few = solved(tmp_path, "orders = 100").record
    many = solved(tmp_path, f"orders = {orders}", "[accuracy]", "rtol = 1e-9").record
    name = f"{ROOT}/shell_acceleration"
    missed = np.abs(many[name].values[:100] - few[name].values)
    assert np.max(missed) <= many[name].error_estimate + few[name].error_estimate
    size = np.abs(many[name].values)
    assert many[name].error_estimate <= 1e-9 * np.max(size)
    # the table of the gas has corners: harmonics fall with a power of the order, and none is zero
    assert np.all(np.isfinite(many[f"{ROOT}/level/shell_acceleration"].values))


def test_a_harmonic_hidden_by_a_loose_tolerance_is_found(tmp_path: Path) -> None:
    held = {"stiffness": 1.35e6, "damping": 5.0}
    loose, close = (
        solved(tmp_path, "orders = 40", "[accuracy]", f"rtol = {rtol}", mounts=held).record
        for rtol in (1e-4, 1e-10)
    )
    for path in close:
        if path.startswith(f"{ROOT}/level/"):
            zero = ~np.isfinite(loose[path].values)
            np.testing.assert_array_equal(zero, ~np.isfinite(close[path].values), err_msg=path)
            off = np.abs(loose[path].values - close[path].values)[~zero]
            assert np.max(off, initial=0.0) <= loose[path].error_estimate + 1e-6, path


def quantity(path: str, values: object, error: float) -> Quantity:
    return Quantity(
        path=path,
        values=np.asarray(values),
        unit="",
        long_name=path,
        axes=(),
        amplitude=None,
        error_estimate=error,
    )


def test_weak_harmonics_and_small_works_are_measured_by_the_whole() -> None:
    record = Record()
    record.add(quantity(f"{ROOT}/energy/motor", 1e3, 1e-10))
    record.add(quantity(f"{ROOT}/energy/mounts", 1e-4, 1e-10))
    record.add(quantity(f"{ROOT}/level/slip", 10.0, 1e-6))
    assert "level/slip" in str(tolerance_warning(record, 1e-9))
    record.add(quantity(f"{ROOT}/slip", 3.0 + 0j, 1e-10))
    assert tolerance_warning(record, 1e-9) is None
    # harmonics and works that are off by more are still named
    record.add(quantity(f"{ROOT}/crank_speed", 3.0 + 0j, 1e-6))
    record.add(quantity(f"{ROOT}/energy/gas", 1e3, 1e-4))
    words = str(tolerance_warning(record, 1e-9))
    assert "crank_speed" in words and "energy/gas" in words
    assert reached(record[f"{ROOT}/energy/mounts"]) == pytest.approx(1e-6)
