"""The shipped cases, loaded once in a test session, and their results, read from golden files.

That a run gives these is what `make golden` checks, and that they belong to the cases as they are
`test_golden.py`.
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
    """A finished run of a shipped case, with some keys set; of a sweep its base."""
    if settings or name.endswith("_sweep"):
        return fresh(name, *settings)
    return read_result(ROOT / "tests" / "golden" / f"{name}.h5")


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
