"""Errors of a kernel told by the kernel: from its data moved by their last bits, and a coarser run.

A result is as uncertain as it moves when the data move by what they are uncertain by, and rounding
inside a kernel acts on it as a change in the last bit of the data does. That takes no formula for
each operation. It does not show a method that stops too early; a coarser run does. Kernels whose
speed counts, as in sweeps, carry a bound of their own (`bounded.py`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF

#: copies of the data that are moved, and how many last bits each number of them by
_COPIES, _BITS = 6, 2.0

_SEED = 1977


def with_errors(
    kernel: Callable[..., Any], *data: Any, coarser: Callable[..., Any] | None = None
) -> Any:
    """What `kernel(*data)` gives, each float or complex array of it as `Bounded`.

    Parameters
    ----------
    kernel : gives an array, or arrays in tuples, mappings and dataclasses.
    data : numbers and arrays, and tuples, mappings and dataclasses of them. Floats and complex
        numbers move, each by two last bits up or down and a `Bounded` by all of its error, whose
        value alone the kernel gets. Integers, texts and whatever else stand as they are.
    coarser : the same with a coarser setting; how far it is off is the error of the method.

    Raises
    ------
    What the kernel raises; also of data that moved.
    """
    own, *moved = copies(*data)
    found = [kernel(*one) for one in (own, *moved)]
    return spread(found, None if coarser is None else coarser(*own))


def copies(*data: Any) -> list[tuple[Any, ...]]:
    """The data without their errors, and copies in which they are moved, as in `with_errors`."""
    from numpy.random import default_rng

    source = default_rng(_SEED)
    return [
        _changed(data, lambda value, _: value),
        *(_changed(data, lambda value, size: _moved(value, size, source)) for _ in range(_COPIES)),
    ]


def spread(results: Sequence[Any], coarser: Any = None) -> Any:
    """The first result, each float or complex array of it as `Bounded`: by how far others are off.

    They are what one kernel gives of `copies` of its data, and what it gives by a coarser setting.
    """
    found, *others = results
    moved = [_numbers(other) for other in others]
    missed = [] if coarser is None else _numbers(coarser)
    place = iter(range(len(_numbers(found))))

    def bounded(value: Any, _: Any) -> Bounded:
        number = next(place)
        error = np.where(np.isfinite(value), UNIT_ROUNDOFF * np.abs(value), 0.0)
        error += np.max([_apart(other[number], value) for other in moved], axis=0)
        if missed:
            error = error + _apart(missed[number], value)
        return Bounded(np.asarray(value), np.asarray(error))

    return _changed(found, bounded)


def _moved(value: Any, error: Any, source: Any) -> Any:
    """A number or array with each entry off by its error, to one side or the other."""
    sides = source.choice([-1.0, 1.0], np.shape(value))
    return value + sides * error


def _apart(value: Any, other: Any) -> Any:
    """Distance of two arrays; of what is infinite in both, none."""
    with np.errstate(invalid="ignore"):
        return np.where(np.equal(value, other), 0.0, np.abs(value - other))


def _changed(data: Any, change: Callable[[Any, Any], Any]) -> Any:
    """Data with `change(value, error)` in place of each float, complex number and `Bounded`."""
    if isinstance(data, Bounded):
        return change(data.value, data.error)
    if isinstance(data, float | complex | np.ndarray | np.generic):
        floating = np.asarray(data).dtype.kind in "fc"
        return change(data, _BITS * EPSILON * np.abs(data)) if floating else data
    if isinstance(data, Mapping):
        return {name: _changed(one, change) for name, one in data.items()}
    if isinstance(data, tuple | list):
        parts = [_changed(one, change) for one in data]
        return type(data)(*parts) if hasattr(data, "_fields") else type(data)(parts)
    if is_dataclass(data) and not isinstance(data, type):
        names = [one.name for one in fields(data) if one.init]
        return replace(data, **{name: _changed(getattr(data, name), change) for name in names})
    return data


def _numbers(data: Any) -> list[Any]:
    """The floats and complex numbers of what a kernel gave, in their order."""
    numbers: list[Any] = []

    def note(value: Any, _: Any) -> Any:
        numbers.append(value)
        return value

    _changed(data, note)
    return numbers
