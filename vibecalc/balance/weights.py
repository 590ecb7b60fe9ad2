"""Weights that leave the least of one order: linear in their components, so convex.

A weight u at the angle p pulls in proportion to u cos p and u sin p, and its couple is that pull
times where it stands. At given places the force and couple that are left are linear in these
components and a largest unbalance is a disc: one minimum, with a proof (`numerics/least_norm.py`).
Where places are free between bounds the components are solved for at each of them, and the places
are searched (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973, p. 413).
"""

from collections.abc import Sequence
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.inertia_forces import Complex, Real, pull_along
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.least_norm import LeastNorm, least_norm, range_of
from vibecalc.numerics.rounding import EPSILON, BoolArray

if TYPE_CHECKING:
    from vibecalc.parts.crank_train import CrankTrain

# ----------------------------------------------------------------------------
# What counts: forces, couples across the crankshaft and about it, as one vector of real numbers.
# ----------------------------------------------------------------------------


def counting(
    force_weight: float,
    couple_weight: float,
    roll_weight: float,
    reference_length: float,
    axis: Real,
) -> Real:
    """Columns (6, 7) that take loads to what counts of them.

    The weights are of forces, of couples across the crankshaft and of that about it; couples are
    divided by the length in m. `axis` (3,) is the unit vector of the crankshaft.
    """
    columns = np.zeros((6, 7))
    columns[:3, :3] = force_weight * np.eye(3)
    columns[3:, 3:6] = couple_weight / reference_length * across_of(axis)
    columns[3:, 6] = roll_weight / reference_length * axis
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

    def only(self, which: np.ndarray) -> "Places":
        """Some of the weights."""
        return Places(*(part[which] for part in self))


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
    """constant (k,) + (columns + share columns_along) x, of shares x (n,) of `scale` (n,) kg m.

    `block` (n,) is the weight of each x and `turn` (n,) its direction, as a phasor; `radius` (m,)
    is the largest share of each weight, 1 or inf, and `free` are those whose place is.
    """

    constant: Real
    columns: Real
    along: Real
    block: np.ndarray
    turn: Complex
    scale: Real
    radius: Real
    free: np.ndarray

    def at(self, share: Real) -> Real:
        """Columns with the weights at these shares of their ways."""
        return np.asarray(self.columns + self.along * share[self.block])

    def least(self, share: Real) -> LeastNorm:
        """The least norm there."""
        return least_norm(self.constant, self.at(share), self.block, self.radius)

    def slopes(self, unknowns: Real) -> Real:
        """(k, p): what moving a weight along all of its way adds, for each that may."""
        moved = self.along * unknowns
        return np.stack([moved[:, self.block == i].sum(axis=1) for i in self.free], axis=1)


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
    strongest = float(np.max(np.linalg.norm([first, last], axis=1)))
    if strongest == 0.0:
        raise NumericalFailure(
            "no weight of [balance] changes anything that counts: where they stand they have no "
            "couple, and forces have a weight of zero"
        )
    bounded = np.isfinite(places.largest)
    usual = float(np.linalg.norm(constant)) / strongest or 1.0
    usual = float(np.max(places.largest, where=bounded, initial=0.0)) or usual
    scale = np.where(bounded, places.largest, usual)[block]
    return _Problem(
        constant,
        first * scale,
        (last - first) * scale,
        block,
        turn,
        scale,
        np.where(bounded, 1.0, np.inf),
        np.flatnonzero(np.any(places.start != places.end, axis=1)),
    )


# ----------------------------------------------------------------------------
# Places that are free: searched, with the weights solved for at each of them.
# ----------------------------------------------------------------------------

#: of the largest singular value, below which one counts as zero
_RANK = 1e-12
#: roundings of forces and of their sum
_ROUNDINGS = 64.0
#: pulls towards less weight while places are sought, each from where the one before ended
_PULLS = (1e-1, 1e-2, 1e-3)
#: changes of what is left (never), of places and slopes at which a search ends
_EXACTLY = (None, 1e-15, 1e-15)
#: free places up to which every corner is a start; share of the best that a better start has less
_CORNERS, _BETTER = 3, 1e-9


def _search(problem: _Problem) -> Real:
    """Shares (m,) of the ways of the weights."""
    from scipy.optimize import least_squares

    count, every, components = problem.free.size, problem.radius.size, problem.block.size
    size = float(np.linalg.norm(problem.at(np.full(every, 0.5)), 2))
    constant = np.concatenate([problem.constant, np.zeros(components)])

    def shares(places: Sequence[float] | Real) -> Real:
        whole = np.zeros(every)
        whole[problem.free] = places
        return whole

    @cache  # what is left and its slopes are asked for one after the other
    def solved(pull: float, *places: float) -> tuple[Real, LeastNorm]:
        columns = np.vstack([problem.at(shares(places)), pull * size * np.eye(components)])
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

    def sought(start: Real, pull: float) -> Real:
        """Places near `start` that leave the least, to the last digits."""
        found = least_squares(
            left, start, slopes, (0.0, 1.0), "dogbox", *_EXACTLY, tr_solver="lsmr", args=(pull,)
        )
        return np.asarray(found.x)

    starts = [np.full(count, 0.5), np.arange(count) % 2.0]
    if count <= _CORNERS:
        starts += [np.array(corner) for corner in product((0.0, 1.0), repeat=count)]
    best, least = starts[0], np.inf
    for places in starts:
        for pull in _PULLS:
            places = sought(places, pull)
        value = float(np.linalg.norm(left(places, _PULLS[-1])))
        if value < least * (1.0 - _BETTER):
            best, least = places, value
    return shares(sought(best, 0.0))


def _inner(problem: _Problem, share: Real) -> BoolArray:
    """Which of the free weights stand between the ends of their ways."""
    return np.asarray((share[problem.free] > 0.0) & (share[problem.free] < 1.0))


def _in_the_middle(problem: _Problem) -> LeastNorm:
    """The least norm with each free weight in the middle of its way, and a couple next to it as
    large as the weight's could be at an end: together they leave no more than it can.
    """
    twin = np.isin(problem.block, problem.free)
    others = np.searchsorted(problem.free, problem.block[twin]) + problem.radius.size
    halfway = np.where(np.isin(np.arange(problem.radius.size), problem.free), 0.5, 0.0)
    return least_norm(
        problem.constant,
        np.hstack([problem.at(halfway), 0.5 * problem.along[:, twin]]),
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
    places, train : the weights; the train with its origin, stroke and across.
    counts : (6, 7) of `counting`.

    Raises
    ------
    NumericalFailure
        If no weight changes what counts, or the search within the bounds does not end.

    Notes
    -----
    At given places `lower_bound` meets the value. With free places the search is a local one from
    the middle and the ends, and the bound is that of more than a weight can do, one in the middle
    of its way and a couple besides: it may lie below what is possible. The error then
    holds the slope along the ways that is left, times all of them.
    """
    problem = _problem(load.value, places, train, counts)
    share = _search(problem) if problem.free.size else np.zeros(problem.radius.size)
    columns, found = problem.at(share), problem.least(share)
    # a bound that is far off must not enlarge errors: of each column by itself
    length = np.linalg.norm(columns, axis=0)
    terms = np.linalg.norm(problem.constant) + length @ np.abs(found.unknowns)
    rounding = _ROUNDINGS * EPSILON * float(terms) + float(residual(load, counts).error)
    unit = np.where(length > 0.0, length, 1.0)
    size = np.linalg.svd(columns / unit, compute_uv=False)
    bound, freedom = found.lower_bound, found.free_directions
    off = rounding + max(0.0, found.value - bound)
    if problem.free.size:
        inner, slopes = _inner(problem, share), problem.slopes(found.unknowns)
        left = problem.constant + columns @ found.unknowns
        if found.value > rounding:
            off += float(np.abs(left @ slopes)[inner].sum()) / found.value
        open_ = np.hstack([columns[:, ~found.held[problem.block]], slopes[:, inner]])
        lengths = np.linalg.norm(open_, axis=0)
        freedom = open_.shape[1] - range_of(open_ / np.where(lengths > 0.0, lengths, 1.0)).shape[1]
        bound = _in_the_middle(problem).lower_bound
    weakest = float(size[size > _RANK * size[0]][-1])
    slack = float(size[0]) * rounding / weakest**2 / unit
    unbalance, phase = _as_weights(found.unknowns, slack, problem)
    return Solution(
        unbalance=unbalance,
        phase=phase,
        share=share,
        left=Bounded(np.asarray(found.value), np.asarray(off)),
        lower_bound=max(0.0, bound - rounding),
        free_directions=freedom,
    )


def _as_weights(found: Real, slack: Real, problem: _Problem) -> tuple[Bounded, Bounded]:
    """Unbalances and phases (m,) of unknowns (n,) that are off by no more than `slack` (n,)."""
    weight = np.zeros(problem.radius.size, dtype=complex)
    off = np.zeros(weight.size)
    np.add.at(weight, problem.block, found * problem.scale * problem.turn)
    np.maximum.at(off, problem.block, slack * problem.scale)
    size, angle = np.abs(weight), np.angle(weight) % (2.0 * np.pi)
    none = size <= off
    angle = np.where(none | (2.0 * np.pi - angle < 1e-12), 0.0, angle)
    turned = np.where(none, 0.0, off / np.where(none, 1.0, size) + 8.0 * EPSILON)
    return Bounded(np.where(none, 0.0, size), off), Bounded(angle, turned)
