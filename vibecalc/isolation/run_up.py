"""A slow run-up: at each speed the peak over the cycle, and the highest of them all."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest, highest_of, highest_peaks
from vibecalc.isolation.run_up_samples import (
    Machines,
    Samples,
    curve_speeds,
    exact_peaks,
    in_blocks,
    jets_of,
    resolve,
    rough_peaks,
)
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.response.resonances import MaskedSpeeds, Resonances, masked_speeds


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
    its frequency is not missed however lightly damped. The maxima are polished by Newton's method
    and hold to rounding; their errors are estimates of that.
    """
    machine = machine_of(harmonics_at, orders, resonances, start, stop, shows)

    def peaks(speed: np.ndarray) -> tuple[np.ndarray, ...]:
        jet = harmonics_at(speed, errors=True)
        return (rough_peaks(jet.value, machine.orders), *exact_peaks(jet, machine.orders))

    def curve_at(speed: np.ndarray) -> tuple[np.ndarray, Bounded]:
        rough, value, error = in_blocks(peaks, speed, machine.orders)
        return rough, Bounded(value, error)

    curve = resolve(
        curve_at, curve_speeds(machine), machine.masked, machine.infinite, curve_tolerance,
        most_points,
    )  # fmt: skip
    none = np.zeros(len(curve.speed), int)
    samples = Samples(none, curve.speed, curve.value.value, curve.value)
    peak = with_unbounded(
        highest(machine, samples, 0.97, 1), machine.masked, shows[machine.masked.mode - 1]
    )
    return RunUp(curve.speed, curve.value, peak, machine.masked, curve.unresolved)


def joined(parts: Sequence[RunUp]) -> RunUp:
    """Parts of one range, one after the other, as one: each ends where the next begins."""
    if len(parts) == 1:
        return parts[0]
    speed = np.concatenate([part.speed for part in parts])
    new = np.concatenate([[True], np.diff(speed) > 0.0])
    curve = concatenate([part.curve for part in parts], axis=0)[new]
    masked = MaskedSpeeds(
        *(np.concatenate(each) for each in zip(*(p.masked for p in parts), strict=True))
    )
    # an interval across an end is met from both sides
    both = np.stack([masked.low, masked.order, masked.mode])
    met = np.concatenate([[True], np.any(both[:, 1:] != both[:, :-1], axis=0)])[: len(masked.low)]
    return RunUp(
        speed[new],
        curve,
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
    """The maxima of `run_up` alone, without its curve: for searches that ask thousands of times."""
    machine = machine_of(harmonics_at, orders, resonances, start, stop, shows)
    return with_unbounded(highest_peaks(machine), machine.masked, shows[machine.masked.mode - 1])


def cycle_peaks(harmonics_at: HarmonicsAt, orders: np.ndarray, speed: np.ndarray) -> Bounded:
    """Exact peaks over the cycle (speeds, rows) of all rows, with absolute errors."""
    return Bounded(
        *in_blocks(lambda at: exact_peaks(harmonics_at(at, errors=True), orders), speed, orders)
    )


def machine_of(
    harmonics_at: HarmonicsAt,
    orders: np.ndarray,
    resonances: Resonances,
    start: float,
    stop: float,
    shows: np.ndarray,
) -> Machines:
    """One machine by itself, whose rows have no bound at the undamped resonances that they show."""
    order = np.asarray(orders, dtype=int)
    masked = masked_speeds(resonances, order, start, stop)

    def values(_: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return in_blocks(lambda at: (harmonics_at(at).value,), speed, order)[0]

    return Machines(
        jets_of(harmonics_at), values, order, start, stop,
        Resonances(*(part[None] for part in resonances.sought())),
        shows.shape[1], masked, np.any(shows[masked.mode - 1], axis=0),
    )  # fmt: skip


def with_unbounded(peak: RunUpPeak, masked: MaskedSpeeds, meets: np.ndarray) -> RunUpPeak:
    """With an infinite peak of each row at the first resonance that it `meets` (masked, rows)."""
    for row in np.flatnonzero(np.any(meets, axis=0)):
        first = int(np.argmax(meets[:, row]))
        peak.value[row], peak.speed[row] = np.inf, masked.centre[first]
        peak.speed_error[row] = masked.centre_error[first]
    return peak
