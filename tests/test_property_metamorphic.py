"""Claim: a machine told from another origin, axes, order, parts or units has the same results.

With the estimates of their errors, in other units. That they are right
`test_consistency_random_machines.py` and `test_property_error_estimates.py` hold.
"""

import copy
from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest
from long_but import long_but
from machine_relations import factor_of, in_units, moved, shuffled, turned, with_halves
from random_machines import Table, mounted_machine, random_machine

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case

#: machines of all kinds on all that mounts may stand on; the others with the long tests
SEEDS = long_but(range(300), 5, 7, 8)
#: results whose value depends on the point that they are of, said in their names
OF_THE_POINT = ("reference point", "about the origin", "along and about the same axis")
#: what is free to turn round
EITHER_SENSE = ("modes/shape", "principal_axes")


def run(case: Table) -> Record:
    """All results but the curves over speed, which sample where they like."""
    checked = validate(copy.deepcopy(case))
    paths = [path for path in planned_quantities(checked) if not _over_speed(path)]
    return run_case(checked, wanted=frozenset(paths))


def _over_speed(path: str) -> bool:
    last = path.rsplit("/", 1)[-1]
    return last == "run_up" or ("/run_up/" in path and "largest" not in path)


@cache
def known(seed: int) -> Record:
    return run(mounted_machine(seed))


def _same(name: str) -> str:
    return name


def _next(name: str) -> str:
    """The direction that follows, also of a sensor along it, or of a moment."""
    following = {"x": "y", "y": "z", "z": "x"}
    if name[-1] not in following:
        return name
    if len(name) == 2 and name[0] in following:
        return "".join(sorted(following[one] for one in name))
    return name[:-1] + following[name[-1]]


def aligned(one: Quantity, other: Quantity, name_of: Callable[[str], str]) -> np.ndarray:
    """Values of the other at the entries of the one, which it calls by other names."""
    values = np.asarray(other.values)
    for place, (axis, new) in enumerate(zip(one.axes, other.axes, strict=True)):
        if np.asarray(axis.values).dtype.kind not in "biuf":
            names = [str(name) for name in new.values]
            where = [names.index(name_of(str(name))) for name in axis.values]
            values = np.take(values, where, axis=place)
    return values


RELATIONS = {
    "origin": (partial(moved, by=np.array([0.148, -0.507, 1.446])), _same),
    "axes": (turned, _next),
    "order": (shuffled, _same),
    "halves": (with_halves, _same),
}


@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.parametrize("seed", SEEDS)
def test_told_in_another_way(seed: int, relation: str) -> None:
    tell, name_of = RELATIONS[relation]
    case = mounted_machine(seed)
    one, other = known(seed), run(tell(case))
    assert {*one} == {*other}
    same, wrong = 0, []
    for path, quantity in one.quantities.items():
        of_point = any(words in quantity.long_name for words in OF_THE_POINT)
        if (relation == "origin" and of_point) or (relation == "halves" and "/maxima/" in path):
            continue
        want = np.asarray(quantity.values)
        found = aligned(quantity, other[path], name_of)
        if path.endswith(EITHER_SENSE):
            want, found = np.abs(want), np.abs(found)
        if relation == "halves" and quantity.unit in ("N", "N/m") and quantity.axes:
            first = np.array([n == 0 for n in range(want.shape[0])])
            halved = quantity.axes[0].name == "mount"
            want = want * np.where(first & halved, 0.5, 1.0).reshape(-1, *(1,) * (want.ndim - 1))
        if want.shape != found.shape:
            wrong.append(f"{path}: {want.shape}, {found.shape}")
            continue
        equal = want == found
        off = np.abs(np.where(equal, 0.0, want - np.where(equal, 0.0, found)))
        finite = np.where(np.isfinite(want), np.abs(want), 0.0)
        size = max(float(np.max(finite, initial=0.0)), quantity.terms)
        slack = float(quantity.error_estimate) + float(other[path].error_estimate)
        if float(np.max(off, initial=0.0)) > slack + 1e-9 * size:
            wrong.append(f"{path}: {np.max(off):.3g} of {size:.3g}")
        same += 1
    assert wrong == []
    assert same > 20


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
