"""A motor with transients: what was fitted to its table, and what they change in the levels."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import Section, having, labels, scalar_of, section
from vibecalc.core.report.writing import (
    Column,
    decibels,
    hertz,
    number,
    paragraph,
    rpm,
    show,
    table,
)
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.roll.report.advice import ROLL, level, of_shell, one_row, shell_acts

_MOTOR = ROLL + "motor/"
_FITTED = (
    ("stator_leakage", "leakage of the stator"),
    ("magnetising_inductance", "magnetising inductance"),
    ("rotor_resistance", "resistance of cage"),
    ("rotor_leakage", "leakage of cage"),
)
_POINTS = (
    ("breakdown_torque", "breakdown torque"),
    ("breakdown_slip", "slip at breakdown"),
    ("locked_rotor_torque", "torque at standstill"),
    ("gain", "slope at synchronous speed"),
    ("static_answer", "quasi-static response at the mean slip"),
    ("stator_time", "time constant of the stator"),
)
_ENERGIES = (
    ("electrical", "from the line"),
    ("stator_copper", "heat, stator"),
    ("rotor_copper", "heat, rotor"),
    ("mechanical", "on the shaft"),
    ("residual", "error"),
)


def roll_motor(result: Result) -> Section | None:
    """The section, None for a motor without transients."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_MOTOR))
    blocks = [_changes(record), _parameters(record), _points(record)]
    details = {
        "torque and slip of the motor by row": _rows(record),
        "transients of the motor": _transients(record),
        "energies of the motor": one_row(
            record, _MOTOR + "energy/", _ENERGIES, "energy of a turn", "J"
        ),
    }
    return section("Motor with transients", blocks, details, shown)


def _phase(record: Record) -> Quantity | None:
    answer = having(record, _MOTOR + "torque_answer", "order")
    return answer and replace(answer, values=np.degrees(np.angle(answer.values)))


def _size(value: Any, error: float) -> str:
    return show(abs(value), float(error), 4)


#: levels from the table to the circuit to its transients, and the torque's answer
_CHANGES = Rows(
    "order", "order",
    (
        *(
            Cells(of_shell(path), f"{words}\ndB", level, right=True)
            for path, words in (
                (_MOTOR + "table_level", "slip table"),
                (_MOTOR + "fit_change", "change by fit"),
                (_MOTOR + "static_level", "steady curve"),
                (_MOTOR + "dynamics_change", "by transients"),
                (ROLL + "level/shell_acceleration", "with transients"),
            )
        ),
        Cells(_MOTOR + "torque_answer", "response\nN*m*s/rad", _size, right=True),
        Cells(_phase, "phase\ndeg", lambda value, _: f"{value:.1f}", right=True),
    ),
    right=True,
    above="levels of the shell acceleration and their changes by the fitted curve instead of the "
    "table and by the transients",
)  # fmt: skip


def _changes(record: Record) -> list[str]:
    static = having(record, _MOTOR + "static_level", "order")
    if static is None or having(record, ROLL + "level/shell_acceleration", "order") is None:
        return []
    acts = shell_acts(record, np.asarray(static.axes[0].values))
    return rows_of(record, _CHANGES)[0] + paragraph(_summary(record, acts))


def _summary(record: Record, acts: np.ndarray) -> str:
    change = having(record, _MOTOR + "dynamics_change", "order")
    words = "response: torque per harmonic of the crank speed about the mean slip; quasi-static: "
    still = scalar_of(record, _MOTOR + "static_answer")
    words += "minus the slope of the steady curve"
    if still is not None:
        words += f", {show(abs(still), digits=4)} N*m*s/rad at 180 deg"
    if change is not None and acts.any():
        sizes = np.where(acts & np.isfinite(change.values), np.abs(change.values), 0.0)
        top = int(np.argmax(sizes))
        order = int(change.axes[0].values[top])
        words += f"; transients change order {order} most, by {decibels(change.values[top])} dB"
    speeds = [scalar_of(record, _MOTOR + f"{name}_speed") for name in ("table", "static")]
    mean = scalar_of(record, ROLL + "speed")
    named = [
        f"{show(rpm(one), digits=6)} rpm {how}"
        for one, how in zip(
            (*speeds, mean), ("with the table", "with the steady curve", "with transients"),
            strict=True,
        )
        if one is not None
    ]  # fmt: skip
    return words + "; mean speed " + ", ".join(named)


def _parameters(record: Record) -> list[str]:
    spreads = []
    for name in ("parameter_spread", "parameter_free_spread"):
        found = having(record, _MOTOR + name, "motor_parameter")
        spreads.append({} if found is None else dict(zip(labels(found.axes[0]), found.values,
                                                         strict=True)))  # fmt: skip
    rows = []
    for name, words in _FITTED:
        quantity = record.quantities.get(_MOTOR + name)
        if quantity is None:
            continue
        cages = labels(quantity.axes[0]) if quantity.axes else [""]
        for cage, value in zip(cages, np.atleast_1d(quantity.values), strict=True):
            key = f"{name} {cage}" if len(cages) > 1 else name
            shown = show(float(value), quantity.error_estimate)
            known = [_percent(one.get(key)) for one in spreads]
            rows.append([f"{words} {cage}".rstrip(), shown, quantity.unit, *known])
    columns = (Column("fitted parameter"), number("value"), Column("unit"),
               number("error for 1 %\nin the table %"), number("nothing assumed\n%"))  # fmt: skip
    return table(columns, rows)


def _percent(spread: float | None) -> str:
    """A standard error of a logarithm in percent."""
    if spread is None:
        return ""
    return show(100.0 * spread, digits=3) if np.isfinite(spread) else "not identifiable"


def _slips(record: Record) -> Quantity | None:
    torque = having(record, _MOTOR + "table/torque", "slip")
    return torque and replace(torque, values=rpm(1.0) * torque.axes[0].values)


def _digits(count: int) -> Callable[[Any, float], str]:
    return lambda value, error: show(value, float(error), count)


_ROWS = Rows(
    "slip", "",
    (
        Cells(_slips, "slip\nrpm", lambda value, _: show(value, digits=5), right=True),
        Cells("torque", "table\nN*m", lambda value, _: show(value, digits=5), right=True),
        Cells("fitted", "fitted\nN*m", _digits(5), right=True),
        Cells("difference", "difference\nN*m", _digits(4), right=True),
        Cells("relative_difference", "%", lambda value, _: f"{100.0 * value:+.2f}", right=True),
        Cells("used", "", lambda value, _: "" if value else "not fitted"),
    ),
    "response/roll/motor/table",
)  # fmt: skip


def _rows(record: Record) -> list[str]:
    lines, _ = rows_of(record, _ROWS)
    worst, rms = (scalar_of(record, f"{_MOTOR}{name}_difference") for name in ("worst", "rms"))
    if not lines or worst is None or rms is None:
        return lines
    words = f"fitted rows: error up to {100.0 * worst:.3g} %, r.m.s. {100.0 * rms:.3g} %"
    return lines + paragraph(words)


def _points(record: Record) -> list[str]:
    rows = []
    for name, words in _POINTS:
        quantity = having(record, _MOTOR + name)
        if quantity is None:
            continue
        value = float(quantity.values)
        nearby = f"{show(rpm(value), digits=5)} rpm" if name == "breakdown_slip" else ""
        rows.append([words, show(value, quantity.error_estimate), quantity.unit, nearby])
    for name, words in (
        ("rotor_open_time", "stator open"),
        ("rotor_short_time", "stator short"),
    ):
        times = having(record, _MOTOR + name, "cage")
        if times is not None:
            each = ", ".join(show(one, times.error_estimate, 4) for one in times.values)
            rows.append([f"time constants of the rotor, {words}", each, times.unit, ""])
    columns = (Column("fitted motor"), number("value"), Column("unit"),
               Column("also"))  # fmt: skip
    return table(columns, rows) if rows else []


def _transients(record: Record) -> list[str]:
    decay = having(record, _MOTOR + "transient_decay_time", "transient")
    beat = having(record, _MOTOR + "transient_frequency", "transient")
    speed = scalar_of(record, ROLL + "speed")
    if decay is None or beat is None or not speed:
        return []
    rows = [
        [
            name,
            show(fade, decay.error_estimate, 4),
            show(hertz(float(rate)), hertz(beat.error_estimate), 4),
            show(float(rate) / speed, beat.error_estimate / speed, 4),
        ]
        for name, fade, rate in zip(labels(decay.axes[0]), decay.values, beat.values, strict=True)
    ]
    columns = (number("transient"), number("decay time\ns"), number("frequency\nHz"),
               number("in orders"))  # fmt: skip
    return table(columns, rows)
