"""What the levels of the shell hang on besides the machine: reading of tables, and method."""

import numpy as np

from vibecalc.report.levels import ROLL, decibels, oscillating, shell_acts
from vibecalc.report.lookup import having, labels, table_of
from vibecalc.report.numbers import show
from vibecalc.report.tables import number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

#: a spread in dB that no one hears of
_SMALL = 0.1
#: differences of methods, in dB, below which digits are rounding; the error estimate, one number
#: for all methods, would hide the good ones behind the worst
_ROUNDING = 1e-9


def compared(result: Result) -> list[str]:
    """Both tables, as far as the result has them."""
    found = _interpolations(result)
    methods = _methods(result)
    return [*found, *([""] if found and methods else []), *methods]


def _interpolations(result: Result) -> list[str]:
    record = result.record
    level = having(record, ROLL + "interpolation/level", "interpolant", "order")
    spread = having(record, ROLL + "interpolation/spread", "order")
    if level is None:
        return []
    used = str(table_of(result.case, "machine", "crank_train").get("gas_interpolation") or "")
    columns = [number("order", 6)]
    for name in labels(level.axes[0]):
        columns.append(number(f"{name}\n{'(case) ' if name == used else ''}dB", 15))
    columns.append(number("spread\ndB", 11))
    orders = np.asarray(level.axes[1].values)
    acts = shell_acts(record, orders)
    rows = []
    for i in oscillating(level):
        cells = [decibels(float(one), bool(acts[i])) for one in level.values[:, i]]
        wide = "" if spread is None or not acts[i] else decibels(float(spread.values[i]))
        rows.append([str(int(orders[i])), *cells, wide])
    lines = paragraph("shell acceleration with each way to read the gas tables between their rows")
    lines += table(columns, rows)
    if spread is not None and acts.any():
        lines += paragraph(_open(np.asarray(spread.values), orders, acts))
    return lines


def _open(spread: np.ndarray, orders: np.ndarray, acts: np.ndarray) -> str:
    chosen = acts & (orders != 0) & np.isfinite(spread)
    if not chosen.any():
        return "the tables leave nothing open that can be told"
    sizes = np.where(chosen, spread, 0.0)
    top = int(np.argmax(sizes))
    words = f"the tables leave a level open by up to {decibels(float(sizes[top]))} dB"
    words += f" (order {int(orders[top])})"
    wide = orders[chosen & (spread >= _SMALL)]
    if wide.size and wide.min() > orders[chosen].min():
        words += f", by less than {_SMALL} dB below order {int(wide.min())}"
    return words


def _methods(result: Result) -> list[str]:
    record = result.record
    found = having(record, ROLL + "method/difference", "method", "order")
    if found is None:
        return []
    own = str(table_of(result.case, "response", "roll").get("method") or "collocation")
    columns = [number("order", 9), *(number(f"{name} dB", 14) for name in labels(found.axes[0]))]
    orders = np.asarray(found.axes[1].values)
    chosen = oscillating(found)
    acts = shell_acts(record, orders)[chosen]
    rows = []
    for i, shows in zip(chosen, acts, strict=True):
        cells = [_miss(float(one)) if shows else "-"
                 for one in found.values[:, i]]  # fmt: skip
        rows.append([str(int(orders[i])), *cells])
    lines = paragraph(f"level of the shell acceleration by other methods, less that by {own}")
    below = []
    kept = np.abs(found.values[:, chosen[acts]])
    if kept.size:
        worst = [_miss(float(one)).lstrip("+") for one in kept.max(axis=1)]
        below.append(["largest", *worst])
    points, words = _work(record, found)
    return [*lines, *table(columns, rows, below + points), *words]


def _work(record: Record, found: Quantity) -> tuple[list[list[str]], list[str]]:
    """A row of the counted work of each method, and what it counts."""
    work = having(record, ROLL + "method/work", "method")
    if work is None or len(work.values) != len(found.values):
        return [], []
    row = ["points", *(str(round(float(one))) for one in work.values)]
    words = "points: evaluations of the right-hand side of the equations of motion"
    return [row], paragraph(words)


def _miss(value: float) -> str:
    if not np.isfinite(value):
        return "-"
    shown = show(value, _ROUNDING, digits=3)
    return shown if shown.startswith("-") or shown == "0" else f"+{shown}"
