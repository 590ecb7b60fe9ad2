"""Limits of gears: the torque of the teeth keeps its sign, also in transients and conditions."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibecalc.core.report.sections import having, labels, speed_of
from vibecalc.core.report.writing import read
from vibecalc.core.results.record import (
    BROKEN,
    KEPT,
    UNDECIDED,
    Estimate,
    Quantity,
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.select import numbers
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import state_of
from vibecalc.numerics.rounding import firsts_of_largest
from vibecalc.torsion.report.line import TORSION, speed_range, torque_unit, vector

AT_SPEED = "operating speed"


def covered(result: Result, state: str | None) -> bool:
    """Whether the operating speed lies in a range of speeds over which a limit is kept."""
    low, high = speed_range(result)
    speed = speed_of(result)
    return state == KEPT and speed is not None and low <= speed <= high


def of_gears(result: Result) -> Iterator[Verdict]:
    """No reversal of the torque of teeth: over the speeds, and at the operating one."""
    record = result.record
    loud = having(record, f"{TORSION}speeds/gear_hammers", "gear", "speed")
    here = having(record, f"{TORSION}gear/hammers", "gear")
    known = loud or here
    for place, name in enumerate(labels(known.axes[0]) if known else []):
        state = None
        for quantity, path, words in (
            (loud, "largest/gear_minimum_torque", "any speed"),
            (here, "gear/minimum_torque", AT_SPEED),
        ):
            if quantity is None or (quantity is here and covered(result, state)):
                continue
            low, off, speed = _least(record, path, place)
            speed = speed_of(result) if quantity is here else speed
            parts = np.any(quantity.values[place]) or (quantity is loud and low < -off)
            state = BROKEN if parts else KEPT
            at = np.nan if speed is None else speed
            yield _row(result, quantity, {"gear": name}, (low, off), state, words, speed=at)


#: the least torque of each gear in a transient, and in each condition of the cylinders
TRANSIENT_LEAST = f"{TORSION}transient/gear_minimum_torque"
CONDITION_LEAST = f"{TORSION}conditions/gear_minimum_torque"


def in_transient(result: Result) -> Iterator[Verdict]:
    """No reversal of the torque of teeth in a transient; undecided where its error leaves it."""
    if (found := having(result.record, TRANSIENT_LEAST, "gear")) is not None:
        for name in labels(found.axes[0]):
            yield _reversal(result, found, {"gear": name}, "", "transient")


def in_conditions(result: Result) -> Iterator[Verdict]:
    """No reversal of the torque of teeth in the condition where it is least, if not all fire."""
    found = having(result.record, CONDITION_LEAST, "condition", "gear")
    if found is None:
        return
    named, worst = labels(found.axes[0]), firsts_of_largest(-found.values, axis=0)
    for name, place in zip(labels(found.axes[1]), worst, strict=True):
        if place > 0:
            where = {"condition": named[place], "gear": name}
            words = f"{named[place]} (worst of {len(named)} conditions)"
            yield _reversal(result, found, where, AT_SPEED, words)


def _reversal(
    result: Result, found: Quantity, where: dict[str, str], words: str, condition: str
) -> Verdict:
    """The row of a least torque; undecided where its error leaves the sign."""
    entry = numbers(found, where)
    low, off = (float(np.ravel(one)[0]) for one in (entry.values, entry.errors))
    state = state_of(low, off, 0.0)
    decided_by = remedy(found, result.case) if state == UNDECIDED else ""
    more = {"condition": condition, "decided_by": decided_by}
    return _row(result, found, where, (low, off), state, words, **more)


def _row(
    result: Result, found: Quantity, where: dict[str, str], least: tuple[float, float],
    state: str, words: str, **more: Any,
) -> Verdict:  # fmt: skip
    """The row of the teeth of one gear: least torque and its error, not a number if not known."""
    factor, unit = torque_unit(result.record)
    low, off = factor * least[0], factor * least[1]
    return Verdict(
        found.path, where, "sign of the tooth torque", 0.0, None,
        read(unit) if np.isfinite(low) else "", low,
        ", ".join(f"{axis}={one}" for axis, one in where.items()), Estimate(off, 0.0), low, state,
        element=where["gear"], limit=", ".join(filter(None, ("no torque reversal", words))),
        status="informative", **more,
    )  # fmt: skip


def _least(record: Record, path: str, gear: int) -> tuple[float, float, float | None]:
    """The least torque of a gear with its error, and its speed over a range; NaN if not known."""
    found = having(record, TORSION + path, "gear")
    if found is not None:
        at = vector(record, f"{path}_speed", "gear")
        speed = None if at is None else float(at[gear])
        return float(found.values[gear]), found.error_estimate, speed
    curve = having(record, f"{TORSION}speeds/gear_minimum_torque", "gear", "speed")
    if curve is None or not path.startswith("largest"):
        return np.nan, 0.0, None
    k = int(np.argmin(curve.values[gear]))
    return float(curve.values[gear, k]), curve.error_estimate, float(curve.axes[1].values[k])
