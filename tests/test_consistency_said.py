"""Claim: what is said of every golden result changes only on purpose.

Reports, what `check --json` prints and the words of pictures are held against `tests/snapshots/`;
`make accept-snapshots` renews them.
"""

from importlib import import_module

import pytest
from long_but import long_but
from refused import SUBJECTS, kept
from snapshots.said import GOLDEN, HERE, NAMES, PARTS

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
    assert GOLDEN.is_dir()
    said = (HERE / "generator.pictures.txt").read_text(encoding="utf-8")
    assert "speed" in said and "run_up" in said


@pytest.mark.parametrize("subject", SUBJECTS)
def test_every_refusal_has_its_words_and_nothing_else_has(subject: str) -> None:
    assert list(kept(subject)) == list(import_module(f"test_{subject}").MESSAGES)
