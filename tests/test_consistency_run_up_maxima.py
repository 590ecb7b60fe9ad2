"""Claim: every local maximum of a run-up is found, as a fine scan with dense solves finds them."""

import numpy as np
import pytest
from dense_results import Dense
from dense_run_up import at_speeds, mount_forces
from scipy.optimize import minimize_scalar
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

ROOT, SHARE = "isolation/run_up/maxima", 0.02


def test_maxima_are_those_of_a_fine_scan() -> None:
    (loaded,) = load_checked([CASES["generator_180"]])
    table = {key: one for key, one in loaded.resolved.items() if not key.startswith("reference")}
    table["isolation"] = {
        "model": "rigid_body", "run_up": {"from": 0.0, "to": 60.0},
        "run_up_maxima": SHARE, "efficiency": True,
    }  # fmt: skip
    for place in table["machine"]["mounts"]["positions"]:
        place[2] = -0.3  # couples forces along with rocking
    table["machine"]["mounts"]["positions"][0][0] = -0.5
    table.pop("limit", None)
    record = run_case(validate(table))
    dense = Dense(table, record, deep=False)

    def force_at(speed: float, row: int) -> float:
        """Largest force of a mount over the cycle."""
        moved = at_speeds(dense, np.array([speed]))
        alone = moved._replace(force=moved.force[:, :, row : row + 1])
        return float(mount_forces(dense, alone)[0, 0])

    natural = record["isolation/modes/natural_frequency"].values
    grid = np.linspace(0.5, 60.0, 500)
    curves = mount_forces(dense, at_speeds(dense, grid))
    total = 0
    for row, curve in enumerate(curves.T):
        mine = record[f"{ROOT}/mount"].values == row + 1
        value, speed, order, mode, ratio, end = (
            record[f"{ROOT}/{name}"].values[mine]
            for name in ("force", "speed", "bending_order", "mode", "frequency_ratio", "at_end")
        )
        assert ratio == pytest.approx(order * speed / natural[mode.astype(int) - 1], rel=1e-12)
        local = np.flatnonzero((curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])) + 1
        local = local[curve[local] > SHARE * max(value)]
        inner = end == 0.0
        assert len(local) == np.sum(inner)
        total += len(local)
        for place, top, where in zip(local, value[inner], speed[inner], strict=True):
            if row not in (0, 3):
                continue
            found = minimize_scalar(
                lambda s, row=row: -force_at(s, row), bounds=(grid[place - 1], grid[place + 1]),
                method="bounded", options={"xatol": 1e-6},
            )  # fmt: skip
            assert top == pytest.approx(-found.fun, rel=1e-9)
            assert where == pytest.approx(found.x, rel=1e-5)
        assert max(value) == pytest.approx(
            record["isolation/support_force/run_up_peak"].values[row], rel=1e-12
        )
    assert total >= 12


def test_a_maximum_without_bound_is_said() -> None:
    (loaded,) = load_checked([CASES["generator"]], ["isolation.run_up_maxima=0.1"])
    table = {key: one for key, one in loaded.resolved.items() if not key.startswith("reference")}
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    table.pop("limit", None)
    record = run_case(validate(table))
    force = record[f"{ROOT}/force"].values
    assert np.sum(np.isinf(force)) == 8  # two orders at four supports
    order = record[f"{ROOT}/order"].values[np.isinf(force)]
    speed = record[f"{ROOT}/speed"].values[np.isinf(force)]
    assert order * speed == pytest.approx(float(record["isolation/pitch/natural_frequency"].values))
