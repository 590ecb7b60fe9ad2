"""What stands in a description of a picture: text, quantities over an axis and parts of them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.report.canvas import unit_words, waves
from vibecalc.core.report.sections import labels
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# What stands in a description: text or a function of the result, a path or what is made of one.
# ----------------------------------------------------------------------------

Words = str | Callable[[Result], str]
Source = str | Callable[[Result], Quantity | None]
Number = str | Callable[[Result], Any]
Look = Mapping[str, Any]
Ends = tuple[float | None, float | None]

_ICE = 273.15
#: units of axes that are read in others, and words below an axis
READ_IN = {"rad": "deg", "rad/s": "rpm", "m": "mm"}
_BELOW = {
    "speed": "crank speed in rpm",
    "order": "order, multiple of the crank speed",
}
#: s, a time up to which it is read in ms
_SHORT = 0.1


def said(words: Words, result: Result) -> str:
    """Text, or what a function makes of a result."""
    return words if isinstance(words, str) else words(result)


def sourced(source: Source, result: Result) -> Quantity | None:
    """The quantity at a path or of a function; None if there is none over an axis."""
    found = result.record.quantities.get(source) if isinstance(source, str) else source(result)
    return found if found is not None and found.axes and np.size(found.values) else None


def across(axis: Axis) -> tuple[np.ndarray, str]:
    """Places on the page of the values of an axis, and the words below them."""
    words = axis.long_name or axis.name.replace("_", " ")
    if axis.values.dtype.kind not in "biuf":
        return np.arange(len(axis.values), dtype=float), words
    values = np.asarray(axis.values, dtype=float)
    if axis.unit == "K":
        return values - _ICE, f"{words} in $\\degree$C"
    unit = READ_IN.get(axis.unit, axis.unit)
    if unit == "s":
        unit = "s" if np.max(np.abs(values), initial=0.0) > _SHORT else "ms"
        words = "time"
    return values * convert(1.0, axis.unit, unit), _BELOW.get(
        axis.name, f"{words} in {unit_words(unit)[1]}" if unit else words
    )


def over_turn(path: str, pick: Callable[[np.ndarray], Any] = np.isfinite) -> Source:
    """Harmonics of the orders that `pick` says, summed over the crank angle; halves: two turns."""

    def made(result: Result) -> Quantity | None:
        found = sourced(path, result)
        if found is None:
            return None
        order = np.asarray(found.axes[-1].values, dtype=float)
        chosen, turns = np.flatnonzero(pick(order)), 2 if np.any(order % 1.0) else 1
        angle = np.linspace(0.0, 2.0 * np.pi * turns, max(721, int(16 * turns * order.max()) + 1))
        values = np.real(np.asarray(found.values)[..., chosen] @ waves(order[chosen], angle))
        axis = Axis(name="crank_angle", values=angle, unit="rad", long_name="crank angle")
        return replace(found, path="", values=values, axes=(*found.axes[:-1], axis), terms=0.0)

    return made


def entry_of(path: Source, pick: int | Callable[[Result], Any] | None) -> Source:
    """A quantity with one entry of its first axis, or some, at the places that `pick` gives."""

    def made(result: Result) -> Quantity | None:
        found = sourced(path, result)
        i = None if found is None else pick(result) if callable(pick) else pick
        if found is None or i is None:
            return None
        only = replace(found.axes[0], values=found.axes[0].values[np.atleast_1d(i)])
        return replace(found, values=found.values[np.atleast_1d(i)], axes=(only, *found.axes[1:]))

    return made


def of_freedoms(path: str, turning: bool) -> Source:
    """The entries along x, y and z of a quantity over six freedoms, or those about these axes."""

    def pick(result: Result) -> Any:
        names = labels(result.record[path].axes[0])
        return np.flatnonzero([name.startswith("r") == turning for name in names])

    return entry_of(path, pick)
