"""Claim: what nothing holds is free, however tiny the stiffness that rounding makes of it."""

import tomllib

import numpy as np
import pytest
from random_machines import Table
from report_samples import quantity
from response_machines import run
from response_samples import compressor
from test_property_response_report import row, section

from vibecalc.cli.starters import starter
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis
from vibecalc.errors import NumericalFailure

HARD = "60 N/mm"


def on_mounts(scene: str, *stiffness: object) -> Table:
    table = tomllib.loads(starter(scene))
    table["machine"]["mounts"]["each"]["stiffness"] = list(stiffness)
    return table


@pytest.mark.parametrize(("free", "none"), [(1, 0.0), (3, 1e-14)])
def test_a_direction_without_stiffness_is_a_free_mode(free: int, none: float) -> None:
    # held along x alone it also turns about x as it likes
    stiffness = (HARD, none, HARD if free == 1 else none)
    record = run(on_mounts("compressor", *stiffness))
    natural = record["response/modes/natural_frequency"]
    loose = natural.values <= natural.error_estimate
    assert np.flatnonzero(loose).tolist() == list(range(free))
    assert np.all(natural.values[~loose] > 10.0)
    assert natural.error_estimate < 1e-6
    assert "response/modes/damping_ratio" not in record
    assert "response/modes/distance" not in record
    assert not any("natural_frequency" in words for words in record.warnings)


@pytest.mark.parametrize("soft", ["1 N/m", "60 N/mm"])
def test_a_soft_mode_is_held_and_keeps_its_digits(soft: str) -> None:
    table = on_mounts("compressor", HARD, soft, HARD)
    record = run(table)
    natural = record["response/modes/natural_frequency"]
    assert np.all(natural.values > 1e6 * natural.error_estimate)
    assert "response/modes/damping_ratio" in record


def test_a_change_of_a_body_that_is_free_is_refused_in_these_words() -> None:
    with pytest.raises(NumericalFailure, match="nothing holds the body in it"):
        run(on_mounts("switching", HARD, 0.0, HARD))


def test_a_run_up_through_an_undamped_resonance_has_no_largest_energy() -> None:
    speed = Axis(name="speed", values=np.array([100.0, 149.0, 151.0, 200.0]), unit="rad/s")
    masked = Axis(name="masked", values=np.array([1]))
    parts = [
        quantity(f"response/run_up/{kind}_energy", [1.0, 2e9, 3e9, 1.0], "J", speed)
        for kind in ("kinetic", "potential")
    ] + [
        quantity(f"response/masked/{name}", [value], unit, masked)
        for name, value, unit in (("centre", 150.0, "rad/s"), ("order", 1, ""), ("mode", 2, ""))
    ]
    lines = section(compressor(parts), "Response")
    for kind in ("kinetic", "potential"):
        assert row(lines, f"{kind}, mean over a turn") == ["without", "bound", "1432"]
    text = " ".join(" ".join(lines).split())
    assert "left out, an undamped resonance without bound: 1432 rpm (order 1, mode 2)" in text
    bounded = section(compressor(parts[:2]), "Response")
    assert row(bounded, "kinetic, mean over a turn")[0] == "3.000e+09"
    assert "without bound" not in render_report(compressor(parts[:2]))
