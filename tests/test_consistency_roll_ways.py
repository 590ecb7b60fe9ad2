"""Claim: by every method a run gives the motion that collocation gives, within what it says.

Peaks and courses are read between the points of a method, which may nearly coincide where a turn
ends and begins. Truth: a run by collocation to 1e-11.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from long_but import long_but
from response_machines import run, shipped
from roll_machines import SYNCHRONOUS, source_drive, source_machine, straight_drive

from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.results.tolerance import reached, tolerance_warning
from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.methods import fourier_state, shooting_state
from vibecalc.roll.results import ROLL
from vibecalc.roll.results import ROLL as ROOT
from vibecalc.roll.steady import started_momentum

METHODS = ("fourier", "shooting", "dop853", "rk4", "euler")
#: largest error of peaks and courses over their size, with the settings of these tests
CLOSE = {"fourier": 0.02, "shooting": 0.02, "dop853": 2e-3, "rk4": 0.02, "euler": 0.12}
#: stiffness and damping
MOUNTS = 3e5, 6e3
#: settings of the methods that want some
STEP = {"rk4": {"step": 5e-4}, "euler": {"step": 5e-4}}
PEAKS = ("rod_force_peak", "wall_force_peak")


@cache
def solved(mounts: tuple[float, float] | None = None, rtol: float = 1e-11, **roll: Any) -> Record:
    """The shipped machine, with what [response.roll] says; each is run once."""
    table = shipped("roll")
    table["response"] = {"roll": roll}
    table["accuracy"] = {"rtol": rtol}
    if mounts:
        table["machine"]["shell"] |= dict(zip(("stiffness", "damping"), mounts, strict=True))
    return run({key: part for key, part in table.items() if key != "limit"})


def comparable(record: Record) -> list[str]:
    """Results of a run that another method gives too, but what only the motion decides."""
    left_out = ("multiplier", "level/", "phase_lag/", "residual", "cycle/time")
    return [
        path
        for path in record
        if path.startswith(ROLL) and not any(part in path for part in left_out)
    ]


#: ten seconds and more on mounts, where what fades takes many turns or unknowns
KEPT = (("fourier", True), ("shooting", True), ("rk4", False), ("euler", True))
CHOSEN = [
    pytest.param(
        method,
        mounts,
        id=f"{method}-{name}",
        marks=[]
        if method != "dop853" and (mounts is None or method == "rk4")
        else pytest.mark.long,
    )
    for method in METHODS
    for name, mounts in (("free", None), ("mounted", MOUNTS))
]


@pytest.mark.parametrize(("method", "mounts"), CHOSEN)
def test_a_method_gives_what_collocation_gives(
    method: str, mounts: tuple[float, float] | None
) -> None:
    truth = solved(mounts)
    found = solved(mounts, method=method, **STEP.get(method, {}))
    for path in comparable(found):
        own, exact = found[path], truth[path]
        missed = float(np.max(np.abs(own.values - exact.values)))
        assert missed <= own.error_estimate + exact.error_estimate, path
        size = float(np.max(np.abs(exact.values)))
        if path.endswith(PEAKS) or "/cycle/rod_force" in path or "/cycle/gas_torque" in path:
            assert missed <= CLOSE[method] * size, (path, missed / size)


@pytest.mark.parametrize("method", long_but(METHODS, *(method for method, _ in KEPT)))
def test_levels_and_lags_are_within_what_a_method_says(method: str) -> None:
    truth = solved()
    found = solved(method=method, **STEP.get(method, {}))
    for name in ("shell_acceleration", "rod_force", "motor_torque"):
        level, exact = (one[f"{ROLL}/level/{name}"] for one in (found, truth))
        there = np.isfinite(level.values)
        assert np.max(np.abs(level.values - exact.values)[there]) <= level.error_estimate + 1e-6
        lag, right = (one[f"{ROLL}/phase_lag/{name}"] for one in (found, truth))
        off = np.abs(np.mod(lag.values - right.values + np.pi, 2.0 * np.pi) - np.pi)
        assert np.max(off[there]) <= lag.error_estimate + 1e-6


@pytest.mark.long
def test_compared_methods_say_no_less_than_they_differ() -> None:
    found = solved(compare=("fourier", "shooting"))
    difference = found[f"{ROLL}/method/difference"]
    assert np.max(np.abs(difference.values)) <= difference.error_estimate


@pytest.mark.parametrize(
    ("mounts", "points"),
    [
        pytest.param(
            mounts,
            points,
            id=f"{'mounted' if mounts else 'free'}-{points}",
            marks=[] if (mounts is None) == (points == 1) and points < 3 else [pytest.mark.long],
        )
        for mounts in (None, MOUNTS)
        for points in (1, 2, 3)
    ],
)
def test_few_points_of_the_case_say_how_few(
    points: int, mounts: tuple[float, float] | None
) -> None:
    truth = solved(mounts)
    found = solved(mounts, points=points)
    for path in comparable(found):
        own, exact = found[path], truth[path]
        missed = float(np.max(np.abs(own.values - exact.values)))
        assert missed <= own.error_estimate + exact.error_estimate, path
    for name in ("shell_acceleration", "rod_force"):
        lag, right = (one[f"{ROLL}/phase_lag/{name}"] for one in (found, truth))
        there = np.isfinite(found[f"{ROLL}/level/{name}"].values)
        off = np.abs(np.mod(lag.values - right.values + np.pi, 2.0 * np.pi) - np.pi)
        assert np.max(off[there]) <= lag.error_estimate + 1e-9


@pytest.mark.long
@pytest.mark.parametrize("orders", [150, 400])
def test_many_orders_are_those_of_few(orders: int) -> None:
    few = solved(orders=100)
    many = solved(rtol=1e-9, orders=orders)
    name = f"{ROOT}/shell_acceleration"
    missed = np.abs(many[name].values[:100] - few[name].values)
    assert np.max(missed) <= many[name].error_estimate + few[name].error_estimate
    size = np.abs(many[name].values)
    assert many[name].error_estimate <= 1e-9 * np.max(size)
    # the table of the gas has corners: harmonics fall with a power of the order, and none is zero
    assert np.all(np.isfinite(many[f"{ROOT}/level/shell_acceleration"].values))


@pytest.mark.long
def test_a_harmonic_hidden_by_a_loose_tolerance_is_found() -> None:
    loose, close = (solved((1.35e6, 5.0), rtol, orders=40) for rtol in (1e-4, 1e-10))
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


# ----------------------------------------------------------------------------
# Methods that come to no running state.
# ----------------------------------------------------------------------------


def test_no_running_state_is_said_in_words() -> None:
    with pytest.raises(NumericalFailure, match="comes to a standstill"):
        march_to_repeat(
            source_machine(gas_scale=[3.5, 3.5]), straight_drive(), "rk4", started_at=SYNCHRONOUS
        )
    with pytest.raises(NumericalFailure, match="beyond the last of the motor's table"):
        march_to_repeat(
            source_machine(), straight_drive(holds=False), "euler", started_at=2.5 * SYNCHRONOUS
        )
    with pytest.raises(NumericalFailure, match="not come to a periodic state in 5 turns"):
        march_to_repeat(
            source_machine(),
            straight_drive(),
            "euler",
            started_at=SYNCHRONOUS,
            repeats=1e-14,
            most=5,
        )
    with pytest.raises(UsageError, match="euler, rk4, dop853"):
        march_to_repeat(source_machine(), straight_drive(), "heun", started_at=SYNCHRONOUS)


@pytest.mark.long
def test_a_method_without_a_solution_says_so() -> None:
    machine = as_batch(source_machine(gas_scale=[3.2, 3.2]))
    drive = source_drive(holds=True)
    momentum = started_momentum(machine, SYNCHRONOUS)
    with pytest.raises(NumericalFailure, match="finds no running state"):
        fourier_state(machine, drive, 181, momentum)
    with pytest.raises(NumericalFailure, match="shooting"):
        shooting_state(machine, drive, 4, momentum)
