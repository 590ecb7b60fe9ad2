"""Brings two quantities onto the same entries, by the labels on their axes."""

import itertools
from typing import NamedTuple

import numpy as np

from vibecalc.results.record import Axis, Quantity
from vibecalc.results.select import LABEL_RTOL, entry_text


class Entries(NamedTuple):
    """Compared entries, flat: labels, reference, value, how far apart, and how far they may be."""

    labels: tuple[str, ...]
    reference: np.ndarray
    value: np.ndarray
    difference: np.ndarray
    allowed: np.ndarray


class Aligned(NamedTuple):
    """Two arrays over the same axes, and what had to be left out of either."""

    reference: np.ndarray
    value: np.ndarray
    axes: tuple[Axis, ...]
    problems: tuple[str, ...]


def align(reference: Quantity, value: Quantity, free: str | None = None) -> Aligned:
    """Entries that both have, in the order of the reference; axis names are the same in both.

    The axis named `free` is put first and left as it is in either array (it is not in `axes`).
    """
    left, right = np.asarray(reference.values), np.asarray(value.values)
    axes: list[Axis] = []
    problems: list[str] = []
    first = None
    for position, (one, other) in enumerate(zip(reference.axes, value.axes, strict=True)):
        if one.name == free:
            first = position
            continue
        from_left, from_right = match_labels(one.values, other.values)
        problems += _left_out(one, from_left, "is missing")
        problems += _left_out(other, from_right, "is not in the reference")
        left = left.take(from_left, axis=position)
        right = right.take(from_right, axis=position)
        kept = np.asarray(one.values)[from_left]
        axes.append(Axis(name=one.name, values=kept, unit=one.unit, long_name=one.long_name))
    if first is not None:
        left, right = np.moveaxis(left, first, 0), np.moveaxis(right, first, 0)
    return Aligned(left, right, tuple(axes), tuple(problems))


def match_labels(left: np.ndarray, right: np.ndarray) -> tuple[list[int], list[int]]:
    """Positions of equal labels: names exactly, numbers within 1e-9 of the larger one.

    A label that occurs twice is matched in order of occurrence.
    """
    if left.dtype.kind not in "biuf" or right.dtype.kind not in "biuf":
        return _match_names([str(name) for name in left], [str(name) for name in right])
    order_left, order_right = np.argsort(left, kind="stable"), np.argsort(right, kind="stable")
    pairs: list[tuple[int, int]] = []
    i = j = 0
    while i < len(left) and j < len(right):
        x, y = float(left[order_left[i]]), float(right[order_right[j]])
        if abs(x - y) <= LABEL_RTOL * max(abs(x), abs(y)):
            pairs.append((int(order_left[i]), int(order_right[j])))
            i, j = i + 1, j + 1
        elif x < y:
            i += 1
        else:
            j += 1
    pairs.sort()
    return [one for one, _ in pairs], [other for _, other in pairs]


def labels(axes: tuple[Axis, ...], prefix: str = "") -> tuple[str, ...]:
    """One label per entry of an array over `axes`, in C order."""
    texts = [
        [f"{axis.name}={entry_text(axis, position)}" for position in range(len(axis.values))]
        for axis in axes
    ]
    start = [prefix] if prefix else []
    return tuple(", ".join([*start, *parts]) for parts in itertools.product(*texts))


def _match_names(left: list[str], right: list[str]) -> tuple[list[int], list[int]]:
    places: dict[str, list[int]] = {}
    for position, name in enumerate(right):
        places.setdefault(name, []).append(position)
    pairs = [
        (position, places[name].pop(0)) for position, name in enumerate(left) if places.get(name)
    ]
    return [one for one, _ in pairs], [other for _, other in pairs]


def _left_out(axis: Axis, kept: list[int], words: str) -> list[str]:
    lost = sorted(set(range(len(axis.values))) - set(kept))
    if not lost:
        return []
    more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
    return [f"{axis.name}={entry_text(axis, lost[0])}{more} {words}"]
