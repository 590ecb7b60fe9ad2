"""Writes tests/golden/rules.toml and its derivation from the measured conditioning.

`python tests/matrix/derive.py` perturbs every shipped case (minutes); `--measured FOLDER` keeps
what was measured in, and takes it from, one JSON file for each case. What a method promises, and
what is not compared, stands in tests/matrix/promises.toml with its reason; the numbers of all
other rules are found here: the smallest of 1, 2, 5 times a power of ten that every quantity of the
rule can keep to.
"""

import argparse
import fnmatch
import json
import math
import tomllib
from dataclasses import astuple
from pathlib import Path
from typing import Any

from conditioning import Conditioning, measured

from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import VibecalcError

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
RULES = ROOT / "tests" / "golden" / "rules.toml"
PROMISES = HERE / "promises.toml"
DERIVATION = HERE / "derivation.json"
_HEAD = """# Tolerances of the golden files: how far machines, or sets of versions, may differ.
# Written by tests/matrix/derive.py; docs/accuracy.md says how. Edit promises.toml, not this.
"""
#: a change that no tolerance may be made from
_NONSENSE = 1e-2
Found = dict[str, tuple[Conditioning, str]]


def rounded_up(number: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    power = math.floor(math.log10(number))
    steps = [float(f"{digit}e{power + more}") for more in (0, 1) for digit in (1, 2, 5)]
    return next(step for step in steps if step >= number * (1.0 - 1e-12))


def tied(promises: dict[str, Any], path: str, case: str) -> bool:
    """Whether the quantity of that case is a choice between equals, which no tolerance holds."""
    return any(
        fnmatch.fnmatchcase(path, tie["quantity"]) and case in tie["cases"]
        for tie in promises["tie"]
    )


def measure_all(folder: Path, cases: list[Path]) -> dict[str, list[Conditioning]]:
    """Conditioning by case; from `folder` where it has it."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for case in cases:
        kept = folder / f"{case.stem}.json"
        if not kept.exists():
            (loaded,) = load_checked([case])
            try:
                rows = measured(loaded, execute(loaded), (1, 2))
            except VibecalcError as error:
                print(f"{case.stem}: not measured: {error}", flush=True)
                continue
            kept.write_text(json.dumps([astuple(row) for row in rows]), encoding="utf-8")
        found[case.stem] = [Conditioning(*row) for row in json.loads(kept.read_text())]
    return found


def derive(
    found: dict[str, list[Conditioning]], promises: dict[str, Any]
) -> tuple[str, list[dict[str, Any]]]:
    """Text of the rules file, and one record for each rule, the default first."""
    rules = promises["rule"]
    members: list[Found] = [{} for _ in range(len(rules) + 1)]
    for case, rows in found.items():
        for row in rows:
            fits = [i for i, rule in enumerate(rules) if _fits(row.path, rule["quantity"])]
            place = members[fits[-1] + 1 if fits else 0]
            if tied(promises, row.path, case):
                continue
            if row.path not in place or row.least > place[row.path][0].least:
                place[row.path] = (row, case)
    text, records = _HEAD, []
    for rule, group in zip([{"quantity": "*", "default": True}, *rules], members, strict=True):
        record = _record(rule, group)
        records.append(record)
        text += "\n" + _as_text(rule, record)
    return text, records


def _fits(path: str, pattern: str) -> bool:
    return fnmatch.fnmatchcase(path, pattern)


def _record(rule: dict[str, Any], group: Found) -> dict[str, Any]:
    record: dict[str, Any] = {"quantity": rule["quantity"], "reason": rule.get("reason", "")}
    if rule.get("compare") == "ignore":
        return {**record, "compare": "ignore"}
    worst, case = max(group.values(), key=lambda pair: pair[0].least, default=(None, ""))
    least = 0.0 if worst is None else worst.least
    promise = rule.get("promise", 0.0)
    if "atol" in rule:  # of zeros: relative to them nothing can be said
        return {**record, "atol": rule["atol"]}
    if least > _NONSENSE:
        raise SystemExit(f"{worst} of {case} changes by itself: a tie, or a reason is missing")
    record["rtol"] = rounded_up(max(least, promise))
    if worst is not None:
        record |= {"path": worst.path, "case": case, "condition": worst.condition}
        record |= {"jump": worst.jump, "estimate": worst.estimate, "least": least}
    return {**record, "promise": promise}


def _as_text(rule: dict[str, Any], record: dict[str, Any]) -> str:
    lines = [f"# {line}" for line in _wrapped(record["reason"])] if record["reason"] else []
    if "path" in record:
        size = f"condition {record['condition']:.1e}"
        size += f", jump {record['jump']:.1e}" if record["jump"] else ""
        lines.append(f"# measured: {size}, {record['path']} of {record['case']}")
    lines.append("[default]" if rule.get("default") else "[[rule]]")
    if not rule.get("default"):
        lines.append(f'quantity = "{rule["quantity"]}"')
    if "compare" in rule:
        lines.append(f'compare = "{rule["compare"]}"')
    if "rtol" in record:
        lines.append(f"rtol = {record['rtol']:g}")
    if "atol" in rule:
        lines.append(f"atol = {rule['atol']:g}")
    return "\n".join(lines) + "\n"


def _wrapped(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 96)


def main() -> None:
    """Measure, derive, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measured", type=Path, default=ROOT / "outputs" / "conditioning")
    asked = parser.parse_args()
    promises = tomllib.loads(PROMISES.read_text(encoding="utf-8"))
    left_out = {entry["case"] for entry in promises.get("not_measured", ())}
    cases = [
        path
        for path in sorted((ROOT / "cases").glob("*.toml"))
        if path.stem not in left_out and not path.stem.endswith("_sweep")
    ]
    text, records = derive(measure_all(asked.measured, cases), promises)
    RULES.write_text(text, encoding="utf-8")
    DERIVATION.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
