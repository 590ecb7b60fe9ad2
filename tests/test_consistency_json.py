"""Claim: the `--json` object has the keys that scripts rely on, in valid JSON."""

import json
from dataclasses import replace

import numpy as np
import pytest
from report_samples import ORDERS, generator, optimised, quantity

from vibecalc.core.report.text import as_json

TOP = {"case", "result", "headlines", "quantities", "references", "limits", "timings"}
HEADLINE = {"name", "value", "unit", "where", "quantity", "min", "max", "utilisation", "verdict"}
REFERENCE = {
    "quantity", "where", "source", "value", "computed", "error", "resolved", "unit",
    "relative_difference", "within", "kind", "known_difference",
}  # fmt: skip
LIMIT = {
    "quantity", "where", "element", "limit", "condition", "source", "min", "max", "unit",
    "computed", "error", "margin", "utilisation", "kept", "satisfied", "verdict", "decided_by",
}  # fmt: skip


def test_keys_are_those_promised() -> None:
    found = as_json(generator(), "outputs/generator.h5")
    assert set(found) == TOP
    assert all(set(row) == HEADLINE for row in found["headlines"])
    assert all(set(row) == REFERENCE for row in found["references"])
    assert all(set(row) == LIMIT for row in found["limits"])
    numbers = found["quantities"].values()
    assert all(set(entry) == {"value", "unit", "error", "resolved"} for entry in numbers)
    assert (found["case"], found["result"]) == ("generator", "outputs/generator.h5")


def test_a_headline_carries_the_limit_that_decides() -> None:
    path = "isolation/couple_over_lever/steady_peak"
    limits = [{"quantity": path, "max": bound} for bound in ("1 kN", "50 N")]
    rows = as_json(generator(limit=limits))["headlines"]
    (row,) = (one for one in rows if one["quantity"] == path)
    assert (row["min"], row["max"], row["verdict"], row["unit"]) == (None, 50.0, "broken", "N")
    assert row["utilisation"] == pytest.approx(row["value"] / 50.0, rel=1e-12)
    free = next(one for one in rows if one["quantity"] == "excitation/couple_peak")
    assert [free[name] for name in ("min", "max", "utilisation", "verdict")] == 4 * [None]


def test_it_survives_strict_json() -> None:
    result = optimised()
    result.record.add(quantity("isolation/extra", np.inf, "N"))
    again = json.loads(json.dumps(as_json(result), allow_nan=False))
    extra = {"value": None, "unit": "N", "error": 0.0, "resolved": True}
    assert again["quantities"]["isolation/extra"] == extra
    assert again["result"] is None


def test_scalars_only_and_complex_as_magnitude() -> None:
    result = generator()
    result.record.add(quantity("isolation/phasor", 3.0 - 4.0j, "m"))
    quantities = as_json(result)["quantities"]
    assert quantities["isolation/phasor"]["value"] == pytest.approx(5.0, rel=1e-15)
    assert quantities["isolation/pitch/natural_frequency"]["unit"] == "rad/s"
    assert "isolation/support_force/steady_peak" not in quantities


def test_arrays_come_on_request_with_their_axes() -> None:
    result = generator()
    wave = np.array([3.0 - 4.0j, 1e-14 + 0.0j])
    result.record.add(quantity("isolation/wave", wave, "m", ORDERS, error=1e-13))
    result.record.add(quantity("isolation/heights", np.array([np.inf, 2.0]), "m", ORDERS))
    assert "isolation/wave" not in as_json(result)["quantities"]
    found = json.loads(json.dumps(as_json(result, full=True), allow_nan=False))["quantities"]
    wave = found["isolation/wave"]
    assert (wave["real"], wave["imaginary"], wave["error"]) == ([3.0, 0.0], [-4.0, 0.0], 1e-13)
    assert [len(axis["values"]) for axis in wave["axes"]] == [2]
    assert found["isolation/heights"]["value"] == [None, 2.0]
    for path, one in result.record.items():
        if one.axes and one.values.dtype.kind == "f" and np.isfinite(one.values).all():
            same = pytest.approx(one.values, abs=one.error_estimate)
            assert np.array(found[path]["value"]) == same


def test_a_zero_is_0_and_an_unknown_is_not_resolved() -> None:
    result = generator()
    for name, value, error, terms in (
        ("zero", 3e-12, 9e-11, 1e4), ("unknown", 196.0, 722.0, 1e4), ("known", 196.0, 7.0, 1e4),
    ):  # fmt: skip
        one = quantity(f"isolation/{name}", value, "N", error=error)
        result.record.add(replace(one, terms=terms))
    found = as_json(result)["quantities"]
    shown = {name: found[f"isolation/{name}"] for name in ("zero", "unknown", "known")}
    assert [one["value"] for one in shown.values()] == [0.0, 196.0, 196.0]
    assert [one["resolved"] for one in shown.values()] == [True, False, True]


def test_an_unbounded_limit_is_null_and_not_kept() -> None:
    result = generator(limit=[{"quantity": "isolation/worst", "max": "400 N"}])
    result.record.add(quantity("isolation/worst", np.inf, "N"))
    row = as_json(result)["limits"][0]
    assert (row["computed"], row["margin"], row["kept"]) == (None, None, False)
    assert (row["min"], row["max"]) == (None, 400.0)
    json.dumps(row, allow_nan=False)
