"""What a report says of a clutch, of torques in time and of the cycles that were counted."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.report.sections import having, labels, scalar_of
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Record
from vibecalc.torsion.report.line import short, torque_unit

# ----------------------------------------------------------------------------
# What happens, in words.
# ----------------------------------------------------------------------------

_STEM = "response/torsion/transient/"
#: J -> kJ, Pa -> N/mm2
_KILO, _MEGA = 1e-3, 1e-6


def jolt_in_words(change: Mapping[str, Any]) -> str:
    """What a stop, a jolt or a clutch is, in a sentence without its end; "" for other changes."""
    kind, on = change.get("kind"), change.get("on")
    if kind == "stop":
        start = short(rpm(float(change.get("from") or 0.0)))
        return f"Stop without fuel from {start} rpm"
    if kind == "short_circuit":
        parts = [
            f"{short(float(one['amplitude']))} N m at "
            f"{short(float(one.get('frequency') or 0.0) / (2.0 * np.pi))} Hz"
            for one in change.get("terms") or ()
        ]
        return f"Short circuit at {on}, an air-gap torque that decays from {' and '.join(parts)}"
    if kind == "torque_history":
        table_ = change.get("history") or {}
        time, torque = ([float(one) for one in table_.get(key, ())] for key in ("time", "torque"))
        if not time:
            return f"Torque in time at {on}"
        return (
            f"Torque in time at {on} for {short(time[-1])} s, from {short(min(torque))} to "
            f"{short(max(torque))} N m"
        )
    if kind == "clutch_in":
        words = (
            f"Clutch {change.get('clutch')} takes along what turns at "
            f"{short(rpm(float(change.get('driven_speed') or 0.0)))} rpm, with "
            f"{short(float(change.get('friction_torque') or 0.0))} N m"
        )
        grows = change.get("engaging_time")
        return words + (f" reached in {short(float(grows))} s" if grows else "")
    return ""


# ----------------------------------------------------------------------------
# What the clutch does.
# ----------------------------------------------------------------------------


def clutch_in_words(record: Record) -> str:
    """Slip, heat, common speed and what is left of its friction torque; "" without a clutch."""
    slip, heat = (scalar_of(record, f"{_STEM}clutch/{name}") for name in ("slip_time", "heat"))
    if slip is None or heat is None:
        return ""
    words = f"The clutch slips for {show(slip, digits=4)} s"
    held = scalar_of(record, f"{_STEM}clutch/held")
    common = scalar_of(record, f"{_STEM}clutch/common_speed")
    words += f" and turns {show(_KILO * heat, digits=4)} kJ into heat"
    if held is None or common is None:
        return words + "; it does not hold within the time watched."
    words += (
        f". It holds {show(held, digits=4)} s after it is engaged, at "
        f"{show(rpm(common), digits=4)} rpm of the crankshaft"
    )
    times = scalar_of(record, f"{_STEM}clutch/engagements") or 1.0
    use = scalar_of(record, f"{_STEM}clutch/use")
    if times > 1.0:
        return words + f"; the vibration makes it slip again {int(times) - 1} times."
    if use is not None:
        words += f"; from then on it carries up to {show(100.0 * use, digits=3)} % of its torque"
    return words + "."


# ----------------------------------------------------------------------------
# Cycles that were counted.
# ----------------------------------------------------------------------------


def counted_table(record: Record) -> list[str]:
    """A row for each section whose cycles were counted; [] where none were."""
    largest = having(record, _STEM + "counted/largest_range", "section")
    equal = having(record, _STEM + "counted/equivalent_number", "section")
    cycles = having(record, _STEM + "counted/number", "section", "range_bin")
    if largest is None or equal is None or cycles is None:
        return []
    factor, unit = torque_unit(record)
    names = labels(largest.axes[0])
    columns = [Column("section"), number("cycles"), number(f"largest range\n{unit}"),
               number("equivalent\nnumber")]  # fmt: skip
    more = []
    for path, words, by in (
        ("largest_stress_range", "stress range\nN/mm2", _MEGA),
        ("damage", "Miner,\none change", 1.0),
        ("damage_of_all", "Miner,\nall changes", 1.0),
    ):
        found = having(record, f"{_STEM}counted/{path}", "section")
        if found is not None:
            columns.append(number(words))
            values = dict(zip(labels(found.axes[0]), by * found.values, strict=True))
            more.append(values)
    rows = [
        [name, show(float(cycles.values[place].sum()), digits=4),
         show(factor * float(largest.values[place]), digits=4),
         show(float(equal.values[place]), digits=4),
         *(show(float(one[name]), digits=4) if name in one else "-" for one in more)]
        for place, name in enumerate(names)
    ]  # fmt: skip
    words = (
        "Cycles by rainflow, range: crest less trough; equivalent number: of cycles of the largest "
        "range. Means do not count in the sum of Miner; the file has ranges and means in bins."
    )
    return ["", *table(columns, rows), *paragraph(words)]
