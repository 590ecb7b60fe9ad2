"""Claim: every local maximum of a run-up is found, as a fine scan with dense solves finds them."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.parts.machine import build_machine
from vibecalc.parts.matrices import displacement_at

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
    case = validate(table)
    record, machine = run_case(case), build_machine(case)
    loads = np.hstack(
        [record[f"isolation/efficiency/{part}/held"].values for part in ("force", "couple")]
    )
    loads = loads / case.machine.speed**2
    orders = np.arange(1, len(loads) + 1)
    mounts = machine.mounts
    arms = [displacement_at(place) for place in mounts.position]
    k, c = (sum(a.T @ m @ a for a, m in zip(arms, each, strict=True))
            for each in (mounts.stiffness, mounts.damping))  # fmt: skip
    mass = machine.body.mass_matrix

    def harmonics(row: int, speeds: np.ndarray) -> np.ndarray:
        w = np.multiply.outer(speeds, orders)[..., None, None]
        motion = np.linalg.solve(k + 1j * w * c - w**2 * mass, (speeds**2)[:, None, None, None]
                                 * loads[:, :, None])[..., 0]  # fmt: skip
        spring = mounts.stiffness[row] + 1j * w * mounts.damping[row]
        return np.asarray((spring @ arms[row] @ motion[..., None])[..., 0])

    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    turns = np.exp(1j * np.outer(orders, angle))

    def envelope(row: int, speeds: np.ndarray) -> np.ndarray:
        course = np.einsum("snc,na->sca", harmonics(row, speeds), turns).real
        return np.linalg.norm(course, axis=1).max(axis=1)

    def exact(row: int, speed: float) -> float:
        parts = harmonics(row, np.array([speed]))[0]
        size = np.linalg.norm((parts.T @ turns).real, axis=0)
        at = angle[int(np.argmax(size))]
        found = minimize_scalar(
            lambda a: -np.linalg.norm((parts.T @ np.exp(1j * orders * a)).real),
            bounds=(at - 0.03, at + 0.03), method="bounded", options={"xatol": 1e-9},
        )  # fmt: skip
        return float(-found.fun)

    natural = record["isolation/modes/natural_frequency"].values
    total = 0
    for row in range(len(arms)):
        mine = record[f"{ROOT}/mount"].values == row + 1
        value, speed, order, mode, ratio, end = (
            record[f"{ROOT}/{name}"].values[mine]
            for name in ("force", "speed", "bending_order", "mode", "frequency_ratio", "at_end")
        )
        assert ratio == pytest.approx(order * speed / natural[mode.astype(int) - 1], rel=1e-12)
        grid = np.linspace(0.5, 60.0, 1500)
        curve = envelope(row, grid)
        local = np.flatnonzero((curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])) + 1
        local = local[curve[local] > SHARE * max(value)]
        inner = end == 0.0
        assert len(local) == np.sum(inner)
        total += len(local)
        for place, top, where in zip(local, value[inner], speed[inner], strict=True):
            if row not in (0, 3):
                continue
            found = minimize_scalar(
                lambda s, row=row: -exact(row, s), bounds=(grid[place - 1], grid[place + 1]),
                method="bounded", options={"xatol": 1e-8},
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
