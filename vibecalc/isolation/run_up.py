"""A slow run-up: at each speed the peak over the cycle, and the highest of them all."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest, highest_of, highest_peaks
from vibecalc.isolation.run_up_samples import (
    Machines,
    Samples,
    exact_peaks,
    in_blocks,
    resolve,
    rough_peaks,
)
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.response.resonances import MaskedSpeeds, Resonances, masked_speeds


class Range(NamedTuple):
    """What passes the speeds from `start` to `stop`, rad/s: rows over speed, with derivatives.

    `orders` (orders,) are ascending positive integers, `resonances` what they may meet. `shows`
    (modes, rows) is True where a mode can be seen in a row at all.
    """

    harmonics_at: HarmonicsAt
    orders: np.ndarray
    resonances: Resonances
    start: float
    stop: float
    shows: np.ndarray


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


def run_up(given: Range, curve_tolerance: float = 1e-3) -> RunUp:
    """Pass the speeds of a range, denser where the curve bends, and find each row's maximum.

    Straight lines between the speeds are as good as `curve_tolerance`, relative to each maximum.
    Clusters of speeds stand at every w_r / n, so that a second order passing a resonance at half
    its frequency is not missed however lightly damped. The maxima are polished by Newton's method
    and hold to rounding; their errors are estimates of that.
    """
    machine = machine_of(given)

    def peaks(speed: np.ndarray) -> tuple[np.ndarray, ...]:
        jet = given.harmonics_at(speed, errors=True)
        return (rough_peaks(jet.value, machine.orders), *exact_peaks(jet, machine.orders))

    speed, curve, unresolved = resolve(
        lambda speed: in_blocks(peaks, speed, machine.orders), machine, curve_tolerance
    )
    samples = Samples(np.zeros(len(speed), int), speed, curve.value, curve)
    return RunUp(speed, curve, highest(machine, samples, 0.97, 1), machine.masked, unresolved)


def joined(parts: Sequence[RunUp]) -> RunUp:
    """Parts of one range, one after the other, as one: each ends where the next begins."""
    speed = np.concatenate([part.speed for part in parts])
    new = np.concatenate([[True], np.diff(speed) > 0.0])
    curve = concatenate([part.curve for part in parts], axis=0)[new]
    masked = MaskedSpeeds(
        *(np.concatenate(each) for each in zip(*(p.masked for p in parts), strict=True))
    )
    # an interval across an end is met from both sides
    _, met = np.unique([masked.low, masked.order, masked.mode], axis=1, return_index=True)
    return RunUp(
        speed[new],
        curve,
        highest_of([part.peak for part in parts]),
        MaskedSpeeds(*(each[met] for each in masked)),
        sum(part.unresolved for part in parts),
    )


def run_up_peak(given: Range) -> RunUpPeak:
    """The maxima of `run_up` alone, without its curve: for searches that ask thousands of times."""
    return highest_peaks(machine_of(given))


def cycle_peaks(harmonics_at: HarmonicsAt, orders: np.ndarray, speed: np.ndarray) -> Bounded:
    """Exact peaks over the cycle (speeds, rows) of all rows, with absolute errors."""
    return Bounded(
        *in_blocks(lambda at: exact_peaks(harmonics_at(at, errors=True), orders), speed, orders)
    )


def machine_of(given: Range) -> Machines:
    """One machine by itself, whose rows have no bound at the undamped resonances that they show."""
    order = np.asarray(given.orders, dtype=int)
    masked = masked_speeds(given.resonances, order, given.start, given.stop)

    def jets_at(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
        # rows that are alike share all their speeds
        shown, which = np.unique(speed, return_inverse=True)
        jet = given.harmonics_at(shown, slopes=True, errors=errors)
        return Jet(*(part if part is EMPTY else part[which, row] for part in jet))

    def values(_: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return in_blocks(lambda at: (given.harmonics_at(at).value,), speed, order)[0]

    return Machines(
        jets_at, values, order, given.start, given.stop,
        Resonances(*(part[None] for part in given.resonances)),
        given.shows.shape[1], masked, given.shows[masked.mode - 1],
    )  # fmt: skip
