"""Compressors as case tables: the shipped ones, seeded random ones, and how to run them."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from random_machines import Table, random_machine

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

FOLDER = Path(__file__).resolve().parents[1] / "cases"
INCH, POUND_FORCE = 0.0254, 4.4482216152605
IMPERIAL = {
    "mass_matrix": ["lbf*s^2/in", "lbf*s^2", "lbf*in*s^2"],
    "stiffness_matrix": ["lbf/in", "lbf", "lbf*in"],
    "damping_matrix": ["lbf*s/in", "lbf*s", "lbf*in*s"],
}
SI = {
    "mass_matrix": ["kg", "kg*m", "kg*m^2"],
    "stiffness_matrix": ["N/m", "N", "N*m"],
    "damping_matrix": ["N*s/m", "N*s", "N*m*s"],
}


def shipped(name: str = "compressor", **response: Any) -> Table:
    """A shipped case with its CSV files read and without its references; keys of [response]."""
    table = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    assert attach_files(table, FOLDER) == []
    table.pop("reference", None), table.pop("reference_table", None)
    table["response"] = {**table.get("response", {}), **response}
    table["response"] = {key: value for key, value in table["response"].items() if value != []}
    return table


def bare(name: str = "compressor", **response: Any) -> Table:
    """The same without operations and balances."""
    return shipped(name, operations=[], balances=[], **response)


def run(table: Table, *wanted: str) -> Record:
    """All results, or those wanted, of a case table that no check finds fault with."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    return run_case(case, wanted=frozenset(wanted) if wanted else None)


def blocks(along: float, coupled: float, turning: float) -> np.ndarray:
    """Factors (6, 6) of the blocks of a matrix."""
    return np.block(
        [
            [np.full((3, 3), along), np.full((3, 3), coupled)],
            [np.full((3, 3), coupled), np.full((3, 3), turning)],
        ]
    )


def si_matrix(table: Table, part: str, key: str) -> np.ndarray:
    """A matrix of a case table in SI; its units are SI or those of `IMPERIAL`."""
    entry = table["machine"][part][key]
    values = np.array(entry["values"], dtype=float)
    if entry.get("units", SI[key]) == SI[key]:
        return values
    assert entry["units"] == IMPERIAL[key]
    return values * blocks(POUND_FORCE / INCH, POUND_FORCE, POUND_FORCE * INCH)


def random_compressor(seed: int, damping: str | None = None) -> Table:
    """A compressor of one to four cylinders, its body and suspension as matrices or as parts.

    `damping` is one of "none", "loss_factor", "modal_damping", "damping_matrix"; it makes matrices.
    """
    generator = np.random.default_rng([seed, 77])
    table = random_machine(seed, "rigid_body")
    del table["isolation"]
    machine = table["machine"]
    machine["kind"], train = "compressor", machine["crank_train"]
    train["cylinders"] = train["cylinders"][:4]
    names = [cylinder["name"] for cylinder in train["cylinders"]]
    if "rod" in train and table.get("kinematics", {}).get("series") != "truncated":
        rod = train["rod"]
        near = rod["crank_pin_to_mass_centre"]
        points = rod["mass"] * near * (train["rod_length"] - near)
        rod["inertia"] = points * float(generator.uniform(0.3, 0.9))
    table["excitation"] = {
        "driven_machine": str(generator.choice(["cancels_torque", "on_body", "separate"])),
        "working": _some(generator, names),
        "idle": str(generator.choice(["stopped", "unloaded"])),
        "balanced_for": _some(generator, names),
    }
    if generator.random() < 0.25:
        table["excitation"]["orders"] = int(generator.choice([3, 4, 6]))
    if damping is not None or generator.random() < 0.6:
        kinds = ["none", "loss_factor", "modal_damping", "damping_matrix"]
        _as_matrices(generator, machine, damping or str(generator.choice(kinds)))
    elif generator.random() < 0.3:
        machine["mounts"]["modal_damping"] = 0.01
    table["response"] = {
        "method": str(generator.choice(["modal", "direct"])),
        "energies": True,
        "operations": [
            {"name": f"o{n}", "working": _some(generator, names), "weight": float(1 + n)}
            for n in range(int(generator.integers(1, 4)))
        ],
        "run_up": {"from": 0.0, "to": 1.2 * machine["speed"]},
    }
    if generator.random() < 0.6:
        table["response"]["balances"] = [
            {"name": f"b{n}", "balanced_for": _some(generator, names)} for n in range(2)
        ]
    return table


def _some(generator: np.random.Generator, names: list[str]) -> list[str]:
    count = int(generator.integers(1, len(names) + 1))
    return sorted(generator.permutation(names)[:count].tolist())


def _definite(generator: np.random.Generator, size: np.ndarray) -> np.ndarray:
    """A symmetric positive definite matrix (6, 6) whose diagonal is about `size` (6,)."""
    turn, _ = np.linalg.qr(generator.normal(size=(6, 6)))
    inner = turn @ np.diag(generator.uniform(0.3, 2.0, 6)) @ turn.T
    root = np.sqrt(size)
    matrix = inner * np.outer(root, root)
    return np.asarray(0.5 * (matrix + matrix.T))


def _as_matrices(generator: np.random.Generator, machine: Table, damping: str) -> None:
    mass, reach = machine["body"]["mass"], float(generator.uniform(0.1, 0.5))
    size = mass * np.array([1.0] * 3 + [reach**2] * 3)
    frequency = machine["speed"] * float(np.exp(generator.uniform(np.log(0.05), np.log(3.0))))
    ratio = float(np.exp(generator.uniform(np.log(1e-4), np.log(0.3))))
    stiffness = _definite(generator, size * frequency**2)
    machine["body"] = {"mass_matrix": _entry(generator, "mass_matrix", _definite(generator, size))}
    mounts = {"stiffness_matrix": _entry(generator, "stiffness_matrix", stiffness)}
    if damping == "damping_matrix":
        matrix = _definite(generator, 2.0 * ratio * frequency * size)
        mounts["damping_matrix"] = _entry(generator, "damping_matrix", matrix)
    elif damping != "none":
        mounts[damping] = ratio
    machine["mounts"] = mounts


def _entry(generator: np.random.Generator, key: str, matrix: np.ndarray) -> Table:
    if generator.random() < 0.5:
        return {"values": matrix.tolist()}
    values = matrix / blocks(POUND_FORCE / INCH, POUND_FORCE, POUND_FORCE * INCH)
    return {"units": IMPERIAL[key], "values": (0.5 * (values + values.T)).tolist()}
