"""Quantities with names on their axes, as xarray and pandas have them."""

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.results.dimensions import dimension_names
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.errors import UsageError

if TYPE_CHECKING:
    from pandas import DataFrame, Series
    from xarray import DataArray, DataTree


def data_array(quantity: Quantity) -> "DataArray":
    """A quantity with its axes as coordinates; `attrs` say unit, long name, amplitude and error."""
    return _array(quantity, tuple(axis.name for axis in quantity.axes))


def data_tree(result: Mapping[str, Quantity]) -> "DataTree":
    """Quantities by their paths, each group with the coordinates of what stands in it.

    An axis is `order_2` and so on where `order` is another axis of its stage, or a quantity or
    group at or below its place, as in the file.
    """
    names = dimension_names({path: quantity.axes for path, quantity in result.items()})
    groups: dict[str, dict[str, DataArray]] = {}
    for path, quantity in result.items():
        folder, _, name = path.rpartition("/")
        groups.setdefault(f"/{folder}", {})[name] = _array(quantity, names[path])
    datasets = {path: library("xarray").Dataset(one) for path, one in groups.items()}
    tree: DataTree = library("xarray").DataTree.from_dict(datasets)
    return tree


def series(quantity: Quantity) -> "Series[Any]":
    """The entries of a quantity in one column, its index the axes."""
    pandas = library("pandas")
    values = np.asarray(quantity.values)
    if not quantity.axes:
        return pandas.Series([values.item()], name=quantity.path)
    names = [axis.name for axis in quantity.axes]
    if len(names) == 1:
        index = pandas.Index(quantity.axes[0].values, name=names[0])
    else:
        index = pandas.MultiIndex.from_product([a.values for a in quantity.axes], names=names)
    return pandas.Series(values.ravel(), index=index, name=quantity.path)


def data_frame(result: Mapping[str, Quantity]) -> "DataFrame":
    """A row for each quantity; `value` is that of one number, `largest` the largest magnitude."""
    pandas = library("pandas")
    rows = []
    for quantity in result.values():
        values = np.asarray(quantity.values)
        number = values.dtype.kind in "biufc"
        size = np.abs(values[np.isfinite(values)]) if number else np.empty(0)
        rows.append({
            "unit": quantity.unit,
            "value": values.item() if values.ndim == 0 else np.nan,
            "largest": size.max() if size.size else np.nan,
            "error": float(quantity.error_estimate),
            "axes": ", ".join(f"{axis.name} ({len(axis.values)})" for axis in quantity.axes),
            "long_name": quantity.long_name,
        })  # fmt: skip
    table = pandas.DataFrame(rows, index=pandas.Index(list(result), name="path"))
    if table["value"].dtype.kind == "c":  # one complex number makes no other number complex
        table["value"] = pandas.Series([row["value"] for row in rows], table.index, dtype=object)
    return table


def _array(quantity: Quantity, dimensions: tuple[str, ...]) -> "DataArray":
    attributes = {name: one for name, one in quantity.attributes.items() if name != "errors"}
    coordinates = {
        name: (name, _entries(axis), {"units": axis.unit, "long_name": axis.long_name})
        for name, axis in zip(dimensions, quantity.axes, strict=True)
    }
    array: DataArray = library("xarray").DataArray(
        quantity.values,
        coords=coordinates,
        dims=dimensions,
        name=quantity.path,
        attrs=attributes,
    )
    return array


def _entries(axis: Axis) -> np.ndarray:
    values = np.asarray(axis.values)
    return values.astype(np.str_) if values.dtype.kind == "O" else values


def library(name: str) -> Any:
    """A library that only tables need; UsageError where it is not installed."""
    try:
        return import_module(name)
    except ImportError as error:
        raise UsageError(
            f"this needs {name}, which is not installed; "
            "install it with: pip install 'vibecalc[tables]'"
        ) from error
