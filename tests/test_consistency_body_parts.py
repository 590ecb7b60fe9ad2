"""Claim: a body of parts is the same wherever the datum stands, and as one with a block."""

import numpy as np
import pytest
from mounted_sets import ran, tables

from vibecalc.core.case.load import validate
from vibecalc.parts.body import build_body


def moved(data: dict[str, object], by: np.ndarray) -> dict[str, object]:
    """The same machine with all places measured from elsewhere."""
    machine = data["machine"]
    for part in machine["body"]["parts"]:
        part["centre"] = (np.array(part["centre"]) + by).tolist()
    machine["crank_train"]["origin"] = (np.array(machine["crank_train"]["origin"]) + by).tolist()
    machine["mounts"]["datum"] = by.tolist()
    return data


@pytest.mark.parametrize("by", [[0.9, 0.1, -0.4], [-30.0, 200.0, 60.0]])
def test_the_datum_changes_nothing_beyond_the_errors_stated(by: list[float]) -> None:
    here, there = ran(tables()), ran(moved(tables(), np.array(by)))
    for path in (
        "isolation/modes/natural_frequency",
        "isolation/modes/damping_ratio",
        "isolation/support_displacement/static",
        "isolation/support_force/static",
        "isolation/support_force/steady_peak",
        "body/moments",
        "body/principal_moments",
    ):
        one, other = here[path], there[path]
        allowed = one.error_estimate + other.error_estimate
        assert np.abs(one.values - other.values).max() <= allowed, path
        assert other.error_estimate < 1e-3 * np.abs(other.values).max(), path


def test_mass_and_centre_given_are_a_body_of_one_part_and_a_block_another() -> None:
    data = tables()
    parts = data["machine"]["body"]["parts"]
    block, rest = parts[2], parts[1]
    data["machine"]["body"] = {"parts": [rest, block]}
    given = {key: rest[key] for key in ("mass", "centre", "inertia", "inertia_products")}
    position = {"mass": block["mass"], "box": block["box"], "position": block["centre"]}
    assembled = build_body(validate(data).machine.body)
    data["machine"]["body"] = {**given, "inertia_block": position}
    body = build_body(validate(data).machine.body)
    for name in ("mass", "centre", "mass_matrix", "inertia"):
        assert getattr(body, name) == pytest.approx(getattr(assembled, name), rel=1e-13, abs=1e-12)
