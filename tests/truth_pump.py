"""Runs a pump and holds every error estimate of its record against the exact results."""

from collections.abc import Iterator
from typing import Any

import mpmath
from estimate_counts import Reported
from exact_body import BodyTruth
from exact_pump import PumpTruth, pump_rows
from exact_pump_mounts import ROOT, ReactionTruth, reaction_rows
from exact_results import exact_results
from exact_train import Shaking, motion_of, shaking_of
from random_machines import Table
from truth_report import judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

DIGITS = 50
#: results without a truth, and why
NO_TRUTH = {f"{ROOT}nearest_order": "a number of a row: which order is said to drive a mode"}


def judge_pump(table: Table) -> Reported:
    """Every quantity of a run of a case table next to the truth; none is left out unsaid."""
    case = validate(table)
    record = run_case(case)
    noise: dict[str, float] = {}
    with mpmath.workdps(DIGITS):
        rows = judge_rows(exact_pump_results(case, record, noise), record)
        judged = [one._replace(noise=noise.get(one.path, 0.0)) for one in rows]
    missing = set(record) - {one.path for one in judged} - set(NO_TRUTH)
    assert not missing, f"no truth for {sorted(missing)}"
    return Reported(table, record, judged)


def exact_pump_results(
    case: Case, record: Record, noise: dict[str, float]
) -> Iterator[tuple[str, Any, Any]]:
    """Path, values found and exact ones; `noise` gets what a truth may be off itself."""
    case = _without_stopped(case)
    pump, shaking = PumpTruth(case), shaking_of(case, motion_of(case))
    # harmonics of the exact motion end where n^2 C_n is below 1e-26 of the crank radius
    reach = case.machine.speed**2 * case.machine.crank_train.crank_radius
    noise["kinematics/dropped_acceleration"] = 1e-24 * reach
    yield from pump_rows(case, record, pump)
    yield from exact_results(case, record)
    if f"{ROOT}couple" in record:
        kept = len(record[f"{ROOT}couple"].values)
        body = BodyTruth(case, Shaking([], [], []))
        truth = ReactionTruth(case, body, shaking, pump, kept)
        yield from reaction_rows(record, truth, noise)


def _without_stopped(case: Case) -> Case:
    """The same with no mass in cylinders that stop."""
    asked, train = case.excitation, case.machine.crank_train
    if asked is None or asked.working is None or asked.idle != "stopped":
        return case
    assert train.rod is None
    none = {"reciprocating_mass": 0.0, "rotating_mass": 0.0}
    cylinders = [
        one if one.name in asked.working else one.model_copy(update=none) for one in train.cylinders
    ]
    train = train.model_copy(update={"cylinders": cylinders})
    machine = case.machine.model_copy(update={"crank_train": train})
    return case.model_copy(update={"machine": machine})
