"""Claim: the `--json` object has the keys that scripts rely on, in valid JSON."""

import json

import numpy as np
import pytest
from report_samples import generator, optimised, quantity

from vibecalc.report.machine_readable import as_json
from vibecalc.report.references import judge_references

TOP = {"case", "result", "quantities", "references", "limits", "timings"}
REFERENCE = {
    "quantity", "where", "source", "value", "computed", "unit", "relative_difference", "within",
    "kind", "known_difference",
}  # fmt: skip
LIMIT = {"quantity", "where", "min", "max", "unit", "computed", "margin", "kept"}


def test_keys_are_those_promised() -> None:
    found = as_json(generator(), "outputs/generator.h5")
    assert set(found) == TOP
    assert all(set(row) == REFERENCE for row in found["references"])
    assert all(set(row) == LIMIT for row in found["limits"])
    assert all(set(entry) == {"value", "unit"} for entry in found["quantities"].values())
    assert (found["case"], found["result"]) == ("generator", "outputs/generator.h5")
    assert found["timings"] == {"excitation": 0.0012, "isolation": 0.0101}


def test_it_survives_strict_json() -> None:
    result = optimised()
    result.record.add(quantity("isolation/extra", np.inf, "N"))
    again = json.loads(json.dumps(as_json(result), allow_nan=False))
    assert again["quantities"]["isolation/extra"] == {"value": None, "unit": "N"}
    assert again["quantities"]["optimisation/evaluations"] == {"value": 214, "unit": ""}
    assert again["result"] is None


def test_scalars_only_and_complex_as_magnitude() -> None:
    result = generator()
    result.record.add(quantity("isolation/phasor", 3.0 - 4.0j, "m"))
    quantities = as_json(result)["quantities"]
    assert quantities["isolation/phasor"]["value"] == pytest.approx(5.0, rel=1e-15)
    assert quantities["isolation/pitch/natural_frequency"]["unit"] == "rad/s"
    assert "isolation/support_force/steady_peak" not in quantities


def test_references_carry_the_judged_numbers() -> None:
    result = generator()
    rows = as_json(result)["references"]
    judged = judge_references(result)
    assert [row["computed"] for row in rows] == [row.computed for row in judged]
    known = rows[5]
    assert known["value"] == 93.0
    assert known["within"] is None
    assert known["known_difference"].startswith("the source")
    assert rows[0]["known_difference"] is None
    assert rows[0]["where"] == {"order": 1}
    assert rows[0]["relative_difference"] == pytest.approx((rows[0]["computed"] - 8209) / 8209)


def test_an_unbounded_limit_is_null_and_not_kept() -> None:
    result = generator(limit=[{"quantity": "isolation/worst", "max": "400 N"}])
    result.record.add(quantity("isolation/worst", np.inf, "N"))
    row = as_json(result)["limits"][0]
    assert (row["computed"], row["margin"], row["kept"]) == (None, None, False)
    assert (row["min"], row["max"]) == (None, 400.0)
    json.dumps(row, allow_nan=False)
