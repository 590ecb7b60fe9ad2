"""Claim: by every method a run gives the motion that collocation gives, within what it says.

Peaks and courses are read between the points of a method, which may nearly coincide where a turn
ends and begins. Truth: a run by collocation to 1e-11.
"""

from pathlib import Path

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import CASES

from vibecalc.core.results.record import Result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.roll.results import ROLL

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
