"""A slow run-up: at each speed the peak over the cycle, and the highest of them all."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.run_up_grid import (
    CachedFunction,
    admitted,
    angle_grid,
    base_speeds,
    beside_poles,
    clusters,
    coarse_peak,
    exact_peaks,
    resolve,
    resonant_speeds,
    uncertainty_of,
)
from vibecalc.isolation.run_up_machines import NEGLIGIBLE, ROUNDING, Machines, highest_peaks
from vibecalc.isolation.run_up_peaks import (
    Ground,
    RunUpPeak,
    Samples,
    Search,
    beyond_speeds,
    highest,
    highest_of,
    jets_of,
    over_all,
)
from vibecalc.numerics.bounded import Bounded, concatenate
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
    order = np.asarray(orders, dtype=int)
    angle = angle_grid(order)
    bounds = _bounds(resonances, order, start, stop, shows)
    masked = bounds.masked

    def coarse_peaks(speed: np.ndarray) -> tuple[np.ndarray, ...]:
        jet = harmonics_at(speed, errors=True)
        return coarse_peak(jet.value, order, angle), jet.value, uncertainty_of(jet)

    sampled = CachedFunction(lambda speed: in_blocks(coarse_peaks, speed, order))
    sought = resonances.sought()
    speed = base_speeds(sought, order, start, stop, 25)
    centre = resonant_speeds(sought, order)
    within = (centre > 0.2 * start) & (centre < 4.0 * stop)
    if np.sum(within) > 8:
        within &= _worth(sampled, order, sought, masked, start, stop, speed)
    speed = np.concatenate([speed, centre[within], clusters(sought, order, within)])
    refined = resolve(
        lambda at: sampled(at)[0], admitted(speed, masked, start, stop),
        masked, bounds.infinite, curve_tolerance, most_points,
    )  # fmt: skip
    ground = Ground(jets_of(harmonics_at), order, np.array([start]), np.array([stop]))

    def known_harmonics(_: np.ndarray, speed: np.ndarray) -> np.ndarray:
        shown, which = np.unique(speed, return_inverse=True)
        return sampled(shown)[1][which]

    search = Search(ground, angle, bounds.infinite, known_harmonics)
    value, harmonics, uncertainty = sampled(refined.speed)
    samples = Samples(np.zeros(len(refined.speed), int), refined.speed, value, harmonics)
    curve = exact_peaks(harmonics, uncertainty, order)

    def curves_of(rows: np.ndarray) -> Iterator[tuple[int, np.ndarray, Bounded]]:
        more = beyond_speeds(sought.frequency, sought.exposed(), ground.highest)
        more = admitted(more, masked, start, stop)
        _, there, off = sampled(more)
        speed = np.concatenate([refined.speed, more])
        rising = np.argsort(speed, kind="stable")
        whole = concatenate([curve, exact_peaks(there, off, order)], axis=0)[rising]
        return ((row, speed[rising], whole[:, row]) for row in rows.tolist())

    peak = bounds.applied(over_all(highest(search, samples, 0.97), curves_of))
    return RunUp(refined.speed, curve, peak, masked, refined.unresolved)


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
    order = np.asarray(orders, dtype=int)
    bounds = _bounds(resonances, order, start, stop, shows)
    sought = resonances.sought()
    machine = Machines(
        Ground(jets_of(harmonics_at), order, np.array([start]), np.array([stop])),
        lambda _, speed: in_blocks(lambda at: (harmonics_at(at).value,), speed, order)[0],
        sought.frequency[None],
        sought.damping_ratio[None],
        sought.exposed()[None],
        bounds.infinite,
        bounds.masked,
    )
    return bounds.applied(highest_peaks(machine))


def cycle_peaks(harmonics_at: HarmonicsAt, orders: np.ndarray, speed: np.ndarray) -> Bounded:
    """Exact peaks over the cycle (speeds, rows) of all rows, with absolute errors."""

    def peaks(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        jet = harmonics_at(at, errors=True)
        found = exact_peaks(jet.value, uncertainty_of(jet), orders)
        return found.value, found.error

    return Bounded(*in_blocks(peaks, speed, orders))


class _Bounds(NamedTuple):
    """Which intervals are masked, and which rows have no bound in each of them and in any."""

    masked: MaskedSpeeds
    shown: np.ndarray
    infinite: np.ndarray

    def applied(self, peak: RunUpPeak) -> RunUpPeak:
        """With infinite peaks at the first resonance without bound."""
        for number in np.flatnonzero(self.infinite):
            first = int(np.argmax(self.shown[:, number]))
            peak.value[number], peak.speed[number] = np.inf, self.masked.centre[first]
            peak.speed_error[number] = self.masked.centre_error[first]
        return peak


def _bounds(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float, shows: np.ndarray
) -> _Bounds:
    masked = masked_speeds(resonances, orders, start, stop)
    shown = shows[masked.mode - 1]
    return _Bounds(masked, shown, np.any(shown, axis=0))


def _worth(
    sampled: CachedFunction,
    orders: np.ndarray,
    resonances: Resonances,
    masked: MaskedSpeeds,
    start: float,
    stop: float,
    base: np.ndarray,
) -> np.ndarray:
    """Which (order, mode) resonances can matter to the curve or to the maximum of any row."""
    centre = resonant_speeds(resonances, orders)
    at = beside_poles(centre, resonances.exposed(), masked, start, stop)
    speed, back = np.unique(np.concatenate([base, at.ravel()]), return_inverse=True)
    peak, harmonics = sampled(speed)[:2]
    back = back[len(base) :].reshape(centre.shape)
    of_order = harmonics[back, ..., np.arange(len(orders))[:, None]]
    of_order = np.sqrt(np.sum(np.square(np.abs(of_order)), axis=-1))
    here, top = peak[back], np.max(peak, axis=0)
    visible = (of_order > NEGLIGIBLE * top) | ((of_order > ROUNDING * top) & (here > 0.5 * top))
    worth: np.ndarray = np.any(visible, axis=-1)
    return worth
