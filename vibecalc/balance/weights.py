"""Weights that leave the least of one order: linear in their components, so convex.

A weight u at the angle p pulls in proportion to u cos p and u sin p, and its couple is that pull
times where it stands. At given places the force and couple that are left are linear in these
components and a largest unbalance is a disc: one minimum, with a proof (`numerics/least_norm.py`).
Where places are free between bounds the components are solved for at each of them, and the places
are searched (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973, p. 413).
"""

from functools import cache
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.excitation.inertia_forces import Complex, Real, pull_along
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.least_norm import LeastNorm, least_norm, range_of
from vibecalc.numerics.rounding import EPSILON

if TYPE_CHECKING:
    from vibecalc.parts.crank_train import CrankTrain

# ----------------------------------------------------------------------------
# What counts: forces, couples across the crankshaft and about it, as one vector of real numbers.
# ----------------------------------------------------------------------------


def counting(weights: tuple[float, float, float], reference_length: float, axis: Real) -> Real:
    """Columns (6, 7) that take loads to what counts of them.

    The weights are of forces, of couples across the crankshaft and of that about it; couples are
    divided by the length in m. `axis` (3,) is the unit vector of the crankshaft.
    """
    of_forces, of_couples, of_roll = weights
    columns = np.zeros((6, 7))
    columns[:3, :3] = of_forces * np.eye(3)
    columns[3:, 3:6] = of_couples / reference_length * across_of(axis)
    columns[3:, 6] = of_roll / reference_length * axis
    return columns


def across_of(axis: Real) -> Real:
    """Matrix (3, 3) of what a vector has across an axis (3,)."""
    return np.asarray(np.eye(3) - np.outer(axis, axis))


def counted(loads: Complex, counts: Real) -> Real:
    """Real rows (..., 14) of loads (..., 6), complex amplitudes, of which the norm is

    sqrt(wf^2 |F|^2 + (wc^2 |M|^2 + wr^2 |R|^2) / l^2), R the couple about the crankshaft.
    """
    whole = loads @ counts
    return np.concatenate([whole.real, whole.imag], axis=-1)


def longest(vector: Bounded) -> Bounded:
    """Largest length (...) over a turn of Re(V exp(i n angle)), whose end moves on an ellipse.

    Its half axes follow from V.conj(V) and V.V of a complex V (..., 3): one that turns on a circle
    of radius R has the largest length R, one that swings has |V|.
    """
    size, error = np.linalg.norm(vector.value, axis=-1), np.linalg.norm(vector.error, axis=-1)
    bare = np.abs(np.sum(vector.value**2, axis=-1))
    length = np.sqrt(0.5 * (size**2 + np.minimum(bare, size**2)))
    return Bounded(length, error + 8.0 * EPSILON * size)


def residual(loads: Bounded, counts: Real) -> Bounded:
    """Size (...) of what counts of loads (..., 6), and its error."""
    return (loads @ counts).norm()


# ----------------------------------------------------------------------------
# Weights at their places: what a unit of each component adds.
# ----------------------------------------------------------------------------


class Places(NamedTuple):
    """m weights of one order: where they may stand, at which angle, how large they may be.

    `speed_ratio` (m,) is +n or -n for all; `start` and `end` (m, 3) are the ends of where each may
    stand, from the train's origin in m, equal where that is given; `phase` (m,) in rad is nan where
    it is free; `largest` (m,) in kg m is inf without a bound.
    """

    speed_ratio: np.ndarray
    start: Real
    end: Real
    phase: Real
    largest: Real


class Solution(NamedTuple):
    """The weights found and what proves them; errors are absolute.

    `unbalance` (m,) in kg m, 0 or more, `phase` (m,) in rad from 0 to below a turn, of no weight 0,
    `share` (m,) of the way from `start` to `end`. The residual there is `left`; no weights within
    their bounds leave less than `lower_bound`, wherever they may stand. `free_directions` counts
    those in which the residual does not change. All per crank speed squared.
    """

    unbalance: Bounded
    phase: Bounded
    share: Real
    left: Bounded
    lower_bound: float
    free_directions: int


class _Problem(NamedTuple):
    """constant (k,) + (columns + along moves p) x, with components x (n,) of unbalances in kg m.

    `block` (n,) is the weight of each x and `turn` (n,) its direction, as a phasor; no weight is
    larger than its `radius` (m,). Places p, from 0 to 1 of their ways, are those of the weights
    `free`, whose components `moves` (n, p) tells.
    """

    constant: Real
    columns: Real
    along: Real
    block: np.ndarray
    turn: Complex
    radius: Real
    free: np.ndarray

    @property
    def moves(self) -> Real:
        """1 where a component is that of a free weight."""
        return np.asarray(self.block[:, None] == self.free, dtype=float)

    def at(self, places: Real) -> Real:
        """Columns with the free weights at these places."""
        return np.asarray(self.columns + self.along * (self.moves @ places))

    def slopes(self, unknowns: Real) -> Real:
        """(k, p): what moving a weight along all of its way adds, for each that may."""
        return np.asarray((self.along * unknowns) @ self.moves)


def _problem(load: Complex, places: Places, train: "CrankTrain", counts: Real) -> _Problem:
    constant = counted(load, counts)
    fixed = ~np.isnan(places.phase)
    block = np.repeat(np.arange(fixed.size), np.where(fixed, 1, 2))
    turn = np.where(fixed, np.exp(1j * places.phase), 1.0)[block]
    turn[1:][block[1:] == block[:-1]] = 1j
    # a unit of each component pulls with q^2 at crank angle zero, ahead of it or behind
    sense, square = np.sign(places.speed_ratio)[:, None], places.speed_ratio[:, None] ** 2
    pull = square * (train.stroke + 1j * sense * train.across)
    direction = turn.real + 1j * sense[block, 0] * turn.imag
    first, last = (
        counted(direction[:, None] * pull_along(place + train.origin, pull).value[block], counts).T
        for place in (places.start, places.end)
    )
    free = np.flatnonzero(np.any(places.start != places.end, axis=1))
    return _Problem(constant, first, last - first, block, turn, places.largest, free)


# ----------------------------------------------------------------------------
# Places that are free: searched, with the weights solved for at each of them.
# ----------------------------------------------------------------------------

#: of the largest singular value, below which one counts as zero
_RANK = 1e-12
#: roundings of forces and of their sum
_ROUNDINGS = 64.0
#: pulls towards less weight while places are sought, each from where the one before ended
_PULLS = (1e-1, 1e-2, 1e-3)
#: steps of places and slopes at which a search ends, with a pull, and in the end without one
_NEAR, _EXACTLY = 1e-9, 1e-15
#: free places up to which every corner is a start; share of the best that a better start has less
_CORNERS, _BETTER = 3, 1e-9


def _search(problem: _Problem) -> Real:
    """Places (p,) of the free weights."""
    from scipy.optimize import least_squares

    count, components = problem.free.size, problem.block.size
    middle = np.full(count, 0.5)
    size = float(np.linalg.norm(problem.at(middle), 2))
    constant = np.concatenate([problem.constant, np.zeros(components)])

    @cache  # what is left and its slopes are asked for one after the other
    def solved(pull: float, *places: float) -> tuple[Real, LeastNorm]:
        columns = np.vstack([problem.at(np.array(places)), pull * size * np.eye(components)])
        return columns, least_norm(constant, columns, problem.block, problem.radius)

    def left(places: Real, pull: float) -> Real:
        columns, found = solved(pull, *places)
        return constant + columns @ found.unknowns

    def slopes(places: Real, pull: float) -> Real:
        """With weights that follow: what they can take back is none of it."""
        columns, found = solved(pull, *places)
        moved = np.vstack([problem.slopes(found.unknowns), np.zeros((components, count))])
        basis = range_of(columns[:, ~found.held[problem.block]])
        return np.asarray(moved - basis @ (basis.T @ moved))

    def sought(start: Real, pull: float, within: float) -> Real:
        """Places near `start` that leave the least."""
        return np.asarray(least_squares(
            left, start, slopes, (0.0, 1.0), "dogbox", None, within, within, tr_solver="lsmr",
            args=(pull,),
        ).x)  # fmt: skip

    starts = [middle, np.arange(count) % 2.0]
    if count <= _CORNERS:
        starts += [np.array(corner) for corner in product((0.0, 1.0), repeat=count)]
    best, least = middle, np.inf
    for places in starts:
        for pull in _PULLS:
            places = sought(places, pull, _NEAR)
        value = float(np.linalg.norm(left(places, _PULLS[-1])))
        if value < least * (1.0 - _BETTER):
            best, least = places, value
    return sought(best, 0.0, _EXACTLY)


def _in_the_middle(problem: _Problem) -> LeastNorm:
    """The least norm with each free weight in the middle of its way, and a couple next to it as
    large as the weight's could be at an end: together they leave no more than it can.
    """
    twin = np.isin(problem.block, problem.free)
    others = np.searchsorted(problem.free, problem.block[twin]) + problem.radius.size
    return least_norm(
        problem.constant,
        np.hstack([problem.at(np.full(problem.free.size, 0.5)), 0.5 * problem.along[:, twin]]),
        np.concatenate([problem.block, others]),
        np.concatenate([problem.radius, problem.radius[problem.free]]),
    )


# ----------------------------------------------------------------------------
# All of one order.
# ----------------------------------------------------------------------------


def least_residual(load: Bounded, places: Places, train: "CrankTrain", counts: Real) -> Solution:
    """Weights that leave the least of one order.

    Parameters
    ----------
    load : (6,) complex amplitudes without the weights, per crank speed squared, in kg m and kg m^2
        about the body's reference point.
    places, train : the weights, one of which at least changes what counts; the train with its
        origin, stroke and across.
    counts : (6, 7) of `counting`.

    Raises
    ------
    NumericalFailure
        If the search within the bounds does not end.

    Notes
    -----
    At given places `lower_bound` meets the value. With free places the search is a local one from
    the middle and the ends, and the bound is that of more than a weight can do, one in the middle
    of its way and a couple besides: it may lie below what is possible. The error then
    holds the slope along the ways that is left, times all of them.
    """
    problem = _problem(load.value, places, train, counts)
    places_found = _search(problem) if problem.free.size else np.zeros(0)
    columns = problem.at(places_found)
    found = least_norm(problem.constant, columns, problem.block, problem.radius)
    # a bound that is far off must not enlarge errors: of each column by itself
    unit, length = _unit(columns)
    terms = np.linalg.norm(problem.constant) + length @ np.abs(found.unknowns)
    rounding = _ROUNDINGS * EPSILON * float(terms) + float(residual(load, counts).error)
    off = rounding + max(0.0, found.value - found.lower_bound)
    inner, slopes = np.abs(places_found - 0.5) < 0.5, problem.slopes(found.unknowns)
    if found.value > rounding:
        rest = problem.constant + columns @ found.unknowns
        off += float(np.abs(rest @ slopes)[inner].sum()) / found.value
    open_, _ = _unit(np.hstack([columns[:, ~found.held[problem.block]], slopes[:, inner]]))
    size = np.linalg.svd(unit, compute_uv=False)
    weakest = float(size[size > _RANK * size[0]][-1])
    slack = float(size[0]) * rounding / weakest**2 / np.where(length > 0.0, length, 1.0)
    share = np.zeros(problem.radius.size)
    share[problem.free] = places_found
    left = Bounded(np.asarray(found.value), np.asarray(off))
    bound = max(0.0, _in_the_middle(problem).lower_bound - rounding)
    freedom = open_.shape[1] - range_of(open_).shape[1]
    return Solution(*_as_weights(found.unknowns, slack, problem), share, left, bound, freedom)


def _unit(columns: Real) -> tuple[Real, Real]:
    """Columns (k, n) of length one, and the lengths (n,) that they had; zeros stay as they are."""
    length = np.linalg.norm(columns, axis=0)
    return columns / np.where(length > 0.0, length, 1.0), length


def _as_weights(found: Real, slack: Real, problem: _Problem) -> tuple[Bounded, Bounded]:
    """Unbalances and phases (m,) of unknowns (n,) that are off by no more than `slack` (n,)."""
    weight = np.zeros(problem.radius.size, dtype=complex)
    off = np.zeros(weight.size)
    np.add.at(weight, problem.block, found * problem.turn)
    np.maximum.at(off, problem.block, slack)
    size, angle = np.abs(weight), np.angle(weight) % (2.0 * np.pi)
    none = size <= off
    angle = np.where(none | (2.0 * np.pi - angle < 1e-12), 0.0, angle)
    turned = np.where(none, 0.0, off / np.where(none, 1.0, size) + 8.0 * EPSILON)
    return Bounded(np.where(none, 0.0, size), off), Bounded(angle, turned)
