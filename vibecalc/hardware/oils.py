"""An oil from a list: what damping it gives in a gap at a temperature, and which is nearest."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.hardware.gap import RingGap, gap_shares
from vibecalc.hardware.oil_density import oil_density
from vibecalc.hardware.stock import Ranking, rank
from vibecalc.hardware.viscosity import COLDEST, HOTTEST, Walther, kinematic_viscosity
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray

_HALVINGS = 60


class Oil(NamedTuple):
    """Name, viscosity line, density at 15 C in kg/m^3; expansion in 1/K unless a mineral oil."""

    name: str
    line: Walther
    density_at_15: float
    expansion: float | None = None


def dynamic_viscosity(oil: Oil, temperature: ArrayLike) -> WithError:
    """Kinematic viscosity times density in Pa s, at temperatures in K; refuses as the line does."""
    thick = kinematic_viscosity(oil.line, temperature)
    dense = oil_density(oil.density_at_15, temperature, oil.expansion)
    value = thick.value * dense.value
    error = thick.error * dense.value + thick.value * dense.error + UNIT_ROUNDOFF * value
    return WithError(value, error)


def oil_damping(oil: Oil, gap: RingGap, temperature: ArrayLike) -> WithError:
    """Damping in N m s/rad of a gap filled with an oil, at temperatures in K."""
    thick, shares = dynamic_viscosity(oil, temperature), gap_shares(gap).total
    value = thick.value * shares.value
    error = thick.error * shares.value + thick.value * shares.error + UNIT_ROUNDOFF * value
    return WithError(value, error)


def nearest_oils(stock: Sequence[Oil], gap: RingGap, damping: float, temperature: float) -> Ranking:
    """The oils of a list by how near they come, as a ratio, to a damping at a temperature (K).

    An oil that is outside its viscosity line there comes with a damping of zero, last.
    Raises NumericalFailure where none is left.
    """
    offered = np.array([_damping_or_none(oil, gap, temperature) for oil in stock])
    if not np.any(offered):
        raise NumericalFailure(
            f"none of {len(stock)} oils has a known viscosity at {temperature - 273.15:.6g} C"
        )
    return rank(offered, damping)


def right_temperature(oil: Oil, gap: RingGap, damping: float) -> WithError:
    """Temperature in K at which an oil gives a gap a damping in N m s/rad.

    Damping falls with temperature; the place is found by bisection. Raises NumericalFailure where
    the oil does not reach the damping between the ends of its line.
    """
    low, high = _known_range(oil)
    ends = oil_damping(oil, gap, np.array([low, high])).value
    if not ends[1] <= damping <= ends[0]:
        raise NumericalFailure(
            f"{oil.name} gives this gap between {ends[1]:.4g} and {ends[0]:.4g} N m s/rad "
            f"({high - 273.15:.4g} to {low - 273.15:.4g} C), never {damping:.4g}"
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if oil_damping(oil, gap, middle).value > damping:
            low = middle
        else:
            high = middle
    near = oil_damping(oil, gap, np.array([low, high - 1e-3, high + 1e-3]).clip(COLDEST, HOTTEST))
    slope = (near.value[1] - near.value[2]) / 2e-3
    doubt = near.error[0] / slope + 2.0 * UNIT_ROUNDOFF * high + (high - low)
    return WithError(np.asarray(0.5 * (low + high)), np.asarray(doubt))


def _damping_or_none(oil: Oil, gap: RingGap, temperature: float) -> float:
    try:
        return float(oil_damping(oil, gap, temperature).value)
    except NumericalFailure:
        return 0.0


def _known_range(oil: Oil) -> tuple[float, float]:
    """Temperatures between which the line of an oil stays within its viscosities, to 1e-9 K."""
    inside = float(np.mean(np.asarray(oil.line.temperature, dtype=float)))
    return _last_known(oil, inside, COLDEST + 1e-3), _last_known(oil, inside, HOTTEST - 1e-3)


def _last_known(oil: Oil, known: float, end: float) -> float:
    if _known(oil, end):
        return end
    for _ in range(_HALVINGS):
        middle = 0.5 * (known + end)
        known, end = (middle, end) if _known(oil, middle) else (known, middle)
    return known


def _known(oil: Oil, temperature: float) -> bool:
    try:
        kinematic_viscosity(oil.line, temperature)
    except NumericalFailure:
        return False
    return True


def stock_array(stock: Sequence[Oil], gap: RingGap, temperature: ArrayLike) -> FloatArray:
    """Damping (oils, temperatures) of every oil of a list; refuses as `oil_damping` does."""
    return np.stack([oil_damping(oil, gap, temperature).value for oil in stock])
