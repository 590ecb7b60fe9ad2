"""What to change on the machine to lower each harmonic of the shell, from machines so changed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import having, labels
from vibecalc.core.report.writing import Column, decibels, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

ROLL = "response/roll/"
SHELL = ROLL + "shell_acceleration"
#: the machines of the result are changed by so many percent
PERCENT = 10
_STRONGEST = 3
_THOSE = "the zero orders"
#: a smaller effect, in dB, is no advice
_WORTH = 0.005
#: behind a change whose effect has another sign than a small change of the same kind
_CURVED = " (curved)"

#: names of parameters, where they are not words already
_WORDS = {
    "reciprocating_mass": "piston mass",
    "shell_stiffness": "mount stiffness",
    "shell_damping": "mount damping",
    "friction_damping": "viscous friction",
}


class Changes(NamedTuple):
    """What ten percent more and ten percent less of each parameter do to each harmonic.

    `values` (2, parameters, orders) are changes of level in dB, first for more, then for less, zero
    where they are within their error and NaN where such a machine has no running state. `words`
    are those of the parameters, `acts` says which `orders` the shell has.

    `wakes` (parameters,) says which are of one cylinder alone where others are alike: harmonics
    that are zero by symmetry appear when these change, and no change in dB can tell it. `curved`
    (2, parameters, orders) says where a small change of the same kind does the opposite.
    """

    values: np.ndarray
    words: list[str]
    orders: np.ndarray
    acts: np.ndarray
    wakes: np.ndarray
    curved: np.ndarray


def changes(result: Result) -> Changes | None:
    """The changes of the levels; None if the result has none."""
    record = result.record
    stem = ROLL + "sensitivity/"
    both = [
        having(record, f"{stem}ten_percent_{word}", "parameter", "order")
        for word in ("more", "less")
    ]
    given = [one for one in both if one is not None]
    if not given:
        return None
    slopes = having(record, f"{stem}level", "parameter", "order")
    tables = [one for one in (slopes, *given) if one is not None]
    names = list(dict.fromkeys(str(name) for one in tables for name in labels(one.axes[0])))
    # harmonics that are zero have no change in dB, and need not be among the orders
    level = having(record, ROLL + "level/shell_acceleration", "order")
    known = [] if level is None else [level.axes[0].values]
    orders = np.unique(np.concatenate([*(one.axes[1].values for one in given), *known]))
    acts = shell_acts(record, orders)
    values = np.stack([_spread(one, names, orders) for one in both])
    values = np.where(acts | np.isnan(values), values, 0.0)
    small = np.nan_to_num(_spread(slopes, names, orders))
    signs = np.stack([small, -small]) * np.nan_to_num(values) < 0.0
    return Changes(
        values,
        [parameter_words(name) for name in names],
        orders,
        acts,
        np.array([" " in name for name in names]) & (not acts.all()),
        signs,
    )


def _spread(quantity: Quantity | None, names: list[str], orders: np.ndarray) -> np.ndarray:
    """Values (names, orders), zero within the error; rows that are not there are NaN."""
    values = np.full((len(names), len(orders)), np.nan)
    if quantity is None:
        return values
    rows = [names.index(str(name)) for name in labels(quantity.axes[0])]
    values[rows] = 0.0
    given = np.asarray(quantity.axes[1].values)
    effect = np.asarray(quantity.values, dtype=float)
    seen = np.isfinite(effect) & (np.abs(effect) > known_error(quantity))
    there = np.isin(given, orders)
    places = np.searchsorted(orders, given[there])
    values[np.ix_(np.array(rows), places)] = np.where(seen, effect, 0.0)[:, there]
    return values


def advice(result: Result) -> list[str]:
    """For each order the changes that lower it most, and what they do to the other orders."""
    effects = changes(result)
    if effects is None:
        return []
    level = having(result.record, ROLL + "level/shell_acceleration", "order")
    columns = (
        number("order"),
        number("level dB"),
        Column("measure"),
        number("by dB"),
        Column("raises orders"),
    )
    rows = [row for j in range(len(effects.orders)) for row in _rows(effects, j, level)]
    curved = any(_CURVED in cell for row in rows for cell in row)
    return [
        *paragraph(f"Measures to lower each harmonic of the shell, {PERCENT} % of one parameter:"),
        *_all_orders(effects),
        *_missing(effects, result.record),
        *table(columns, rows),
        *paragraph(
            "by dB: each change solved anew; effects neither add nor scale, so compute combined or "
            "larger changes by a run or sweep; -6 dB halves the amplitude"
            + ("; curved: a small change has the opposite effect" if curved else "")
        ),
    ]


def _rows(effects: Changes, j: int, level: Quantity | None) -> list[list[str]]:
    order = str(int(effects.orders[j]))
    shown = (
        "" if level is None else decibels(_at(level, int(effects.orders[j])), bool(effects.acts[j]))
    )
    if not effects.acts[j]:
        return [[order, shown, "zero", "", ""]]
    effect = effects.values[:, :, j]
    places = [(side, i) for i in range(effect.shape[1]) for side in (0, 1)]
    lowering = [place for place in places if effect[place] <= -_WORTH]
    strongest = sorted(lowering, key=lambda place: float(effect[place]))[:_STRONGEST]
    if not strongest:
        return [[order, shown, "no noticeable effect", "", ""]]
    rows = []
    for place, (side, i) in enumerate(strongest):
        head = [order, shown] if place == 0 else ["", ""]
        words = change(effects.words[i], side) + (_CURVED if effects.curved[side, i, j] else "")
        rows.append([*head, words, f"{effect[side, i]:.2f}", _raised(effects, side, i)])
    return rows


def change(words: str, side: int) -> str:
    """`10 % more rotor inertia`, or for a `side` of 1 less of it."""
    return f"{PERCENT} % {'less' if side else 'more'} {words}"


def _raised(effects: Changes, side: int, i: int) -> str:
    up = effects.values[side, i] >= _WORTH
    words = [joined(effects.orders[up])] if up.any() else []
    words += [_THOSE] if effects.wakes[i] else []
    return ", ".join(words) or "none"


def joined(orders: Sequence[int] | np.ndarray) -> str:
    """`1, 4 to 9`: ascending orders, three neighbours or more joined."""
    whole = [int(order) for order in orders]
    words: list[str] = []
    start = 0
    for i in range(1, len(whole) + 1):
        if i < len(whole) and whole[i] == whole[i - 1] + 1:
            continue
        run = whole[start:i]
        words += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(order) for order in run]
        start = i
    return ", ".join(words)


def _all_orders(effects: Changes) -> list[str]:
    """Changes that lower every harmonic at once."""
    lines = []
    for i, words in enumerate(effects.words):
        for side in (0, 1):
            row = effects.values[side, i, effects.acts]
            if effects.wakes[i] or not row.size or not np.all(row <= -_WORTH):
                continue
            low, high = f"{-row.max():.2f}", f"{-row.min():.2f}"
            by = f"{low} dB" if low == high else f"{low} to {high} dB"
            lines += paragraph(f"{change(words, side)} lowers every harmonic, by {by}", "-")
    return lines


def _missing(effects: Changes, record: Record) -> list[str]:
    """Changes that leave no running state, where such changes were examined at all."""
    words = []
    for side, name in enumerate(("more", "less")):
        if f"{ROLL}sensitivity/ten_percent_{name}" in record:
            gone = np.isnan(effects.values[side]).all(axis=1)
            words += [change(effects.words[i], side) for i in np.flatnonzero(gone)]
    if not words or not effects.orders.size:
        return []
    return paragraph(f"no running state with {', nor with '.join(words)}", "-")


def parameter_words(name: str) -> str:
    """The name of a parameter in words: `rotor inertia`, `piston mass of first stage`.

    A cylinder stands behind the parameter, after a blank.
    """
    key, _, cylinder = name.partition(" ")
    words = _WORDS.get(key, key.replace("_", " "))
    return f"{words} of {cylinder}" if cylinder else words


def _at(level: Quantity, order: int) -> float:
    orders = np.asarray(level.axes[0].values)
    hit = np.flatnonzero(orders == order)
    return float(level.values[hit[0]]) if hit.size else float("nan")


def known_error(quantity: Quantity) -> float:
    """The error estimate; 0 where it is not known, since that hides nothing."""
    error = quantity.error_estimate
    return error if math.isfinite(error) else 0.0


def shell_acts(record: Record, orders: np.ndarray) -> np.ndarray:
    """Whether the shell's acceleration has each of the orders; yes where that is not known."""
    harmonics = having(record, SHELL, "order")
    if harmonics is None:
        return np.ones(orders.shape, dtype=bool)
    known = dict(zip(harmonics.axes[0].values.tolist(), (~harmonics.zero).tolist(), strict=True))
    return np.array([known.get(int(order), True) for order in orders], dtype=bool)


def of_shell(path: str) -> Callable[[Record], Quantity | None]:
    """Levels at a path over the orders of the shell, those that it does not have read as zero."""

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(path)
        if found is None or not found.axes or found.axes[-1].name != "order":
            return None
        acts = shell_acts(record, found.axes[-1].values)
        return replace(found, values=np.where(acts, found.values, -np.inf))

    return made


def level(value: Any, _error: float) -> str:
    """A level in dB, as a column has it."""
    return decibels(value)


def one_row(
    record: Record, stem: str, names: Sequence[tuple[str, str]], title: str, row: str
) -> list[str]:
    """A table of one row: those scalars below a stem that there are."""
    found = [(record[path], words) for name, words in names if (path := stem + name) in record]
    cells = [show(float(one.values), one.error_estimate) for one, _ in found]
    return table([title, *(number(words) for _, words in found)], [[row, *cells]] * bool(found))
