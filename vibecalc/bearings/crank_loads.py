"""Main bearing loads of a crankshaft taken as statically determinate, and loads over a cycle."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.gauss import integral
from vibecalc.numerics.maxima import Maxima, by_values, first_highest
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Which bearing takes what of a load at a place of the shaft.
# ----------------------------------------------------------------------------


def bearing_shares(bearing: ArrayLike, place: ArrayLike) -> FloatArray:
    """Share (b, n) of loads at places (n,) that each of b bearings takes; both in m, any order.

    Each bay between two neighbouring bearings is a beam on two supports of its own, so that a load
    goes to these two by its levers; beyond the last bearing the outer bay has an overhang, and the
    bearing behind is pulled. The shares of a load add up to 1 and their moments to its own. With
    two bearings this is no assumption. (The usual statically determinate method, as in textbooks on
    crankshaft bearings; bending of the shaft over several bearings and their clearances are left
    out.)
    """
    bearings, places = np.asarray(bearing, dtype=float), np.asarray(place, dtype=float)
    order = np.argsort(bearings)
    along = bearings[order]
    left = np.clip(np.searchsorted(along, places, side="right") - 1, 0, len(along) - 2)
    beyond = (places - along[left]) / (along[left + 1] - along[left])
    shares = np.zeros((len(along), len(places)))
    column = np.arange(len(places))
    shares[order[left], column] = 1.0 - beyond
    shares[order[left + 1], column] += beyond
    return shares


# ----------------------------------------------------------------------------
# The highest load of a cycle, and the mean one.
# ----------------------------------------------------------------------------

#: forces (..., rows), complex, at crank angles (...)
ForcesAt = Callable[[FloatArray], ComplexArray]
#: places per cycle at least, of the grid for peaks and of panels for means
GRID, PANELS = 1440, 144
#: share of the highest on the grid that a place has, to be looked into on both of its sides
NEARLY = 0.98
#: rad, how far aside of a place it is seen whether a curve rises from there
ASIDE = 1e-6
#: relative height below which a curve counts as level
LEVEL = 1e-13


def _grid(kinks: FloatArray, cycle: float, parts: int) -> FloatArray:
    """Crank angles (k,) from 0 to a cycle in even parts, with the kinks among them."""
    even = np.linspace(0.0, cycle, parts + 1)
    every = np.sort(np.concatenate([even, np.mod(kinks, cycle)]))
    return np.asarray(every[np.concatenate([[True], np.diff(every) > 1e-9])])


def cycle_peaks(forces_at: ForcesAt, kinks: FloatArray, cycle: float) -> tuple[Bounded, Bounded]:
    """Highest magnitude (rows,) over a cycle in N, and the crank angle (rows,) of it in rad.

    Kinks of the forces stand on the grid, so that between two of its places they are smooth. The
    error holds what the search leaves; that of the forces is none of it.
    """
    grid = _grid(kinks, cycle, GRID)
    size = np.abs(forces_at(grid)).T
    top = np.max(size, axis=1)
    level = np.flatnonzero(top - np.min(size, axis=1) <= LEVEL * top)
    none = np.zeros(len(level))
    flat = Maxima(level, Bounded(none, none), Bounded(top[level], LEVEL * top[level]), none)

    def values_at(row: IntArray, places: FloatArray) -> FloatArray:
        every = forces_at(places)
        return np.abs(np.take_along_axis(every, row[:, None, None], axis=-1)[..., 0])

    # every place of the grid, and every cell next to it, that may hold the highest one
    nearly = size >= NEARLY * top[:, None]
    nearly[level] = False
    row, place = np.nonzero(nearly)
    at = grid[place]
    before, here, after = values_at(row, at[:, None] + ASIDE * np.array([-1.0, 0.0, 1.0])).T
    # a cell holds a maximum where the curve rises into it from both of its ends, as far as seen
    leftwards, rightwards = np.ones((2, *size.shape), dtype=bool)
    leftwards[row, place], rightwards[row, place] = before > here, after > here
    rising = rightwards[:, :-1] & leftwards[:, 1:] & (nearly[:, :-1] | nearly[:, 1:])
    inside, cell = np.nonzero(rising)
    corner = (here >= before) & (here >= after)
    low = np.concatenate([at[corner] - ASIDE, grid[cell]])
    high = np.concatenate([at[corner] + ASIDE, grid[cell + 1]])
    rows = np.concatenate([row[corner], inside])
    found = first_highest([flat, by_values(values_at, rows, low, 0.5 * (low + high), high)])
    missing = np.setdiff1d(np.arange(len(size)), found.row)
    if len(missing):
        raise NumericalFailure(
            f"bearing loads: no highest point of the load {int(missing[0]) + 1} was found over the "
            "cycle"
        )
    angle, error = np.mod(found.place.value, cycle), found.place.error + EPSILON * cycle
    return found.height, Bounded(np.where(cycle - angle <= error, 0.0, angle), error)


def cycle_means(
    forces_at: ForcesAt, kinks: FloatArray, cycle: float, rtol: float = 1e-11
) -> tuple[Bounded, Bounded]:
    """Mean magnitude (rows,) over a cycle in N, and the mean vector (rows,), complex.

    Where a force passes close to zero its magnitude has almost a kink. Raises NumericalFailure
    where the integrals do not settle.
    """

    def values_at(angle: FloatArray) -> ComplexArray:
        force = forces_at(angle) / cycle
        return np.concatenate([np.abs(force), force], axis=-1)

    def allowed(whole: ComplexArray) -> FloatArray:
        return np.tile(rtol * whole[: len(whole) // 2].real, 2)

    found = integral(
        values_at,
        _grid(kinks, cycle, PANELS),
        allowed,
        "bearing loads: the mean load over a cycle does not settle; a gas pressure this steep has "
        "to be given with fewer kinks",
    )
    rows = found.shape[0] // 2
    magnitude = found[:rows].real
    # what is summed up of a vector may be larger than its sum
    return magnitude, found[rows:] + Bounded(np.zeros(rows), 8.0 * EPSILON * magnitude.value)
