"""Claim: the largest of a reading over the speeds hangs on no grid, and no limit on it does."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from vibecalc import run
from vibecalc.core.results.record import Result
from vibecalc.torsion.results import FOLLOWED, ROOT

CASES = Path(__file__).parent.parent / "cases"


@cache
def found(case: str, points: int) -> Result:
    return run(
        CASES / f"{case}.toml",
        set={"response.torsion.speeds.points": points},
        unset=("reference", "reference_table", "limit"),
    )


@pytest.mark.parametrize(
    "case", ["engine_damped", pytest.param("engine_geared", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("name", FOLLOWED)
def test_extremes_are_those_of_a_fine_grid(case: str, name: str) -> None:
    """Fourteen points find what two thousand come near from below."""
    coarse, fine = found(case, 14).record, found(case, 2001).record
    path = f"{ROOT}/largest/{name}"
    if path not in coarse:
        pytest.skip("no such parts on this line")
    sense = -1.0 if "minimum" in name else 1.0
    value, at = coarse[path].values, coarse[f"{path}_speed"].values
    assert value == pytest.approx(fine[path].values, rel=1e-9)
    samples = sense * fine[f"{ROOT}/speeds/{name}"].values
    most = samples.max(axis=1)
    assert np.all(sense * value >= most - 1e-12 * np.abs(most))
    assert sense * value == pytest.approx(most, rel=2e-2)
    speeds = fine[f"{ROOT}/speeds/{name}"].axes[1].values
    high = samples >= (most - 1e-3 * np.abs(most))[:, None]
    nearest = [np.min(np.abs(speeds[row] - one)) for row, one in zip(high, at, strict=True)]
    assert max(nearest) <= 2.0 * np.max(np.diff(speeds))


def test_a_limit_on_a_curve_hangs_on_no_grid() -> None:
    limit = [{"quantity": f"{ROOT}/speeds/heat", "max": 1e-3}]
    rows = [
        run(
            CASES / "engine_damped.toml",
            set={"response.torsion.speeds.points": points, "limit": limit},
            unset=("reference", "reference_table"),
        ).verdicts
        for points in (7, 101)
    ]
    (coarse, *_), (fine, *_) = (one or () for one in rows)
    assert coarse.computed == pytest.approx(fine.computed, rel=1e-9)
    assert coarse.state == fine.state == "broken"
    assert coarse.label.startswith("damper=ring, speed=")


def test_an_undamped_critical_is_skipped_with_a_station_without_inertia() -> None:
    stations = [("a", 2.0), ("m", 0.0), ("b", 3.0)]
    drive = {"on": "a", "orders": [1, 2], "torques": [100.0, 50.0]}
    line = {
        "stations": [{"name": name, "inertia": inertia} for name, inertia in stations],
        "shafts": [{"stiffness": 1e5}, {"stiffness": 2e5}],
        "excitations": [drive],
    }
    result = run({
        "schema": 1,
        "title": "light station",
        "machine": {"kind": "drive_train", "speed": 20.0, "shaft_line": line},
        "response": {"torsion": {"speeds": {"from": 50.0, "to": 300.0, "points": 31}}},
    }).record  # fmt: skip
    critical = np.sqrt(1.0 / (1.0 / 1e5 + 1.0 / 2e5) * (1.0 / 2.0 + 1.0 / 3.0))
    start, end = (result[f"{ROOT}/resonances_skipped/{name}"].values for name in ("from", "to"))
    assert np.all((start < [critical / 2.0, critical]) & (end > [critical / 2.0, critical]))
    assert np.all(np.isinf(result[f"{ROOT}/largest/torque_half_range"].values))
