"""Report of the control of the motor: the loop, its margins, its levels, gains compared."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, part_of, rows_of
from vibecalc.core.report.sections import Section, having, scalar_of, section, table_of
from vibecalc.core.report.writing import (
    Column,
    decibels,
    hertz,
    number,
    pairs,
    paragraph,
    rpm,
    show,
    table,
)
from vibecalc.core.results.record import Quantity, Record, Result

# ----------------------------------------------------------------------------
# Words for loops: what their status means, and what their margins come to.
# ----------------------------------------------------------------------------

CONTROL = "response/control/"
#: of `status`
STATUS = (
    "stable",
    "STABLE ONLY WITHOUT ANY DELAY",
    "ON THE LIMIT OF STABILITY",
    "UNSTABLE",
    "UNSTABLE WITH THE LEAST LAG",
)
#: s; shorter times are written in microseconds
_SHORT = 1e-4
SHORT = ("stable", "no delay", "limit", "UNSTABLE", "UNSTABLE")


def status_words(record: Record, below: str) -> str:
    """What holds of a loop, loud where its levels are worth nothing; empty if not known."""
    status = scalar_of(record, f"{CONTROL}{below}status")
    if status is None:
        return ""
    words = STATUS[int(status)]
    if int(status) == 1:
        return f"{words}: its levels are valid for zero delay only"
    return words if int(status) == 0 else f"{words}: amplitudes unbounded"


def feedback_words(gain: Any, speed: float, acceleration: Any) -> str:
    """Gain and feedbacks in one line."""
    return (
        f"gain {show(gain, digits=5)}, speed feedback {show(speed, digits=6)}, feedback of the "
        f"shell's acceleration {show(acceleration, digits=5)} s"
    )


def margin_words(record: Record, below: str) -> list[tuple[str, str]]:
    """Rows of margins, and of what the actuator has to bear."""

    def value(name: str) -> float:
        found = scalar_of(record, f"{CONTROL}{below}{name}")
        return math.nan if found is None else found

    up, down = in_decibels(value("gain_margin")), in_decibels(value("gain_reduction"))
    margins = (
        f"gain {up} up, {down} down, phase {in_phase(value('phase_margin'))}, "
        f"delay {in_time(value('delay_margin'))}"
    )
    width, through = value("bandwidth"), value("feedthrough")
    wide = "unbounded" if math.isinf(width) else f"{show(hertz(width), digits=4)} Hz"
    bears = f"crossover {wide}, gain {show(through, digits=4)} at high frequency; rate of change "
    rate = value("command_rate")
    bears += f"of the synchronous speed up to {show(rate, digits=4)} rad/s^2, "
    bears += f"motor torque up to {show(value('torque_peak'), digits=4)} N*m"
    most = scalar_of(record, f"{CONTROL}breakdown_torque")
    if most is not None and math.isfinite(value("torque_peak")) and value("torque_peak") > most:
        bears += f", EXCEEDS the breakdown torque of {show(most, digits=4)} N*m"
    return [("margins", margins), ("demand", bears)]


def in_decibels(level: float) -> str:
    """A factor in dB; `unlimited` if it is infinite."""
    return "unlimited" if math.isinf(level) else f"{level:.2f} dB"


def in_phase(angle: float) -> str:
    """An angle in degrees; `unlimited` if it is infinite."""
    return "unlimited" if math.isinf(angle) else f"{np.degrees(angle):.1f} deg"


def in_time(time: Any) -> str:
    """A time in ms; `unlimited` if it is infinite, `none` for nothing."""
    if time is None or time == 0.0:
        return "none"
    if math.isinf(time):
        return "unlimited"
    if time < _SHORT:
        return f"{show(1e6 * float(time), digits=4)} us"
    return f"{show(1e3 * float(time), digits=4)} ms"


# ----------------------------------------------------------------------------
# Control of the motor: the loop and its margins, levels with it and without, and what to
# uncertainty.
# ----------------------------------------------------------------------------

_MODEL = (
    ("motor_gain", "slope of the motor torque over slip"),
    ("motor_offset", "motor torque at zero slip, linear curve"),
    ("breakdown_torque", "breakdown torque"),
    ("inertia", "inertia accelerated by the motor"),
    ("shell_share", "acceleration ratio, shell / crank"),
    ("mean_torque", "mean torque of gas and friction"),
    ("speed_without", "mean speed without control"),
    ("target_speed", "target mean speed"),
    ("speed", "mean speed under control"),
)
#: dB by which the reduced model may be off and still be called the same
_CLOSE = 0.5
_POLES = 6


def roll_control(result: Result) -> Section | None:
    """The section, None if the result has no control."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(CONTROL))
    blocks = [_model(record), _loop(result), _levels(record), _full(record), _range(record)]
    details = {"gains compared": grid(record), "other motors without control": motor_gains(record)}
    return section("Control of the motor", [*blocks, tuned(result)], details, shown)


def _model(record: Record) -> list[str]:
    rows = []
    for name, words in _MODEL:
        value = scalar_of(record, CONTROL + name)
        if value is None:
            continue
        quantity = record[CONTROL + name]
        factor, unit = (rpm(1.0), "rpm") if quantity.unit == "rad/s" else (1.0, quantity.unit)
        shown_value, error = float(quantity.values) * factor, quantity.error_estimate * factor
        rows.append([words, show(shown_value, error), unit])
    columns = (Column("reduced model"), number("value"), Column("unit"))
    return table(columns, rows) if rows else []


def _loop(result: Result) -> list[str]:
    record = result.record
    words = status_words(record, "")
    if not words:
        return []
    asked = table_of(result.case, "response", "control")
    lag, delay = asked.get("actuator_lag"), asked.get("delay")
    feedback = scalar_of(record, CONTROL + "speed_feedback")
    speed_feedback = 0.0 if feedback is None else float(record[CONTROL + "speed_feedback"].values)
    rows = [
        (
            "controller",
            feedback_words(asked.get("gain"), speed_feedback, asked.get("acceleration_feedback")),
        ),
        ("actuator", f"lag {in_time(lag)}, delay {in_time(delay)}"),
        ("stability", words),
        *margin_words(record, ""),
    ]
    pole = having(record, CONTROL + "pole", "pole")
    if pole is not None:
        texts = [_pole(complex(value)) for value in pole.values[:_POLES] if value.imag >= 0.0]
        rows.append(("poles", f"{', '.join(texts)} 1/s"))
    return [*paragraph("The loop (reduced model):"), *pairs(rows)]


def _pole(value: complex) -> str:
    if not math.isfinite(abs(value)):
        return "one at infinity"
    real = show(value.real, digits=4)
    return real if value.imag == 0.0 else f"{real} +- {show(value.imag, digits=4)} i"


def _levels(record: Record) -> list[str]:
    """Levels by order; those of a loop that is not stable have no bound."""
    notes = "levels of the shell's angular acceleration, dB re 1 rad/s^2 zero-to-peak; load at "
    notes += f"constant speed. The loop is {status_words(record, '')}"
    return rows_of(record, _LEVELS._replace(note=notes))[0]


def _in_level(value: Any, _error: float) -> str:
    return decibels(float(value))


def _reduction(value: Any, _error: float) -> str:
    return "grows" if value == -math.inf else decibels(float(value))


_LEVELS = Rows(
    "order",
    "order",
    (
        Cells("disturbance", "load\nN*m", show, right=True),
        Cells("level_without", "without\ndB", _in_level, right=True),
        Cells("level", "control\ndB", _in_level, right=True),
        Cells("attenuation", "reduction\ndB", _reduction, right=True),
        Cells("range/level", "full model\nwithout dB", _in_level, right=True),
        Cells("full/level", "full model\ncontrol dB", _in_level, right=True),
        Cells("full/attenuation", "full model\nreduction dB", _reduction, right=True),
        Cells("full/difference", "full - reduced\nmodel dB", _in_level, right=True),
    ),
    CONTROL.rstrip("/"),
    right=True,
)


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
            "full model: UNSTABLE under control, disturbances grow by a factor of "
            f"{show(size, digits=4)} per turn; no levels"
        )
    slip = scalar_of(record, CONTROL + "full/largest_slip")
    words = f"full model: stable, disturbances decay to {show(100.0 * size, digits=2)} % per turn"
    if slip is not None:
        words += f"; slip up to {show(rpm(slip), digits=4)} rpm"
    worst = int(np.argmax(np.abs(difference.values)))
    words += _apart("; level", difference, worst)
    louder = _louder(record)
    return paragraph(words + louder)


def _louder(record: Record) -> str:
    """Orders that control makes louder in the full model."""
    gained = having(record, CONTROL + "full/attenuation", "order")
    if gained is None:
        return ""
    values = np.asarray(gained.values, dtype=float)
    orders = [str(int(order)) for order in gained.axes[0].values[values < -_CLOSE]]
    noun = "order" if len(orders) == 1 else "orders"
    return f". Control increases {noun} {', '.join(orders)}" if orders else ""


def _range(record: Record) -> list[str]:
    difference = having(record, CONTROL + "range/difference", "order")
    if difference is None:
        return []
    values = np.asarray(difference.values, dtype=float)
    orders = difference.axes[0].values
    close = [str(int(order)) for order in orders[np.abs(values) <= _CLOSE]]
    words = (
        f"without control: reduced model within {_CLOSE:g} dB of the full model in orders "
        f"{', '.join(close)}" if close else
        f"without control: reduced model more than {_CLOSE:g} dB off in every order"
    )  # fmt: skip
    words += _apart("; full model", difference, int(np.argmax(np.abs(values))))
    straight = having(record, CONTROL + "range/linear_difference", "order")
    if straight is not None:
        off = np.asarray(straight.values, dtype=float)
        here = int(np.argmax(np.abs(values)))
        sense = "above" if off[here] > 0.0 else "below"
        words += (
            ". With a linear motor curve: "
            f"{abs(off[here]):.2f} dB {sense} in order {int(orders[here])}"
            + _apart(", over all orders", straight, int(np.argmax(np.abs(off))))
            + "; the remainder is due to the curvature of the motor curve"
        )
    return paragraph(words)


def _apart(lead: str, difference: Quantity, place: int) -> str:
    value = float(difference.values[place])
    order = int(difference.axes[0].values[place])
    if not math.isfinite(value):
        return f"{lead} unbounded relative to the reduced model in order {order}"
    sense = "above" if value > 0.0 else "below"
    return f"{lead} up to {abs(value):.2f} dB {sense} the reduced model (order {order})"


# ----------------------------------------------------------------------------
# Control of the motor, continued: gains found, gains compared, other motors.
# ----------------------------------------------------------------------------

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
        ("gains", words),
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
        rows.append(("reduction", ", ".join(each)))
    rows.append(("limited by", _held(record)))
    return [*paragraph("Tuned gains within the specified margins (reduced model):"), *pairs(rows)]


def _held(record: Record) -> str:
    active = having(record, f"{CONTROL}tuned/active", "bound")
    worth = having(record, f"{CONTROL}tuned/multiplier", "bound")
    if active is None or worth is None:
        return "not known"
    texts = []
    for name, holds, value in zip(active.axes[0].values, active.values, worth.values, strict=True):
        if holds:
            gained = f"{0.01 * float(value):.3f} dB per 1 % relaxation"
            texts.append(f"{name} ({gained})" if value > 0.0 else str(name))
    return ", ".join(texts) or "no bound: interior minimum"


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
        number("gain"), number("feedback\ns"), Column("stability"),
        *(number(f"order {int(order)}\ndB") for order in orders[:count]),
        number("torque\nN*m"), number("gain\nmargin"), number("phase\nmargin"),
        number("delay\nmargin")
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
        notes.append(f"* exceeds the breakdown torque, {show(most, digits=4)} N*m")
    left = len(rows) - _MOST_ROWS
    lines = paragraph("Gains compared at the same mean speed (reduced model):")
    lines += table(columns, rows[:_MOST_ROWS])
    if left > 0:
        lines += paragraph(f"{left} more pairs in the result file")
    if np.any(status == 1):
        notes.append('"no delay": stable, and its levels valid, for zero delay only')
    return lines + [line for note in notes for line in paragraph(note)]


def _level(value: float) -> str:
    return "-" if math.isinf(value) and value > 0.0 else decibels(value)


def _torque(value: float, most: float) -> str:
    if math.isinf(value):
        return "-"
    return f"{value:.0f}{' *' if value > most else '  '}"


def motor_gains(record: Record) -> list[str]:
    """Speed and levels with other motors, uncontrolled."""
    return rows_of(record, _OTHERS)[0]


def _first_levels(record: Record) -> Quantity | None:
    """Levels of the first orders."""
    level = having(record, f"{CONTROL}motor_gains/level", "motor_gain", "order")
    if level is None:
        return None
    gain, order = level.axes
    first = replace(order, values=order.values[:_ORDERS])
    return part_of(level, level.values[:, :_ORDERS], gain, first)


_OTHERS = Rows(
    "motor_gain",
    "motor slope\nN*m*s/rad",
    (
        Cells("speed", "speed\nrpm", lambda value, _: show(rpm(value), digits=5), right=True),
        Cells(_first_levels, "order {}\ndB", _in_level, right=True),
    ),
    f"{CONTROL}motor_gains",
    label=lambda gain: show(gain, digits=5),
    right=True,
    above="Other motors without control (reduced model):",
)
