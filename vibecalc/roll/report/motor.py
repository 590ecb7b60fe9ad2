"""A motor with transients: what was fitted to its table, and what they change in the levels."""

import numpy as np

from vibecalc.core.report.sections import (
    Section,
    having,
    labels,
    scalar_of,
    section,
)
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
from vibecalc.roll.report.advice import ROLL, oscillating, shell_acts

_MOTOR = ROLL + "motor/"
_OF_ALL = (
    ("stator_leakage", "leakage of the stator", "stator_leakage"),
    ("magnetising_inductance", "magnetising inductance", "magnetising_inductance"),
)
_OF_CAGES = (
    ("rotor_resistance", "resistance of cage", "rotor_resistance"),
    ("rotor_leakage", "leakage of cage", "rotor_leakage"),
)
_POINTS = (
    ("breakdown_torque", "largest steady torque"),
    ("breakdown_slip", "slip there"),
    ("locked_rotor_torque", "torque at standstill"),
    ("gain", "slope at synchronous speed"),
    ("static_answer", "minus the slope at the mean slip"),
    ("stator_time", "time constant of the stator"),
)
_ENERGIES = (
    ("electrical", "from the line"),
    ("stator_copper", "heat, stator"),
    ("rotor_copper", "heat, rotor"),
    ("mechanical", "on the shaft"),
    ("residual", "left over"),
)


def roll_motor(result: Result) -> Section | None:
    """The section, None for a motor without transients."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_MOTOR))
    blocks = [_changes(record), _parameters(record), _points(record)]
    details = {
        "torque and slip of the motor by row": _rows(record),
        "transients of the motor": _transients(record),
        "energies of the motor": _energies(record),
    }
    return section("Motor with transients", blocks, details, shown)


def _changes(record: Record) -> list[str]:
    """Levels from the table to the circuit to its transients, and the torque's answer."""
    static = having(record, _MOTOR + "static_level", "order")
    level = having(record, ROLL + "level/shell_acceleration", "order")
    if static is None or level is None:
        return []
    columns = [number("order")]
    rows = [[str(int(static.axes[0].values[i]))] for i in oscillating(static)]
    acts = shell_acts(record, np.asarray(static.axes[0].values))
    for path, words in (
        (_MOTOR + "table_level", "slip table\ndB"),
        (_MOTOR + "fit_change", "the fit\ndB"),
        (_MOTOR + "static_level", "steady curve\ndB"),
        (_MOTOR + "dynamics_change", "transients\ndB"),
        (level.path, "with them\ndB"),
    ):
        quantity = having(record, path, "order")
        if quantity is None:
            continue
        columns.append(number(words))
        for row, i in zip(rows, oscillating(quantity), strict=True):
            row.append(decibels(quantity.values[i], bool(acts[i])))
    _add_answer(record, columns, rows)
    lines = paragraph(
        "levels of the shell acceleration; what the fitted curve in place of the table changes, "
        "and what the transients change"
    )
    lines += table(columns, rows)
    return lines + paragraph(_summary(record, acts))


def _add_answer(record: Record, columns: list[Column], rows: list[list[str]]) -> None:
    answer = having(record, _MOTOR + "torque_answer", "order")
    if answer is None or len(answer.values) != len(rows):
        return
    columns += [number("answer\nN*m*s/rad"), number("phase\ndeg")]
    for row, value in zip(rows, answer.values, strict=True):
        angle = float(np.degrees(np.angle(value)))
        row += [show(abs(value), answer.error_estimate, 4), f"{angle:.1f}"]


def _summary(record: Record, acts: np.ndarray) -> str:
    change = having(record, _MOTOR + "dynamics_change", "order")
    words = (
        "answer: torque for a harmonic of the crank's speed about the mean slip; with the steady "
    )
    still = scalar_of(record, _MOTOR + "static_answer")
    words += "curve it is minus its slope at every order"
    if still is not None:
        words += f", {show(abs(still), digits=4)} N*m*s/rad at 180 deg"
    if change is not None and acts.any():
        sizes = np.where(acts & np.isfinite(change.values), np.abs(change.values), 0.0)
        top = int(np.argmax(sizes))
        order = int(change.axes[0].values[top])
        words += f"; the transients change order {order} most, by {decibels(change.values[top])} dB"
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
    spread = having(record, _MOTOR + "parameter_spread", "motor_parameter")
    free = having(record, _MOTOR + "parameter_free_spread", "motor_parameter")
    known = {} if spread is None else dict(zip(labels(spread.axes[0]), spread.values, strict=True))
    alone = {} if free is None else dict(zip(labels(free.axes[0]), free.values, strict=True))
    rows = []
    for name, words, key in _OF_ALL:
        quantity = having(record, _MOTOR + name)
        if quantity is not None:
            rows.append(_parameter(words, quantity, float(quantity.values), key, known, alone))
    for name, words, key in _OF_CAGES:
        quantity = having(record, _MOTOR + name, "cage")
        if quantity is None:
            continue
        for cage, value in zip(labels(quantity.axes[0]), quantity.values, strict=True):
            name_of = key if len(quantity.values) == 1 else f"{key} {cage}"
            rows.append(
                _parameter(f"{words} {cage}", quantity, float(value), name_of, known, alone)
            )
    columns = (Column("fitted parameter"), number("value"), Column("unit"),
               number("for 1 % in\nthe table %"), number("nothing\nassumed %"))  # fmt: skip
    return table(columns, rows) if rows else []


def _parameter(
    words: str,
    quantity: Quantity,
    value: float,
    key: str,
    known: dict[str, float],
    alone: dict[str, float],
) -> list[str]:
    shown = show(value, quantity.error_estimate)
    return [words, shown, quantity.unit, _percent(known.get(key)), _percent(alone.get(key))]


def _percent(spread: float | None) -> str:
    """A standard error of a logarithm in percent."""
    if spread is None:
        return ""
    return show(100.0 * spread, digits=3) if np.isfinite(spread) else "not identifiable"


def _rows(record: Record) -> list[str]:
    paths = ("torque", "fitted", "difference", "relative_difference", "used")
    quantities = [having(record, f"{_MOTOR}table/{name}", "slip") for name in paths]
    torque, fitted, difference, relative, used = quantities
    if torque is None or fitted is None or difference is None or relative is None or used is None:
        return []
    rows = [
        [
            show(rpm(float(slip)), digits=5),
            show(torque.values[i], digits=5),
            show(fitted.values[i], fitted.error_estimate, 5),
            show(difference.values[i], difference.error_estimate, 4),
            f"{100.0 * relative.values[i]:+.2f}",
            "" if used.values[i] else "not fitted",
        ]
        for i, slip in enumerate(torque.axes[0].values)
    ]
    columns = (number("slip\nrpm"), number("table\nN*m"), number("fitted\nN*m"),
               number("difference\nN*m"), number("%"), Column(""))  # fmt: skip
    lines = table(columns, rows)
    worst, rms = (scalar_of(record, f"{_MOTOR}{name}_difference") for name in ("worst", "rms"))
    if worst is None or rms is None:
        return lines
    words = f"fitted rows are met within {100.0 * worst:.3g} %, {100.0 * rms:.3g} % rms"
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
    columns = (Column("of the fitted motor"), number("value"), Column("unit"),
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


def _energies(record: Record) -> list[str]:
    found = [
        (quantity, words)
        for name, words in _ENERGIES
        if (quantity := having(record, f"{_MOTOR}energy/{name}")) is not None
    ]
    if not found:
        return []
    columns = [Column("energy of a turn"), *(number(words) for _, words in found)]
    cells = [show(float(one.values), one.error_estimate) for one, _ in found]
    return table(columns, [["J", *cells]])
