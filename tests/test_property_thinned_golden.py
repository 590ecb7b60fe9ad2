"""A golden file keeps some samples of a long curve, and `diff` sees what changed at them."""

from pathlib import Path

import numpy as np
import pytest

from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.compare import accept, compare
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.core.results.store import read_result, write_result

SPEED = np.linspace(10.0, 100.0, 1001)


def curve(height: np.ndarray, speed: np.ndarray, unit: str = "rad/s") -> Result:
    axes = (Axis(name="speed", values=speed, unit=unit),)
    one = Quantity(path="x/curve", values=height, unit="m", long_name="a curve", axes=axes)
    return Result(
        name="x", case={}, case_toml="", case_toml_resolved="", case_sha256=case_hash({}, "1"),
        version="1", record=Record(quantities={"x/curve": one}),
    )  # fmt: skip


def resonance(speed: np.ndarray) -> np.ndarray:
    return np.asarray(1.0 / np.hypot(1.0 - (speed / 40.04) ** 2, 1e-4))


@pytest.fixture
def golden(tmp_path: Path) -> Result:
    write_result(curve(resonance(SPEED), SPEED), tmp_path / "run.h5")
    return read_result(accept(tmp_path / "run.h5", tmp_path / "golden.h5"))


def test_a_tenth_of_the_samples_is_kept_with_the_highest(golden: Result) -> None:
    kept = golden.record["x/curve"]
    assert len(kept.values) == 102 and kept.axes[0].run_samples == 1001
    assert kept.values.max() == resonance(SPEED).max()
    assert [kept.axes[0].values[0], kept.axes[0].values[-1]] == [10.0, 100.0]


def test_the_run_it_was_made_of_is_the_same_and_a_changed_one_is_not(golden: Result) -> None:
    assert compare(golden, curve(resonance(SPEED), SPEED)).same
    assert compare(golden, golden).same
    place = int(np.argmax(resonance(SPEED)))
    changed = resonance(SPEED)
    changed[place] *= 1.01
    assert not compare(golden, curve(changed, SPEED)).same
    shifted = SPEED * 1.01
    assert not compare(golden, curve(resonance(shifted), shifted)).same


def test_samples_that_a_run_chose_and_angles_of_a_cycle_are_kept(tmp_path: Path) -> None:
    chosen = np.concatenate([SPEED[:500], [55.01], SPEED[500:]])
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    for axis, unit in ((chosen, "rad/s"), (angle, "rad")):
        write_result(curve(np.sin(axis), axis, unit), tmp_path / "run.h5")
        kept = read_result(accept(tmp_path / "run.h5", tmp_path / "golden.h5")).record["x/curve"]
        assert len(kept.values) == len(axis) and not kept.axes[0].run_samples


def test_an_axis_without_any_sample_is_compared_like_another() -> None:
    nothing = curve(np.zeros(0), np.zeros(0))
    assert compare(nothing, nothing).same
