"""Control of the motor, continued: gains found, gains compared, other motors."""

import math

import numpy as np

from vibecalc.report.levels import decibels
from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.roll_control_words import (
    CONTROL,
    SHORT,
    feedback_words,
    in_decibels,
    in_phase,
    in_time,
    margin_words,
    status_words,
)
from vibecalc.report.tables import Column, number, pairs, paragraph, table
from vibecalc.results.record import Record, Result

#: orders that have a column in tables over gains
_ORDERS = 4
#: rows of a grid that are printed
_MOST_ROWS = 120


def tuned(result: Result) -> list[str]:
    """Gains that the search found, what holds them there, and what they bring."""
    record = result.record
    gain, feedback, speed = (
        record.quantities.get(f"{CONTROL}tuned/{name}")
        for name in ("gain", "acceleration_feedback", "speed_feedback")
    )
    if gain is None or feedback is None or speed is None:
        return []
    words = feedback_words(float(gain.values), float(speed.values), float(feedback.values))
    rows = [
        ("found", words),
        ("stability", status_words(record, "tuned/")),
        *margin_words(record, "tuned/"),
    ]
    taken = having(record, f"{CONTROL}tuned/attenuation", "order")
    if taken is not None:
        orders = taken.axes[0].values[:_ORDERS]
        each = [
            f"order {int(order)}: {value:.2f} dB"
            for order, value in zip(orders, taken.values, strict=False)
        ]
        rows.append(("takes off", ", ".join(each)))
    rows.append(("held by", _held(record)))
    return ["  gains found under the margins asked for (reduced model)", *pairs(rows, 16)]


def _held(record: Record) -> str:
    active = having(record, f"{CONTROL}tuned/active", "bound")
    worth = having(record, f"{CONTROL}tuned/multiplier", "bound")
    if active is None or worth is None:
        return "not known"
    texts = []
    for name, holds, value in zip(active.axes[0].values, active.values, worth.values, strict=True):
        if holds:
            gained = f"{0.01 * float(value):.3f} dB for one percent less of it"
            texts.append(f"{name} ({gained})" if value > 0.0 else str(name))
    return ", ".join(texts) or "nothing: a minimum inside all bounds"


def grid(record: Record) -> list[str]:
    """One row for each pair of gain and feedback; a loop without bound has no level."""
    level = having(record, f"{CONTROL}grid/level", "gain", "feedback", "order")
    names = ("status", "gain_margin", "phase_margin", "delay_margin", "torque_peak")
    parts = [
        np.asarray(part.values)
        for name in names
        if (part := having(record, f"{CONTROL}grid/{name}", "gain", "feedback")) is not None
    ]
    if level is None or len(parts) < len(names):
        return []
    status, growth, phase, delay, torque = parts
    gains, feedbacks, orders = (axis.values for axis in level.axes)
    count = min(len(orders), _ORDERS - 1)
    columns = (
        number("gain", 7), number("feedback\ns", 9), Column("stability", 9),
        *(number(f"order {int(order)}\ndB", 8) for order in orders[:count]),
        number("torque\nN*m", 8), number("gain\nmargin", 9), number("phase\nmargin", 9),
        number("delay\nmargin", 10),
    )  # fmt: skip
    breakdown, notes = scalar_of(record, f"{CONTROL}breakdown_torque"), []
    most = math.inf if breakdown is None else breakdown
    rows = [
        [
            show(gain, digits=4), show(feedback, digits=4), SHORT[int(status[i, j])],
            *(_level(float(level.values[i, j, k])) for k in range(count)),
            _torque(float(torque[i, j]), most),
            in_decibels(float(growth[i, j])),
            in_phase(float(phase[i, j])),
            in_time(float(delay[i, j])),
        ]
        for i, gain in enumerate(gains) for j, feedback in enumerate(feedbacks)
    ]  # fmt: skip
    if any("*" in row[3 + count] for row in rows):
        notes.append(f"* more than the {show(most, digits=4)} N*m that the motor has")
    left = len(rows) - _MOST_ROWS
    lines = ["  gains compared, each keeping the speed (reduced model)"]
    lines += table(columns, rows[:_MOST_ROWS])
    if left > 0:
        lines += paragraph(f"and {left} pairs more, in the file")
    if np.any(status == 1):
        notes.append('"no delay": stable only without any delay, so that levels hold on paper only')
    return lines + [line for note in notes for line in paragraph(note)]


def _level(value: float) -> str:
    return "-" if math.isinf(value) and value > 0.0 else decibels(value)


def _torque(value: float, most: float) -> str:
    if math.isinf(value):
        return "-"
    return f"{value:.0f}{' *' if value > most else '  '}"


def motor_gains(record: Record) -> list[str]:
    """Speed and levels with other motors, uncontrolled."""
    level = having(record, f"{CONTROL}motor_gains/level", "motor_gain", "order")
    speed = having(record, f"{CONTROL}motor_gains/speed", "motor_gain")
    if level is None or speed is None:
        return []
    orders = level.axes[1].values[:_ORDERS]
    columns = (
        number("torque per slip\nN*m*s/rad", 16), number("speed\nrpm", 10),
        *(number(f"order {int(order)}\ndB", 10) for order in orders),
    )  # fmt: skip
    rows = [
        [
            show(gain, digits=5), show(rpm(float(turning)), digits=5),
            *(decibels(float(value)) for value in row[: len(orders)]),
        ]
        for gain, turning, row in zip(level.axes[0].values, speed.values, level.values, strict=True)
    ]  # fmt: skip
    return ["  other motors without control (reduced model)", *table(columns, rows)]
