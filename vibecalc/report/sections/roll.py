"""Roll of the shell: the running state, its balances, and what moves at each order."""

import math
from collections.abc import Sequence

import numpy as np

from vibecalc.report.levels import ROLL, acting, decibels, lag_degrees, oscillating
from vibecalc.report.lookup import having, scalar_of, table_of
from vibecalc.report.numbers import hertz, rpm, show
from vibecalc.report.sections.roll_advice import advice
from vibecalc.report.sections.roll_compared import compared
from vibecalc.report.sections.roll_forces import forces
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_STATE = (
    ("speed", "mean speed of the crank"),
    ("speed_variation", "largest less smallest speed, over it"),
    ("mean_slip", "mean slip (% of synchronous speed)"),
    ("largest_slip", "largest slip in a turn"),
    ("mean_torque", "mean torque of the motor"),
    ("breakdown_margin", "breakdown torque, above that mean"),
    ("shell_drift", "mean speed of the shell"),
    ("angular_momentum", "angular momentum about the crank axis"),
)
_WORK = (
    ("motor", "by motor"),
    ("gas", "to gas"),
    ("friction", "to friction"),
    ("mounts", "to mounts"),
    ("residual", "left over"),
)
_LEVELS = (
    ("shell_acceleration", "shell"),
    ("rotor_acceleration", "rotor"),
    ("motor_torque", "motor torque"),
)
_MORE = (
    ("crank_speed", "crank speed"),
    ("gas_torque", "gas torque"),
    ("mount_torque", "mount torque"),
)
_DIGITS = 5
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
    lines: list[str] = []
    for block in (
        _state(result),
        _stability(record),
        _balances(record),
        _levels(record),
        _more(record),
        forces(record),
        compared(result),
        advice(result),
    ):
        if block:
            lines += ["", *block] if lines else block
    return Section("Roll of the shell", lines, shown) if lines else None


def _state(result: Result) -> list[str]:
    rows = []
    for name, words in _STATE:
        value = scalar_of(result.record, ROLL + name)
        if value is None:
            continue
        quantity = result.record[ROLL + name]
        value, error = float(quantity.values), quantity.error_estimate
        if quantity.unit:
            rows.append([words, show(value, error), quantity.unit, _also(result, quantity)])
        else:
            unit = "%" if math.isfinite(value) else ""
            rows.append([words, show(100.0 * value, 100.0 * error, 4), unit, ""])
    columns = (Column("running state", 40), number("value", 13), Column("unit", 9),
               Column("also", 33))  # fmt: skip
    return table(columns, rows) if rows else []


def _also(result: Result, quantity: Quantity) -> str:
    if quantity.unit != "rad/s":
        return ""
    value, error = float(quantity.values), quantity.error_estimate
    words = f"{show(rpm(value), rpm(error))} rpm"
    if quantity.path == ROLL + "speed":
        return f"{words}, {show(hertz(value), hertz(error))} turns/s"
    synchronous = table_of(result.case, "machine", "motor").get("synchronous_speed")
    if quantity.path.endswith("_slip") and isinstance(synchronous, int | float) and synchronous:
        words += f", {100.0 * value / synchronous:.3g} %"
    return words


def _stability(record: Record) -> list[str]:
    largest = scalar_of(record, ROLL + "largest_multiplier")
    if largest is None:
        return []
    if abs(largest - 1.0) <= record[ROLL + "largest_multiplier"].error_estimate:
        words = "neither stable nor unstable: a disturbance stays as large as it is"
    elif largest > 1.0:
        words = f"UNSTABLE: a disturbance grows to {show(largest, digits=4)} of itself in a turn"
    else:
        words = f"stable: of a disturbance {show(100.0 * largest, digits=3)} % is left after a turn"
        if largest > _SLOW:
            turns = math.ceil(math.log(0.01) / math.log(largest))
            words += f", 1 % after {turns} turns"
    found = having(record, ROLL + "multiplier", "multiplier")
    if found is not None:
        values = np.asarray(found.values, dtype=complex)
        ordered = values[np.argsort(-np.abs(values), kind="stable")][:_MULTIPLIERS]
        words += "; Floquet multipliers " + ", ".join(_complex(one) for one in ordered)
        words += ", ..." if values.size > _MULTIPLIERS else ""
    trivial = scalar_of(record, ROLL + "trivial_multipliers")
    if trivial:
        what = "phase" if trivial == 1 else "phase, and angle and momentum of a free shell"
        words += f"; {int(trivial)} more {'is' if trivial == 1 else 'are'} 1 in any case ({what})"
    return paragraph(words)


def _complex(value: complex) -> str:
    real = show(value.real, digits=4)
    if abs(value.imag) <= 1e-12 * abs(value):
        return real
    sign = "+" if value.imag > 0 else "-"
    return f"{real} {sign} {show(abs(value.imag), digits=4)}i"


def _balances(record: Record) -> list[str]:
    found = [
        (record[path], words) for name, words in _WORK if (path := f"{ROLL}energy/{name}") in record
    ]
    strayed = record.quantities.get(ROLL + "momentum_residual")
    lines = []
    if found:
        columns = [Column("balances of a turn", 24), *(number(words, 13) for _, words in found)]
        lines += table(columns, [["energy J", *(_left(quantity) for quantity, _ in found)]])
    if strayed is not None:
        lines += paragraph(
            f"angular momentum strays by {_left(strayed)} {strayed.unit} from what the mounts "
            "explain"
        )
    return lines


def _left(quantity: Quantity) -> str:
    return show(float(quantity.values), quantity.error_estimate)


def _levels(record: Record) -> list[str]:
    """Amplitude, level and lag of what matters most, side by side."""
    lines = _by_order(record, _LEVELS, 12)
    return lines and lines + paragraph(
        "amplitudes zero-to-peak, levels re 1 of their unit; lag phi of C cos(n W t - phi), with "
        "t = 0 where the crank angle is 0"
    )


def _more(record: Record) -> list[str]:
    """Amplitude and lag of what else oscillates."""
    return _by_order(record, _MORE, 14, with_level=False)


def _by_order(
    record: Record, names: Sequence[tuple[str, str]], width: int, with_level: bool = True
) -> list[str]:
    found = [
        (harmonics, words)
        for name, words in names
        if (harmonics := having(record, ROLL + name, "order")) is not None
        and (with_level or np.any(acting(harmonics)[oscillating(harmonics)]))
    ]
    if not found:
        return []
    columns = [number("order", 6)]
    rows = _order_rows(found[0][0])
    for harmonics, words in found:
        columns.append(number(f"{words}\n{harmonics.unit}", width))
        columns += [number("level\ndB", 8)] if with_level else []
        columns.append(number("lag\ndeg", 7))
        level, lag = (
            having(record, harmonics.path.replace(ROLL, f"{ROLL}{part}/"), "order")
            for part in ("level", "phase_lag")
        )
        acts = acting(harmonics)
        for row, i in zip(rows, oscillating(harmonics), strict=True):
            row.append(show(harmonics.values[i], harmonics.error_estimate, _DIGITS))
            if with_level:
                row.append("" if level is None else decibels(level.values[i], acts[i]))
            row.append("" if lag is None else lag_degrees(lag.values[i], acts[i]))
    return table(columns, rows)


def _order_rows(harmonics: Quantity) -> list[list[str]]:
    orders = np.asarray(harmonics.axes[-1].values)
    return [[str(int(orders[i]))] for i in oscillating(harmonics)]
