"""The shipped cases, loaded and run once in a test session.

Those that take longer than reading are read from their golden files: that a run gives these is what
`make golden` checks, and that they belong to the cases as they are `test_golden.py`.
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from vibecalc.core.results.record import Result
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import execute, load_checked

ROOT = Path(__file__).resolve().parents[1]
CASES = {path.stem: path for path in sorted((ROOT / "cases").glob("*.toml"))}
SLOW = frozenset(
    {
        "absorber",
        "absorber_curves",
        "absorber_design_chart",
        "absorber_floor",
        "absorber_pendulum",
        "absorber_rig_a",
        "absorber_rig_b",
        "absorber_two",
        "compressor",
        "compressor_balance",
        "compressor_impact",
        "compressor_switching",
        "engine_as_published",
        "engine_damped",
        "engine_damper_design",
        "engine_damper_heat",
        "engine_geared",
        "engine_misfire",
        "engine_run_up",
        "engine_two_stroke",
        "engine_undamped",
        "engine_v8",
        "engine_variable_inertia",
        "four_cylinder",
        "genset_coupling",
        "genset_points",
        "genset_skid",
        "marine_propulsion",
        "pump_drive",
        "generator_mount_design",
        "generator_mount_design_lever",
        "generator_mount_stock",
        "generator_mount_fit",
        "generator_on_floor",
        "genset_on_deck",
        "pump",
        "roll",
        "roll_balanced",
        "roll_control",
        "roll_design",
        "roll_dynamic_motor",
        "roll_equal_pressure",
        "roll_measured",
        "roll_mounted",
        "roll_records",
        "roll_startup",
    }
)


@cache
def table_of(name: str) -> dict[str, Any]:
    """A shipped case as TOML reads it."""
    return tomllib.loads(CASES[name].read_text(encoding="utf-8"))


def takes_long(name: str) -> bool:
    """A search that nothing published hangs on; `make golden` runs it."""
    case = table_of(name)
    return "optimisation" in case and not {"reference", "reference_table"} & set(case)


@cache
def result_of(name: str, *settings: str) -> Result:
    """A finished run of a shipped case, with some keys set."""
    if name in SLOW and not settings:
        return read_result(ROOT / "tests" / "golden" / f"{name}.h5")
    return fresh(name, *settings)


@cache
def fresh(name: str, *settings: str) -> Result:
    """The same, run here and now, for tests that hold it against kernels bit by bit."""
    (loaded,) = load_checked([CASES[name]], settings)
    return execute(loaded)


@cache
def judge() -> Any:
    """What holds tables against the JSON schema of all cases; to make it takes seconds."""
    import jsonschema

    from vibecalc.json_schema import json_schema

    return jsonschema.Draft202012Validator(json_schema())
