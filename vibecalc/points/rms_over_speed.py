"""Kernel: r.m.s. values in a band of frequency over crank speed, and the largest of each.

An order counts while its frequency, order times speed, is in the band: at the speeds where one
comes in or goes out a curve has a step. Between these speeds it is smooth; the ends of the band are
in it, so that the highest value is reached.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.run_up import RunUp
from vibecalc.isolation.run_up_peaks import RunUpPeak, over_all, with_unbounded
from vibecalc.isolation.run_up_samples import in_blocks
from vibecalc.numerics import maxima
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, BoolArray, FloatArray, IntArray
from vibecalc.points.readings import in_band, rms
from vibecalc.response.resonances import MaskedSpeeds, outside

#: share of the highest sampled value from which on an interval of speed may hold the maximum
_HIGH = 0.9
#: relative distance of the speeds on both sides of a step
_BESIDE = 1e-9


class BandRows(NamedTuple):
    """Rows over crank speed with their orders (m,), some orders left out (n,), and the band.

    The orders left out stand `factor` times for all of them; `band` is in rad/s.
    """

    rows: HarmonicsAt
    left_out: HarmonicsAt
    order: FloatArray
    beyond: FloatArray
    factor: np.ndarray | float
    band: tuple[float, float]


def rms_at(counted: BandRows, speed: FloatArray, counts_at: FloatArray) -> Bounded:
    """R.m.s. values (speeds, rows), of the orders that count at other speeds (speeds,)."""

    def values(number: np.ndarray) -> tuple[np.ndarray, ...]:
        jet, dropped = counted.rows(speed[number], errors=True), counted.left_out(speed[number])
        counts, others = (
            in_band(counts_at[number][:, None, None] * order, counted.band)
            for order in (counted.order, counted.beyond)
        )
        size = np.where(others, np.abs(dropped.value[..., 0, :]), 0.0).sum(axis=-1)
        kept = Bounded(jet.value[..., 0, :], jet.error[..., 0, :])
        return tuple(rms(kept, counts, counted.factor * size))

    return Bounded(*in_blocks(values, np.arange(len(speed)), counted.order))


def rms_run_up(
    counted: BandRows, passed: RunUp, shows: BoolArray, start: float, stop: float
) -> RunUp:
    """R.m.s. values over the speeds [start, stop] and the highest of each row.

    Parameters
    ----------
    passed : the same with peaks over the cycle, whose speeds are close where curves bend; the steps
        are added. In its intervals without speeds, about an undamped resonance each, a row (modes,
        rows) that `shows` the mode has no bound if its order counts.

    Maxima are found by Newton's method between speeds that are high, the orders that count being
    those half way. Their errors hold roundings and what the orders left out may add.
    """
    masked, beside = passed.masked, np.array([1.0 - _BESIDE, 1.0, 1.0 + _BESIDE])
    edges = np.multiply.outer(beside, np.divide.outer(counted.band, counted.order)).ravel()
    edges = edges[(edges > start) & (edges < stop) & outside(masked, edges)]
    grid = np.unique(np.concatenate([passed.speed, edges]))
    curve = rms_at(counted, grid, grid)
    place, rows = np.argmax(curve.value, axis=0), np.arange(curve.shape[1])
    at_end = (grid[place] == start) | (grid[place] == stop)
    off = np.where(at_end, 0.0, UNIT_ROUNDOFF * grid[place])
    sampled = maxima.Maxima(rows, Bounded(grid[place], off), curve[place, rows], 0.0 * off)
    best = maxima.first_highest([sampled, _tops(counted, grid, curve, masked)])
    peak = RunUpPeak(best.height.value, best.height.error, best.place.value, best.place.error)
    found = over_all(peak, lambda row: (grid, curve[:, row]))
    # rows without a bound, at the first of the resonances that they have none at
    meets = in_band(masked.order * masked.centre, counted.band)[:, None] & shows[masked.mode - 1]
    found = with_unbounded(found, masked, meets)
    return passed._replace(speed=grid, curve=curve, peak=found)


def _tops(
    counted: BandRows, grid: FloatArray, curve: Bounded, masked: MaskedSpeeds
) -> maxima.Maxima:
    """Tops between the speeds, of each row in the steps that are high enough."""
    value = curve.value
    high = np.maximum(value[:-1], value[1:]) >= _HIGH * np.max(value, axis=0)
    middle = 0.5 * (grid[:-1] + grid[1:])
    high &= (value[:-1] + value[1:] > 0.0) & outside(masked, middle)[:, None]
    step, row = np.nonzero(high)
    counts = in_band(middle[:, None] * counted.order, counted.band)

    def jet_at(curve: IntArray, place: FloatArray) -> maxima.Jet:
        """Mean squares, twice, of some rows in some steps, at places (n,)."""
        speeds, back = np.unique(place, return_inverse=True)
        x, error, slope, _, bend = in_blocks(
            lambda part: tuple(each[..., 0, :] for each in counted.rows(part, True, True)[:5]),
            speeds,
            np.zeros(4 * len(counted.order)),
        )
        which, use = (back, row[curve]), counts[step[curve]]
        value, first, second = (np.where(use, each[which], 0.0) for each in (x, slope, bend))
        off, size = np.where(use, error[which], 0.0), np.square(np.abs(value))
        return maxima.Jet(
            size.sum(-1),
            (2.0 * np.abs(value) * off + 4.0 * UNIT_ROUNDOFF * size).sum(-1),
            2.0 * (value.conj() * first).real.sum(-1),
            2.0 * (np.square(np.abs(first)) + (value.conj() * second).real).sum(-1),
        )

    tops = maxima.by_slopes(jet_at, np.stack([grid[step], grid[step + 1]], axis=1))
    own, half, each = row[tops.row], middle[step[tops.row]], np.arange(len(tops.row))
    height = rms_at(counted, tops.place.value, half)[each, own]
    # squares of what is left out move a top by their slope over the curvature
    dropped = counted.left_out(tops.place.value, True)
    use = in_band(half[:, None] * counted.beyond, counted.band)
    size, slope = (
        np.where(use, np.abs(part[each, own, 0]), 0.0).sum(axis=-1)
        for part in (dropped.value, dropped.slope)
    )
    moved = 2.0 * np.square(counted.factor) * size * slope / np.abs(tops.bend)
    place = Bounded(tops.place.value, tops.place.error + moved)
    return tops._replace(row=own, place=place, height=height)
