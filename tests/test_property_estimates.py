"""Claim: error estimates are honest, from cards and valves to the loads on the mounts.

Seeded random machines run from their case tables. The truth of each is the same machine, twice,
with all its inputs moved within half of their last digit and finer numerics: other roundings
everywhere, as far as the inputs carry them, and less left out. At most 1 % of the estimates are
below a tenth of what results move by, at most 5 % above a thousand times of it, and what misses
`[accuracy] rtol` is said to. That results are right is held elsewhere, by formulas of their own
(`test_consistency_*.py`), levels on plates in 40 digits (`test_consistency_measurement_stage.py`).
An undershot `[excitation] orders` is in the estimates.
"""

import copy
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from long_but import long_but
from random_absorbers import random_absorber
from random_lines import (
    CHANGES,
    random_change,
    random_damper_case,
    random_line,
    random_variable_line,
)
from random_machines import Table, random_machine, without_damping
from random_mounted import random_mounted
from random_pumps import random_pump
from random_rolls import random_roll
from response_machines import random_compressor

from vibecalc.core.case.load import resolve, validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.results.tolerance import reached
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.transient import march as transient_pieces

sys.path.insert(0, str(Path(__file__).parent / "matrix"))
from conditioning import moved

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05
UNIT = 2.0**-52


class Uncertain(NamedTuple):
    """A quantity with its true error, its estimate and its size; the truth is off by `noise`."""

    path: str
    error: float
    estimate: float
    size: float
    noise: float = 0.0

    @property
    def too_low(self) -> bool:
        """The estimate is surely below a tenth of the true error."""
        return self.estimate < 0.1 * (self.error - self.noise)

    @property
    def too_high(self) -> bool:
        """Surely a thousand times above it; errors below .001 ulp are hits by luck."""
        largest = self.error + self.noise
        return largest > 1e-3 * UNIT * self.size and self.estimate > 1e3 * largest


class Reported(NamedTuple):
    """One machine: its case, its record, and each quantity that has a truth."""

    table: Table
    record: Record
    judged: list[Uncertain]


def reported_or_refused(
    tables: Iterable[Table], judge: Callable[[Table], Reported]
) -> Iterator[Reported | NumericalFailure]:
    """Each machine judged; one that is refused (exit 3) has nothing to be wrong."""
    for table in tables:
        try:
            yield judge(table)
        except NumericalFailure as failure:
            yield failure


def hold(judged: list[Uncertain], words: str = "", most_high: float = MOST_TOO_HIGH) -> None:
    """At most 1 % of the estimates are too low, at most 5 %, or as given, too high."""
    low, high = [one for one in judged if one.too_low], [one for one in judged if one.too_high]
    print(f"{words}: {len(judged)} estimates, {len(low)} too low, {len(high)} too high")
    print("  too low:", Counter(one.path for one in low).most_common(8))
    print("  too high:", Counter(one.path for one in high).most_common(8))
    assert len(low) <= MOST_TOO_LOW * len(judged), low[:20]
    assert len(high) <= most_high * len(judged), high[:20]
    assert [one for one in judged if one.error - one.noise > one.estimate == 0.0] == []


def broken_promises(reported: Reported) -> list[Uncertain]:
    """Quantities beyond `[accuracy] rtol` by their true error, of which the run says nothing."""
    rtol = float(reported.table["accuracy"]["rtol"])
    shares = {
        path: reached(quantity, reported.record) for path, quantity in reported.record.items()
    }
    missed = {path for path, share in shares.items() if share is not None and share > rtol}
    said = any("accuracy not reached" in words for words in reported.record.warnings)
    assert said == bool(missed)
    broken = []
    for one in reported.judged:
        share = shares[one.path]
        if share is None or one.path in missed:
            continue
        # a part of a balance is measured by the whole of it
        size = one.estimate / share if share > 0.0 else one.size
        if one.error - one.noise > rtol * size:
            broken.append(one)
    return broken


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
    """Of a machine on its mounts: sixteen times as many, or all that a case may have."""
    orders = len(run_case(validate(table))["excitation/force"].axes[0].values)
    return table | {"excitation": {**table.get("excitation", {}), "orders": min(16 * orders, 400)}}


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


def on_springs(seed: int) -> Table:
    """Pitch or rigid body; every third with its run-up, of every other one in five no damping."""
    table = random_machine(seed, "pitch" if seed % 2 else "rigid_body")
    if seed % 3:
        del table["isolation"]["run_up"]
        return table if seed % 5 else without_damping(table)
    return table


def cut_machine(seed: int) -> Table:
    """With R/L = .4, of which only a few orders are kept."""
    table = random_machine(seed, "rigid_body" if seed % 2 else "pitch")
    train = table["machine"]["crank_train"]
    train["rod_length"] = train["crank_radius"] / 0.4
    table.pop("kinematics", None)
    table["excitation"]["orders"] = seed
    return table


def compressor(seed: int) -> Table:
    """Of its operations two, that their first orders may cancel at some phases."""
    table = random_compressor(seed)
    table["accuracy"]["rtol"] = max(table["accuracy"]["rtol"], 1e-9)
    del table["response"]["operations"][2:]
    return table


def change(seed: int) -> Table:
    return random_change(seed, (*CHANGES, "start"), 10.0)


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
    # a rod, counterweights, balance shafts, every sort of driven machine; two without damping
    "generator": Kind(on_springs, more_orders, (1, 4, 5, 10, 22), 150),
    # by seed gears, a coupling, a propeller, elastic teeth, a loop, rings, misfires
    "engine": Kind(random_line, as_it_is, (2, 11), 200),
    # with whole steps and with quarters the same remains, far below what half steps tell
    "transient": Kind(change, shorter_steps, (4, 102), 100, most_high=0.3),
    "variable": Kind(random_variable_line, more_of_a_cycle, (7,), 10),
    "damper": Kind(random_damper_case, as_it_is, (100,), 25),
    # pitch with an offset, planar with the driven machine on the body
    "pump": Kind(random_pump, more_orders, (103, 156), 100),
    "compressor": Kind(compressor, more_orders, (0, 3, 9), 90),
    "mounted": Kind(random_mounted, more_orders, (11,), 25),
    "absorber": Kind(random_absorber, as_it_is, (6, 7, 9, 13, 17), 90),
    "roll": Kind(random_roll, more_points, (14,), 50, broken=0.001),
}


def judged(kind: Kind, table: Table) -> Reported:
    """Every estimate of a run next to what the result moves by."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    record = run_case(case)
    draws = [np.random.default_rng(seed) for seed in range(TIMES)]
    with pytest.MonkeyPatch.context() as patch:
        finer = resolve(validate(kind.finer(copy.deepcopy(table), patch)))
        near = [validate(moved(finer, 0.5 * UNIT, draw)) for draw in draws]
        assert [check_machine(one) for one in near] == [[] for _ in near]
        others = [run_case(one) for one in near]
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


@pytest.mark.parametrize("name", long_but(KINDS, "generator", "mounted"))
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


@pytest.mark.parametrize("orders", long_but((2, 3, 4), 2, 3))
def test_peaks_count_what_a_cut_leaves_out(orders: int) -> None:
    found = judged(Kind(cut_machine, more_orders, (), 0), cut_machine(orders)).judged
    peaks = [one for one in found if "peak" in one.path or one.path.endswith("residual")]
    cut = [one for one in peaks if one.error > 1e-9 * one.size]
    assert len(cut) > 0.6 * len(peaks)
    for one in cut:
        assert 0.1 * one.error <= one.estimate <= 1e3 * one.error, one
    harmonics = [one for one in found if one.path.endswith("_harmonics")]
    assert len(harmonics) >= 6
    for one in harmonics:  # a harmonic that is kept is as exact as ever
        assert one.estimate <= 1e-9 * one.size, one


@pytest.mark.parametrize(
    ("rtol", "count"),
    [
        (1e-6, 4),
        *(pytest.param(rtol, 100, marks=pytest.mark.long) for rtol in (1e-3, 1e-6, 1e-9)),
    ],
)
def test_default_orders_meet_the_tolerance_or_the_run_says_where_not(
    rtol: float, count: int
) -> None:
    missed = total = 0
    for seed in range(40, 40 + count):
        table = random_machine(seed, "pitch" if seed % 2 else "rigid_body")
        table["accuracy"]["rtol"] = rtol
        table["excitation"].pop("orders", None)
        record = run_case(validate(table))
        warned = " ".join(record.warnings)
        for path, quantity in record.items():
            relative = reached(quantity)
            if relative is None:
                continue
            total += 1
            if relative > rtol:
                missed += 1
                assert f"(relative error above rtol = {rtol:g})" in warned, path
    assert total > count * 30
    assert missed <= 0.02 * total


def test_a_tolerance_that_is_missed_is_named_with_what_was_reached() -> None:
    table = cut_machine(2)
    record = run_case(validate(table))
    (warning,) = [text for text in record.warnings if "accuracy not reached" in text]
    name, share = warning.split("): ", 1)[1].split(" (")[:2]
    quantity = record[name]
    largest = float(np.max(np.abs(quantity.values)))
    assert float(share.split(")")[0]) == pytest.approx(quantity.error_estimate / largest, rel=0.06)
    table["excitation"]["orders"] = 60
    assert not any("accuracy not reached" in text for text in run_case(validate(table)).warnings)
