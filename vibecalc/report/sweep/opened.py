"""The open file of a sweep as what the report reads."""

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from vibecalc.errors import UnitError
from vibecalc.report.sweep.view import GridAxis, Key, Stacked, SweepView
from vibecalc.results.layout import TEXT_CHECKSUM
from vibecalc.results.record import Quantity
from vibecalc.results.sweep_file import StackedQuantity, SweepResult
from vibecalc.results.sweep_layout import SAMPLE
from vibecalc.results.sweep_record import SweptKey
from vibecalc.units import convert

#: words that more than one table has, and the tables that say whose they are
_SHARED = frozenset({"inertia", "stiffness", "damping", "torque", "gain"})
_OWNERS = frozenset({"rotor", "shell", "motor", "friction", "control"})


def view_of(result: SweepResult) -> SweepView:
    """The view of a sweep; its results are read from the file one by one, when asked for."""
    head = result.head
    swept = [key for axis in head.axes for key in axis.keys]
    words = _short([key.key for key in swept], head.result.case)
    keys = tuple(_key(key, name) for key, name in zip(swept, words, strict=True))
    sampled = [axis.name for axis in head.axes] == [SAMPLE]
    columns = [np.stack(axis.read(0, axis.count), axis=1).astype(float) for axis in head.axes]
    groups = _groups([1] * len(keys)) if sampled else _groups([len(a.keys) for a in head.axes])
    if sampled:
        groups = _groups([len(table) for table in head.design["axes"]])
    grid = [
        GridAxis(tuple(keys[place] for place in group), values)
        for group, values in zip(groups, columns, strict=False)
    ]
    failures = result.failures()
    reasons = {
        int(point): failures.texts[int(cause)]
        for point, cause in zip(failures.points, failures.causes, strict=True)
    }
    return SweepView(
        name=head.result.name,
        case=head.result.case,
        sampling=head.sampling,
        keys=keys,
        grid=() if sampled else tuple(grid),
        drawn=columns[0] if sampled else None,
        together=groups,
        indices=bool(head.design.get("indices")),
        status=result.status().ravel(),
        message=lambda point: reasons.get(point, ""),
        kept={path: _described(quantity) for path, quantity in result.quantities.items()},
        read=lambda path: _read(result.quantities[path], result.count),
        facts=(
            ("sha256 of the case", head.result.case_sha256),
            ("sha256 of the sweep", head.identity),
            ("vibecalc", head.result.version),
        ),
        left_out=result.left_out,
        provenance=_provenance(head.result.provenance),
    )


def _groups(sizes: list[int]) -> tuple[tuple[int, ...], ...]:
    ends = np.cumsum([0, *sizes]).tolist()
    return tuple(tuple(range(start, stop)) for start, stop in pairwise(ends))


def _key(key: SweptKey, words: str) -> Key:
    if key.choices:
        return Key(key.key, words, "", 1.0, key.choices)
    try:
        factor, unit = convert(1.0, key.unit, key.written_unit), key.written_unit
    except UnitError:
        factor, unit = 1.0, key.unit
    return Key(key.key, words, unit, factor, ())


def _short(keys: list[str], case: Mapping[str, Any]) -> list[str]:
    """The shortest end of each key that no other key has, and whose it is where many have such."""
    parts = [key.split(".") for key in keys]
    names = []
    for mine, own in enumerate(parts):
        others = [other for place, other in enumerate(parts) if place != mine]
        sizes = range(1, len(own) + 1)
        size = next((n for n in sizes if all(o[-n:] != own[-n:] for o in others)), len(own))
        if size == 1 and own[-1] in _SHARED and own[-2:-1] and own[-2] in _OWNERS:
            size = 2
        owner = _member(own[:-1], case) if size == 2 else ""
        mark = " " if size == 2 and own[-2] in _OWNERS else "."
        words = f"{own[-1]} of {owner}" if owner else mark.join(own[-size:])
        names.append(words.replace("_", " "))
    return names


def _member(parts: Sequence[str], case: Mapping[str, Any]) -> str:
    """The name that the case gives to a member of a list, `cylinders[0]`; empty if it has none."""
    found: Any = case
    for part in parts:
        match = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", part)
        if match is None or not isinstance(found, Mapping):
            return ""
        found = found.get(match[1])
        if match[2] is not None:
            inside = isinstance(found, list | tuple) and int(match[2]) < len(found)
            found = found[int(match[2])] if inside else None
    indexed = bool(parts) and parts[-1].endswith("]")
    return str(found.get("name") or "") if indexed and isinstance(found, Mapping) else ""


def _described(quantity: StackedQuantity) -> Quantity:
    """All but the values."""
    return Quantity(
        path=quantity.path,
        values=np.empty(0),
        unit=quantity.unit,
        long_name=quantity.long_name,
        axes=quantity.axes,
        amplitude=quantity.amplitude,
        error_estimate=quantity.error_estimate,
        standard_error=quantity.standard_error,
    )


def _read(quantity: StackedQuantity, count: int) -> Stacked:
    own = tuple(len(axis.values) for axis in quantity.axes)
    spread = quantity.standard_errors()
    return Stacked(
        quantity.values().reshape(count, *own),
        quantity.errors().reshape(count),
        None if spread is None else spread.reshape(count),
    )


def _provenance(given: Any) -> dict[str, Any]:
    return {name: value for name, value in given.items() if name != TEXT_CHECKSUM}
