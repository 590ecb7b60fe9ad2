"""Units and choices that suit a picture: lengths that are small, orders that are many."""

from typing import Any

import numpy as np

from vibecalc.results.record import Axis

_LENGTHS = ((1.0, "m"), (1e3, "mm"), (1e6, "\u00b5m"))


def length_scale(largest: float) -> tuple[float, str]:
    """Factor and unit that give a length in m at least one digit before the point."""
    for factor, unit in _LENGTHS:
        if factor * largest >= 1.0:
            return factor, unit
    return _LENGTHS[-1]


def factor_of(unit: str) -> float:
    """How many of a unit of length are a metre."""
    return next(factor for factor, name in _LENGTHS if name == unit)


def clearance_names(axis: Axis) -> list[str]:
    """Clearances in mm, as legends name them."""
    return [f"play {1e3 * float(value):.4g} mm" for value in axis.values]


def plain_ticks(axis: Any) -> None:
    """1, 2, 5, 10, 20, 50 ... in plain numbers on a logarithmic axis."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def spread_out(count: int, most: int) -> list[int]:
    """At most `most` of `count` places, the first and the last among them."""
    if count <= most:
        return list(range(count))
    return sorted({round(float(place)) for place in np.linspace(0, count - 1, most)})
