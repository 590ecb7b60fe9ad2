"""Claim: every result of random machines on mounts is that of the equations of motion alone.

Bodies of parts, gas, misfire, laws of mounts, stops, foundations, bases, points and run-ups at
once, against the dense model of `dense_results.py`. Kept orders agree to 1e-9 of the size of a
result or the stated error; with as many orders as count the stated error covers what is left out.
"""

import copy
from collections.abc import Iterator

import numpy as np
import pytest
from dense_ground import base_results, coupled_results, two_mass_results
from dense_machine import OnMounts, peak
from dense_results import Dense, Expected, compare
from dense_run_up import at_speeds, mount_forces, response_results, run_up_results
from dense_train import Table, Train
from long_but import long_but
from random_machines import mounted_machine, random_machine
from scipy.optimize import minimize_scalar
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

#: of 300 machines those that have all kinds of parts, tables and laws together, and one whose
#: highest motion is parted by a kink from the end of its run-up; the rest are long
USUAL = (19, 52, 64, 114, 122, 125, 126, 149, 272, 276)
#: of these with all orders and searches over speed
DEEP = (52, 64, 122, 125)
#: paths, or their ends, that are not compared, and why
UNCOMPARED = {
    "speed": "the result at that speed is compared; the place of a flat maximum is no number",
    "kinematics/": "tested by themselves",
    "body/principal_axes": "signs are free",
    "run_up/maxima/": "but for the force at each place: what names order and mode",
    "response/resonances_skipped/": "of undamped machines, which these are not",
    "response/modes/": "but for frequency, damping and shape: what names the nearest order",
}


def every_result(dense: Dense) -> Iterator[Expected]:
    """All that a run of the case records."""
    yield from dense.values()
    if dense.foundation in ("body", "impedance"):
        yield from coupled_results(dense)
    if dense.foundation == "mass":
        yield from two_mass_results(dense)
    if "base_motion" in dense.case:
        yield from base_results(dense)
    if "response" in dense.case:
        yield from response_results(dense)
    if "run_up" in dense.case["isolation"]:
        yield from run_up_results(dense)


def problems(seed: int, deep: bool) -> list[str]:
    """What a run of a random machine has wrong, or has and is not compared."""
    case = mounted_machine(seed)
    checked = validate(copy.deepcopy(case))
    assert not check_machine(checked)
    record = run_case(checked)
    expected = [*every_result(Dense(case, record, deep))]
    compared = {one.path for one in expected}
    left = [path for path in record if path not in compared and _said(path)]
    return [*filter(None, (compare(one, record) for one in expected)), *left]


def _said(path: str) -> bool:
    return not any(path.endswith(one) or one in path for one in UNCOMPARED)


@pytest.mark.parametrize("seed", long_but(range(300), *USUAL))
def test_results_are_those_of_the_equations_of_motion(seed: int) -> None:
    assert problems(seed, seed in DEEP or seed not in USUAL) == []


def test_a_change_of_a_hundred_millionth_is_seen() -> None:
    """In the mass of a piston, the stiffness of a mount, the pressure in a cylinder."""
    case = mounted_machine(22)
    record = run_case(validate(copy.deepcopy(case)))
    train, parts = case["machine"]["crank_train"], case["machine"]["body"]["parts"]
    for row, key, path in (
        (train, "crank_radius", "excitation/force"),
        (parts[0], "mass", "isolation/support_force/static"),
        (train, "bore", "isolation/torque_reaction/couple"),
    ):
        whole = row[key]
        row[key] = np.float64(whole) * (1.0 + 1e-8)
        found = [compare(one, record) for one in Dense(case, record, False).values()]
        assert any(words.startswith(path) for words in found), path
        row[key] = whole


def pitching(case: Table, record: Record) -> Iterator[Expected]:
    """Of a body that turns about the axis across its crankshaft, through its mass centre, alone.

    Its mounts resist along the stroke; at rest it heaves and pitches on them.
    """
    on, train, root = OnMounts(case), Train(case), "isolation"
    solid, mounts, up, speed = on.solid, on.mounts, train.up, case["machine"]["speed"]
    order = np.asarray(record[f"{root}/pitch/angle_harmonics"].axes[0].values, dtype=float)
    train.prepare(order)
    load, rate = train.loads(speed), order * speed
    couple = (load[:, 3:] - np.cross(solid.centre, load[:, :3])) @ train.across
    inertia = train.across @ solid.central[3:, 3:] @ train.across
    far = (mounts.place - solid.centre) @ train.axis
    still, damping = (
        np.einsum("i,nij,j->n", up, one, up) for one in (mounts.stiffness, mounts.damping)
    )
    passing = np.einsum("i,mnij,j->mn", up, mounts.passing(rate), up)
    whole = passing @ far**2
    angle = couple / (whole - rate**2 * inertia)
    own = np.sqrt(still @ far**2 / inertia)
    loss = mounts.passing(np.zeros(1))[0].imag
    lost = np.einsum("i,nij,j->n", up, loss, up) @ far**2 / (still @ far**2)
    lever = case["isolation"]["lever"]
    for name, value in (
        ("pitch/inertia", inertia),
        ("pitch/stiffness", still @ far**2),
        ("pitch/damping", damping @ far**2),
        ("pitch/natural_frequency", own),
        ("pitch/damping_ratio", 0.5 * (damping @ far**2 / (own * inertia) + lost)),
        ("pitch/angle_harmonics", angle),
        ("couple_over_lever/blocked_harmonics", couple / lever),
        ("couple_over_lever/steady_harmonics", whole * angle / lever),
        ("couple_over_lever/steady_peak", peak(whole * angle / lever, order)),
        ("support_force/steady_peak", peak((-far * passing).T * angle, order)),
    ):
        yield Expected(f"{root}/{name}", value)
    held = np.array([[still.sum(), still @ far], [still @ far, still @ far**2]])
    heave, tilt = np.linalg.solve(held, [np.linalg.norm(on.weight[:3]), 0.0])
    yield Expected(f"{root}/support_displacement/static", heave + tilt * far)


@pytest.mark.parametrize("model", ["pitch", "rigid_body"])
@pytest.mark.parametrize("seed", range(8))
def test_a_body_with_a_block_moves_as_its_equations_of_motion_say(seed: int, model: str) -> None:
    case = random_machine(seed, model, efficiency=True)
    del case["isolation"]["run_up"]
    record = run_case(validate(copy.deepcopy(case)))
    whole = model == "rigid_body"
    expected = Dense(case, record).values() if whole else pitching(case, record)
    assert [*filter(None, (compare(one, record) for one in expected))] == []


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
