"""Claim: machine and foundation in six freedoms, and on tables, move as dense solves say."""

import copy
import dataclasses
from typing import Any

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.base_motion.model import on_base
from vibecalc.core.case.load import validate
from vibecalc.core.results.renamed import current_path
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.foundation.impedance import Curve, FlexibleFoundation, on_flexible_foundation
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.body import RigidBody, build_body
from vibecalc.parts.machine import build_machine
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mounts import Mounts, build_mounts

ROOT = "foundation/coupled"
FORCE = "isolation/support_force/steady_harmonics"


def deck() -> dict[str, Any]:
    """The shipped case without its run-up and its base."""
    (loaded,) = load_checked([CASES["genset_on_deck"]], [])
    table = copy.deepcopy(dict(loaded.resolved))
    table = {key: table[key] for key in ("schema", "title", "machine", "excitation", "foundation")}
    table["isolation"] = {"model": "rigid_body"}
    table["machine"]["mounts"]["positions"][0][2] = -0.4
    table["machine"]["mounts"]["each"]["damping"] = 300.0
    return table


@pytest.fixture(scope="module")
def on_body() -> tuple[Any, Any]:
    case = validate(deck())
    return case, run_case(case)


def dense(case: Any, w: float) -> tuple[np.ndarray, ...]:
    """Complex stiffness, mass, of mounts alone, and R of both bodies."""
    machine, given = build_machine(case), case.foundation
    place = np.array(given.position)
    springs = build_mounts(given.springs)
    parts = []
    for mounts, upper in ((machine.mounts, True), (springs, False)):
        whole = np.zeros((12, 12), dtype=complex)
        for p, k, c, h in zip(
            mounts.position, mounts.stiffness, mounts.damping, mounts.structural, strict=True
        ):
            rows = np.zeros((3, 12))
            if upper:
                rows[:, :6], rows[:, 6:] = displacement_at(p), -displacement_at(p - place)
            else:
                rows[:, 6:] = displacement_at(p)
            whole += rows.T @ (k + 1j * (h + w * c)) @ rows
        parts.append(whole)
    mass = np.zeros((12, 12))
    mass[:6, :6], mass[6:, 6:] = machine.body.mass_matrix, build_body(given.body).mass_matrix
    rigid = np.vstack([np.eye(6), np.eye(6)])
    rigid[6:9, :] = displacement_at(place)
    return parts[0], parts[1], mass, rigid


def test_motion_loads_and_power_are_those_of_dense_solves(on_body: tuple[Any, Any]) -> None:
    case, record = on_body
    orders = record[f"{ROOT}/power"].axes[0].values
    loads = {
        what: record[f"excitation/{what}"].values[: len(orders)] for what in ("force", "couple")
    }
    total = {"ground": 0.0, "held": 0.0}
    for i, order in enumerate(orders):
        w = float(order) * case.machine.speed
        mounts, springs, mass, rigid = dense(case, w)
        load = np.concatenate([loads["force"][i], loads["couple"][i], np.zeros(6)])
        motion = np.linalg.solve(mounts + springs - w**2 * mass, load)
        scale = np.max(np.abs(load)) + 1e-30
        for name, part in (
            ("machine/translation", motion[:3]), ("machine/rotation", motion[3:6]),
            ("body/translation", motion[6:9]), ("body/rotation", motion[9:]),
        ):  # fmt: skip
            found = record[current_path(f"{ROOT}/{name}")].values[i]
            assert found == pytest.approx(part, rel=1e-9, abs=1e-16 * scale)
        upper = build_machine(case).mounts
        for m, place in enumerate(upper.position):
            below = displacement_at(place - np.array(case.foundation.position))
            stretch = displacement_at(place) @ motion[:6] - below @ motion[6:]
            lagging = upper.structural[m] + w * upper.damping[m]
            force = (upper.stiffness[m] + 1j * lagging) @ stretch
            found = record[FORCE].values[m, :, i]
            assert found == pytest.approx(force, rel=1e-9, abs=1e-11 * scale)
        ground = rigid.T @ (mounts + springs) @ motion
        mine = [record[f"{ROOT}/ground/{what}"].values[i] for what in ("force", "couple")]
        assert np.concatenate(mine) == pytest.approx(ground, rel=1e-9, abs=1e-11 * scale)
        # what goes into the foundation is turned into heat in its springs
        heat = 0.5 * w * np.imag(np.vdot(motion, springs @ motion))
        assert record[f"{ROOT}/power"].values[i] == pytest.approx(heat, rel=1e-8, abs=1e-14 * scale)
        put_in = 0.5 * w * np.imag(np.vdot(motion, load))
        assert put_in == pytest.approx(
            heat + 0.5 * w * np.imag(np.vdot(motion, mounts @ motion)), rel=1e-8, abs=1e-14 * scale
        )
        total["ground"] += float(np.sum(np.abs(ground[:3]) ** 2))
        total["held"] += float(np.sum(np.abs(load[:3]) ** 2))
    share = 1.0 - np.sqrt(total["ground"] / total["held"])
    assert record[f"{ROOT}/ground/force_efficiency"].values == pytest.approx(share, rel=1e-9)
    mounts, springs, mass, _ = dense(case, 0.0)
    squares = np.linalg.eigvals(np.linalg.solve(mass, (mounts + springs).real)).real
    found = record[f"{ROOT}/modes/natural_frequency"].values
    assert found == pytest.approx(np.sqrt(np.sort(squares)), rel=1e-10)
    # over frequency: reciprocity with the base that moves both
    grid = record[f"{ROOT}/ground/transmissibility"].axes[1].values[::40]
    mine = record[f"{ROOT}/ground/transmissibility"].values[:, ::40].T
    for f, row in zip(grid, mine, strict=True):
        w = 2.0 * np.pi * f
        mounts, springs, mass, rigid = dense(case, w)
        whole = mounts + springs
        moved = np.linalg.solve(whole - w**2 * mass, whole @ rigid)[:6]
        assert row == pytest.approx(np.abs(np.diag(moved)), rel=1e-9)


def test_loads_of_the_mounts_and_the_run_up_are_those_on_the_foundation() -> None:
    """Loads by sums over the cycle; forces over speed by runs at the speeds, far from rigid."""
    table = deck()
    first, last = 0.6 * table["machine"]["speed"], 1.1 * table["machine"]["speed"]
    table["isolation"]["run_up"] = {"from": first, "to": last}
    record = run_case(validate(table))
    force = record[FORCE]
    turn = np.exp(1j * np.outer(force.axes[2].values, np.linspace(0.0, 4.0 * np.pi, 8001)))
    load = record["isolation/support_force/static"].values[:, None]
    load = load - (force.values[:, 2] @ turn).real
    for path, found in (("minimum_load", load.min(axis=1)), ("largest_load", load.max(axis=1))):
        known = record[f"isolation/support_force/{path}"]
        assert np.abs(known.values - found).max() <= known.error_estimate + 1e-5 * load.max()
    curve = record["isolation/support_force/run_up"]
    speeds = curve.axes[1].values
    del table["isolation"]["run_up"]
    for place in (0, len(speeds) // 3, len(speeds) // 2, -1):
        table["machine"]["speed"] = float(speeds[place])
        plain = run_case(validate(table))["isolation/support_force/steady_peak"].values
        assert curve.values[:, place] == pytest.approx(plain, rel=1e-9)
    del table["foundation"]
    rigid = run_case(validate(table))["isolation/support_force/steady_peak"].values
    assert np.all(np.abs(rigid / plain - 1.0) > 1e-3)


def test_a_stiff_body_is_a_rigid_foundation_and_tables_of_it_are_the_same(
    on_body: tuple[Any, Any],
) -> None:
    case, record = on_body
    table = deck()
    orders = record[f"{ROOT}/power"].axes[0].values
    # the same foundation, whose springs are even about its centre, as dynamic stiffness by tables;
    # guard orders are solved too
    w = np.arange(1, 3 * len(orders) + 1) * case.machine.speed
    springs, mass = build_mounts(case.foundation.springs), build_body(case.foundation.body)
    arms = [displacement_at(p) for p in springs.position]
    k, h = (sum(a.T @ one @ a for a, one in zip(arms, each, strict=True))
            for each in (springs.stiffness, springs.structural))  # fmt: skip
    assert np.allclose(k, np.diag(np.diag(k)))
    flexibilities = []
    for i, direction in enumerate(("x", "y", "z", "rx", "ry", "rz")):
        value = k[i, i] + 1j * h[i, i] - w**2 * mass.mass_matrix[i, i]
        by_velocity = i % 2 == 1
        value = value / (1j * w) if by_velocity else value
        key = "angular_" * (i > 2) + ("impedance" if by_velocity else "dynamic_stiffness")
        columns = {"frequency": w, "real": value.real, "imaginary": value.imag}
        flexibilities.append({"at": "whole", "direction": direction, key: columns})
    table["foundation"] = {
        "kind": "impedance", "position": list(case.foundation.position),
        "flexibilities": flexibilities,
    }  # fmt: skip
    by_tables = run_case(validate(table))
    # what is on tables has no ground below it: the loads are those of the mounts
    pushed = by_tables[FORCE].values.sum(axis=0).T
    size = np.max(np.abs(pushed))
    assert by_tables[f"{ROOT}/ground/force"].values == pytest.approx(pushed, abs=1e-12 * size)
    for name in ("machine/translation", "body/rotation", "power", "mount_force", "foot"):
        path = current_path(f"{ROOT}/{name}")
        found, known = by_tables[path], record[path]
        size = np.max(np.abs(known.values))
        assert found.values == pytest.approx(known.values, rel=1e-8, abs=1e-10 * size)
        assert found.error_estimate < 1e-8 * size
    stiff = deck()
    stiff["foundation"]["springs"]["each"]["stiffness"] = 1e17
    rigid = run_case(validate(stiff))
    for what in ("force", "couple"):
        known = rigid[f"{ROOT}/rigid/{what}"].values
        size = np.max(np.abs(known))
        assert rigid[f"{ROOT}/ground/{what}"].values == pytest.approx(known, abs=1e-7 * size)


def test_feet_are_springs_in_series_with_the_mounts() -> None:
    """A foot of stiffness z under a mount of k (both complex) passes k z / (k + z)."""
    table = deck()
    table["machine"]["mounts"]["each"].update(damping=0.0)
    foot = 3.0e6 * (1.0 + 0.08j)
    columns = {"frequency": [100.0], "real": [foot.real], "imaginary": [foot.imag]}
    table["foundation"] = {
        "kind": "impedance",
        "flexibilities": [
            {"direction": one, "dynamic_stiffness": columns} for one in ("x", "y", "z")
        ],
    }
    found = run_case(validate(table))
    series = copy.deepcopy(table)
    del series["foundation"]
    each = series["machine"]["mounts"]["each"]
    springs = np.array(each["stiffness"]) * (1.0 + 1j * each["loss_factor"])
    whole = springs * foot / (springs + foot)
    # its real part as spring; the loss factor differs by direction, so one direction is compared
    each.update(stiffness=whole.real.tolist(), loss_factor=float(whole[2].imag / whole[2].real))
    known = run_case(validate(series))["isolation/support_force/steady_harmonics"].values
    rows = [i for i in range(12) if np.max(np.abs(known[..., i])) > 1.0]
    assert rows
    mine = found[FORCE].values
    total, other = mine[:, 2].sum(axis=0), known[:, 2].sum(axis=0)
    assert total[rows] == pytest.approx(other[rows], rel=2e-2)
    velocity = found[f"{ROOT}/foot"].values
    assert velocity == pytest.approx(mine / foot, rel=1e-9, abs=1e-20)
    assert f"{ROOT}/body/translation" not in found
    # what is put in is turned into heat in mounts and feet
    assert np.all(found[f"{ROOT}/power"].values >= 0.0)


def test_no_steady_motion_is_refused() -> None:
    table = deck()
    w = 2.0 * table["machine"]["speed"]
    columns = {"frequency": [1.0], "real": [0.0], "imaginary": [0.0]}
    table["foundation"] = {
        "kind": "impedance", "flexibilities": [{"direction": "z", "dynamic_stiffness": columns}],
    }  # fmt: skip
    with pytest.raises(NumericalFailure, match="nothing carries it"):
        run_case(validate(table))
    columns = {"frequency": [1.0, 0.9 * w], "real": [1e6, 1e6], "imaginary": [1e4, 1e4]}
    table["foundation"]["flexibilities"][0]["dynamic_stiffness"] = columns
    with pytest.raises(NumericalFailure, match="beyond the tables"):
        run_case(validate(table))


def test_a_base_that_moves_carries_the_foundation() -> None:
    table = deck()
    point = [0.3, -0.2, -3.0]
    table["base_motion"] = {
        "point": point,
        "harmonics": [{"name": "blades", "frequency": 88.0, "velocity": [1e-3, 2e-3, 4e-3],
                       "angular_velocity": [4e-4, 1e-4, 0.0]}],
        "spectra": [{"direction": "z", "acceleration": {
            "frequency": [30.0, 200.0], "density": [1e-3, 1e-3]}}],
    }  # fmt: skip
    case = validate(table)
    record = run_case(case)
    mounts, springs, mass, rigid = dense(case, 88.0)
    whole = mounts + springs
    turn = np.eye(6)
    turn[:3] = displacement_at(-np.array(point))
    base = turn @ (np.array([1e-3, 2e-3, 4e-3, 4e-4, 1e-4, 0.0]) / 88.0j)
    motion = np.linalg.solve(whole - 88.0**2 * mass, whole @ rigid @ base)
    root = "base_motion/harmonic"
    for name, part in (
        ("translation", motion[:3]), ("rotation", motion[3:6]),
        ("relative_translation", motion[:3] - base[:3]),
        ("foundation_translation", motion[6:9]), ("foundation_rotation", motion[9:]),
    ):  # fmt: skip
        assert record[f"{root}/{name}"].values[0] == pytest.approx(part, rel=1e-9, abs=1e-15)
    # white acceleration of the base: sums over a fine grid, which is even about the resonances
    w = np.linspace(30.0, 200.0, 4001)
    grid = np.array([dense_acceleration(case, float(one)) for one in w[::8]])
    power = np.trapezoid(np.abs(grid) ** 2, w[::8]) / (2.0 * np.pi) * 1e-3
    rms = record["base_motion/spectrum/acceleration_rms"].values[2]
    assert rms == pytest.approx(np.sqrt(power), rel=1e-3)


@pytest.mark.parametrize("kind", ["base", "body", "tables"])
def test_what_is_uncertain_of_mass_and_mounts_is_in_the_errors(kind: str) -> None:
    """Results of a machine that is off by so much are as far away as the errors say, or nearer."""
    case = validate(deck())
    alone = validate({key: value for key, value in deck().items() if key != "foundation"})
    machine = build_machine(case)
    assert machine.body is not None and machine.mounts is not None
    share, w = 1.0e-6, np.array([60.0, 157.0])
    rough = share * np.abs(machine.body.mass_matrix)
    given = dataclasses.replace(machine.body, mass_error=rough)
    known = dataclasses.replace(machine.mounts, relative_error=np.full(6, share))
    unit = np.broadcast_to(np.eye(6, dtype=complex), (2, 6, 6))
    feet = {(n, 2): Curve(w[:1], np.array([3e6 + 3e5j]), False) for n in range(6)}
    foundation = FlexibleFoundation(feet, {}, np.zeros(3))

    def results(body: RigidBody, mounts: Mounts) -> Bounded:
        if kind == "tables":
            load = Bounded(unit, np.zeros(unit.shape))
            return on_flexible_foundation(body, mounts, foundation, w, load).force
        system = on_base(case if kind == "body" else alone, body, mounts)
        relative, _ = system.moved_by_base(Bounded(unit[:, 0], np.zeros((2, 6))), w)
        return system.force(system.at_mounts(relative), w)

    plain, told = results(machine.body, machine.mounts), results(given, known)
    assert np.array_equal(plain.value, told.value)
    for sign in (1.0, -1.0):
        heavy = dataclasses.replace(
            machine.body, mass_matrix=machine.body.mass_matrix * (1.0 + sign * share)
        )
        stiff = dataclasses.replace(
            machine.mounts,
            stiffness=machine.mounts.stiffness * (1.0 - sign * share),
            structural=machine.mounts.structural * (1.0 - sign * share),
        )
        for other in (results(heavy, machine.mounts), results(machine.body, stiff)):
            moved = np.abs(other.value - plain.value)
            assert np.max(moved) > 1e3 * np.max(plain.error)
            assert np.all(moved <= 1.001 * told.error + plain.error)
    assert np.max(told.error) < 1e2 * share * np.max(np.abs(plain.value))


def dense_acceleration(case: Any, w: float) -> complex:
    """Of the machine up and down, by a unit of the base."""
    if "parts" not in CACHE:
        CACHE["parts"] = [dense(case, one) for one in (0.0, 1.0)]
    (m0, s0, mass, rigid), (m1, s1, *_) = CACHE["parts"]
    still, moving = m0 + s0, m1 + s1
    whole = still + w * (moving - still)
    up = rigid[:, 2]
    return complex(np.linalg.solve(whole - w**2 * mass, whole @ up)[2])


CACHE: dict[str, Any] = {}
