"""Claim: by every method a run gives the motion that collocation gives, within what it says.

Peaks and courses are read between the points of a method, which may nearly coincide where a turn
ends and begins. Truth: a run by collocation to 1e-11.
"""

from pathlib import Path

import numpy as np
import pytest
from long_but import long_but
from roll_machines import SYNCHRONOUS, source_drive, source_machine, straight_drive
from shipped_cases import CASES

from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.core.results.tolerance import reached, tolerance_warning
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.methods import fourier_state, shooting_state
from vibecalc.roll.results import ROLL
from vibecalc.roll.results import ROLL as ROOT
from vibecalc.roll.steady import started_momentum

FILES = ("roll_first_stage.csv", "roll_second_stage.csv", "roll_motor.csv")
METHODS = ("fourier", "shooting", "dop853", "rk4", "euler")
#: largest error of peaks and courses over their size, with the settings of these tests
CLOSE = {"fourier": 0.02, "shooting": 0.02, "dop853": 2e-3, "rk4": 0.02, "euler": 0.12}
MOUNTS = {"stiffness": 3e5, "damping": 6e3}
#: settings of the methods that want some
STEP = {"rk4": ('step = "0.5 ms"',), "euler": ('step = "0.5 ms"',)}
DONE: dict[object, Result] = {}
PEAKS = ("rod_force_peak", "wall_force_peak")


def solved(
    folder: Path, *lines: str, mounts: dict[str, float] | None = None, **swaps: str
) -> Result:
    """The shipped machine, with what [response.roll] says in `lines`; each is run once."""
    asked = (lines, tuple((mounts or {}).items()), tuple(swaps.items()))
    if asked not in DONE:
        DONE[asked] = _solved(folder, *lines, mounts=mounts, **swaps)
    return DONE[asked]


def _solved(
    folder: Path, *lines: str, mounts: dict[str, float] | None = None, **swaps: str
) -> Result:
    text = CASES["roll"].read_text(encoding="utf-8").split("[response.roll]")[0]
    shell = "".join(f"\n{key} = {value}" for key, value in (mounts or {}).items())
    text = text.replace("[machine.motor]", f"{shell}\n[machine.motor]")
    for old, new in swaps.items():
        head, _, tail = text.partition(f"[machine.{old}]")
        text = f"{head}[machine.{old}]\n{new}\n" + tail[tail.find("\n\n") :]
    for name in FILES:
        (folder / name).write_text((CASES["roll"].parent / name).read_text(encoding="utf-8"))
    path = folder / "case.toml"
    body = "\n".join(lines)
    rtol = "" if "[accuracy]" in body else "\n[accuracy]\nrtol = 1e-11\n"
    path.write_text(f"{text}[response.roll]\n{body}\n{rtol}", encoding="utf-8")
    (loaded,) = load_checked([path])
    return execute(loaded)


def comparable(result: Result) -> list[str]:
    """Results of a run that another method gives too, but what only the motion decides."""
    left_out = ("multiplier", "level/", "phase_lag/", "residual", "cycle/time")
    return [
        path
        for path in result.record
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
    tmp_path: Path, method: str, mounts: dict[str, float] | None
) -> None:
    truth = solved(tmp_path, mounts=mounts).record
    found = solved(tmp_path, f'method = "{method}"', *STEP.get(method, ()), mounts=mounts)
    for path in comparable(found):
        own, exact = found.record[path], truth[path]
        missed = float(np.max(np.abs(own.values - exact.values)))
        assert missed <= own.error_estimate + exact.error_estimate, path
        size = float(np.max(np.abs(exact.values)))
        if path.endswith(PEAKS) or "/cycle/rod_force" in path or "/cycle/gas_torque" in path:
            assert missed <= CLOSE[method] * size, (path, missed / size)


@pytest.mark.parametrize("method", long_but(METHODS, *(method for method, _ in KEPT)))
def test_levels_and_lags_are_within_what_a_method_says(tmp_path: Path, method: str) -> None:
    truth = solved(tmp_path).record
    found = solved(tmp_path, f'method = "{method}"', *STEP.get(method, ())).record
    for name in ("shell_acceleration", "rod_force", "motor_torque"):
        level, exact = (one[f"{ROLL}/level/{name}"] for one in (found, truth))
        there = np.isfinite(level.values)
        assert np.max(np.abs(level.values - exact.values)[there]) <= level.error_estimate + 1e-6
        lag, right = (one[f"{ROLL}/phase_lag/{name}"] for one in (found, truth))
        off = np.abs(np.mod(lag.values - right.values + np.pi, 2.0 * np.pi) - np.pi)
        assert np.max(off[there]) <= lag.error_estimate + 1e-6


@pytest.mark.long
def test_compared_methods_say_no_less_than_they_differ(tmp_path: Path) -> None:
    found = solved(tmp_path, 'compare = ["fourier", "shooting"]').record
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
    tmp_path: Path, points: int, mounts: dict[str, float] | None
) -> None:
    truth = solved(tmp_path, mounts=mounts).record
    found = solved(tmp_path, f"points = {points}", mounts=mounts)
    for path in comparable(found):
        own, exact = found.record[path], truth[path]
        missed = float(np.max(np.abs(own.values - exact.values)))
        assert missed <= own.error_estimate + exact.error_estimate, path
    for name in ("shell_acceleration", "rod_force"):
        lag, right = (one[f"{ROLL}/phase_lag/{name}"] for one in (found.record, truth))
        there = np.isfinite(found.record[f"{ROLL}/level/{name}"].values)
        off = np.abs(np.mod(lag.values - right.values + np.pi, 2.0 * np.pi) - np.pi)
        assert np.max(off[there]) <= lag.error_estimate + 1e-9


@pytest.mark.long
@pytest.mark.parametrize("orders", [150, 400])
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


@pytest.mark.long
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
