"""Claim: a compressor that is described in another way has the same results.

Other units, other names and another sequence of the cylinders, another reference point with the
matrices moved along, another crank angle zero, all masses and forces scaled, tables in a file or in
the case: results change as they have to and not otherwise.
"""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from long_but import long_but
from random_machines import Table
from response_machines import IMPERIAL, SI, bare, blocks, random_compressor, run, shipped, si_matrix

from vibecalc.core.case.load import load_case
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.study.execute import execute

CASES = Path(__file__).resolve().parents[1] / "cases"
SEEDS = long_but(range(4), 1)
CURVES = ("response/run_up", "response/masked")
MATRICES = (
    ("body", "mass_matrix"),
    ("mounts", "stiffness_matrix"),
    ("mounts", "damping_matrix"),
)


def machine(seed: int) -> Table:
    """A random compressor with matrices in SI, motion to many digits, no run-up."""
    table = random_compressor(seed, "damping_matrix")
    table["accuracy"] = {"rtol": 1e-9}
    del table["response"]["run_up"]
    for part, key in MATRICES:
        matrix = si_matrix(table, part, key)
        table["machine"][part][key] = {"values": matrix.tolist(), "units": SI[key]}
    return table


def agree(
    one: Record,
    other: Record,
    expected: Callable[[Quantity], Any] = lambda quantity: quantity.values,
    *,
    skip: tuple[str, ...] = (),
    rounding: float = 1e-10,
) -> None:
    """Every result of `other` against what becomes of that of `one`."""
    assert set(one) == set(other)
    compared = 0
    for path, quantity in one.items():
        if path.startswith((*CURVES, *skip)):
            continue
        want, have = np.asarray(expected(quantity)), other[path].values
        assert want.shape == have.shape, path
        size = float(np.max(np.abs(want), initial=0.0))
        stretch = size / float(np.max(np.abs(quantity.values), initial=0.0)) if size else 1.0
        slack = stretch * quantity.error_estimate + other[path].error_estimate
        off = float(np.max(np.abs(have - want), initial=0.0))
        assert off <= rounding * size + 2.0 * slack, f"{path}: {off:.3g} of {size:.3g}"
        compared += 1
    assert compared > 25


@pytest.mark.parametrize("seed", SEEDS)
def test_names_and_sequence_of_the_cylinders(seed: int) -> None:
    table = machine(seed)
    new = copy.deepcopy(table)
    train = new["machine"]["crank_train"]
    count = len(train["cylinders"])
    order = np.random.default_rng(seed).permutation(count)
    renamed = {c["name"]: f"number {c['name']}" for c in train["cylinders"]}
    train["cylinders"] = [copy.deepcopy(train["cylinders"][n]) for n in order]
    for cylinder in train["cylinders"]:
        cylinder["name"] = renamed[cylinder["name"]]
    places = [
        new["excitation"],
        *new["response"]["operations"],
        *new["response"].get("balances", []),
    ]
    for place in places:
        for key in ("working", "balanced_for"):
            if key in place:
                place[key] = [renamed[name] for name in reversed(place[key])]

    def expected(quantity: Quantity) -> Any:
        names = [axis.name for axis in quantity.axes]
        if "cylinder" not in names:
            return quantity.values
        return quantity.values.take(order, axis=names.index("cylinder"))

    agree(run(table), run(new), expected, rounding=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_units_of_the_matrices_and_lengths(seed: int) -> None:
    table = machine(seed)
    new = copy.deepcopy(table)
    factors = blocks(4.4482216152605 / 0.0254, 4.4482216152605, 4.4482216152605 * 0.0254)
    for part, key in MATRICES:
        values = np.array(table["machine"][part][key]["values"]) / factors
        new["machine"][part][key] = {
            "values": (0.5 * (values + values.T)).tolist(),
            "units": IMPERIAL[key],
        }
    train = new["machine"]["crank_train"]
    train["crank_radius"] = f"{train['crank_radius'] / 0.0254!r} in"
    train["rod_length"] = f"{1e3 * train['rod_length']!r} mm"
    for cylinder in train["cylinders"]:
        cylinder["position"] = f"{100.0 * cylinder['position']!r} cm"
        cylinder["crank_phase"] = f"{float(np.degrees(cylinder['crank_phase']))!r} deg"
    new["machine"]["speed"] = f"{new['machine']['speed'] * 30.0 / np.pi!r} rpm"
    agree(run(table), run(new))


@pytest.mark.parametrize("seed", SEEDS)
def test_scaled_masses_and_forces_move_the_body_alike(seed: int) -> None:
    """Twice the masses, stiffness and damping: the same motion, twice the forces and energies."""
    table, factor = machine(seed), 2.0
    new = copy.deepcopy(table)
    for part, key in MATRICES:
        matrix = factor * np.array(table["machine"][part][key]["values"])
        new["machine"][part][key]["values"] = matrix.tolist()
    masses = ("reciprocating_mass", "rotating_mass", "piston_mass", "pin_mass", "mass", "unbalance")

    def heavier(place: Any) -> None:
        for key, value in list(place.items()):
            if key in (*masses, "inertia"):
                place[key] = factor * value
            elif isinstance(value, dict):
                heavier(value)
            elif isinstance(value, list):
                [heavier(item) for item in value if isinstance(item, dict)]

    heavier(new["machine"]["crank_train"])

    def expected(quantity: Quantity) -> Any:
        grown = quantity.unit in ("N", "N*m", "J", "kg", "kg*m^2")
        if quantity.path == "response/modes/shape":
            return quantity.values / np.sqrt(factor)
        return factor * quantity.values if grown else quantity.values

    agree(run(table), run(new), expected, rounding=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_another_reference_point(seed: int) -> None:
    """Matrices about a point that lies d away: M' = T^T M T; energies and frequencies stay."""
    table, away = machine(seed), np.array([0.11, -0.07, 0.19])
    new = copy.deepcopy(table)
    x, y, z = away
    # the old point moves by u' + r x (0 - d) when the new one moves by u'
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    shift = np.block([[np.eye(3), cross], [np.zeros((3, 3)), np.eye(3)]])
    for part, key in MATRICES:
        matrix = shift.T @ np.array(table["machine"][part][key]["values"]) @ shift
        new["machine"][part][key]["values"] = (0.5 * (matrix + matrix.T)).tolist()
    train = new["machine"]["crank_train"]
    train["origin"] = (np.array(train.get("origin", [0.0, 0.0, 0.0])) - away).tolist()
    one, other = run(table), run(new)
    moved = (
        "response/translation", "response/ground_couple", "excitation/couple",
        "response/modes/shape", "response/modes/energy_fraction", "response/modes/assurance",
        "excitation/counterweight/couple",
    )  # fmt: skip
    agree(one, other, skip=moved, rounding=1e-9)
    turned = other["response/rotation_harmonics"].values
    # back at the old point, which lies at -d from the new one
    there = other["response/translation_harmonics"].values + np.cross(turned, -away)
    before = one["response/translation_harmonics"]
    assert there == pytest.approx(before.values, abs=1e-9 * np.abs(before.values).max())
    force, couple = (other[f"response/ground_{name}"].values for name in ("force", "couple"))
    about = couple + np.cross(away, force)
    whole = one["response/ground_couple"]
    size = np.abs(couple).max() + np.abs(whole.values).max()
    assert about == pytest.approx(whole.values, abs=1e-9 * size)


@pytest.mark.parametrize("seed", SEEDS)
def test_another_crank_angle_zero(seed: int) -> None:
    """Order n turns by n times the angle; peaks and energies stay."""
    table, angle = machine(seed), 0.8125
    new = copy.deepcopy(table)
    train = new["machine"]["crank_train"]
    for cylinder in train["cylinders"]:
        cylinder["crank_phase"] += angle
    for weight in train.get("counterweights", ()):
        weight["phase"] += angle
    for shaft in train.get("balance_shafts", ()):
        shaft["phase"] += shaft["speed_ratio"] * angle

    def expected(quantity: Quantity) -> Any:
        names = [axis.name for axis in quantity.axes]
        fixed = quantity.path.startswith(("kinematics/", "excitation/rod/"))
        if "order" not in names or not np.iscomplexobj(quantity.values) or fixed:
            return quantity.values
        shape = [1] * quantity.values.ndim
        shape[names.index("order")] = -1
        turn = np.exp(1j * angle * quantity.axes[names.index("order")].values)
        return quantity.values * turn.reshape(shape)

    agree(run(table), run(new), expected)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_cylinder_that_is_stopped_might_as_well_not_be_there(seed: int) -> None:
    table = machine(seed)
    table["machine"]["crank_train"]["cylinders"].append(
        {"name": "idle", "position": 0.3, "crank_phase": 1.0, "reciprocating_mass": 0.7}
    )
    names = [c["name"] for c in table["machine"]["crank_train"]["cylinders"]]
    table["excitation"] = {"working": names[:-1], "idle": "stopped"}
    for key in ("operations", "balances"):
        table["response"].pop(key, None)
    new = copy.deepcopy(table)
    del new["machine"]["crank_train"]["cylinders"][-1], new["excitation"]
    agree(run(table), run(new), skip=("excitation/mass",), rounding=1e-14)


def folder_with(table: Table, tmp_path: Path, *files: str) -> Path:
    tmp_path.mkdir(exist_ok=True)
    case = tmp_path / "case.toml"
    case.write_text(tomli_w.dumps(table), encoding="utf-8")
    for name in files:
        (tmp_path / name).write_bytes((CASES / name).read_bytes())
    return case


MOTOR = "compressor_motor_torque.csv"


def with_motor() -> Table:
    """The motor's case, its torque in a file next to it."""
    table = shipped("compressor_motor")
    del table["response"]
    return table


def test_a_table_in_a_file_is_a_table_in_the_case(tmp_path: Path) -> None:
    inline = with_motor()
    nearby = copy.deepcopy(inline)
    nearby["machine"]["motor"]["torque"] = MOTOR
    one = load_case(folder_with(inline, tmp_path / "inline"))
    two = load_case(folder_with(nearby, tmp_path / "nearby", MOTOR))
    assert one.sha256 == two.sha256
    assert one.resolved == two.resolved
    assert MOTOR in two.text and MOTOR not in two.resolved_toml
    records = [execute(loaded).record for loaded in (one, two)]
    for path, quantity in records[0].items():
        assert np.array_equal(quantity.values, records[1][path].values), path


def test_another_number_in_the_file_is_another_case(tmp_path: Path) -> None:
    table = with_motor()
    table["machine"]["motor"]["torque"] = MOTOR
    case = folder_with(table, tmp_path, MOTOR)
    first = load_case(case).sha256
    csv = tmp_path / MOTOR
    text = csv.read_text(encoding="utf-8")
    csv.write_text("# a comment\n" + text, encoding="utf-8")
    assert load_case(case).sha256 == first
    head, last = text.rstrip("\n").rsplit("\n", 1)
    cells = last.split(",")
    cells[-1] = repr(float(cells[-1]) * 1.5 + 1.0)
    csv.write_text(f"{head}\n{','.join(cells)}\n", encoding="utf-8")
    assert load_case(case).sha256 != first


def test_a_result_runs_again_without_the_file(tmp_path: Path) -> None:
    table = with_motor()
    table["machine"]["motor"]["torque"] = MOTOR
    loaded = load_case(folder_with(table, tmp_path / "with", MOTOR))
    stored = tmp_path / "result.h5"
    write_result(execute(loaded), stored)
    result = read_result(stored)
    alone = tmp_path / "alone.toml"
    alone.write_text(result.case_toml_resolved, encoding="utf-8")
    again = load_case(alone)
    assert again.sha256 == result.case_sha256
    for path, quantity in execute(again).record.items():
        assert np.array_equal(quantity.values, result.record[path].values), path


def test_references_in_a_file_are_references_one_by_one(tmp_path: Path) -> None:
    name = "compressor_table_4_1.csv"
    table = bare()
    row = {"quantity": "response/kinetic_energy/peak_by_order", "axis": "order", "source": "4.1"}
    table["reference_table"] = [{**row, "file": name, "column": "A"}]
    loaded = load_case(folder_with(table, tmp_path / "file", name))
    lines = [
        line
        for line in (CASES / name).read_text(encoding="utf-8").splitlines()
        if line and not line.startswith("#")
    ]
    head = [cell.split("[")[0].strip() for cell in lines[0].split(",")]
    unit = lines[0].split(",")[head.index("A")].partition("[")[2].strip(" ]")
    one_by_one = copy.deepcopy(table)
    del one_by_one["reference_table"]
    one_by_one["reference"] = [
        {
            "quantity": row["quantity"],
            "where": {"order": int(line.split(",")[0])},
            "value": line.split(",")[head.index("A")].strip(),
            "unit": unit,
            "source": "4.1",
        }
        for line in lines[1:]
        if line.split(",")[head.index("A")].strip()
    ]
    other = load_case(folder_with(one_by_one, tmp_path / "single"))
    assert len(loaded.case.reference) > 20
    assert loaded.case.reference == other.case.reference
    assert loaded.sha256 == other.sha256
