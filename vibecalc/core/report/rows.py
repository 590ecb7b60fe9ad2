"""Tables as descriptions: which results stand in the columns over an axis, and the one renderer.

A `Rows` stands as data in the `report.py` of a subject. What a result lacks is left out; without
any of its columns there is no table.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import (
    by_size,
    labels,
    magnitudes,
    merged,
    read_as,
    turns_of,
    written,
)
from vibecalc.core.report.writing import DIGITS, Column, number, paragraph, show, table
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Axis, Estimate, Quantity, Record, Result
from vibecalc.numerics.rounding import first_of_largest

# ----------------------------------------------------------------------------
# What stands in a description.
# ----------------------------------------------------------------------------

Found = Sequence[Quantity]
#: the unit that a value is read in, or a function that writes a value in SI with its error
How = str | Callable[[Any, Estimate], str]
Made = Callable[[Record], Quantity | None]


#: the heading that a result has by itself
OWN = "*"


class Cells(NamedTuple):
    """A column: a result below the root of its table, or what a function makes of the record.

    Without a `head` it is the name of the result, else the last word of its path, in the unit that
    people read; "" is none.
    Of a result with a second axis each entry of that is a column, whose name stands for `{}` in the
    `head`; its unit stands at `{unit}`, the larger one that people read where values are large.
    Words stand at the left, numbers and what is said to at the `right`. The `note` stands below the
    table. With `blank` an infinite entry is none, shown as "-".
    """

    of: str | Made
    head: str = OWN
    how: How = ""
    note: str = ""
    blank: bool = False
    right: bool = False


class Rows(NamedTuple):
    """A table with a row for each entry of `axis`, below the `title` of their names.

    `axis` may name several axes by blanks, whose entries are of one kind: "mount station".
    `label` formats the names, such as "{:g}", or is a function that writes them,
    and `right` sets them like numbers; without a `title` they are left out. At `{turn}` in it, or
    in a head, stands `a turn`, or `two turns` where half orders act. `places` says which
    entries are shown, `rest` what is said of the others, `none` what if there is none to show.
    A column that is but a path is a `Cells` of that; `note` is said of all of them.
    Words `above` stand over the table; an `acting` one has no columns of zeros.
    `merge` makes one row of equal ones; `across` turns the table: a row for each result, with its
    unit at the end, of entries along a second axis the largest with its name.
    """

    axis: str
    title: str
    columns: Sequence[Cells | str]
    root: str = ""
    label: str | Callable[[Any], str] = ""
    right: bool = False
    digits: int = DIGITS
    places: Callable[[Found], np.ndarray] | None = None
    rest: Callable[[Found, np.ndarray], str] | None = None
    none: str = ""
    merge: bool = False
    across: bool = False
    note: str = ""
    above: str = ""
    acting: bool = False


def whole(value: Any, _error: float) -> str:
    """A whole number."""
    return str(int(value))


def short(value: Any, _error: float) -> str:
    """A number without zeros at its end, such as an order."""
    return f"{value:g}"


def in_decibels(value: Any, _error: float = 0.0) -> str:
    """The level of a ratio in dB, `-` of nothing and of what has no bound."""
    return f"{20.0 * math.log10(abs(value)):.2f}" if 0.0 < abs(value) < math.inf else "-"


def over_natural(distance: Any, _error: float) -> str:
    """Frequency of an order over the natural one, from its distance, which is that less 1."""
    return show(1.0 + distance) if math.isfinite(distance) else "-"


def percent(decimals: int) -> How:
    """A share in percent without its unit, `-` where it is undefined."""

    def written(value: Any, _error: float) -> str:
        return f"{round(100.0 * value, decimals) + 0.0:.{decimals}f}" if np.isfinite(value) else "-"

    return written


def part_of(quantity: Quantity, values: np.ndarray, *axes: Axis) -> Quantity:
    """Other values made of those of a quantity, with its error and the size of its terms."""
    return replace(quantity, values=values, axes=axes, terms=quantity.estimate.terms)


def derived(path: str, make: Callable[[Quantity], Quantity | None]) -> Made:
    """What a function makes of the result at a path; none without it."""

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(path)
        return None if found is None else make(found)

    return made


def reduced(path: str, by: Callable[..., np.ndarray] = np.linalg.norm) -> Made:
    """Lengths of vectors that stand along the second axis, or what `by` makes of their entries."""

    def lengths(found: Quantity) -> Quantity | None:
        if len(found.axes) != 2:
            return None
        return part_of(found, by(magnitudes(found), axis=1), found.axes[0])

    return derived(path, lengths)


def chosen(
    of: Made, places: Callable[[Found], np.ndarray], *by: Made
) -> Callable[[Result], Quantity | None]:
    """For pictures: a quantity at those entries of its axis that `places` chooses of others."""

    def made(result: Result) -> Quantity | None:
        found = [one for each in (of, *by) if (one := each(result.record)) is not None]
        if len(found) <= len(by):
            return None
        there, (axis,) = places(found[1:]), found[0].axes
        axis = replace(axis, values=axis.values[there])
        return replace(found[0], path="", values=found[0].values[there], axes=(axis,))

    return made


def named_at(path: str, of: str) -> Made:
    """Names of the first axis of the quantity `of` in place of numbers, from 1, at `path`."""

    def made(record: Record) -> Quantity | None:
        numbers, known = record.quantities.get(path), record.quantities.get(of)
        if numbers is None or known is None:
            return None
        names = np.array(labels(known.axes[0]))
        return part_of(numbers, names[numbers.values.astype(int) - 1], *numbers.axes)

    return made


def first(most: int) -> Callable[[Found], np.ndarray]:
    """The first entries."""
    return lambda found: np.arange(len(found[0].values))[:most]


def evenly(most: int) -> Callable[[Found], np.ndarray]:
    """So many entries, evenly spread from the first to the last."""

    def places(found: Found) -> np.ndarray:
        return np.unique(np.linspace(0, len(found[0].values) - 1, most).round().astype(int))

    return places


def loud(share: float, most: int, count: int = 1) -> Callable[[Found], np.ndarray]:
    """The first entries where one of the first `count` columns has that `share` of the largest."""

    def places(found: Found) -> np.ndarray:
        sizes = np.array([np.where(one.zero, 0.0, np.abs(one.values)) for one in found[:count]])
        large = (sizes > 0.0) & (sizes >= share * np.max(sizes))
        return np.flatnonzero(np.any(large, axis=0))[:most]

    return places


OTHERS = "the other {left} orders are zero or weaker, and in the result file"


def others(words: str, *, acting: bool = False) -> Callable[[Found, np.ndarray], str]:
    """Words on the {left} other entries up to the {last}, or on those that are not zero."""

    def said(found: Found, places: np.ndarray) -> str:
        left = (np.count_nonzero(~found[0].zero) if acting else len(found[0].values)) - len(places)
        last = labels(found[0].axes[0])[-1]
        return words.format(left=left, shown=len(places), last=last) if left else ""

    return said


def left_out(root: str) -> Rows:
    """The speeds left out of a run-up."""
    note = "speeds left out: an order on an undamped natural frequency, where there is no bound"
    ends = Cells("low", "from rpm", "rpm"), Cells("high", "to rpm", "rpm")
    return Rows("resonance_skipped", "", ("order", "mode", *ends), root, digits=7, note=note)


# ----------------------------------------------------------------------------
# The renderer.
# ----------------------------------------------------------------------------


def rows_of(record: Record, of: Rows) -> tuple[list[str], set[str]]:
    """Lines of a table with its notes, and the paths that it shows."""
    columns = [Cells(one) if isinstance(one, str) else one for one in of.columns]
    given = [(one, quantity) for one in columns if (quantity := _found(record, of, one))]
    found = [(_headed(one, quantity, of.across), quantity) for one, quantity in given]
    quantities = [quantity for _, quantity in found]
    paths = {quantity.path for quantity in quantities}
    if not found:
        return [], paths
    axis = quantities[0].axes[0]
    places = np.arange(len(axis.values)) if of.places is None else of.places(quantities)
    if not len(places):
        return paragraph(of.none) if of.none else [], paths
    write_name = of.label.format if isinstance(of.label, str) else of.label
    names = [write_name(one) for one in axis.values] if of.label else labels(axis)
    cells, notes = [[names[i] for i in places]], list[str]()
    heads: list[Column | str] = [Column(_turned(of.title, quantities[0], record), right=of.right)]
    for one, quantity in found:
        write, kind = _writer(quantity, one, of.digits), quantity.values.dtype.kind
        there, own = _there(axis, quantity.axes[0], places), list[list[str]]()
        if of.across and len(quantity.axes) > 1:
            own.append([_largest(quantity, i, write) for i in there])
        else:
            for entries in quantity.values.reshape(len(quantity.values), -1).T:
                own.append(["" if i is None else write(entries[i].item()) for i in there])
        for name in labels(quantity.axes[1]) if len(quantity.axes) > 1 else [""]:
            head = one.head.format(name, unit=_unit(quantity, one)).rstrip()
            plain = callable(one.how) and not one.right
            heads.append(head if plain else Column(head, right=one.right or kind not in "UO"))
        notes += [one.note] * any(map(any, own))
        cells += own
    if of.across:
        units = [_unit(quantity, one) for one, quantity in found]
        cells = [[one.head for one, _ in found], *map(list, zip(*cells[1:], strict=True)), units]
        heads = [heads[0], *map(number, names), Column("unit")]
    start = 0 if of.title else 1
    lines = [list(row) for row in zip(*cells[start:], strict=True)]
    notes += [of.note, of.rest(quantities, places) if of.rest else ""]
    below = [line for words in notes if words for line in paragraph(words)]
    above = paragraph(of.above) if of.above else []
    return [*above, *table(heads[start:], merged(lines) if of.merge else lines), *below], paths


def _turned(words: str, quantity: Quantity, record: Record) -> str:
    return words.replace("{turn}", turns_of(record, quantity.path)) if "{turn}" in words else words


def _found(record: Record, of: Rows, one: Cells) -> Quantity | None:
    """What stands in a column, if it is over the axis of the table and has an entry.

    Of two axes that of the table may be the second one.
    """
    path = f"{of.root}/{one.of}" if of.root else one.of
    quantity = one.of(record) if callable(one.of) else record.quantities.get(str(path))
    if quantity is None or not quantity.axes:
        return None
    if len(quantity.axes) == 2 and quantity.axes[1].name in of.axis.split():
        quantity = replace(quantity, values=quantity.values.T, axes=quantity.axes[::-1])
    named = of.across and quantity.axes[-1].values.dtype.kind not in "biuf"
    if len(quantity.axes) - 1 not in ({0, 1} if named else {one.head.count("{}")}):
        return None
    there = quantity.axes[0].name in of.axis.split() and np.size(quantity.values)
    return quantity if there and (not of.acting or np.count_nonzero(quantity.values)) else None


#: last words of the paths of what is counted
_COUNTED = ("order", "mode")


def _headed(one: Cells, quantity: Quantity, across: bool) -> Cells:
    """The column with a heading of its own: the words and the unit of its result."""
    if one.head != OWN:
        return one
    name, unit = quantity.path.rpartition("/")[2], read_as(quantity.path, quantity.unit)[1]
    known = CATALOGUE.get(quantity.path)
    how = one.how or (short if name.endswith(_COUNTED) else unit)
    told = "" if known is None else known.name
    head = told or name.replace("_", " ").replace("run up", "run-up")
    return one._replace(head=head if across else f"{head} {unit}".rstrip(), how=how)


def _largest(quantity: Quantity, place: int | None, write: Callable[[Any], str]) -> str:
    """That of the entries along the second axis with its name, which a zero has not."""
    if place is None:
        return ""
    top = first_of_largest(magnitudes(quantity)[place])
    text = write(quantity.values[place, top].item())
    return text if text == "0" else f"{text} {labels(quantity.axes[1])[top]}"


def _unit(quantity: Quantity, one: Cells) -> str:
    unit = one.how if isinstance(one.how, str) and one.how else quantity.unit
    return by_size(unit, quantity.values) if "{unit}" in one.head else unit


def _there(axis: Axis, own: Axis, places: np.ndarray) -> list[int | None]:
    """Where the entries shown of the table's axis stand in a column; None where it lacks one."""
    if np.array_equal(own.values, axis.values):
        return list(places)
    known = {entry: i for i, entry in enumerate(own.values.tolist())}
    return [known.get(entry) for entry in axis.values[places].tolist()]


def _writer(quantity: Quantity, one: Cells, digits: int) -> Callable[[Any], str]:
    """What writes the values of a column."""
    how, plain = one.how, written(quantity, _unit(quantity, one), digits)

    def text(value: Any) -> str:
        if one.blank and not isinstance(value, str) and not np.isfinite(value):
            return "-"
        return how(value, quantity.estimate) if callable(how) else plain(value)

    return text


def by_name(
    record: Record, title: str, names: Mapping[str, tuple[str, ...]], columns: Sequence[Cells],
    root: str,
) -> tuple[list[str], set[str]]:  # fmt: skip
    """A table of scalars with their units: a row for each name, whose parts stand in the paths.

    The path of a cell is that of its column below the root, with the parts at its braces.
    """
    rows, paths = [], set[str]()
    for name, parts in names.items():
        found = [record.quantities.get(f"{root}/{str(one.of).format(*parts)}") for one in columns]
        cells = []
        for one, quantity in zip(columns, found, strict=True):
            text = _writer(quantity, one, DIGITS)(quantity.values.item()) if quantity else ""
            unit = "" if quantity is None or callable(one.how) else _unit(quantity, one)
            cells.append(f"{text} {unit}".strip())
            paths |= {quantity.path} if quantity else set()
        rows += [[name, *cells]] * any(found)
    heads = (one.head.replace("{turn}", turns_of(record, f"{root}/")) for one in columns)
    return table((title, *map(number, heads)), rows), paths
