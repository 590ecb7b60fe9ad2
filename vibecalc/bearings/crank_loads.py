"""Main bearing loads of a crankshaft taken as statically determinate, and loads over a cycle."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.maxima import by_values
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
#: brackets of one row that are looked into
BRACKETS = 8
#: share of the highest on the grid that a top has, to be looked into
NEARLY = 0.98
#: points of a panel, of the rule that it is held against, and panels at most
POINTS, MORE_POINTS, MOST_PANELS = 8, 13, 200_000
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
    size = np.abs(on_grid)
    cycle = grid[-1] - grid[0]
    inner, angle = size[:, :-1], grid[:-1]  # the last is the first of the next cycle
    before, after = np.roll(inner, 1, axis=1), np.roll(inner, -1, axis=1)
    top = np.max(inner, axis=1)
    flat = top - np.min(inner, axis=1) <= LEVEL * top
    best = np.argmax(inner, axis=1)
    found = (inner > before) & (inner >= after) & (inner >= NEARLY * top[:, None])
    found[np.arange(len(top)), best] = True
    found[flat] = False
    rank = np.argsort(np.argsort(-np.where(found, inner, -1.0), axis=1, kind="stable"), axis=1)
    row, place = np.nonzero(found & (rank < BRACKETS))
    height = Bounded(top.copy(), LEVEL * top)
    where = Bounded(np.where(flat, 0.0, angle[best]), np.full(len(top), EPSILON * cycle))
    if not len(row):
        return Peaks(height, where)

    def values_at(rows: IntArray, places: FloatArray) -> FloatArray:
        return np.abs(forces_at(rows, places))

    at, count = angle[place], len(angle)
    low = angle[(place - 1) % count] - np.where(place == 0, cycle, 0.0)
    high = angle[(place + 1) % count] + np.where(place == count - 1, cycle, 0.0)
    near = values_at(row, at[:, None] + ASIDE * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    corner = (near[:, 2] >= near[:, 1]) & (near[:, 2] >= near[:, 3])
    # straight on both sides it is a corner, whose height is known; round ones are lower by so much
    drop = near[:, 2:3] - near[:, [0, 4]]
    half = near[:, 2:3] - near[:, [1, 3]]
    bent = np.abs(drop - 2.0 * half).max(axis=-1) + 4.0 * EPSILON * near[:, 2]
    tops = [
        (row[corner], at[corner], ASIDE * np.ones(int(corner.sum())), near[corner, 2], bent[corner])
    ]
    # else it rises on one side, in a cell of the grid without a kink
    right = near[:, 3] > near[:, 2]
    for side, ends in (
        (right, (at, at + np.minimum(ASIDE, 0.5 * (high - at)), high)),
        (~right, (low, at - np.minimum(ASIDE, 0.5 * (at - low)), at)),
    ):
        some = side & ~corner
        if np.any(some):
            maxima = by_values(values_at, row[some], *(end[some] for end in ends))
            tops.append((maxima.row, *maxima.place, *maxima.height))
    rows, places, slips, heights, errors = (
        np.concatenate(part) for part in zip(*tops, strict=True)
    )
    order = np.lexsort((heights, rows))
    last = order[np.append(np.diff(rows[order]) > 0, True)]
    found_row = rows[last]
    height.value[found_row], height.error[found_row] = heights[last], errors[last]
    where.value[found_row] = np.mod(places[last], cycle)
    where.error[found_row] = slips[last] + EPSILON * cycle
    missing = np.setdiff1d(np.flatnonzero(~flat), found_row)
    if len(missing):
        raise NumericalFailure(
            f"bearing loads: no highest point of the load {int(missing[0]) + 1} was found over the "
            "cycle"
        )
    return Peaks(height, where)


def cycle_means(every_at: EveryAt, grid: FloatArray, rtol: float = 1e-11) -> Means:
    """Means of forces over a cycle whose kinks stand on the grid.

    Gauss panels, halved where two rules differ: where a force passes close to zero its magnitude
    has almost a kink. The difference of both is the error.

    Raises NumericalFailure where 200000 panels do not suffice.
    """
    starts, widths = grid[:-1], np.diff(grid)
    short, long = gauss_rule(POINTS), gauss_rule(MORE_POINTS)
    cycle = grid[-1] - grid[0]
    magnitude = off = vector_off = np.zeros(1)
    vector = np.zeros(1, dtype=complex)
    done = 0
    while len(starts):
        done += len(starts)
        if done > MOST_PANELS:
            raise NumericalFailure(
                f"bearing loads: the mean load over a cycle does not settle with {MOST_PANELS} "
                "panels; a gas pressure this steep has to be given with fewer kinks"
            )
        sums = []
        for rule in (short, long):
            places = starts[:, None] + widths[:, None] * rule.nodes
            force = every_at(places.ravel()).reshape(-1, *places.shape)
            weight = widths[:, None] * rule.weights / cycle
            sums.append(((force * weight).sum(-1), (np.abs(force) * weight).sum(-1)))
        (vector_1, size_1), (vector_2, size_2) = sums
        lost = np.abs(size_2 - size_1)
        whole = magnitude + size_2.sum(-1)
        bad = np.any(lost > rtol * whole[:, None] * widths / cycle + 1e-15 * whole[:, None], axis=0)
        bad &= widths > 1e-7
        good = ~bad
        vector = vector + vector_2[:, good].sum(-1)
        magnitude = magnitude + size_2[:, good].sum(-1)
        off = off + lost[:, good].sum(-1)
        vector_off = vector_off + np.abs(vector_2 - vector_1)[:, good].sum(-1)
        starts, widths = (
            np.concatenate([starts[bad], starts[bad] + 0.5 * widths[bad]]),
            np.tile(0.5 * widths[bad], 2),
        )
    rounding = 8.0 * EPSILON * magnitude
    return Means(Bounded(magnitude, off + rounding), Bounded(vector, vector_off + rounding))
