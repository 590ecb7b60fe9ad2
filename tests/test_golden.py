"""Claim: every shipped case has a golden file, which no run but `diff --accept` has made."""

import json
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibecalc.core.case.load import load_case
from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.layout import PROVENANCE, TEXT_CHECKSUM, TIMINGS
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
