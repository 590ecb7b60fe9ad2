"""Claim: error estimates are honest, from cards and valves to the loads on the mounts.

Seeded random machines run from their case tables. The truth of each is the same machine, twice,
with all its inputs moved within half of their last digit and finer numerics: other roundings
everywhere, as far as the inputs carry them, and less left out. At most 1 % of the estimates are
below a tenth of what results move by, at most 5 % above a thousand times of it, and what misses
`[accuracy] rtol` is said to. That results are right is held elsewhere, by formulas of their own
(`test_consistency_*.py`); generators have their truth in 50 digits
(`test_property_error_estimates.py`), levels on plates in 40
(`test_consistency_measurement_stage.py`).
"""

import copy
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from estimate_counts import (
    MOST_TOO_HIGH,
    UNIT,
    Reported,
    Uncertain,
    broken_promises,
    checked_run,
    hold,
    reported_or_refused,
)
from long_but import long_but
from random_absorbers import random_absorber
from random_dampers import random_damper_case
from random_engines import random_engine
from random_line_studies import random_transient, random_variable_line
from random_machines import Table
from random_mounted import random_mounted
from random_pumps import random_pump
from random_rolls import random_roll
from response_machines import random_compressor

from vibecalc.core.case.load import resolve, validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.run import run_case
from vibecalc.torsion.transient import march as transient_pieces

sys.path.insert(0, str(Path(__file__).parent / "matrix"))
from conditioning import moved

#: how often each machine is moved
TIMES = 2
#: estimates themselves, inputs as the case has them, counts, places in a list, what more orders
#: take away, or come nearer to; poles of one frequency may change places
NO_RESULTS = (
    *("frequency_error", "holzer_residual", "tuning/primary_damping", "method/work"),
    *("trivial_multipliers", "highest_order", "secondary/source", "largest_change_speed"),
    *("kinematics/dropped_acceleration", "absorber/pole", "modes/distance"),
)
#: of the first order by definition, and as the case has them
NOT_JUDGED = ("variable_inertia/wedge/", "limit/basis/")


def as_it_is(table: Table, patch: pytest.MonkeyPatch) -> Table:
    """What computes to rounding, or orders that are the choice of the case."""
    return table


def more_orders(table: Table, patch: pytest.MonkeyPatch) -> Table:
    """Of a machine on its mounts: sixteen times as many, or all there are."""
    orders = len(run_case(validate(table))["excitation/force"].axes[0].values)
    return table | {"excitation": {**table.get("excitation", {}), "orders": 16 * orders}}


def more_of_a_cycle(table: Table, patch: pytest.MonkeyPatch) -> Table:
    """Of inertias that vary: 40 orders."""
    table["response"]["torsion"]["variable_inertia"] = {"orders": 40}
    return table


def shorter_steps(table: Table, patch: pytest.MonkeyPatch) -> Table:
    """Of a change in time: a quarter of them."""
    for name in ("ORDER_STEP", "MODE_STEP"):
        patch.setattr(transient_pieces, name, 0.25 * getattr(transient_pieces, name))
    return table


def more_points(table: Table, patch: pytest.MonkeyPatch) -> Table:
    """Of a roll: 20 Gauss points on each panel."""
    table["response"]["roll"] |= {"method": "collocation", "points": 20}
    table["accuracy"]["rtol"] = 1e-12
    return table


def compressor(seed: int) -> Table:
    """Of its operations two, that their first orders may cancel at some phases."""
    table = random_compressor(seed)
    table["accuracy"]["rtol"] = max(table["accuracy"]["rtol"], 1e-9)
    del table["response"]["operations"][2:]
    return table


class Kind(NamedTuple):
    """Machines by seed, their finer numerics, seeds of the quick test and estimates it has.

    `broken` is the share of estimates beyond the tolerance, of which nothing was said; `most_high`
    that of estimates that may be too high.
    """

    make: Callable[[int], Table]
    finer: Callable[[Table, pytest.MonkeyPatch], Table]
    few: tuple[int, ...]
    least: int
    broken: float = 0.0
    most_high: float = MOST_TOO_HIGH


KINDS = {
    # a cycle, a damper, a branch; elastic teeth, misfire, limits, barred and hammering ranges
    "engine": Kind(random_engine, as_it_is, (102, 400), 130),
    # with whole steps and with quarters the same remains, far below what half steps tell
    "transient": Kind(random_transient, shorter_steps, (20,), 15, most_high=0.3),
    "variable": Kind(random_variable_line, more_of_a_cycle, (7,), 10),
    "damper": Kind(random_damper_case, as_it_is, (2,), 25),
    # pitch with an offset, planar with the driven machine on the body
    "pump": Kind(random_pump, more_orders, (103, 156), 100),
    "compressor": Kind(compressor, more_orders, (0, 3, 9), 90),
    "mounted": Kind(random_mounted, more_orders, (11,), 25),
    "absorber": Kind(random_absorber, as_it_is, (6, 7, 9, 13, 17), 90),
    "roll": Kind(random_roll, more_points, (14,), 50, broken=0.001),
}


def judged(kind: Kind, table: Table) -> Reported:
    """Every estimate of a run next to what the result moves by."""
    case, record = checked_run(table)
    draws = [np.random.default_rng(seed) for seed in range(TIMES)]
    with pytest.MonkeyPatch.context() as patch:
        finer = resolve(validate(kind.finer(copy.deepcopy(table), patch)))
        others = [run_case(validate(moved(finer, 0.5 * UNIT, draw))) for draw in draws]
    found = [one for one in record.values() if _has_an_estimate(one)]
    same = [one for one in found if all(_same_places(one, other[one.path]) for other in others)]
    assert len(same) > 0.9 * len(found)
    return Reported(resolve(case), record, [_uncertain(one, others) for one in same])


def _has_an_estimate(one: Quantity) -> bool:
    result = not one.path.endswith(NO_RESULTS) and not any(part in one.path for part in NOT_JUDGED)
    return result and one.values.dtype.kind in "fc" and one.values.size > 0


def _same_places(one: Quantity, other: Quantity) -> bool:
    """Whether it is of the same speeds, which a run chooses along a run-up, and orders."""
    pairs = ((np.asarray(axis.values), np.asarray(seen.values)[: len(axis.values)])
             for axis, seen in zip(one.axes, other.axes, strict=True))  # fmt: skip
    return all(
        len(axis) == len(seen) and (axis.dtype.kind != "f" or np.allclose(axis, seen, rtol=1e-12))
        for axis, seen in pairs
    )


def _uncertain(one: Quantity, others: list[Record]) -> Uncertain:
    finite = one.values[np.isfinite(one.values)]
    size = float(np.abs(finite).max(initial=0.0))
    error = max(_apart(one, other[one.path].values) for other in others)
    # what is moved is rounded as well
    return Uncertain(one.path, error, one.error_estimate, size, UNIT * size)


def _apart(one: Quantity, other: np.ndarray) -> float:
    """Largest difference of entries; phases that are whole turns apart are one."""
    seen = other[tuple(slice(n) for n in one.values.shape)]  # without what has been added
    assert seen.shape == one.values.shape, one.path
    there = np.isfinite(one.values) & np.isfinite(seen)
    away = np.where(there, one.values, 0.0) - np.where(there, seen, 0.0)
    if "phase" in one.path:
        # zero stands for the phase of nothing
        away = np.where((one.values != 0.0) & (seen != 0.0), np.angle(np.exp(1j * away)), 0.0)
    return float(np.abs(away).max(initial=0.0))


@pytest.mark.parametrize("name", long_but(KINDS, "mounted"))
def test_estimates_of_a_few_machines(name: str) -> None:
    kind = KINDS[name]
    found = [judged(kind, kind.make(seed)) for seed in kind.few]
    every = [one for each in found for one in each.judged]
    assert len(every) > kind.least
    hold(every, name, kind.most_high)
    assert [one for each in found for one in broken_promises(each)] == []


@pytest.mark.long
@pytest.mark.timeout(9000)
@pytest.mark.parametrize("name", KINDS)
def test_estimates_of_hundreds_of_machines(name: str) -> None:
    kind = KINDS[name]
    tables = (copy.deepcopy(kind.make(seed)) for seed in range(100, 400))
    found = list(reported_or_refused(tables, lambda table: judged(kind, table)))
    kept = [one for one in found if isinstance(one, Reported)]
    assert len(kept) > 280
    every = [one for each in kept for one in each.judged]
    hold(every, f"{len(kept)} of {name}", kind.most_high)
    broken = [one for each in kept for one in broken_promises(each)]
    assert len(broken) <= kind.broken * len(every), broken
