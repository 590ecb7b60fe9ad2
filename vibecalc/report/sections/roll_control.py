"""Control of the motor: the loop and its margins, levels with it and without, and what to doubt."""

import math

import numpy as np

from vibecalc.report.levels import decibels
from vibecalc.report.lookup import having, scalar_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.roll_control_studies import grid, motor_gains, tuned
from vibecalc.report.sections.roll_control_words import (
    CONTROL,
    feedback_words,
    in_time,
    margin_words,
    status_words,
)
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, pairs, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_MODEL = (
    ("motor_gain", "torque of the motor per slip"),
    ("motor_offset", "torque of its straight curve at no slip"),
    ("breakdown_torque", "its largest torque"),
    ("inertia", "inertia that it accelerates"),
    ("shell_share", "acceleration of the shell over the crank's"),
    ("mean_torque", "mean torque of gas and friction"),
    ("speed_without", "mean speed without control"),
    ("target_speed", "mean speed to be kept"),
    ("speed", "mean speed under control"),
)
_COLUMNS = (
    ("disturbance", "load\nN*m", False),
    ("level_without", "without\ndB", True),
    ("level", "control\ndB", True),
    ("attenuation", "less by\ndB", True),
    ("range/level", "full model\nwithout", True),
    ("full/level", "full model\ncontrol", True),
    ("full/attenuation", "full\nless by", True),
    ("full/difference", "full less\nreduced", True),
)
#: dB by which the reduced model may be off and still be called the same
_CLOSE = 0.5
_POLES = 6


def roll_control(result: Result) -> Section | None:
    """The section, None if the result has no control."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(CONTROL))
    lines: list[str] = []
    for block in (
        _model(record),
        _loop(result),
        _levels(record),
        _full(record),
        _range(record),
        tuned(result),
        grid(record),
        motor_gains(record),
    ):
        if block:
            lines += ["", *block] if lines else block
    return Section("Control of the motor", lines, shown) if lines else None


def _model(record: Record) -> list[str]:
    rows = []
    for name, words in _MODEL:
        value = scalar_of(record, CONTROL + name)
        if value is None:
            continue
        quantity = record[CONTROL + name]
        own = float(quantity.values)
        also = f"{show(rpm(own))} rpm" if quantity.unit == "rad/s" else ""
        rows.append([words, show(own, quantity.error_estimate), quantity.unit, also])
    columns = (Column("reduced model", 44), number("value", 13), Column("unit", 11),
               Column("also", 20))  # fmt: skip
    return table(columns, rows) if rows else []


def _loop(result: Result) -> list[str]:
    record = result.record
    words = status_words(record, "")
    if not words:
        return []
    asked = table_of(result.case, "response", "control")
    lag, delay = asked.get("actuator_lag"), asked.get("delay")
    feedback = scalar_of(record, CONTROL + "speed_feedback")
    own = 0.0 if feedback is None else float(record[CONTROL + "speed_feedback"].values)
    rows = [
        ("controller", feedback_words(asked.get("gain"), own, asked.get("acceleration_feedback"))),
        ("actuator", f"lag {in_time(lag)}, delay {in_time(delay)}"),
        ("stability", words),
        *margin_words(record, ""),
    ]
    pole = having(record, CONTROL + "pole", "pole")
    if pole is not None:
        texts = [_pole(complex(value)) for value in pole.values[:_POLES] if value.imag >= 0.0]
        rows.append(("poles", f"{', '.join(texts)} 1/s"))
    return ["  the loop (reduced model)", *pairs(rows, 16)]


def _pole(value: complex) -> str:
    if not math.isfinite(abs(value)):
        return "one at infinity"
    real = show(value.real, digits=4)
    return real if value.imag == 0.0 else f"{real} +- {show(value.imag, digits=4)} i"


def _levels(record: Record) -> list[str]:
    """Levels by order; those of a loop that is not stable have no bound."""
    found = [
        (quantity, title, is_level)
        for name, title, is_level in _COLUMNS
        if (quantity := having(record, CONTROL + name, "order")) is not None
    ]
    if not found:
        return []
    columns, orders = [number("order", 5)], found[0][0].axes[0].values
    rows = [[str(int(order))] for order in orders]
    for quantity, title, is_level in found:
        columns.append(number(title, 10))
        for place, row in enumerate(rows):
            row.append(_cell(quantity, place, is_level))
    notes = "levels of the shell's angular acceleration, dB re 1 rad/s^2 zero-to-peak; load at "
    notes += f"constant speed. The loop is {status_words(record, '')}"
    return [*table(columns, rows), *paragraph(notes)]


def _cell(quantity: Quantity, place: int, is_level: bool) -> str:
    value = quantity.values[place]
    if not is_level:
        return show(value, quantity.error_estimate, 5)
    if value == -math.inf and quantity.path.endswith("attenuation"):
        return "grows"
    return decibels(float(value))


def _full(record: Record) -> list[str]:
    """Is the loop stable in the full model too, and does it do there what the reduced one says?"""
    stable = scalar_of(record, CONTROL + "full/stable")
    difference = having(record, CONTROL + "full/difference", "order")
    if stable is None or difference is None:
        return []
    multiplier = having(record, CONTROL + "full/multiplier", "multiplier")
    size = 0.0 if multiplier is None else float(np.max(np.abs(multiplier.values)))
    if not stable:
        return paragraph(
            "full model: UNSTABLE under control, a disturbance grows to "
            f"{show(size, digits=4)} of itself in each turn. It has no levels"
        )
    slip = scalar_of(record, CONTROL + "full/largest_slip")
    words = f"full model: stable, a disturbance shrinks to {show(size, digits=2)} in a turn"
    if slip is not None:
        words += f"; the slip reaches {show(rpm(slip), digits=4)} rpm in size"
    worst = int(np.argmax(np.abs(difference.values)))
    words += _apart("; it is", difference, worst)
    louder = _louder(record)
    return paragraph(words + louder)


def _louder(record: Record) -> str:
    """Orders that control makes louder in the full model."""
    gained = having(record, CONTROL + "full/attenuation", "order")
    if gained is None:
        return ""
    values = np.asarray(gained.values, dtype=float)
    orders = [str(int(order)) for order in gained.axes[0].values[values < -_CLOSE]]
    return f". Control makes louder there: orders {', '.join(orders)}" if orders else ""


def _range(record: Record) -> list[str]:
    own = having(record, CONTROL + "range/difference", "order")
    if own is None:
        return []
    values = np.asarray(own.values, dtype=float)
    orders = own.axes[0].values
    kept = [str(int(order)) for order in orders[np.abs(values) <= _CLOSE]]
    words = (
        f"without control the reduced model is within {_CLOSE:g} dB of the full one in orders "
        f"{', '.join(kept)}" if kept else
        f"without control the reduced model is more than {_CLOSE:g} dB off in every order"
    )  # fmt: skip
    words += _apart("; the full one is", own, int(np.argmax(np.abs(values))))
    straight = having(record, CONTROL + "range/linear_difference", "order")
    if straight is not None:
        off = np.asarray(straight.values, dtype=float)
        here = int(np.argmax(np.abs(values)))
        sense = "above" if off[here] > 0.0 else "below"
        words += (
            ". Were the curve of the motor straight, it would be "
            f"{abs(off[here]):.2f} dB {sense} it in order {int(orders[here])}"
            + _apart(", and over all orders", straight, int(np.argmax(np.abs(off))))
            + ": the rest is the bend of that curve"
        )
    return paragraph(words)


def _apart(lead: str, difference: Quantity, place: int) -> str:
    value = float(difference.values[place])
    order = int(difference.axes[0].values[place])
    if not math.isfinite(value):
        return f"{lead} without a bound to its difference from the reduced one in order {order}"
    sense = "above" if value > 0.0 else "below"
    return f"{lead} at most {abs(value):.2f} dB {sense} the reduced one (order {order})"
