"""Claim: what is left out of a case or of a run never changes what is kept.

Left out are tables, results that nobody wants, orders beyond those that count, and references.
Kept results may differ by what both runs state as their error, and by the tolerance of the case.
"""

from typing import Any

import numpy as np
import pytest
from long_but import long_but
from needs_cases import Key, case_of, optional_keys, table_of, without

from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.schema import Case

#: one of each kind that runs in some tens of milliseconds
QUICK = ("generator", "compressor", "absorber_curves")
#: (case, table): it says how the machine is built or driven, so that what is left is another one
ANOTHER_MACHINE: dict[Key, str] = {
    ("excitation",): "what works, what is driven and how many orders count",
    ("tuning",): "the spring and the damper that the absorber gets",
    ("kinematics",): "the series that all forces come from",
    ("response", "torsion", "misfire"): "which cylinders fire",
}
LONG = (
    "generator_180", "four_cylinder", "compressor_a", "compressor_motor", "compressor_switching",
    "absorber", "absorber_rig_a", "absorber_rig_b", "absorber_two", "absorber_design_chart",
    "engine_v8", "engine_damped", "engine_geared", "engine_run_up", "engine_two_stroke",
    "engine_as_published", "engine_variable_inertia", "engine_misfire", "roll", "roll_control",
    "roll_dynamic_motor",
)  # fmt: skip


def ran(case: Case, wanted: frozenset[str] | None = None) -> Record | None:
    """The record of a run without studies; None where the machine has no trustworthy number."""
    try:
        return run_case(case, wanted=wanted)
    except NumericalFailure:
        return None


def changed(path: str, whole: Quantity, part: Quantity, rtol: float) -> str | None:
    """How one result differs by more than its errors and the tolerance; None where it does not."""
    one, other = aligned(whole, part)
    if one.dtype.kind not in "iufc":
        return None if np.array_equal(one, other) else f"{path}: other names"
    finite = np.isfinite(one) & np.isfinite(other)
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return f"{path}: finite elsewhere"
    scale = float(np.max(np.abs(one[finite]), initial=0.0))
    allowed = whole.error_estimate + part.error_estimate + rtol * scale
    apart = float(np.max(np.abs(one[finite] - other[finite]), initial=0.0))
    return None if apart <= allowed else f"{path}: {apart:.3g} apart, {allowed:.3g} allowed"


def aligned(whole: Quantity, part: Quantity) -> tuple[np.ndarray, np.ndarray]:
    """Entries of both at the orders, speeds and names that both have."""
    one, other = np.asarray(whole.values), np.asarray(part.values)
    for place, (axis, twin) in enumerate(zip(whole.axes, part.axes, strict=True)):
        first, second = list(axis.values), list(twin.values)
        common = [label for label in first if label in second]
        one = np.take(one, [first.index(label) for label in common], axis=place)
        other = np.take(other, [second.index(label) for label in common], axis=place)
    return one, other


def differing(case: Case, whole: Record, part: Record) -> list[str]:
    """What is in both records and not the same."""
    rtol = case.accuracy.rtol
    pairs = (
        (p, q, part.quantities[p]) for p, q in whole.quantities.items() if p in part.quantities
    )
    return [found for row in pairs if (found := changed(*row, rtol)) is not None]


def run_of(name: str) -> tuple[dict[str, Any], Case, Record]:
    """A shipped case without its studies: table, case, record."""
    table = table_of(name)
    for study in ("optimisation", "find"):
        table.pop(study, None)
    case = case_of(table)
    assert case is not None
    whole = ran(case)
    assert whole is not None
    return table, case, whole


def hold_tables(name: str) -> int:
    """Run a case without each of its optional tables; the number of results compared."""
    table, case, whole = run_of(name)
    compared = 0
    for key in optional_keys(name):
        if key in ANOTHER_MACHINE or key[0] in ("optimisation", "find"):
            continue
        less = case_of(without(table, key))
        part = None if less is None else ran(less)
        if part is None:
            continue
        assert set(part.quantities) <= set(whole.quantities), key
        assert differing(case, whole, part) == [], key
        compared += len(part.quantities)
    return compared


@pytest.mark.parametrize("name", long_but((*QUICK, *LONG), "generator", "compressor"))
def test_a_table_less_changes_nothing_else(name: str) -> None:
    assert hold_tables(name) > (10 if name in QUICK else -1)


def hold_wanted(name: str, draws: int) -> None:
    """A few results alone are those of the whole run, within the errors stated."""
    _, case, whole = run_of(name)
    paths = sorted(set(planned_quantities(case)) & set(whole.quantities))
    random = np.random.default_rng(0)
    for _ in range(draws):
        few = frozenset(random.choice(paths, size=3, replace=False).tolist())
        part = ran(case, few)
        assert part is not None
        assert few <= set(part.quantities) <= few | set(whole.quantities)
        for path in few:
            one, other = whole.quantities[path], part.quantities[path]
            assert changed(path, one, other, 0.0) is None
            # one batch of fewer results may take another bound on the same rounding
            assert one.error_estimate <= 2.0 * other.error_estimate <= 4.0 * one.error_estimate, (
                path
            )


@pytest.mark.parametrize("name", long_but((*QUICK, *LONG), "generator", "absorber_curves"))
def test_results_that_nobody_wants_change_nothing(name: str) -> None:
    hold_wanted(name, 3 if name in QUICK else 10)


def test_orders_beyond_those_that_count_change_nothing() -> None:
    table = table_of("compressor_a")
    records, kept = {}, {}
    for orders in (None, 24, 80):
        given = {**table["excitation"], "orders": orders}
        if orders is None:
            del given["orders"]
        case = case_of({**table, "excitation": given})
        assert case is not None
        record = ran(case)
        assert record is not None
        records[orders] = record
        kept[orders] = len(record.quantities["excitation/force"].values)
    assert kept == {None: 10, 24: 24, 80: 80}
    for path, few in records[None].quantities.items():
        if path != "kinematics/dropped_acceleration":  # what the orders leave out
            assert changed(path, few, records[80].quantities[path], 1e-9) is None
