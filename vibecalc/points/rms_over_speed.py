"""Kernel: r.m.s. values in a band of frequency over crank speed, and the largest of each.

An order counts while its frequency, order times speed, is in the band: at the speeds where one
comes in or goes out a curve has a step. Between these speeds it is smooth; the ends of the band are
in it, so that the highest value is reached.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.run_up import in_blocks
from vibecalc.isolation.run_up_peaks import RunUpPeak
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


class RmsRunUp(NamedTuple):
    """R.m.s. values `curve` (speeds, rows) at rising speeds (speeds,), and the largest of each."""

    speed: FloatArray
    curve: Bounded
    peak: RunUpPeak


def rms_at(counted: BandRows, speed: FloatArray, at: FloatArray | None = None) -> Bounded:
    """R.m.s. values (speeds, rows), of the orders that count at the speeds `at` (speeds,)."""
    every = np.concatenate([counted.order, counted.beyond])
    where = speed if at is None else at

    def values(number: np.ndarray) -> tuple[np.ndarray, ...]:
        jet, dropped = counted.rows(speed[number], errors=True), counted.left_out(speed[number])
        value = np.concatenate([jet.value[..., 0, :], dropped.value[..., 0, :]], axis=-1)
        error = np.concatenate([jet.error[..., 0, :], np.abs(0.0 * dropped.value[..., 0, :])], -1)
        counts = in_band(where[number][:, None] * every, counted.band)[:, None, :]
        return tuple(rms(Bounded(value, error), counts, len(counted.order), counted.factor))

    return Bounded(*in_blocks(values, np.arange(len(speed)), every))


def rms_run_up(
    counted: BandRows,
    speed: FloatArray,
    masked: MaskedSpeeds,
    shows: BoolArray,
    start: float,
    stop: float,
) -> RmsRunUp:
    """R.m.s. values over the speeds [start, stop] and the highest of each row.

    Parameters
    ----------
    speed : (speeds,) rising, close where curves bend; the steps are added.
    masked : intervals without speeds, about an undamped resonance each: a row (modes, rows) that
        `shows` its mode has no bound there if its order counts.

    Maxima are found by Newton's method between speeds that are high, the orders that count being
    those half way. Their errors hold roundings and what the orders left out may add.
    """
    edges = (np.array(counted.band)[:, None] / counted.order).ravel()
    edges = np.concatenate([edges * (1.0 - _BESIDE), edges, edges * (1.0 + _BESIDE)])
    edges = edges[(edges > start) & (edges < stop)]
    edges = edges[outside(masked, edges)] if len(masked.low) else edges
    grid = np.unique(np.concatenate([speed, edges]))
    curve = rms_at(counted, grid)
    place = np.argmax(curve.value, axis=0)
    rows = np.arange(curve.shape[1])
    found = RunUpPeak(
        curve.value[place, rows],
        curve.error[place, rows],
        grid[place],
        np.where((grid[place] == start) | (grid[place] == stop), 0.0, UNIT_ROUNDOFF * grid[place]),
    )
    _refine(counted, grid, curve, masked, found)
    for row in rows.tolist():
        place, height = (
            Bounded(found.speed[row], found.speed_error[row]),
            Bounded(found.value[row], found.error[row]),
        )
        found.speed_error[row], found.error[row] = maxima.top_errors(
            place, height, grid, curve[:, row]
        )
    _unbounded(counted, masked, shows, found)
    return RmsRunUp(grid, curve, found)


def _refine(
    counted: BandRows, grid: FloatArray, curve: Bounded, masked: MaskedSpeeds, found: RunUpPeak
) -> None:
    """Put tops between the speeds in the place of what is sampled, where they are higher."""
    value = curve.value
    high = np.maximum(value[:-1], value[1:]) >= _HIGH * np.max(value, axis=0)
    high &= value[:-1] + value[1:] > 0.0
    middle = 0.5 * (grid[:-1] + grid[1:])
    if len(masked.low):
        high &= outside(masked, middle)[:, None]
    step, row = np.nonzero(high)
    if not len(step):
        return
    counts = in_band(middle[:, None] * counted.order, counted.band)

    def jet_at(curve: IntArray, place: FloatArray) -> maxima.Jet:
        """Mean squares, twice, of some rows in some steps, at places (n,)."""
        speeds, back = np.unique(place, return_inverse=True)

        def jets(part: np.ndarray) -> tuple[np.ndarray, ...]:
            return tuple(each[..., 0, :] for each in counted.rows(part, True, True)[:5])

        count = max(len(counted.order) * 4, 1)
        x, error, slope, _, bend = in_blocks(jets, speeds, np.zeros(count))
        which = (back, row[curve])
        use = counts[step[curve]]
        value, first, second = (np.where(use, each[which], 0.0) for each in (x, slope, bend))
        off = np.where(use, error[which], 0.0)
        return maxima.Jet(
            np.square(np.abs(value)).sum(-1),
            2.0 * (np.abs(value) * off).sum(-1)
            + 4.0 * UNIT_ROUNDOFF * np.square(np.abs(value)).sum(-1),
            2.0 * (value.conj() * first).real.sum(-1),
            2.0 * (np.square(np.abs(first)) + (value.conj() * second).real).sum(-1),
        )

    tops = maxima.by_slopes(jet_at, np.stack([grid[step], grid[step + 1]], axis=1))
    if not len(tops.row):
        return
    own = row[tops.row]
    heights = rms_at(counted, tops.place.value, middle[step[tops.row]])
    # squares of what is left out move a top by their slope over the curvature
    dropped = counted.left_out(tops.place.value, True)
    use = in_band(middle[step[tops.row]][:, None] * counted.beyond, counted.band)
    size, slope = (
        np.where(use, np.abs(part[np.arange(len(own)), own, 0]), 0.0).sum(axis=-1)
        for part in (dropped.value, dropped.slope)
    )
    moved = 2.0 * np.square(counted.factor) * size * slope / np.abs(tops.bend)
    height = heights[np.arange(len(own)), own]
    for i in np.argsort(tops.place.value, kind="stable").tolist():
        if height.value[i] > found.value[own[i]]:
            off = tops.place.error[i] + moved[i]
            new = height.value[i], height.error[i], tops.place.value[i], off
            for part, number in zip(found, new, strict=True):
                part[own[i]] = number


def _unbounded(counted: BandRows, masked: MaskedSpeeds, shows: BoolArray, found: RunUpPeak) -> None:
    """Rows without a bound, at the first of the resonances that they have none at."""
    meets = in_band(masked.order * masked.centre, counted.band)[:, None] & shows[masked.mode - 1]
    for row in np.flatnonzero(np.any(meets, axis=0)):
        first = int(np.argmax(meets[:, row]))
        found.value[row], found.speed[row] = np.inf, masked.centre[first]
        found.speed_error[row] = masked.centre_error[first]
