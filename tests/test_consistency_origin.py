"""Claim: where the origin of a case is changes nothing but what is said of the reference point."""

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

MOVE = np.array([0.148, -0.507, 1.446])
#: results whose description names the reference point
OF_THE_POINT = "reference point"


def moved(table: dict[str, Any]) -> dict[str, Any]:
    """The machine with every position given from an origin elsewhere."""
    other = deepcopy(table)
    machine = other["machine"]
    places = [(machine["crank_train"], "origin"), (machine["body"], "centre")]
    places += [(one, "position") for one in machine["mounts"].get("individual", [])]
    places += [(one, "position") for one in other.get("point", [])]
    for row, key in places:
        row[key] = (np.array(row.get(key) or [0.0, 0.0, 0.0]) + MOVE).tolist()
    if "positions" in machine["mounts"]:
        machine["mounts"]["positions"] = (np.array(machine["mounts"]["positions"]) + MOVE).tolist()
    return other


@pytest.mark.parametrize("name", ["generator_on_floor", "generator_180"])
def test_a_moved_origin_changes_no_result(name: str) -> None:
    (loaded,) = load_checked([CASES[name]])
    resolved = deepcopy(dict(loaded.resolved))
    table = {key: resolved[key] for key in ("schema", "title", "machine")}
    # off its middle, so that a direction couples with the others
    table["machine"]["body"]["centre"] = [0.03, -0.05, 0.09]
    table["excitation"] = {**resolved.get("excitation", {}), "orders": 6}
    table["isolation"] = {"model": "rigid_body", "efficiency": True}
    table["point"] = [{"name": "head", "position": [0.1, 0.2, 0.3]}]
    first, second = (run_case(validate(one)) for one in (table, moved(table)))
    assert {*first.quantities} == {*second.quantities}
    same = 0
    for path, found in first.quantities.items():
        other = second[path]
        if OF_THE_POINT in found.long_name:
            continue
        finite = np.isfinite(found.values)
        assert np.array_equal(found.values[~finite], other.values[~finite]), path
        one, moved_one = found.values[finite], other.values[finite]
        size = float(np.max(np.abs(one), initial=0.0))
        off = found.error_estimate + other.error_estimate
        assert np.all(np.abs(one - moved_one) <= off + 1e-9 * size), path
        same += 1
    assert same > 30
    assert np.min(second["isolation/modes/energy_fraction"].values) > -0.05
