"""Quantities as rows of comma-separated values, as spreadsheets and shells read them."""

import csv
import io
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.select import Key, nearest, select
from vibecalc.core.results.visible import text_cell
from vibecalc.errors import MissingQuantity
from vibecalc.units import convert


def quantity_at(result: Mapping[str, Quantity], path: str) -> Quantity:
    """The quantity at a path; ResultError, with the paths most like it, if there is none."""
    if path in result:
        return result[path]
    raise missing(result, path)


def missing(result: Mapping[str, Quantity], given: object) -> MissingQuantity:
    """The error that says what a result has instead."""
    path = str(given)
    group = [name for name in result if name.startswith(f"{path.strip('/')}/")]
    known = group or nearest(path, list(result))
    words = f"{path} is a group" if group else f"there is no {path!r}"
    shown = ", ".join(known[:4])
    return MissingQuantity(f"{words} in this result; it has {shown}{' ...' * (len(known) > 4)}")


def picked(quantity: Quantity, where: Mapping[str, Key], unit: str = "") -> Quantity:
    """What `where` leaves of a quantity, in another unit if one is named.

    Raises ResultError as `select` does, UnitError for a unit of another dimension.
    """
    left = replace(
        quantity,
        values=np.asarray(select(quantity, where).values),
        axes=tuple(axis for axis in quantity.axes if axis.name not in where),
    )
    if not unit:
        return left
    size = convert(1.0, quantity.unit, unit)
    return replace(
        left,
        values=left.to(unit),
        unit=unit,
        error_estimate=quantity.error_estimate * size,
        terms=quantity.terms * size,
    )


def comma_separated(quantity: Quantity) -> str:
    """A quantity as text: one number alone, or a table with a column for each axis.

    Numbers have all their digits; of what is complex the real and the imaginary part have a column
    each. The first line names axes and quantity with their units.
    """
    values = np.asarray(quantity.values)
    if not quantity.axes and not np.iscomplexobj(values):
        return f"{_text(values.item())}\n"
    name = quantity.path.rpartition("/")[2]
    return _table(quantity.axes, _columns(name, quantity.unit, values))


def _columns(name: str, unit: str, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if not np.iscomplexobj(values):
        return [(_titled(name, unit), values)]
    parts = (("real", values.real), ("imaginary", values.imag))
    return [(_titled(f"{name} {part}", unit), numbers) for part, numbers in parts]


def _table(axes: Sequence[Axis], columns: Sequence[tuple[str, np.ndarray]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*(_titled(axis.name, axis.unit) for axis in axes), *(t for t, _ in columns)])
    places = itertools.product(*(axis.values for axis in axes))
    numbers = [np.ravel(values) for _, values in columns]
    for place, *row in zip(places, *numbers, strict=True):
        writer.writerow([_text(one) for one in (*place, *row)])
    return stream.getvalue()


def _titled(name: str, unit: str) -> str:
    return text_cell(f"{name} [{unit}]" if unit else name)


def _text(value: Any) -> str:
    """A number with all its digits; a name, marked as a text where it could be a formula."""
    plain = value.item() if isinstance(value, np.generic) else value
    return repr(plain) if isinstance(plain, int | float) else text_cell(str(plain))
