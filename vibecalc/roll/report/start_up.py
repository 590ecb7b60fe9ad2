"""A start-up: does the machine come to speed, how hard is it on the way, and from which angles?"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import Section, having, read_as, scalar_of, section, table_of
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.roll.report.advice import one_row
from vibecalc.units import convert

_STEM = "response/start_up/"
_PEAKS = (
    ("shell_angle", "roll of the shell"),
    ("shell_acceleration", "roll acceleration of the shell"),
    ("rotor_acceleration", "acceleration of the rotor"),
    ("crank_speed", "speed of the crank"),
    ("motor_torque", "motor torque"),
    ("mount_torque", "mount torque"),
)
_WORK = (
    ("motor", "by motor"),
    ("gas", "to gas"),
    ("friction", "to friction"),
    ("mounts", "to mounts"),
    ("stored", "stored"),
    ("residual", "error"),
)
_DIGITS = 4


def start_up(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_STEM))
    energies = one_row(record, _STEM + "energy/", _WORK, "balance", "energy J")
    blocks = [_verdict(result), _steady(record), _peaks(record), _load(record), _angles(result)]
    return section("Start-up", blocks, {"energy balance of the start": energies}, shown)


def _verdict(result: Result) -> list[str]:
    record = result.record
    started = scalar_of(record, _STEM + "started")
    if started is None:
        return []
    options = table_of(result.case, "response", "start_up")
    speed = scalar_of(record, _STEM + "running_speed")
    turns = "" if not speed else f"{show(rpm(speed), digits=_DIGITS)} rpm in the last turn"
    if not started:
        duration = options.get("duration")
        within = f" within {duration:g} s" if isinstance(duration, int | float) else ""
        remark = f"; it makes {turns}" if turns else "; it does not turn over"
        return paragraph(f"IT DOES NOT START{within}{remark}. See the warnings.")
    to_speed, words = scalar_of(record, _STEM + "time_to_speed"), "runs"
    if to_speed == 0.0:
        words = "started at speed"
    elif to_speed is not None and math.isfinite(to_speed):
        words = f"reaches speed after {show(to_speed, digits=4)} s"
    words += f"; {turns}" if turns else ""
    return paragraph(words + "; " + _settling(record, options.get("settling_tolerance", 0.01)))


def _settling(record: Record, share: object) -> str:
    steady = scalar_of(record, _STEM + "time_to_steady")
    within = f" to {100.0 * share:g} %" if isinstance(share, int | float) else ""
    if steady is None or not math.isfinite(steady):
        return f"NOT settled{within} at the end"
    words = f"settled{within} after {show(steady, digits=4)} s"
    turns = scalar_of(record, _STEM + "turns_to_steady")
    if turns is not None and math.isfinite(turns):
        words += f", {turns:.0f} turns after the start or the last change of load"
    return words


def _steady(record: Record) -> list[str]:
    """The last turn next to the periodic motion, where the result has both."""
    last = having(record, _STEM + "turn/shell_acceleration", "turn")
    speeds = having(record, _STEM + "turn/speed", "turn")
    cycle = having(record, "response/roll/cycle/shell_acceleration", "crank_angle")
    mean = scalar_of(record, "response/roll/speed")
    started = scalar_of(record, _STEM + "started")
    if last is None or speeds is None or cycle is None or mean is None or not started:
        return []
    half = 0.5 * float(np.ptp(cycle.values))
    rows = [
        ["mean speed", "rpm", show(rpm(float(speeds.values[-1]))), show(rpm(mean))],
        ["half range of the shell acceleration", last.unit, show(last.values[-1], digits=_DIGITS),
         show(half, digits=_DIGITS)],
    ]  # fmt: skip
    columns = (Column("final state"), Column("unit"), number("last turn"),
               number("periodic motion"))  # fmt: skip
    return table(columns, rows)


def _peaks(record: Record) -> list[str]:
    rows = []
    for name, words in _PEAKS:
        quantity = record.quantities.get(f"{_STEM}{name}_peak")
        when = scalar_of(record, f"{_STEM}{name}_peak_time")
        if quantity is None or quantity.axes or not abs(quantity.values) > quantity.error_estimate:
            continue
        value = float(quantity.values)
        unit = read_as(quantity.path, quantity.unit)[1] if name != "crank_speed" else "rpm"
        factor = convert(1.0, quantity.unit, unit)
        after = "" if when is None else show(when, digits=4)
        rows.append([words, show(value * factor, quantity.error_estimate * factor), unit, after])
    columns = (Column("peak during start"), number("value"), Column("unit"), number("at s"))
    return table(columns, rows) if rows else []


def _load(record: Record) -> list[str]:
    factor = having(record, _STEM + "load/factor", "load_step")
    speed = having(record, _STEM + "load/speed", "load_step")
    if factor is None or speed is None:
        return []
    return rows_of(record, _LOAD)[0]


def _begins(record: Record) -> Quantity:
    factor = record[_STEM + "load/factor"]
    return replace(factor, values=factor.axes[0].values)


def _short(value: Any, _error: float) -> str:
    return f"{value:g}"


_LOAD = Rows(
    "load_step", "",
    (
        Cells(_begins, "from\ns", _short, right=True),
        Cells("factor", "load\nfactor", _short, right=True),
        Cells("speed", "speed\nrpm", lambda v, _: show(rpm(v)) if v else "-", right=True),
        Cells("shell_angle_peak", "shell angle\nmrad",
              lambda v, error: show(1e3 * v, 1e3 * float(error), _DIGITS), right=True),
        *(
            Cells(f"{name}_peak", head, lambda v, error: show(v, float(error), _DIGITS), right=True)
            for name, head in (
                ("shell_acceleration", "shell\nrad/s^2"),
                ("motor_torque", "motor\nN*m"),
                ("mount_torque", "mounts\nN*m"),
            )
        ),
    ),
    "response/start_up/load",
    note="speed: mean of the last whole turn under that load; other columns: peaks",
)  # fmt: skip


def _angles(result: Result) -> list[str]:
    record = result.record
    fraction = scalar_of(record, _STEM + "start_angles/fraction")
    lower = record.quantities.get(_STEM + "start_angles/lower")
    upper = record.quantities.get(_STEM + "start_angles/upper")
    if fraction is None or lower is None or upper is None:
        return []
    options = table_of(result.case, "response", "start_up")
    within = options.get("start_within", options.get("duration"))
    time = f" within {within:g} s" if isinstance(within, int | float) else ""
    words = f"starts from rest under full load{time} "
    if fraction >= 1.0:
        return paragraph(words + "from every crank angle")
    if fraction <= 0.0:
        return paragraph(words + "from none of the crank angles examined")
    words += f"from {show(100.0 * fraction, digits=4)} % of all crank angles"
    rows = [
        [f"{math.degrees(low):.3f}", f"{math.degrees(high):.3f}", f"{math.degrees(high - low):.3f}"]
        for low, high in zip(lower.values, upper.values, strict=True)
    ]
    columns = (number("starts from deg"), number("to deg"), number("width deg"))
    return [*paragraph(words), *table(columns, rows)]
