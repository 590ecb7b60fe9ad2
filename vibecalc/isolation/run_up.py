"""A slow run-up: at each speed the peak over the cycle, and the highest of them all."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up_grid import (
    CachedFunction,
    admitted,
    angle_grid,
    base_speeds,
    clusters,
    coarse_peak,
    resolve,
    resonant_speeds,
    sparse_clusters,
    sparse_speeds,
)
from vibecalc.isolation.run_up_peaks import RunUpPeak, Search, highest, highest_of
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak
from vibecalc.response.resonances import MaskedSpeeds, Resonances, masked_speeds

# ----------------------------------------------------------------------------
# Many speeds at many orders, taken in blocks that bound the memory.
# ----------------------------------------------------------------------------

#: speeds times orders that are worked on at once: some 60 MB for a rigid body on four mounts
MOST_AT_ONCE = 30_000


def in_blocks(
    function: Callable[[np.ndarray], tuple[np.ndarray, ...]], speed: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The arrays `function` gives for speeds (speeds,), each joined along its first axis."""
    count = -(-len(speed) * len(orders) // MOST_AT_ONCE)
    if count < 2:
        return function(speed)
    parts = [function(part) for part in np.array_split(speed, min(count, len(speed)))]
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


# ----------------------------------------------------------------------------
# A slow run-up: at each speed the peak over the cycle, and the highest of them all.
# ----------------------------------------------------------------------------

#: a resonance whose own order stays below this share of a row's maximum gets no cluster there
_NEGLIGIBLE = 1e-4

#: unless it stands where the row is high anyway: then down to this share
_ROUNDING = 1e-13

#: next to a resonance a row is no higher than there and so many times what the resonance gives
_ADDED = 3.0


class RunUp(NamedTuple):
    """The whole curve: `speed` (speeds,) ascending, `curve` (speeds, rows), and its peaks.

    `masked` lists the intervals in which nothing was computed; `unresolved` counts intervals
    between speeds that a cap on their number left coarser than asked for (normally 0).
    """

    speed: np.ndarray
    curve: Bounded
    peak: RunUpPeak
    masked: MaskedSpeeds
    unresolved: int


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
    search = _search(harmonics_at, orders, resonances, start, stop, shows, errors=True)
    sought = resonances.sought()
    speed = base_speeds(sought, search.orders, start, stop, 25)
    centre = resonant_speeds(sought, search.orders)
    within = (centre > 0.2 * start) & (centre < 4.0 * stop)
    if np.sum(within) > 8:
        within &= _worth(search, sought, speed)
    speed = np.concatenate([speed, centre[within], clusters(sought, search.orders, within)])
    refined = resolve(
        lambda at: search.sampled(at)[0], admitted(speed, search.masked, start, stop),
        search.masked, search.infinite, curve_tolerance, most_points,
    )  # fmt: skip
    peak = highest(search, refined.speed, 0.97)
    _, harmonics, uncertainty = search.sampled(refined.speed)
    curve = _exact_peaks(harmonics, uncertainty, search.orders)
    return RunUp(refined.speed, curve, peak, search.masked, refined.unresolved)


def joined(parts: Sequence[RunUp]) -> RunUp:
    """Parts of one range, one after the other, as one: each ends where the next begins."""
    if len(parts) == 1:
        return parts[0]
    speed = np.concatenate([part.speed for part in parts])
    new = np.concatenate([[True], np.diff(speed) > 0.0])
    curve = (np.concatenate(each)[new] for each in zip(*(p.curve for p in parts), strict=True))
    masked = MaskedSpeeds(
        *(np.concatenate(each) for each in zip(*(p.masked for p in parts), strict=True))
    )
    # an interval across an end is met from both sides
    both = np.stack([masked.low, masked.order, masked.mode])
    met = np.concatenate([[True], np.any(both[:, 1:] != both[:, :-1], axis=0)])[: len(masked.low)]
    return RunUp(
        speed[new],
        Bounded(*curve),
        highest_of([part.peak for part in parts]),
        MaskedSpeeds(*(each[met] for each in masked)),
        sum(part.unresolved for part in parts),
    )


def run_up_peak(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
) -> RunUpPeak:
    """The maxima of `run_up` alone, without its curve: for searches that ask thousands of times.

    Examines few speeds between the resonances, at the resonances themselves, and closely only about
    those that can hold the maximum of a row: where all that is there and three times what the
    resonance adds come up to the highest value seen. Polishes as `run_up` does, from both sides of
    each maximum.
    """
    search = _search(harmonics_at, orders, resonances, start, stop, shows)
    sought = resonances.sought()
    speed = sparse_speeds(sought, search.orders, start, stop)
    winners = _may_win(search, sought, admitted(speed, search.masked, start, stop))
    spread = sparse_clusters(sought, search.orders, winners)
    speed = np.concatenate([search.sampled.speed, spread])
    return highest(search, admitted(speed, search.masked, start, stop), 0.8, sparse=True)


def cycle_peaks(harmonics_at: HarmonicsAt, orders: np.ndarray, speed: np.ndarray) -> Bounded:
    """Exact peaks over the cycle (speeds, rows) of all rows, with absolute errors."""

    def peaks(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        jet = harmonics_at(at, errors=True)
        found = _exact_peaks(jet.value, _uncertainty(jet), orders)
        return found.value, found.error

    return Bounded(*in_blocks(peaks, speed, orders))


def _uncertainty(jet: Jet) -> np.ndarray:
    """What the errors of the harmonics may add to the length of each row (speeds, rows)."""
    return np.asarray(np.sqrt(np.sum(np.square(np.sum(jet.error, axis=-1)), axis=-1)))


def _exact_peaks(harmonics: np.ndarray, uncertainty: np.ndarray, orders: np.ndarray) -> Bounded:
    """Peaks (speeds, rows) of harmonics (speeds, rows, components, orders) of some uncertainty."""
    if harmonics.shape[-2] == 1:
        peak = cycle_peak(harmonics[..., 0, :], orders)
    else:
        peak = vector_cycle_peak(harmonics, orders)
    return Bounded(peak.value, peak.error + uncertainty)


def _search(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
    errors: bool = False,
) -> Search:
    order = np.asarray(orders, dtype=int)
    angle = angle_grid(order)
    masked = masked_speeds(resonances, order, start, stop)
    shown = shows[masked.mode - 1]
    infinite = np.any(shown, axis=0)

    def coarse_peaks(speed: np.ndarray) -> tuple[np.ndarray, ...]:
        jet = harmonics_at(speed, errors=errors)
        found = coarse_peak(jet.value, order, angle), jet.value
        return (*found, _uncertainty(jet)) if errors else found

    sampled = CachedFunction(lambda speed: in_blocks(coarse_peaks, speed, order))
    return Search(harmonics_at, sampled, order, angle, masked, shown, infinite, start, stop)


class _AtResonances(NamedTuple):
    """At the resonances (orders, modes): what the own order gives and all together, and `top`.

    `of_order` and `here` (orders, modes, rows); `top` (rows,) is the highest of all speeds.
    """

    of_order: np.ndarray
    here: np.ndarray
    top: np.ndarray


def _at_resonances(search: Search, resonances: Resonances, base: np.ndarray) -> _AtResonances:
    """Look at first speeds and at all resonances; outside the range, at its end."""
    centre = resonant_speeds(resonances, search.orders)
    width = np.maximum(resonances.exposed(), 0.0)
    # next to a pole the response is taken at the edge of its interval; poles moved by damping that
    # is not there stand on others
    at = np.clip((centre * (1.0 - width)).ravel(), search.start, search.stop)
    for low, high in zip(search.masked.low.tolist(), search.masked.high.tolist(), strict=True):
        at[(at > low) & (at < high)] = low if low >= search.start else high
    speed, back = np.unique(np.concatenate([base, at]), return_inverse=True)
    peak, harmonics = search.sampled(speed)[:2]
    back = back[len(base) :].reshape(centre.shape)
    of_order = harmonics[back, ..., np.arange(len(search.orders))[:, None]]
    of_order = np.sqrt(np.sum(np.square(np.abs(of_order)), axis=-1))
    return _AtResonances(of_order, peak[back], np.max(peak, axis=0))


def _worth(search: Search, resonances: Resonances, base: np.ndarray) -> np.ndarray:
    """Which (order, mode) resonances can matter to the curve or to the maximum of any row."""
    of_order, here, top = _at_resonances(search, resonances, base)
    visible = (of_order > _NEGLIGIBLE * top) | ((of_order > _ROUNDING * top) & (here > 0.5 * top))
    worth: np.ndarray = np.any(visible, axis=-1)
    return worth


def _may_win(search: Search, resonances: Resonances, base: np.ndarray) -> np.ndarray:
    """Which (order, mode) resonances can hold the maximum of any row that has one."""
    of_order, here, top = _at_resonances(search, resonances, base)
    may = (of_order > _ROUNDING * top) & (here + _ADDED * of_order >= top) & ~search.infinite
    won: np.ndarray = np.any(may, axis=-1)
    return won
