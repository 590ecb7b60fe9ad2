"""Quantities as rows of comma-separated values, as spreadsheets and shells read them."""

import csv
import io
import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.results.record import Quantity
from vibecalc.core.results.renamed import current_path
from vibecalc.core.results.select import Key, nearest, select
from vibecalc.core.results.visible import text_cell
from vibecalc.errors import MissingQuantity
from vibecalc.units import convert


def missing(result: Mapping[str, Quantity], given: object) -> MissingQuantity:
    """The error that says what a result has instead."""
    path = str(given)
    now = current_path(path)
    if now in result:
        return MissingQuantity(f"there is no {path!r} in this result: it is {now!r} now")
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
    values, axes = np.asarray(quantity.values), quantity.axes
    if not axes and not np.iscomplexobj(values):
        return f"{_text(values.item())}\n"
    name, parts = quantity.path.rpartition("/")[2], {"": values}
    if np.iscomplexobj(values):
        parts = {" real": values.real, " imaginary": values.imag}
    titles = [(axis.name, axis.unit) for axis in axes]
    titles += [(f"{name}{part}", quantity.unit) for part in parts]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([_titled(*one) for one in titles])
    places = itertools.product(*(axis.values for axis in axes))
    for place, *row in zip(places, *(np.ravel(part) for part in parts.values()), strict=True):
        writer.writerow([_text(one) for one in (*place, *row)])
    return stream.getvalue()


def _titled(name: str, unit: str) -> str:
    return text_cell(f"{name} [{unit}]" if unit else name)


def _text(value: Any) -> str:
    """A number with all its digits; a name, marked as a text where it could be a formula."""
    plain = value.item() if isinstance(value, np.generic) else value
    return repr(plain) if isinstance(plain, int | float) else text_cell(str(plain))
