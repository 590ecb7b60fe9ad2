"""A slow run-up: at each speed the peak over the cycle, and the highest of them all."""

from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.blocks import in_blocks
from vibecalc.isolation.envelope import angle_grid, coarse_peak, squares
from vibecalc.isolation.refine import resolve
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.speeds import admitted, base_speeds, clusters, resonant_speeds
from vibecalc.isolation.summit import Starts, climb
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak
from vibecalc.numerics.rounding import WithError
from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import Masked, masked_speeds

#: a resonance whose own order stays below this share of a row's maximum gets no cluster there
_NEGLIGIBLE = 1e-4

#: unless it stands where the row is high anyway: then down to this share
_ROUNDING = 1e-13


class RunUpPeak(NamedTuple):
    """Highest peak of each row (rows,) and its speed in rad/s, with absolute errors.

    The value is infinite, with the speed of the first such resonance, where a driven undamped
    natural frequency lies in the range and shows in the row.
    """

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray


class RunUp(NamedTuple):
    """The whole curve: `speed` (speeds,) ascending, `curve` (speeds, rows), and its summits.

    `masked` lists the intervals in which nothing was computed; `unresolved` counts intervals
    between speeds that a cap on their number left coarser than asked for (normally 0).
    """

    speed: np.ndarray
    curve: WithError
    peak: RunUpPeak
    masked: Masked
    unresolved: int


class _Search(NamedTuple):
    harmonics_at: HarmonicsAt
    orders: np.ndarray
    angle: np.ndarray
    masked: Masked
    shown: np.ndarray
    infinite: np.ndarray
    start: float
    stop: float


def run_up(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
    *,
    curve_tolerance: float = 1e-3,
    most_points: int = 20_000,
) -> RunUp:
    """Pass the speeds [start, stop], denser where the curve bends, and find each row's maximum.

    Parameters
    ----------
    harmonics_at : rows with their derivatives by speed, as `vibecalc.isolation.rows` makes them.
    orders : (orders,) of the harmonics, ascending positive integers.
    shows : (modes, rows) True where a mode can be seen in a row at all.
    curve_tolerance : straight lines between the speeds are this good, relative to each maximum.

    Clusters of speeds stand at every w_r / n, so that a second order passing a resonance at half
    its frequency is not missed however lightly damped. The maxima are polished by Newton's
    method and hold to rounding; their errors are estimates of that.
    """
    search, speed = _prepare(harmonics_at, orders, resonances, start, stop, shows, 49)
    curve_at = partial(_coarse, search)
    found = resolve(curve_at, speed, search.masked, search.infinite, curve_tolerance, most_points)
    peak = _highest(search, found.speed, found.value, 0.97)
    return RunUp(
        found.speed, cycle_peaks(harmonics_at, search.orders, found.speed), peak,
        search.masked, found.unresolved,
    )  # fmt: skip


def run_up_peak(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
) -> RunUpPeak:
    """The maxima of `run_up` alone, without its curve: for searches that ask thousands of times.

    Looks at the same clusters and polishes the same way, but does not bisect between them.
    """
    search, speed = _prepare(harmonics_at, orders, resonances, start, stop, shows, 25)
    return _highest(search, speed, _coarse(search, speed), 0.85)


def cycle_peaks(harmonics_at: HarmonicsAt, orders: np.ndarray, speed: np.ndarray) -> WithError:
    """Exact peaks over the cycle (speeds, rows) of all rows, with absolute errors."""

    def peaks(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        jet = harmonics_at(at, errors=True)
        doubt = np.sqrt(np.sum(np.square(np.sum(jet.error, axis=-1)), axis=-1))
        if jet.value.shape[-2] == 1:
            peak = cycle_peak(jet.value[..., 0, :], orders)
        else:
            peak = vector_cycle_peak(jet.value, orders)
        return peak.value, peak.error + doubt

    return WithError(*in_blocks(peaks, speed, orders))


def _prepare(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
    base: int,
) -> tuple[_Search, np.ndarray]:
    """First speeds: base, order resonances, and clusters at those that are worth one."""
    order = np.asarray(orders, dtype=int)
    angle = angle_grid(order)
    masked = masked_speeds(resonances, order, start, stop)
    shown = shows[masked.mode - 1]
    infinite = np.any(shown, axis=0)
    search = _Search(harmonics_at, order, angle, masked, shown, infinite, start, stop)
    sought = resonances.sought()
    centre = resonant_speeds(sought, order)
    within = (centre > 0.2 * start) & (centre < 4.0 * stop)
    speed = base_speeds(sought, order, start, stop, base)
    if np.sum(within) > 8:
        within &= _worth(search, sought, speed)
    spread = clusters(sought, order, within)
    speed = np.concatenate([speed, centre[within], spread])
    return search, admitted(speed, masked, start, stop)


def _worth(search: _Search, resonances: Resonances, base: np.ndarray) -> np.ndarray:
    """Which (order, mode) resonances can matter to the curve or to the maximum of any row."""
    centre = resonant_speeds(resonances, search.orders)
    width = np.maximum(resonances.exposed(), 0.0)
    # beside a pole the response is taken at the edge of its interval
    at = np.clip((centre * (1.0 - width)).ravel(), search.start, search.stop)

    def peak_and_orders(speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value = search.harmonics_at(speed).value
        length = np.sqrt(np.sum(np.square(np.abs(value)), axis=-2))
        return coarse_peak(value, search.orders, search.angle), length

    peak, length = in_blocks(peak_and_orders, np.concatenate([base, at]), search.orders)
    top = np.max(peak, axis=0)
    count, rows = len(search.orders), peak.shape[1]
    own = length[len(base) :].reshape(*centre.shape, rows, count)
    own = own[np.arange(count), :, :, np.arange(count)]
    here = peak[len(base) :].reshape(*centre.shape, rows)
    seen = (own > _NEGLIGIBLE * top) | ((own > _ROUNDING * top) & (here > 0.5 * top))
    worth: np.ndarray = np.any(seen, axis=-1)
    return worth


def _coarse(search: _Search, speed: np.ndarray) -> np.ndarray:
    """Peaks over the grid of crank angles (speeds, rows)."""

    def peaks(at: np.ndarray) -> tuple[np.ndarray]:
        return (coarse_peak(search.harmonics_at(at).value, search.orders, search.angle),)

    return in_blocks(peaks, speed, search.orders)[0]


def _highest(search: _Search, speed: np.ndarray, value: np.ndarray, threshold: float) -> RunUpPeak:
    """Polish every local maximum that may be the highest, and keep the best of each row."""
    rows = value.shape[1]
    padded = np.pad(value, ((1, 1), (0, 0)), constant_values=-1.0)
    local = (value >= padded[:-2]) & (value >= padded[2:])
    top = np.max(value, axis=0)
    at, row = np.nonzero(local & (value >= threshold * top) & (value > 0.0) & ~search.infinite)
    peak = RunUpPeak(np.zeros(rows), np.zeros(rows), np.full(rows, search.start), np.zeros(rows))
    if len(at):
        starts = _starts(search, speed, at, row, threshold)
        summit = climb(search.harmonics_at, search.orders, starts, search.start, search.stop)
        for number in range(rows):
            mine = np.flatnonzero(starts.row == number)
            if len(mine):
                best = mine[np.argmax(summit.value[mine])]
                peak.value[number], peak.error[number] = summit.value[best], summit.error[best]
                peak.speed[number] = summit.speed[best]
                peak.speed_error[number] = summit.speed_error[best]
    for number in range(rows):
        if not search.infinite[number]:
            continue
        first = int(np.argmax(search.shown[:, number]))
        peak.value[number], peak.speed[number] = np.inf, search.masked.centre[first]
        peak.speed_error[number] = search.masked.centre_error[first]
    return peak


def _starts(
    search: _Search, speed: np.ndarray, at: np.ndarray, row: np.ndarray, threshold: float
) -> Starts:
    """One start for each high branch over the crank angle at each of the chosen speeds."""
    shown, which = np.unique(at, return_inverse=True)
    value = search.harmonics_at(speed[shown]).value[which, row]
    height = squares(value, search.orders, search.angle)
    around = np.maximum(np.roll(height, 1, axis=-1), np.roll(height, -1, axis=-1))
    # the grid itself may miss two per cent of a peak
    floor = np.square(0.96 * threshold) * np.max(height, axis=-1, keepdims=True)
    each, column = np.nonzero((height >= around) & (height >= floor))
    before, after = speed[np.maximum(at - 1, 0)], speed[np.minimum(at + 1, len(speed) - 1)]
    reach = np.maximum(after - before, 1e-12 * speed[at])
    return Starts(speed[at[each]], search.angle[column], row[each], reach[each])
