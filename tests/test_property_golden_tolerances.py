"""Claim: the tolerances next to the golden files are those that conditioning asks for.

Every rule has its derivation on record; recomputed for two quick cases (`long`: for all), no
tolerance is smaller than the change that round-off can make, or so large that it says nothing.
"""

import json
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "matrix"))

import derive  # noqa: E402
from conditioning import measured  # noqa: E402

from vibecalc.core.results.compare_rules import read_rules  # noqa: E402
from vibecalc.core.study.execute import execute, load_checked  # noqa: E402

PROMISES = tomllib.loads(derive.PROMISES.read_text(encoding="utf-8"))
LEFT_OUT = {entry["case"] for entry in PROMISES.get("not_measured", ())}
ALL = [
    path.stem
    for path in sorted((ROOT / "cases").glob("*.toml"))
    if not path.stem.endswith("_sweep") and path.stem not in LEFT_OUT
]


def _shipped() -> dict[str, dict[str, Any]]:
    content = tomllib.loads(derive.RULES.read_text(encoding="utf-8"))
    rules = {"*": content["default"]}
    return rules | {rule["quantity"]: rule for rule in content["rule"]}


def test_every_rule_has_its_derivation_and_every_exception_a_reason() -> None:
    records = {entry["quantity"]: entry for entry in json.loads(derive.DERIVATION.read_text())}
    shipped = _shipped()
    assert list(records) == list(shipped)
    for pattern, rule in shipped.items():
        record = records[pattern]
        assert rule.get("rtol") == record.get("rtol"), pattern
        assert rule.get("atol") == record.get("atol"), pattern
        if rule.get("compare") == "ignore" or "atol" in rule or record.get("promise"):
            assert len(record["reason"]) > 30, pattern
        else:
            assert record["rtol"] >= record["least"], pattern
            # the next smaller one of 1, 2, 5 would not do
            assert record["rtol"] < 2.51 * record["least"], pattern
    for entry in (*PROMISES["tie"], *PROMISES.get("not_measured", ())):
        assert len(entry["reason"]) > 30


def _outside(case: str, seeds: tuple[int, ...]) -> list[str]:
    """Quantities whose tolerance is too small, or larger than it may be and no promise says so."""
    rules = read_rules(derive.RULES)
    promised = [rule["quantity"] for rule in PROMISES["rule"]]
    (loaded,) = load_checked([ROOT / "cases" / f"{case}.toml"])
    found = []
    for row in measured(loaded, execute(loaded), seeds):
        rule = rules.given(row.path)
        special = any(derive.fnmatch.fnmatchcase(row.path, pattern) for pattern in promised)
        if rule.compare == "ignore" or rule.atol or derive.tied(PROMISES, row.path, case):
            continue
        assert rule.rtol is not None
        if row.problem or rule.rtol < row.least or (rule.rtol > row.most and not special):
            found.append(f"{row}: {rule.rtol}")
    return found


@pytest.mark.parametrize("case", ["compressor_b", "generator"])
def test_quick_cases_keep_to_the_tolerances_that_their_conditioning_asks_for(case: str) -> None:
    assert _outside(case, (3,)) == []


@pytest.mark.long
@pytest.mark.parametrize("case", ALL)
def test_all_cases_keep_to_the_tolerances_that_their_conditioning_asks_for(case: str) -> None:
    assert _outside(case, (3, 4)) == []
