"""Orders of a signal in time: pulses of a tachometer, the angle, equal angles, blocks of turns.

A record is resampled at equal angles of the shaft (computed order tracking: Fyfe and Munck,
Mechanical Systems and Signal Processing 11, 1997, 187-205), and blocks of whole turns are
transformed. Amplitudes are 0-to-peak, a signal is the real part of A exp(i n theta) with theta = 0
at the first pulse, so that a positive phase leads.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Pulses of a tachometer, and the time at each angle.
# ----------------------------------------------------------------------------

_TURN = 2.0 * np.pi


def pulse_times(
    times: FloatArray, signal: FloatArray, threshold: float, hysteresis: float
) -> FloatArray:
    """Times (k,) at which a signal (n,) rises through a threshold, on the straight line between
    two samples.

    It counts again after it has been at or below the threshold less the hysteresis, so that noise
    on an edge makes no second pulse.
    """
    above, below = signal >= threshold, signal <= threshold - hysteresis
    above &= ~below
    place = np.arange(signal.size)
    # the last sample at which it was surely on either side
    seen = np.maximum.accumulate(np.where(above | below, place, -1))
    state = np.where(seen >= 0, above[np.maximum(seen, 0)], True)
    rises = 1 + np.flatnonzero(state[1:] & ~state[:-1])
    low, high = signal[rises - 1], signal[rises]
    share = (threshold - low) / (high - low)
    return np.asarray(times[rises - 1] + share * (times[rises] - times[rises - 1]))


class Shaft(NamedTuple):
    """Times (k,) of a shaft at angles (k,) that rise, rad; a cubic spline joins them."""

    angles: FloatArray
    times: FloatArray

    @property
    def turns(self) -> int:
        """Whole turns."""
        return int(np.floor((self.angles[-1] - self.angles[0]) / _TURN * (1.0 + 1e-12)))

    def at(self, angles: FloatArray) -> FloatArray:
        """Times at angles, s."""
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(self.angles, self.times)(angles))


def shaft_of_pulses(times: FloatArray, pulses_per_turn: int) -> Shaft:
    """The shaft of a tachometer; the angle is zero at the first pulse."""
    return Shaft(_TURN * np.arange(times.size) / pulses_per_turn, times)


def shaft_of_speed(times: FloatArray, speed: FloatArray) -> Shaft:
    """The shaft of a speed > 0 (n,) in rad/s over time; the angle is zero at the first sample."""
    from scipy.interpolate import CubicSpline

    angle = CubicSpline(times, speed).antiderivative()
    return Shaft(np.asarray(angle(times)), times)


def uneven_pulse(times: FloatArray) -> int | None:
    """The first of the intervals between pulses that is no neighbour of the one before it.

    A pulse that was missed, or one too many, halves or doubles an interval; None where none did.
    """
    ratio = np.diff(times)[1:] / np.diff(times)[:-1]
    odd = np.flatnonzero((ratio > _ODD) | (ratio < 1.0 / _ODD))
    return int(odd[0]) + 1 if odd.size else None


#: an interval over the one before it, of a shaft that turns
_ODD = 1.6

# ----------------------------------------------------------------------------
# Signals at equal angles, and the orders of blocks of whole turns.
# ----------------------------------------------------------------------------


class OrderBlocks(NamedTuple):
    """Complex amplitudes (..., blocks, lines) of the orders `lines` / turns, and the speeds.

    `error` (..., blocks, lines) is how far they change where splines of the next lower degree stand
    for the signals; `speeds` (blocks,) in rad/s are means over the turns of a block.
    """

    amplitudes: ComplexArray
    error: FloatArray
    speeds: FloatArray


def samples_per_turn(rate: float, shaft: Shaft) -> int:
    """Equal angles per turn that keep all that the samples have, a power of two."""
    slowest = _TURN * float(np.max(np.diff(shaft.times) / np.diff(shaft.angles)))
    return int(2 ** np.ceil(np.log2(max(rate * slowest, 8.0))))


def resampled(
    times: FloatArray, signals: FloatArray, wanted: FloatArray, degree: int
) -> FloatArray:
    """Signals (..., n) over times (n,) at other times (m,), by splines of an odd degree."""
    from scipy.interpolate import make_interp_spline

    return np.asarray(np.moveaxis(make_interp_spline(times, signals.T, degree)(wanted), 0, -1))


def amplitudes_of_blocks(
    samples: FloatArray, per_turn: int, turns: int, lines: int, window: str
) -> ComplexArray:
    """Orders (..., blocks, lines + 1) of samples (..., n) at equal angles, n whole blocks of turns.

    Line j is the order j / turns. With a window of Hann each line has half of its neighbours in it.
    """
    size = per_turn * turns
    blocks = samples.reshape(*samples.shape[:-1], -1, size)
    weights = np.ones(size)
    if window == "hann":
        weights = 1.0 - np.cos(_TURN * np.arange(size) / size)
    found = np.fft.rfft(blocks * (weights / size))[..., : lines + 1]
    return np.asarray(np.where(np.arange(lines + 1) > 0, 2.0, 1.0) * found)


def order_blocks(
    times: FloatArray,
    signals: FloatArray,
    shaft: Shaft,
    turns: int,
    lines: int,
    window: str = "none",
    degree: int = 5,
) -> OrderBlocks:
    """Orders of signals (..., n) sampled at times (n,), block by block of so many turns.

    The samples have to go on over all angles of the shaft.
    """
    rate = (times.size - 1) / (times[-1] - times[0])
    per_turn = samples_per_turn(rate, shaft)
    while per_turn * turns < 4 * lines:
        per_turn *= 2
    blocks = shaft.turns // turns
    count = blocks * turns * per_turn
    angles = shaft.angles[0] + _TURN * np.arange(count + 1) / per_turn
    at = shaft.at(angles)
    found = [
        amplitudes_of_blocks(
            resampled(times, signals, at[:-1], one), per_turn, turns, lines, window
        )
        for one in (degree, max(degree - 2, 1))
    ]
    ends = at[:: per_turn * turns]
    apart = np.abs(found[0] - found[1]) if degree > 1 else np.zeros(found[0].shape)
    return OrderBlocks(found[0], apart, _TURN * turns / np.diff(ends))


class MeanOrders(NamedTuple):
    """Means (...) over blocks, standard uncertainties along the phasor and across it (...)."""

    amplitudes: ComplexArray
    along: FloatArray
    across: FloatArray


def mean_of_blocks(amplitudes: ComplexArray) -> MeanOrders:
    """Mean over the first axis of (b, ...), b >= 2, and what the scatter of blocks leaves open.

    Standard deviations of the mean of independent blocks (JCGM 100:2008, 4.2.3), of both parts of
    the blocks turned into the phase of the mean.
    """
    mean = np.mean(amplitudes, axis=0)
    turned = (amplitudes - mean) * np.exp(-1j * np.angle(mean))
    share = 1.0 / np.sqrt(amplitudes.shape[0])
    along, across = (np.std(part, axis=0, ddof=1) * share for part in (turned.real, turned.imag))
    return MeanOrders(np.asarray(mean), np.asarray(along), np.asarray(across))
