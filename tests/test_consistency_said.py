"""Claim: what is said of every golden result changes only on purpose.

Reports, what `check --json` prints and the words of pictures are held against `tests/snapshots/`;
`make accept-snapshots` renews them.
"""

import pytest
from snapshots.said import GOLDEN, HERE, NAMES, PARTS

#: of these what others say as well is left to `make test-long`: reports and checks that run code
#: which no other of them runs, and a few pictures
KEPT = {
    ".txt": (
        "absorber", "absorber_pendulum", "absorber_rig_b", "compressor", "compressor_balance",
        "compressor_clearance_sweep.sweep", "compressor_impact", "compressor_speed_sweep.sweep",
        "compressor_switching", "engine_as_published", "engine_damper_heat", "engine_geared",
        "engine_run_up", "engine_v8", "engine_variable_inertia", "four_cylinder",
        "generator_mount_design", "generator_on_floor", "pump", "roll", "roll_control",
        "roll_dynamic_motor", "roll_measured", "roll_mounted", "roll_rod_sweep.sweep",
        "roll_startup",
    ),
    ".check.json": (
        "absorber", "absorber_pendulum", "absorber_rig_b", "compressor", "compressor_balance",
        "compressor_clearance_sweep.sweep", "engine_as_published", "engine_damper_heat",
        "engine_geared", "engine_run_up", "engine_v8", "generator_mount_design_lever", "pump",
        "roll", "roll_control", "roll_measured", "roll_mounted", "roll_piston_sweep.sweep",
    ),
    ".pictures.txt": ("absorber", "compressor_impact", "generator", "roll_mounted"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("ending", "name"),
    [
        pytest.param(ending, name, marks=() if name in kept else pytest.mark.long)
        for ending, kept in KEPT.items()
        for name in NAMES
    ],
)
def test_what_is_said_is_as_before(ending: str, name: str) -> None:
    kept = (HERE / f"{name}{ending}").read_text(encoding="utf-8")
    assert PARTS[ending](name) == kept


def test_every_golden_file_has_its_snapshots_and_nothing_else_has() -> None:
    found = {path.name for path in HERE.iterdir() if path.suffix in (".txt", ".json")}
    assert found == {f"{name}{ending}" for name in NAMES for ending in PARTS}
    assert GOLDEN.is_dir()
    said = (HERE / "generator.pictures.txt").read_text(encoding="utf-8")
    assert "speed" in said and "run_up" in said
