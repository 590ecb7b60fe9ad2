"""Claim: every shipped case has a golden file, which no run but `diff --accept` has made."""

import json
from pathlib import Path

import h5py

from vibecalc.core.case.load import case_hash, load_case
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
    """
    for name, path in GOLDEN.items():
        with h5py.File(path) as file:
            held = case_hash(load_case(CASES[name]).resolved, file.attrs["vibecalc_version"])
            assert file.attrs["case_sha256"] == held, name
            kept = file.get(PROVENANCE, {})
            assert not set(getattr(kept, "attrs", ())) - {TEXT_CHECKSUM} and TIMINGS not in kept, (
                name
            )


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
        assert all(one.startswith("isolation/masked/") for one in planned - made), name
