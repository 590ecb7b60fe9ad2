"""Main bearing loads of a crankshaft taken as statically determinate, and loads over a cycle."""

from collections.abc import Callable
from typing import NamedTuple

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

#: forces (n, k), complex, of rows (n,) at crank angles (n, k)
ForcesAt = Callable[[IntArray, FloatArray], ComplexArray]
#: forces (rows, k), complex, of all rows at crank angles (k,)
EveryAt = Callable[[FloatArray], ComplexArray]
#: places per cycle at least, of the grid for peaks and of panels for means
GRID, PANELS = 1440, 144
#: share of the highest on the grid that a place has, to be looked into on both of its sides
NEARLY = 0.98
#: rad, how far aside of a place it is seen whether a curve has a corner there
ASIDE = 1e-6
#: relative height below which a curve counts as level
LEVEL = 1e-13


class Peaks(NamedTuple):
    """Highest magnitude (rows,) in N over a cycle, and the crank angle (rows,) of it in rad."""

    height: Bounded
    angle: Bounded


class Means(NamedTuple):
    """Mean magnitude (rows,) in N over a cycle, and the mean vector (rows,), complex."""

    magnitude: Bounded
    vector: Bounded


def grid_of(breaks: FloatArray, cycle: float, parts: int = GRID) -> FloatArray:
    """Crank angles (k,) from 0 to a cycle in even parts, with `breaks` among them."""
    even = np.linspace(0.0, cycle, parts + 1)
    every = np.sort(np.concatenate([even, np.mod(breaks, cycle)]))
    return np.asarray(every[np.concatenate([[True], np.diff(every) > 1e-9])])


def cycle_peaks(forces_at: ForcesAt, on_grid: ComplexArray, grid: FloatArray) -> Peaks:
    """Highest magnitudes of rows whose forces `on_grid` (rows, k) tell where to look.

    Kinks of the forces stand on the grid, so that between two of its places they are smooth. The
    error holds what the search leaves; that of the forces is none of it.
    """
    size, cycle = np.abs(on_grid), grid[-1] - grid[0]
    top = np.max(size, axis=1)
    flat = top - np.min(size, axis=1) <= LEVEL * top
    height = Bounded(top.copy(), LEVEL * top)
    where = Bounded(np.zeros(len(top)), np.full(len(top), EPSILON * cycle))

    def values_at(rows: IntArray, places: FloatArray) -> FloatArray:
        return np.abs(forces_at(rows, places))

    # every place of the grid, and every cell next to it, that may hold the highest one
    row, place = np.nonzero((size >= NEARLY * top[:, None]) & ~flat[:, None])
    at = grid[place]
    near = values_at(row, at[:, None] + ASIDE * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    corner = (near[:, 2] >= near[:, 1]) & (near[:, 2] >= near[:, 3])
    # straight on both sides it is a corner, whose height is known; round ones are lower by so much
    drop = near[:, 2:3] - near[:, [0, 4]]
    half = near[:, 2:3] - near[:, [1, 3]]
    bent = np.abs(drop - 2.0 * half).max(axis=-1) + 4.0 * EPSILON * near[:, 2]
    aside, none = np.full(int(corner.sum()), ASIDE), np.zeros(int(corner.sum()))
    tops = [Maxima(
        row[corner], Bounded(at[corner], aside), Bounded(near[corner, 2], bent[corner]), none
    )]  # fmt: skip
    # without a kink, a cell holds a maximum where it rises inwards from both of its ends
    rises = np.zeros((2, *size.shape), dtype=bool)  # to the left and to the right
    rises[:, row, place] = near[:, 2] < near[:, [1, 3]].T
    unseen = size < NEARLY * top[:, None]
    row, cell = np.nonzero((rises[1] | unseen)[:, :-1] & (rises[0] | unseen)[:, 1:]
                           & ~(unseen[:, :-1] & unseen[:, 1:]) & ~flat[:, None])  # fmt: skip
    low, high = grid[cell], grid[cell + 1]
    step = np.minimum(ASIDE, 0.5 * (high - low))
    start = np.where(size[row, cell] >= size[row, cell + 1], low + step, high - step)
    if len(row):
        tops.append(by_values(values_at, row, low, start, high))
    found = first_highest(tops)
    height.value[found.row], height.error[found.row] = found.height
    where.value[found.row] = np.mod(found.place.value, cycle)
    where.error[found.row] = found.place.error + EPSILON * cycle
    missing = np.setdiff1d(np.flatnonzero(~flat), found.row)
    if len(missing):
        raise NumericalFailure(
            f"bearing loads: no highest point of the load {int(missing[0]) + 1} was found over the "
            "cycle"
        )
    return Peaks(height, where)


def cycle_means(every_at: EveryAt, grid: FloatArray, rtol: float = 1e-11) -> Means:
    """Means of forces over a cycle whose kinks stand on the grid.

    Where a force passes close to zero its magnitude has almost a kink. Raises NumericalFailure
    where the integrals do not settle.
    """
    cycle = grid[-1] - grid[0]

    def values_at(angle: FloatArray) -> ComplexArray:
        force = every_at(angle).T / cycle
        return np.concatenate([np.abs(force), force], axis=-1)

    def allowed(whole: ComplexArray) -> FloatArray:
        return np.tile(rtol * whole[: len(whole) // 2].real, 2)

    found = integral(
        values_at,
        grid,
        allowed,
        "bearing loads: the mean load over a cycle does not settle; a gas pressure this steep has "
        "to be given with fewer kinks",
    )
    rows = found.shape[0] // 2
    magnitude = found[:rows].real
    rounding = Bounded(np.zeros(rows), 8.0 * EPSILON * magnitude.value)
    return Means(magnitude + rounding, found[rows:] + rounding)
