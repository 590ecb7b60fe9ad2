"""Finding things in a result: the quantity a row of the case asks for, labels of axes, pieces."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.report.numbers import show
from vibecalc.results.record import Axis, Quantity, Record, Result

START = "optimisation/start/"


def entries(result: Result, table: str) -> tuple[Mapping[str, Any], ...]:
    """The rows of a list of tables of the case (`reference`, `limit`), none if it is absent."""
    rows: Any = result.case.get(table) or ()
    return tuple(rows)


def asked(result: Result, entry: Mapping[str, Any], table: str) -> Quantity:
    """The quantity that a row of the case names; `at = "start"` looks under `START`.

    Raises
    ------
    ResultError
        The result does not have it; the nearest path is named.
    """
    path = str(entry["quantity"])
    if entry.get("at") == "start":
        path = START + path
    if path not in result.record:
        from difflib import get_close_matches

        near = get_close_matches(path, list(result.record), n=1, cutoff=0.5)
        hint = f"; the nearest one is {near[0]}" if near else ""
        raise ResultError(f"a [[{table}]] asks for {path}, which this result does not have{hint}")
    return result.record[path]


def not_found(result: Result, entry: Mapping[str, Any]) -> bool:
    """Whether a row of the case names something of a [[find]] that found nothing."""
    path = str(entry["quantity"])
    names = {f"find/{search['name']}" for search in entries(result, "find")}
    return path not in result.record and path.rsplit("/", 1)[0] in names


@contextmanager
def naming(table: str, entry: Mapping[str, Any]) -> Iterator[None]:
    """Say in a ResultError which row of a list of tables asked for what is not there."""
    try:
        yield
    except ResultError as error:
        row = name_of(str(entry["quantity"]), dict(entry.get("where") or {}))
        source = f" ({entry['source']})" if entry.get("source") else ""
        raise ResultError(f"the [[{table}]] on {row}{source}: {error}") from error


def name_of(quantity: str, where: Mapping[str, Any]) -> str:
    """`path [axis=entry, ...]`, as messages and tables name an entry."""
    picks = ", ".join(f"{axis}={entry}" for axis, entry in where.items())
    return f"{quantity} [{picks}]" if picks else quantity


def labels(axis: Axis) -> list[str]:
    """The entries of an axis as words: names and whole numbers as they are, others shortened."""
    if axis.values.dtype.kind in "iu":
        return [str(int(value)) for value in axis.values]
    if axis.values.dtype.kind == "f":
        return [show(value) for value in axis.values]
    return [str(value) for value in axis.values]


def magnitudes(quantity: Quantity) -> np.ndarray:
    """Real values: the magnitude of what is complex, else the values themselves."""
    values = np.asarray(quantity.values)
    return np.abs(values) if np.iscomplexobj(values) else values


def scalar_of(record: Record, path: str) -> float | None:
    """A scalar quantity as a float, None if the record does not have it as one."""
    quantity = record.quantities.get(path)
    if quantity is None or quantity.axes:
        return None
    return float(magnitudes(quantity))


def along(record: Record, path: str, axis: str) -> tuple[Quantity, np.ndarray] | None:
    """A quantity of the one axis `axis` and that axis' values; None if there is none such."""
    quantity = record.quantities.get(path)
    if quantity is None or [own.name for own in quantity.axes] != [axis]:
        return None
    return quantity, np.asarray(quantity.axes[0].values)


def having(record: Record, path: str, *axes: str) -> Quantity | None:
    """A quantity with just these axes, in this order, and an entry at least; else None."""
    quantity = record.quantities.get(path)
    if quantity is None or tuple(axis.name for axis in quantity.axes) != axes:
        return None
    return quantity if np.size(quantity.values) else None


def speed_of(result: Result) -> float | None:
    """Operating speed in rad/s: of the optimum if it was a variable, else of the case."""
    found = scalar_of(result.record, "optimisation/variable/machine.speed")
    given = table_of(result.case, "machine").get("speed")
    if found is None and isinstance(given, int | float):
        return float(given)
    return found


def table_of(case: Mapping[str, Any], *keys: str) -> Mapping[str, Any]:
    """A table of the case by its keys, empty if it is absent."""
    for key in keys:
        found = case.get(key)
        if not isinstance(found, Mapping):
            return {}
        case = found
    return case
