"""Claim: every shipped case has a golden file, which no run but `diff --accept` has made."""

import json
import tomllib
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from long_but import long_but
from refused import SUBJECTS, kept
from sample_results import quantity, result_of
from snapshots.said import HERE, NAMES, PARTS

from vibecalc.core.case.load import load_case
from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.compare import accept, compare
from vibecalc.core.results.layout import PROVENANCE, TEXT_CHECKSUM, TIMINGS
from vibecalc.core.results.record import Axis, Result
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.run.plan import planned_quantities

ROOT = Path(__file__).resolve().parents[1]
# of a sweep, the file of all its points is compared
CASES = {
    f"{path.stem}.sweep" if path.stem.endswith("_sweep") else path.stem: path
    for path in sorted((ROOT / "cases").glob("*.toml"))
}
GOLDEN = {path.stem: path for path in sorted((ROOT / "tests" / "golden").glob("*.h5"))}


def test_every_case_has_a_golden_file_and_no_other() -> None:
    assert CASES
    assert set(CASES) == set(GOLDEN)


def test_golden_files_hold_the_cases_as_they_are_and_no_provenance() -> None:
    """By the attributes alone; that each file is whole `make golden` sees, which reads them all.

    The hash is that of the version which made the file: a new number of the program is no change.
    Orders of records are computed as a case is read; the last bits hang on the processor.
    """
    for name, path in GOLDEN.items():
        with h5py.File(path) as file:
            resolved = load_case(CASES[name]).resolved
            if "record" in resolved.get("measurement", {}):
                take_orders(resolved, tomllib.loads(file.attrs["case_toml_resolved"]))
            held = case_hash(resolved, file.attrs["vibecalc_version"])
            assert file.attrs["case_sha256"] == held, name
            kept = file.get(PROVENANCE, {})
            assert not set(getattr(kept, "attrs", ())) - {TEXT_CHECKSUM} and TIMINGS not in kept, (
                name
            )


def take_orders(resolved: dict[str, Any], kept: dict[str, Any]) -> None:
    """Hold the orders of records against those kept, to 1e-9 of the largest, and take these."""
    rows = zip(resolved["measurement"]["record"], kept["measurement"]["record"], strict=True)
    for row, other in rows:
        assert row["found"].keys() == other["found"].keys()
        for key, values in row["found"].items():
            if isinstance(values, dict | str):  # the keys that these were made with, words
                assert values == other["found"][key]
                continue
            largest = np.max(np.abs(other["found"][key]))
            np.testing.assert_allclose(values, other["found"][key], rtol=0.0, atol=1e-9 * largest)
        row["found"] = other["found"]


def test_what_is_planned_is_made() -> None:
    """Of golden files, which runs have to equal; bands that nothing masks are left out."""
    for name, path in GOLDEN.items():
        case = load_case(CASES[name]).case
        if name.endswith(".sweep") or case.optimisation or case.find or case.fit:
            continue
        with h5py.File(path) as file:
            made = set(json.loads(file.attrs["quantities"]))
        planned = set(planned_quantities(case))
        assert made <= planned, name
        assert all(one.startswith("isolation/resonances_skipped/") for one in planned - made), name


# ----------------------------------------------------------------------------
# Of a long curve some samples are kept, and `diff` sees what changed at them.
# ----------------------------------------------------------------------------

SPEED = np.linspace(10.0, 100.0, 1001)


def curve(height: np.ndarray, speed: np.ndarray, unit: str = "rad/s") -> Result:
    axis = Axis(name="speed", values=speed, unit=unit)
    return result_of(replace(quantity("x/curve", (axis,)), values=height, error_estimate=0.0))


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


# ----------------------------------------------------------------------------
# What is said of every golden result changes only on purpose.
# ----------------------------------------------------------------------------

#: these run all code of reports and checks but some lines; `make test-long` takes the rest as well
KEPT = (
    "absorber", "absorber_pendulum", "absorber_rig_b", "compressor", "compressor_balance",
    "compressor_clearance_sweep.sweep", "compressor_impact", "compressor_switching",
    "engine_as_published", "engine_damper_heat", "engine_geared", "engine_run_up", "engine_v8",
    "engine_variable_inertia", "four_cylinder", "generator_mount_design_lever",
    "generator_on_floor", "pump", "roll", "roll_control", "roll_dynamic_motor", "roll_measured",
    "roll_mounted", "roll_piston_sweep.sweep", "roll_startup",
)  # fmt: skip


def _held(name: str, ending: str) -> None:
    kept = (HERE / f"{name}{ending}").read_text(encoding="utf-8")
    assert PARTS[ending](name) == kept


@pytest.mark.parametrize("name", long_but(NAMES, *KEPT))
@pytest.mark.parametrize("ending", [".txt", ".check.json"])
def test_reports_and_checks_are_as_before(name: str, ending: str) -> None:
    _held(name, ending)


@pytest.mark.parametrize(
    "name", long_but(NAMES, "absorber", "compressor_impact", "generator", "roll_mounted")
)
def test_words_of_pictures_are_as_before(name: str) -> None:
    _held(name, ".pictures.txt")


def test_every_golden_file_has_its_snapshots_and_nothing_else_has() -> None:
    found = {path.name for path in HERE.iterdir() if path.suffix in (".txt", ".json")}
    assert found == {f"{name}{ending}" for name in NAMES for ending in PARTS}
    said = (HERE / "generator.pictures.txt").read_text(encoding="utf-8")
    assert "speed" in said and "run_up" in said


@pytest.mark.parametrize("subject", SUBJECTS)
def test_every_refusal_has_its_words_and_nothing_else_has(subject: str) -> None:
    assert list(kept(subject)) == list(import_module(f"test_{subject}").MESSAGES)
