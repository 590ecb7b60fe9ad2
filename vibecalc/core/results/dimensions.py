"""Names of axes as dimensions of a tree of groups, in files and in trees of xarray.

A group hands its dimensions down to the groups in it, so that a name must not stand for two things
there: not for two axes, nor for an axis and a quantity or group.
"""

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import chain, count
from typing import Any

import numpy as np

from vibecalc.core.results.record import Axis


def dimension_names(
    axes: Mapping[str, Sequence[Axis]], outer: Iterable[str] = ()
) -> dict[str, tuple[str, ...]]:
    """Names of the axes of each quantity, by the paths of these.

    Equal axes of one stage share a name. An axis is `order_2` and so on where `order` is another
    axis of its stage, one of the `outer` names, or a quantity or group at or below a place where
    the axis stands.
    """
    below: dict[str, set[str]] = {}
    for path in axes:
        for group in _groups(path):
            inside = path.removeprefix(group).strip("/")
            below.setdefault(group, set()).update(inside.split("/"))
    keys = {id(axis): _key(axis) for own in axes.values() for axis in own}
    places: dict[tuple[Any, ...], set[str]] = {}
    for path, own in axes.items():
        for axis in own:
            found = places.setdefault((stage_of(path), *keys[id(axis)]), set())
            found.add(path.rpartition("/")[0])
    names: dict[tuple[Any, ...], str] = {}
    taken = {"": set(outer)}
    # what stands in no group is handed down to all of them
    for key in sorted(places, key=lambda one: one[0] != ""):
        stage, name = key[:2]
        of_stage = taken.setdefault(stage, set())
        unfit = set(chain(taken[""], of_stage, *(below[folder] for folder in places[key])))
        names[key] = free_name(name, unfit)
        of_stage.add(names[key])
    return {
        path: tuple(names[stage_of(path), *keys[id(axis)]] for axis in own)
        for path, own in axes.items()
    }


def free_name(name: str, taken: Container[str]) -> str:
    """`order`, or `order_2` and so on where that is taken."""
    numbered = (f"{name}_{number}" for number in count(2))
    return next(one for one in chain([name], numbered) if one not in taken)


def stage_of(path: str) -> str:
    """The first group of a path, empty where it stands in none."""
    return path.partition("/")[0] if "/" in path else ""


def _groups(path: str) -> Iterator[str]:
    """The groups around a path, from the root on."""
    parts = path.split("/")
    return ("/".join(parts[:depth]) for depth in range(len(parts)))


def _key(axis: Axis) -> tuple[Any, ...]:
    """What tells an axis from others; axes with equal keys are one."""
    values = np.asarray(axis.values)
    texts = values.dtype.kind in "UOT"
    content = "\0".join(map(str, values)).encode() if texts else values.tobytes()
    return axis.name, axis.unit, axis.long_name, axis.run_samples, values.dtype.str, content
