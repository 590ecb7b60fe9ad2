"""Claim: the error estimates of an engine on its mounts are honest, those of peaks with the cut.

Seeded engines that drive a machine elsewhere. Couple, motion and forces of single orders against
pistons, gas and body in 30 digits (`exact_engine_drive.py`, `exact_train.py`, `exact_body.py`);
peaks and loads, which mean all orders, against sums over the cycle of sixteen times as many.
"""

import tomllib
from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
import pytest
from engine_mounted import SEPARATE
from estimate_counts import hold
from exact_body import BodyTruth, solve
from exact_engine_drive import EngineDrive
from exact_train import Shaking, motion_of, shaking_of, vector
from mpmath import mpc, mpf
from random_machines import Table
from truth_report import Judged, judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.renamed import current_path
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

ROOT = "isolation/torque_reaction/"
MOVED = "isolation/support_displacement"


def of(name: str) -> str:
    """Path of a result that stood there once."""
    return current_path(f"{ROOT}{name}")


DIGITS = 30
MORE = 16
FEW = (11,)


def random_mounted(seed: int) -> Table:
    """Three cylinders in line that drive a machine elsewhere."""
    draw = np.random.default_rng([seed, 23])
    table: dict[str, Any] = tomllib.loads(SEPARATE)
    machine = table["machine"]
    machine["speed"] = float(draw.uniform(60.0, 300.0))
    train = machine["crank_train"]
    for key in ("piston_mass", "rod"):
        del train[key]
    train |= {"reciprocating_mass": float(draw.uniform(0.5, 3.0)),
              "wrist_pin_offset": float(draw.uniform(-0.006, 0.006)),
              "rod_length": float(draw.uniform(0.16, 0.26))}  # fmt: skip
    if draw.random() < 0.5:
        train["gas_cycle"] = {"kind": "diesel", "compression_ratio": 16.0, "peak_pressure": 9e6}
    for place, one in enumerate(train["cylinders"]):
        one["pressure_scale"] = float(draw.uniform(0.8, 1.1))
        one["position"] = 0.15 * (place - 1.0)
    size = float(np.exp(draw.uniform(-1.0, 2.0)))
    if draw.random() < 0.3:
        each: Table = {"stiffness": [2e5 * size, 2e5 * size, 4e5 * size], "loss_factor": 0.1}
    else:
        each = {"stiffness": [2e5 * size, 3e5 * size, 4e5 * size], "damping": [200.0, 300.0, 400.0]}
    machine["mounts"]["each"] = each
    if draw.random() < 0.5:
        table["excitation"]["orders"] = int(draw.integers(4, 20))
    return table


def judge_mounted(table: Table) -> list[Judged]:
    """Every quantity of the torque reaction that has a truth."""
    case = validate(table)
    record = _of(case)
    wide = {**table, "excitation": {**table["excitation"], "orders": _wide(record)}}
    many = _of(validate(wide))
    with mpmath.workdps(DIGITS):
        rows = [*_by_order(case, record), *_over_the_cycle(case, record, many)]
        return list(judge_rows(rows, record))


def _of(case: Case) -> Record:
    starts = (ROOT, "isolation/support_", "isolation/body/")
    wanted = [p for p in planned_quantities(case) if p.startswith(starts)]
    return run_case(case, wanted=frozenset(wanted))


def _wide(record: Record) -> int:
    order = record[f"{ROOT}couple"].axes[0].values
    return int(MORE * float(order[-1]))


def _by_order(case: Case, record: Record) -> Iterator[tuple[str, Any, Any]]:
    order = [float(one) for one in record[f"{ROOT}couple"].axes[0].values]
    speed = mpf(case.machine.speed)
    drive = EngineDrive(case, order)
    # angles count from crank phase zero, as those of the shaking
    drive.firing = [drive.first + angle for angle in drive.firing]
    gas, mean = drive.healthy(speed)
    whole = [sum(one) for one in zip(*drive.torques(speed), strict=True)]
    yield f"{ROOT}couple", record[f"{ROOT}couple"].values, [-one for one in whole]
    average = -mean * sum(drive.scale)
    yield f"{ROOT}mean_couple", record[f"{ROOT}mean_couple"].values, [average]
    shaking = shaking_of(case, motion_of(case))
    body = BodyTruth(case, Shaking([], [], []))
    axis = vector(*(float(case.machine.crank_train.axis == name) for name in "xyz"))
    force, shift, turn, moved = [], [], [], []
    for k, q in enumerate(order):
        load = np.concatenate([vector(0, 0, 0), vector(0, 0, 0)])
        if q == int(q) and int(q) <= len(shaking.force):
            n = int(q) - 1
            load = speed**2 * np.concatenate([shaking.force[n], shaking.couple[n]])
        burnt = sum(
            s * gas[k] * mpmath.expj(-mpf(q) * a)
            for s, a in zip(drive.scale, drive.firing, strict=True)
        )
        load[3:] = load[3:] - burnt * axis
        w = mpf(q) * speed
        dynamic = body.stiffness - w**2 * body.mass + mpc(0, 1) * (body.loss + w * body.damping)
        motion = solve(dynamic, load)
        shift.append(list(motion[:3]))
        turn.append(list(motion[3:]))
        moved.append([list(g @ motion) for g in body.seen])
        force.append([
            list((m.stiffness + mpc(0, 1) * (m.loss + w * m.damping)) @ (g @ motion))
            for m, g in zip(body.mounts, body.seen, strict=True)
        ])  # fmt: skip
    yield of("translation"), record[of("translation")].values, shift
    yield of("rotation"), record[of("rotation")].values, turn
    turned = np.moveaxis(record[of("support_force")].values, -1, 0)
    yield of("support_force"), turned, force
    turned = np.moveaxis(record[f"{MOVED}/steady_harmonics"].values, -1, 0)
    yield f"{MOVED}/steady_harmonics", turned, moved
    couple = average * axis
    still = solve(body.stiffness, np.concatenate([vector(0, 0, 0), couple]))
    held = [list(m.stiffness @ (g @ still)) for m, g in zip(body.mounts, body.seen, strict=True)]
    yield of("mean_support_force"), record[of("mean_support_force")].values, held


def _over_the_cycle(case: Case, record: Record, many: Record) -> Iterator[tuple[str, Any, Any]]:
    """Peaks and loads by samples of all orders of the wider run."""
    force = many[of("support_force")].values
    number = np.arange(1, force.shape[-1] + 1)
    angle = np.linspace(0.0, 2.0 * np.pi, 40 * len(number) + 1)
    wave = np.exp(1j * np.outer(number, angle))
    course = (force @ wave).real
    yield (of("support_force_peak"), record[of("support_force_peak")].values,
           np.sqrt(np.square(course).sum(1)).max(-1).tolist())  # fmt: skip
    up = ((many[f"{MOVED}/steady_harmonics"].values)[:, 2] @ wave).real
    yield (f"{MOVED}/vertical_peak", record[f"{MOVED}/vertical_peak"].values,
           np.abs(up).max(-1).tolist())  # fmt: skip
    body = BodyTruth(case, Shaking([], [], []))
    mean = float(record[f"{ROOT}mean_couple"].values)
    axis = vector(*(mean * float(case.machine.crank_train.axis == name) for name in "xyz"))
    still = solve(body.stiffness, np.concatenate([vector(0, 0, 0), axis]))
    down = np.array([float(s - (g @ still)[2]) for s, g in zip(body.sag, body.seen, strict=True)])
    yield (f"{MOVED}/total", record[f"{MOVED}/total"].values,
           np.abs(down[:, None] - up).max(-1).tolist())  # fmt: skip
    roll = (many[of("rotation")].values[:, 0] @ wave).real
    yield f"{ROOT}roll_peak", record[f"{ROOT}roll_peak"].values, [float(np.abs(roll).max())]
    for path in (of("minimum_load"), of("largest_load"), "isolation/support_force/by_cause"):
        # their own sums, of so many more orders
        yield path, record[path].values, many[path].values.tolist()


def test_estimates_of_engines_on_mounts() -> None:
    judged = [one for seed in FEW for one in judge_mounted(random_mounted(seed))]
    assert len(judged) == 14 * len(FEW)
    assert sum(one.error > 0.0 for one in judged) > 0.8 * len(judged)
    assert [one for one in judged if one.too_low] == []


@pytest.mark.long
@pytest.mark.timeout(900)
def test_estimates_of_forty_engines_on_mounts() -> None:
    judged = [one for seed in range(40) for one in judge_mounted(random_mounted(seed))]
    assert len(judged) > 300
    hold(judged, "engines on mounts")
