"""The roll of a machine next to a truth: far more Gauss points, and twice, to know its own error.

With 20 and with 24 Gauss points on each panel between the kinks of the gas tables (and of the
motor's) collocation is of order 40 and more: what is left is rounding, and the difference of the
two says how much of it. `test_property_estimates_subjects.py` holds this truth against DOP853 on
formulas of its own (`exact_roll.py`).
"""

import copy

import numpy as np
from estimate_counts import Reported, Uncertain, checked_run
from random_machines import Table

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.run import run_case

POINTS = (20, 24)
#: counts and names of what was done: no estimates
COUNTS = ("trivial_multipliers", "method/work")


def judge_roll(table: Table) -> Reported:
    """Every result of a run next to the truth."""
    _, record = checked_run(table)
    truth, again = (run_case(validate(_refined(table, points))) for points in POINTS)
    judged = [
        _judged(quantity, truth[path], again[path])
        for path, quantity in record.items()
        if not path.endswith(COUNTS)
    ]
    return Reported(table, record, judged)


def truth_of(table: Table) -> Record:
    """The same machine with far more points."""
    return run_case(validate(_refined(table, POINTS[0])))


def _refined(table: Table, points: int) -> Table:
    finer = copy.deepcopy(table)
    finer["response"]["roll"] |= {"method": "collocation", "points": points}
    finer["accuracy"]["rtol"] = 1e-12
    return finer


def _judged(found: Quantity, truth: Quantity, again: Quantity) -> Uncertain:
    noise = _apart(found.path, truth.values, again.values)
    error = _apart(found.path, found.values, truth.values)
    there = np.abs(truth.values)[np.isfinite(truth.values)]
    size = float(np.max(there, initial=0.0))
    return Uncertain(found.path, error, found.error_estimate, size, noise)


def _apart(path: str, one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference; levels of what is zero within its error (-inf) have none."""
    assert one.shape == other.shape, path
    there = np.isfinite(one) & np.isfinite(other)
    if "phase_lag" in path:
        turned = np.angle(np.exp(1j * (one - other)))
        # zero stands for the phase of nothing
        return float(np.max(np.abs(turned), initial=0.0, where=(one != 0.0) & (other != 0.0)))
    away = np.where(there, one, 0.0) - np.where(there, other, 0.0)
    return float(np.max(np.abs(away), initial=0.0))
