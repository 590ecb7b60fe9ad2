"""The keys a sweep may vary: numbers, choices and names of this case, written or left out."""

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from vibecalc.case.overrides import get_key, key_text, parse_key
from vibecalc.case.walk import Shape, keys_of, shape_at, words
from vibecalc.errors import KeyPath, UsageError

VARIED = (
    *("machine", "kinematics", "excitation", "response", "isolation", "measurement"),
    *("tuning", "damper_design", "accuracy"),
)
_LISTED = 64  # entries of a list whose keys are offered as the nearest ones


def target(key: str, resolved: Mapping[str, Any]) -> tuple[KeyPath, Shape]:
    """Path and shape of a key that a sweep may vary; UsageError, with the nearest key, if not.

    `resolved` is the case in SI with its defaults. The table of the key has to be there, the key
    itself may be absent.
    """
    path = parse_key(key)
    shape = shape_at(path)
    if shape is None:
        raise UsageError(f"a case has no key {key_text(path)}{_nearest(path, resolved)}")
    if path[0] not in VARIED:
        raise UsageError(f"only keys below {', '.join(VARIED)} can vary")
    if shape.kind not in ("number", "whole", "choice", "text"):
        if shape.item is not None and shape.item.kind != "table":
            hint = f"; a key in it is {key_text(path)}[0]"
        else:
            inside = list(_leaves(get_key(resolved, path), path))[:1]
            hint = f"; a key in it is {inside[0]}" if inside else ""
        raise UsageError(f"{key_text(path)} is {words(shape)}, no number and no choice{hint}")
    if not _may_be_added(path, resolved):
        get_key(resolved, path)
    return path, shape


def _may_be_added(path: KeyPath, resolved: Mapping[str, Any]) -> bool:
    """Whether the table of a key is there, or the key is the next entry of a list in such a one."""
    last = path[-1]
    if isinstance(last, str):
        return isinstance(get_key(resolved, path[:-1]), dict)
    shape, table = shape_at(path[:-1]), get_key(resolved, path[:-2])
    if shape is None or shape.kind != "list" or not isinstance(table, dict):
        return False
    return last == len(table.get(path[-2], ()))


def label(path: KeyPath) -> str:
    """What the schema says of a key, for axes of plots; the key itself where it says nothing."""
    for size in range(len(path), 0, -1):
        name, parent = path[size - 1], shape_at(path[: size - 1])
        if isinstance(name, str) and parent is not None and parent.table is not None:
            return keys_of(parent.table)[name].description or key_text(path)
    return key_text(path)


def _nearest(path: KeyPath, resolved: Mapping[str, Any]) -> str:
    known = dict.fromkeys([*_leaves(resolved, ()), *_siblings(path)])
    near = difflib.get_close_matches(key_text(path), known, n=1, cutoff=0.6)
    return f"; did you mean {near[0]}?" if near else ""


def _siblings(path: KeyPath) -> Iterator[str]:
    """Keys of the innermost table on the way that the schema knows, present or not."""
    for size in range(len(path) - 1, 0, -1):
        parent = shape_at(path[:size])
        if parent is not None and parent.table is not None:
            yield from (key_text((*path[:size], name)) for name in keys_of(parent.table))
            return


def _leaves(place: Any, above: KeyPath) -> Iterator[str]:
    """Keys of numbers and choices that are in the case, at or below a place."""
    if above:
        if above[0] not in VARIED:
            return
        shape = shape_at(above)
        if shape is not None and shape.kind in ("number", "whole", "choice"):
            yield key_text(above)
            return
    else:
        shape = None
    entries: list[tuple[str | int, Any]] = []
    if isinstance(place, dict):
        entries = list(place.items())
    elif isinstance(place, list):
        entries = list(enumerate(place[:_LISTED]))
    for name, entry in entries:
        yield from _leaves(entry, (*above, name))
