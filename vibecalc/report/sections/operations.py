"""Energies of every operation with every balance, in one table that can be read across."""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_STEM = "response/operations/"
_AXES = ("operation", "balance")
_KINDS = ("kinetic", "potential")
_PER_TABLE = 3
_WORDS = {"mean": "mean over a turn", "peak": "largest over a turn"}
#: of an energy, and of the ends of its range
_DIGITS, _FEWER = 5, 4
#: ends closer than this share of the value are one number
_SAME = 1e-9


def operations(result: Result) -> Section | None:
    """The section, None if the result compares no operations."""
    record = result.record
    lines, shown = _reading(record), set()
    for kind in _KINDS:
        for what in ("mean", "peak"):
            block, paths = _combinations(record, kind, what)
            lines += ["", *block] if block and lines else block
            shown |= paths
    for kind in _KINDS:
        block, paths = _turning(record, kind)
        lines += ["", *block] if block and lines else block
        shown |= paths
    title = "Operations and balances: energies of every combination"
    return Section(title, lines, frozenset(shown)) if shown else None


def _reading(record: Record) -> list[str]:
    """The one line to read first: which balance is best, by which measure."""
    found = []
    for name, words in (("weighted", "least weighted"), ("difference", "smallest difference of")):
        quantity = having(record, f"{_STEM}kinetic_energy/{name}", "balance")
        if quantity is not None:
            best = int(np.argmin(quantity.values))
            value = show(quantity.values[best], quantity.error_estimate)
            balance = labels(quantity.axes[0])[best]
            found.append(f"{words} kinetic energy: {value} {quantity.unit} with balance {balance}")
    if not found:
        return []
    reach = "in brackets, how far the angle of the balance weights to the pistons can move it"
    return paragraph("; ".join([*found, reach]))


def _combinations(record: Record, kind: str, what: str) -> tuple[list[str], set[str]]:
    stem = f"{_STEM}{kind}_energy/"
    values = having(record, stem + what, *_AXES)
    if values is None:
        return [], set()
    ends = [having(record, f"{stem}{what}_{end}", *_AXES) for end in ("low", "high")]
    sums = []
    if what == "mean":
        sums = [
            (words, quantity)
            for name, words in (("difference", "largest - smallest"), ("weighted", "weighted"))
            if (quantity := having(record, stem + name, "balance")) is not None
        ]
    lines = [f"  {kind.capitalize()} energy, {_WORDS[what]}, {values.unit}"]
    names = labels(values.axes[0])
    for columns, part in _tables(values):
        rows = [[name, *(_cell(values, ends, i, j) for j in part)] for i, name in enumerate(names)]
        below = [[text, *(_short(q.values[j], q) for j in part)] for text, q in sums]
        lines += ["", *table(columns, rows, below)]
    shown = {values.path} | {end.path for end in ends if end is not None}
    return lines, shown | {quantity.path for _, quantity in sums}


def _turning(record: Record, kind: str) -> tuple[list[str], set[str]]:
    """Throws and balance weights without all else that moves: what balancing alone leaves."""
    stem = f"{_STEM}{kind}_energy/rotating_"
    mean, peak = (having(record, stem + what, *_AXES) for what in ("mean", "peak"))
    if mean is None or peak is None:
        return [], set()
    lines = [
        f"  {kind.capitalize()} energy of throws and balance weights, without counterweights and "
        "shafts,",
        f"  mean / largest, {mean.unit}",
    ]
    names = labels(mean.axes[0])
    for columns, part in _tables(mean):
        rows = []
        for i, name in enumerate(names):
            cells = [
                _pair(_short(mean.values[i, j], mean), _short(peak.values[i, j], peak))
                for j in part
            ]
            rows.append([name, *cells])
        lines += ["", *table(columns, rows)]
    return lines, {mean.path, peak.path}


def _tables(quantity: Quantity) -> Iterator[tuple[list[Column], range]]:
    """Columns and places of the balances of each table, as many as fit side by side."""
    balances = labels(quantity.axes[1])
    for first in range(0, len(balances), _PER_TABLE):
        part = range(first, min(first + _PER_TABLE, len(balances)))
        names = (number(f"balance {balances[j]}", 25) for j in part)
        yield [Column("operation", 20), *names], part


def _cell(values: Quantity, ends: Sequence[Quantity | None], i: int, j: int) -> str:
    """The energy, and below it from where to where it goes with the angle of the weights."""
    text = _short(values.values[i, j], values)
    low, high = ends
    if low is None or high is None:
        return text
    least, most = float(low.values[i, j]), float(high.values[i, j])
    doubt = low.error_estimate + high.error_estimate + _SAME * abs(most)
    if most - least <= doubt:
        return text
    ends_text = [
        show(value, end.error_estimate, _FEWER) for value, end in ((least, low), (most, high))
    ]
    return f"{text}\n({ends_text[0]} .. {ends_text[1]})"


def _pair(mean: str, peak: str) -> str:
    return mean if mean == peak == "0" else f"{mean} / {peak}"


def _short(value: float, quantity: Quantity) -> str:
    return show(value, quantity.error_estimate, _DIGITS)
