"""The section of the running state: levels and lags by order, works, what moves them."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import (
    Section,
    having,
    labels,
    leads,
    scalar_of,
    section,
    table_of,
)
from vibecalc.core.report.writing import Column, decibels, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import ranked
from vibecalc.roll.report.advice import ROLL, advice, one_row, shell_acts
from vibecalc.roll.report.advice import level as in_level

# ----------------------------------------------------------------------------
# Levels and lags as the report prints them; what is zero to round-off has neither.
# ----------------------------------------------------------------------------


def lag_degrees(lag: float, acts: bool | np.bool_ = True) -> str:
    """An angle of lag in degrees, [0, 360), `-` where nothing lags."""
    if not acts or not math.isfinite(lag):
        return "-"
    return f"{round(math.degrees(lag), 2) % 360.0:.2f}"


def _lag(value: Any, _error: float) -> str:
    return lag_degrees(value)


# ----------------------------------------------------------------------------
# Roll of the shell: the running state, its balances, and what moves at each order.
# ----------------------------------------------------------------------------

_STATE = (
    ("speed", "mean speed of the crank"),
    ("speed_variation", "cyclic irregularity, (max - min) / mean"),
    ("mean_slip", "mean slip (% of synchronous speed)"),
    ("largest_slip", "largest slip in a turn"),
    ("mean_torque", "mean torque of the motor"),
    ("breakdown_margin", "breakdown torque margin, T_max / T_mean - 1"),
    ("shell_drift", "mean speed of the shell"),
    ("angular_momentum", "angular momentum about the crank axis"),
)
_WORK = (
    ("motor", "by motor"),
    ("gas", "to gas"),
    ("friction", "to friction"),
    ("mounts", "to mounts"),
    ("residual", "error"),
)
_DIGITS = 4
_MULTIPLIERS = 4
#: with such a multiplier a disturbance takes some turns to fade
_SLOW = 0.1


def roll(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    # the fluxes of a motor have a section of their own
    shown = frozenset(
        path for path in record if path.startswith(ROLL) and not path.startswith(ROLL + "motor/")
    )
    levels = rows_of(record, _LEVELS)[0]
    blocks = [_state(result), _stability(record), levels, forces(record)]
    details = {
        "energy balance of a turn": _balances(record),
        "further harmonics": rows_of(record, _MORE)[0],
        "interpolation of the gas tables": _interpolations(result),
        "levels by other methods": _methods(result),
        "measures to lower each harmonic": advice(result),
    }
    return section("Roll of the shell", blocks, details, shown)


def _state(result: Result) -> list[str]:
    rows = []
    for name, words in _STATE:
        value = scalar_of(result.record, ROLL + name)
        if value is None or leads(result.record, ROLL + name):
            continue
        quantity = result.record[ROLL + name]
        value, error = float(quantity.values), quantity.error_estimate
        if quantity.unit:
            factor, unit = (rpm(1.0), "rpm") if quantity.unit == "rad/s" else (1.0, quantity.unit)
            rows.append(
                [words, show(value * factor, error * factor), unit, _slip(result, quantity)]
            )
        else:
            unit = "%" if math.isfinite(value) else ""
            rows.append([words, show(100.0 * value, 100.0 * error, 4), unit, ""])
    columns = (Column("running state"), number("value"), Column("unit"),
               Column("slip"))  # fmt: skip
    return table(columns, rows) if rows else []


def _slip(result: Result, quantity: Quantity) -> str:
    synchronous = table_of(result.case, "machine", "motor").get("synchronous_speed")
    if quantity.path.endswith("_slip") and isinstance(synchronous, int | float) and synchronous:
        return f"{100.0 * float(quantity.values) / synchronous:.3g} %"
    return ""


def _stability(record: Record) -> list[str]:
    largest = scalar_of(record, ROLL + "largest_multiplier")
    if largest is None:
        return []
    if abs(largest - 1.0) <= record[ROLL + "largest_multiplier"].error_estimate:
        words = "marginally stable: disturbances neither grow nor decay"
    elif largest > 1.0:
        words = f"UNSTABLE: disturbances grow by a factor of {show(largest, digits=4)} per turn"
    else:
        words = f"stable: disturbances decay to {show(100.0 * largest, digits=3)} % in a turn"
        if largest > _SLOW:
            turns = math.ceil(math.log(0.01) / math.log(largest))
            words += f", to 1 % in {turns} turns"
    quantity = having(record, ROLL + "multiplier", "multiplier")
    if quantity is not None:
        values = np.asarray(quantity.values, dtype=complex)
        ordered = values[ranked(np.abs(values))][:_MULTIPLIERS]
        words += "; Floquet multipliers " + ", ".join(_complex(one) for one in ordered)
        words += ", ..." if values.size > _MULTIPLIERS else ""
    trivial = scalar_of(record, ROLL + "trivial_multipliers")
    if trivial:
        what = "phase" if trivial == 1 else "phase, and angle and momentum of a free shell"
        words += f"; {int(trivial)} more equal{'s' * (trivial == 1)} 1 by symmetry ({what})"
    return paragraph(words)


def _complex(value: complex) -> str:
    real = show(value.real, digits=4)
    if abs(value.imag) <= 1e-12 * abs(value):
        return real
    sign = "+" if value.imag > 0 else "-"
    return f"{real} {sign} {show(abs(value.imag), digits=4)}i"


def _balances(record: Record) -> list[str]:
    lines = one_row(record, ROLL + "energy/", _WORK, "energy balance", "over a turn J")
    strayed = record.quantities.get(ROLL + "momentum_residual")
    if strayed is not None:
        size = show(float(strayed.values), strayed.error_estimate)
        lines += paragraph(f"error of the angular momentum balance: {size} {strayed.unit}")
    return lines


def _by_order(*names: tuple[str, str], with_level: bool = True) -> list[Cells]:
    """Amplitude, level and lag of variables; without levels, of those that oscillate."""

    def part(kind: str, name: str) -> Callable[[Record], Quantity | None]:
        def made(record: Record) -> Quantity | None:
            harmonics = having(record, ROLL + name, "order")
            found = having(record, f"{ROLL}{kind}{name}", "order")
            if harmonics is None or found is None or (harmonics.zero.all() and not with_level):
                return None
            nothing = {"": 0.0, "level/": -np.inf, "phase_lag/": np.nan}[kind]
            values = np.where(harmonics.zero & (kind != ""), nothing, found.values)
            return replace(found, values=values)

        return made

    columns = []
    for name, head in names:
        columns.append(Cells(part("", name), head, _amplitude, right=True))
        if with_level:
            columns.append(Cells(part("level/", name), "level\ndB", in_level, right=True))
        columns.append(Cells(part("phase_lag/", name), "lag\ndeg", _lag, right=True))
    return columns


def _amplitude(value: Any, error: float) -> str:
    return show(value, float(error), _DIGITS)


def _share(value: Any, _error: float) -> str:
    return f"{100.0 * value:.3g}"


_LEVELS = Rows(
    "order",
    "order",
    _by_order(
        ("shell_acceleration", "shell\nrad/s^2"),
        ("rotor_acceleration", "rotor\nrad/s^2"),
        ("motor_torque", "motor torque\nN*m"),
    ),
    right=True,
    note="amplitudes 0-to-peak; levels dB re 1 rad/s^2 and 1 N*m; lag phi: C cos(n W t - phi), "
    "t = 0 at crank angle 0",
)
_MORE = Rows(
    "order", "order",
    _by_order(
        ("crank_speed", "crank speed\nrad/s"),
        ("gas_torque", "gas torque\nN*m"),
        ("mount_torque", "mount torque\nN*m"),
        with_level=False,
    ),
    right=True,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Forces in the rods and on the walls, and what the textbook's assumptions cost in them.
# ----------------------------------------------------------------------------

_FORCES = (("rod_force", "rod"), ("wall_force", "wall"))
_PLACES = {"rod_force": "rod force", "wall_force": "wall force"}


def forces(record: Record) -> list[str]:
    """Largest forces of each cylinder, next to those at constant speed, and what these miss."""
    lines, _ = rows_of(record, _LARGEST)
    if not lines:
        return []
    errors = [
        f"{place} {_worst(error)}" + _at(record, name)
        for name, place in _PLACES.items()
        if (error := having(record, f"{ROLL}classical/{name}_error", "cylinder")) is not None
    ]
    if errors:
        lines += paragraph(
            "error by assuming constant speed and a fixed shell: " + "; ".join(errors)
            + " (largest error over a turn / peak force)"
        )  # fmt: skip
    return lines + shaking(record)


_LARGEST = Rows(
    "cylinder", "largest force",
    [
        Cells(path, head, how, right=True)
        for name, words in _FORCES
        for path, head, how in (
            (f"{ROLL}{name}_peak", f"{words} N", _amplitude),
            (f"{ROLL}classical/{name}_peak", "at constant speed N", _amplitude),
            (f"{ROLL}classical/{name}_error", "error up to %", _share),
        )
    ],
)  # fmt: skip


def shaking(record: Record) -> list[str]:
    """What the textbook has for the whole body: its force and couple, and no roll."""
    words = []
    for name, direction in (("force", "along"), ("couple", "about")):
        peak = having(record, f"{ROLL}shaking/{name}_peak", "direction")
        if peak is None:
            return []
        shown = [
            f"{show(value, peak.error_estimate, _DIGITS)} {peak.unit} {direction} {label}"
            for label, value in zip(labels(peak.axes[0]), peak.values, strict=True)
            if float(value) > peak.error_estimate
        ]
        words.append(", ".join(shown) if shown else f"no {name}")
    level = having(record, f"{ROLL}level/shell_acceleration", "order")
    rolls = level is not None and bool(np.any(np.isfinite(level.values)))
    balanced = all(word.startswith("no ") for word in words)
    text = f"shaking at constant speed: {' and '.join(words)}"
    if balanced:
        text += ", fully balanced" + (", but the body rolls" if rolls else "")
    return paragraph(text + "; peak over a turn, about the reference point")


def _worst(error: Quantity) -> str:
    place = int(np.argmax(error.values))
    return f"up to {100.0 * float(error.values[place]):.3g} % ({labels(error.axes[0])[place]})"


def _at(record: Record, name: str) -> str:
    """The order at which the force is missed most."""
    by_order = having(record, f"{ROLL}classical/{name}_error_by_order", "cylinder", "order")
    if by_order is None:
        return ""
    size = np.abs(by_order.values)
    place = np.unravel_index(int(np.argmax(size)), size.shape)
    if size[place] <= by_order.error_estimate:
        return ""
    order = int(by_order.axes[1].values[place[1]])
    return f", {show(size[place], digits=3)} {by_order.unit} at order {order}"


# ----------------------------------------------------------------------------
# What the levels of the shell hang on besides the machine: reading of tables, and method.
# ----------------------------------------------------------------------------

#: a spread in dB that no one hears of
_SMALL = 0.1
#: differences of methods, in dB, below which digits are rounding; the error estimate, one number
#: for all methods, would hide the good ones behind the worst
_ROUNDING = 1e-9


def _interpolations(result: Result) -> list[str]:
    record = result.record
    level = having(record, ROLL + "interpolation/level", "interpolant", "order")
    spread = having(record, ROLL + "interpolation/spread", "order")
    if level is None:
        return []
    used = str(table_of(result.case, "machine", "crank_train").get("gas_interpolation") or "")
    names = [f"{one}\n{'(case) ' * (one == used)}" for one in labels(level.axes[0])]
    named = replace(level.axes[0], values=np.array(names, dtype=object))
    orders = np.asarray(level.axes[1].values)
    acts = shell_acts(record, orders)
    shown = replace(
        level, values=np.where(acts, level.values, -np.inf), axes=(named, level.axes[1])
    )
    columns = [Cells(lambda _: shown, "{}dB", in_level, right=True)]
    columns += [Cells(ROLL + "interpolation/spread", "spread\ndB", in_level, right=True)]
    above = "shell acceleration by interpolation of the gas tables"
    lines, _ = rows_of(record, Rows("order", "order", columns, right=True, above=above))
    if spread is not None and acts.any():
        lines += paragraph(_open(np.asarray(spread.values), orders, acts))
    return lines


def _open(spread: np.ndarray, orders: np.ndarray, acts: np.ndarray) -> str:
    chosen = acts & np.isfinite(spread)
    if not chosen.any():
        return "no dependence on the interpolation can be determined"
    sizes = np.where(chosen, spread, 0.0)
    top = int(np.argmax(sizes))
    words = f"levels depend on the interpolation by up to {decibels(float(sizes[top]))} dB"
    words += f" (order {int(orders[top])})"
    wide = orders[chosen & (spread >= _SMALL)]
    if wide.size and wide.min() > orders[chosen].min():
        words += f", by less than {_SMALL} dB below order {int(wide.min())}"
    return words


def _methods(result: Result) -> list[str]:
    record = result.record
    differences = having(record, ROLL + "method/difference", "method", "order")
    if differences is None:
        return []
    method = str(table_of(result.case, "response", "roll").get("method") or "collocation")
    columns = [number("order"), *(number(f"{name} dB") for name in labels(differences.axes[0]))]
    orders = np.asarray(differences.axes[1].values)
    acts = shell_acts(record, orders)
    rows = []
    for i, shows in enumerate(acts):
        cells = [_miss(float(one)) if shows else "-"
                 for one in differences.values[:, i]]  # fmt: skip
        rows.append([str(int(orders[i])), *cells])
    lines = paragraph(f"level of the shell acceleration by other methods, difference from {method}")
    below = []
    misses = np.abs(differences.values[:, acts])
    if misses.size:
        worst = [_miss(float(one)).lstrip("+") for one in misses.max(axis=1)]
        below.append(["largest", *worst])
    points, words = _work(record, differences)
    return [*lines, *table(columns, rows, below + points), *words]


def _work(record: Record, differences: Quantity) -> tuple[list[list[str]], list[str]]:
    """A row of the counted work of each method, and what it counts."""
    work = having(record, ROLL + "method/work", "method")
    if work is None or len(work.values) != len(differences.values):
        return [], []
    row = ["points", *(str(round(float(one))) for one in work.values)]
    words = "points: evaluations of the right-hand side of the equations of motion"
    return [row], paragraph(words)


def _miss(value: float) -> str:
    if not np.isfinite(value):
        return "-"
    shown = show(value, _ROUNDING, digits=3)
    return shown if shown.startswith("-") or shown == "0" else f"+{shown}"
