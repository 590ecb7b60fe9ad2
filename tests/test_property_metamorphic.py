"""Claim: a machine told in other units has the same results, with the estimates of their errors.

That they are right, from any origin and along any axes, `test_consistency_random_machines.py` and
`test_property_error_estimates.py` hold.
"""

import copy

import numpy as np
import pytest
from long_but import long_but
from machine_relations import factor_of, in_units
from random_machines import Table, mounted_machine, random_machine

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case


def run(case: Table) -> Record:
    """All results but the curves over speed, which sample where they like."""
    checked = validate(copy.deepcopy(case))
    paths = [path for path in planned_quantities(checked) if not _over_speed(path)]
    return run_case(checked, wanted=frozenset(paths))


def _over_speed(path: str) -> bool:
    last = path.rsplit("/", 1)[-1]
    return last == "run_up" or ("/run_up/" in path and "largest" not in path)


def machine(seed: int, model: str) -> Table:
    """A random machine with gravity and what else has a usual value written out."""
    if model == "pitch":
        case = random_machine(seed, model, gravity=9.80665)
    else:
        case = mounted_machine(seed)
        case["isolation"]["gravity"] = 9.80665
        if "pump_cycle" in case["machine"]["crank_train"]:
            case["machine"]["crank_train"]["pump_cycle"]["outside_pressure"] = 1e5
        # its grades are of frequencies in Hz
        case["vibration_severity"] = {"band": [10.0, 3000.0]} if "point" in case else None
        case = {key: value for key, value in case.items() if value is not None}
    case["accuracy"] = {"rtol": 1e-9}
    return case


@pytest.mark.parametrize("model", ["pitch", "rigid_body"])
@pytest.mark.parametrize("seed", long_but(range(300), 5, 8))
@pytest.mark.parametrize("powers", long_but([(17, -23, 11), (-20, 30, -13)], (17, -23, 11)))
def test_units_of_length_mass_and_time(seed: int, model: str, powers: tuple[int, ...]) -> None:
    """Powers of two round nothing, so that even error estimates follow."""
    factors = (2.0 ** powers[0], 2.0 ** powers[1], 2.0 ** powers[2])
    case = machine(seed, model)
    one, other = run(case), run(in_units(case, factors))
    assert set(one) == set(other) and len(one) > 10
    for path, quantity in one.quantities.items():
        found = other[path]
        # grades are in Hz; a curve of load is at least 1e-9 m long
        if "severity" in path or path.endswith("load_curve"):
            continue
        if path.endswith("modes/shape"):
            turn = factors[0] ** -1.0
            factor = factors[1] ** -0.5 * np.array([1, 1, 1, turn, turn, turn])
        else:
            factor = np.asarray(factor_of(quantity.unit, factors))
            estimate = quantity.error_estimate * float(factor)
            # of mean squares it is the difference of two rules, down to rounding
            rel = 1.0 if path.startswith("base_motion/spectrum/") else 0.1
            assert found.error_estimate == pytest.approx(estimate, rel=rel), path
        want = quantity.values * factor
        size = float(np.max(np.abs(want[np.isfinite(want)]), initial=0.0))
        slack = 2.0 * (quantity.error_estimate * float(np.max(factor)) + found.error_estimate)
        equal = want == found.values
        off = np.abs(np.where(equal, 0.0, want - np.where(equal, 0.0, found.values)))
        worst = float(np.max(off, initial=0.0))
        assert worst <= 1e-12 * size + slack, f"{path}: {worst:.3g} of {size:.3g}"
