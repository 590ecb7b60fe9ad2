"""Claim: limits of a shaft line that cannot be held are refused in words, at their place."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED
from refused import changed, problems_of, refusals, said_of

from vibecalc.core.results.record import Record, Result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import NumericalFailure

CRANK = (
    'crank = { pin_diameter = "70 mm", journal_diameter = "80 mm", web_thickness = "25 mm", '
    'web_width = "110 mm", pin_fillet = "4 mm", journal_fillet = "4 mm" }'
)
CASES = {"engine": ENGINE, "geared": GEARED}


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("limits"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    text = changed(CASES[case], change.replace("CRANK", CRANK))
    found = problems_of(tomllib.loads(text))
    assert found, "nothing found wrong"
    for expected in words:
        assert expected in said_of(found[0])
    assert ".".join(map(str, found[0].path)) == place


def ran(text: str, tmp_path: Path) -> Result:
    path = tmp_path / "line.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path])
    return execute(loaded)


def test_a_gear_without_a_mean_torque_has_no_share_of_it(tmp_path: Path) -> None:
    with pytest.raises(NumericalFailure, match="'wheel - take-off' carries no mean torque"):
        ran(GEARED + "limits = [{ alternating_share = 0.3 }]\n", tmp_path)


def test_limits_of_every_kind_with_a_misfire(tmp_path: Path) -> None:
    damped = GEARED.replace('stiffness = "1e6 N*m/rad"', 'stiffness = "1e6 N*m/rad", damping = 20')
    text = f"""{damped.replace('"4e5 N*m/rad"', '"4e5 N*m/rad", damping = 30')}
speeds = {{ from = "400 rpm", to = "620 rpm", points = 45 }}
misfire = ["2"]
limits = [
  {{ alternating_share = 2, gears = ["pinion - wheel"] }},
  {{ torque = {{ speed = [40, 70], torque = [90, 90], transient = [400, 900] }}, gears = ["wheel - take-off"], sections = ["b - pinion"] }},
  {{ rule = "iacs_m53", sections = ["a - b"], tensile_strength = "600 MPa", bending = {{ web = 0, compressive = 0, additional = 0 }}, {CRANK} }},
]
"""  # noqa: E501
    record = ran(text, tmp_path).record
    place = "response/torsion"
    for start in ("", "healthy/"):
        for name in ("operating_use", "largest_use"):
            found = record[f"{place}/{start}limit/{name}"]
            assert found.values.shape == (3,) and np.all(found.values > 0.0)
            assert found.error_estimate < 1e-8 * np.max(found.values)
    # the same limits, and no bore in the pin
    factor = record[f"{place}/limit/crank/acceptability"].values[2]
    assert np.all(factor[:, 2] == 0.0) and factor[:, :2].max() > 0.0
    # what UR M53 allows is where the worst fillet has 1.15: a use is below one where Q is above
    held = factor.max(axis=1) > 0.0
    least = float(np.min(factor[held][:, :2]))
    use = float(record[f"{place}/limit/largest_use"].values[2])
    assert (least > 1.15) == (use < 1.0)
    # without bending stresses are in proportion to the torsion
    assert least * use == pytest.approx(1.15, rel=1e-9)
    assert f"{place}/limit/gear" in record
    assert sectioned(record) <= {"a - b", "b - pinion", "pinion - wheel", "wheel - take-off"}


def sectioned(record: Record) -> set[str]:
    return {*map(str, record["response/torsion/limit/each/use"].axes[1].values)}
