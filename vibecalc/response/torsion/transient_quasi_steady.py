"""A run through criticals beside the steady response at each speed."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import speed_at
from vibecalc.response.torsion.transient_peaks import Envelope
from vibecalc.response.torsion.transient_waterfall import time_course

#: times that the samples about a peak are finer than the first look
_FINER = 4


class SectionPeaks(NamedTuple):
    """Largest magnitude `peak` (e,) of each section, with error, and where: s, rad/s."""

    peak: FloatArray
    error: FloatArray
    time: FloatArray
    speed: FloatArray


class Passage(NamedTuple):
    """A run beside the steady response, e sections, v windows.

    `half_range` (v, e) is (high - low) / 2 in each window, `steady` (v, e) the largest steady one
    at its speeds. `peak`, `peak_speed` (e,) are the largest half range on the way, `steady_peak`,
    `steady_speed` those of the steady curve between the same speeds. `overshoot` (e,) is
    peak / steady_peak - 1 (negative where the passage is too fast to build up), `lag` (e,) in
    rad/s how much later in the sense of the run the peak comes.
    """

    half_range: FloatArray
    steady: FloatArray
    peak: FloatArray
    peak_speed: FloatArray
    steady_peak: FloatArray
    steady_speed: FloatArray
    overshoot: FloatArray
    lag: FloatArray


def section_peaks(run: TransientRun, found: Envelope) -> SectionPeaks:
    """Largest magnitudes over the whole run, from its envelope."""
    size = np.stack([found.high, -found.low])
    side, row = np.unravel_index(size.reshape(-1, size.shape[2]).argmax(axis=0), size.shape[:2])
    section = np.arange(size.shape[2])
    peak = size[side, row, section]
    time = np.where(side == 0, found.time_high[row, section], found.time_low[row, section])
    # another window within its own doubt of the best may hold a higher value, never by more
    upper = (np.maximum(found.high, -found.low) + found.error).max(axis=0)
    error = np.maximum(found.error[row, section], upper - peak)
    return SectionPeaks(peak, error, time, speed_at(run.stretches, run.borders, time))


def time_doubt(run: TransientRun, peaks: SectionPeaks) -> FloatArray:
    """How far off in s the times of the peaks (e,) may be, a step at most.

    Within so much of a smooth summit the torque is as high as its error says; of summits that are
    equally high within their errors any one may be the peak.
    """
    step = max(piece.step for piece in run.pieces)
    doubt = np.full(peaks.time.size, step)
    for section, time in enumerate(peaks.time):
        near = time_course(run, time - 1.5 * step, time + 1.5 * step, finer=_FINER)
        value = np.abs(near.value[:, section])
        middle = int(np.clip(np.argmin(np.abs(near.time - time)), 1, value.size - 2))
        before, after = np.diff(near.time[middle - 1 : middle + 2])
        rise, fall = np.diff(value[middle - 1 : middle + 2]) / (before, after)
        bend = 2.0 * (rise - fall) / (before + after)
        if abs(near.time[middle] - time) <= max(before, after) and bend > 0.0:
            doubt[section] = min(step, 2.0 * np.sqrt(2.0 * peaks.error[section] / bend))
    return doubt


def against_quasi_steady(
    found: Envelope,
    speed: FloatArray,
    steady: FloatArray,
    between: tuple[float, float] | None = None,
) -> Passage:
    """Compare an envelope with steady half ranges `steady` (k, e) at rising speeds (k,) in rad/s.

    Windows should hold a whole cycle of the machine each. The speed must go one way through the
    run. The steady peak is the largest `between` two speeds in rad/s, by default those in the
    middle of the first and the last window. Raises NumericalFailure if the speed does not go one
    way, or leaves the speeds of the steady curve.
    """
    change = np.diff(found.speed)
    if not (np.all(change > 0.0) or np.all(change < 0.0)):
        raise NumericalFailure(
            "a run is compared with the steady response only where its speed goes one way"
        )
    speed, steady = np.asarray(speed, dtype=float), np.asarray(steady, dtype=float)
    low, high = found.speed.min(), found.speed.max()
    if low < speed[0] or high > speed[-1]:
        raise NumericalFailure(
            f"the steady response covers {speed[0]:.6g} to {speed[-1]:.6g} rad/s, the run "
            f"{low:.6g} to {high:.6g} rad/s"
        )
    sections = np.arange(steady.shape[1])
    # a window has the largest of the steady values between the speeds at its borders
    half_way = 0.5 * (found.speed[:-1] + found.speed[1:])
    ends = 2.0 * found.speed[[0, -1]] - half_way[[0, -1]]
    edges = np.concatenate([ends[:1], half_way, ends[1:]])
    within = edges[:-1] + np.linspace(0.0, 1.0, 9)[:, None] * np.diff(edges)
    at_windows = np.stack(
        [np.interp(within, speed, steady[:, s]).max(axis=0) for s in sections], axis=1
    )
    half = 0.5 * (found.high - found.low)
    least, most = (low, high) if between is None else between
    inside = np.flatnonzero((speed >= least) & (speed <= most))
    if inside.size == 0:
        raise NumericalFailure("no speed of the steady response lies inside the run")
    best, top = half.argmax(axis=0), inside[steady[inside].argmax(axis=0)]
    peak, steady_peak = half[best, sections], steady[top, sections]
    if np.any(steady_peak <= 0.0):
        raise NumericalFailure("a section has no steady response to compare with")
    lag = np.sign(change[0]) * (found.speed[best] - speed[top])
    return Passage(
        half, at_windows, peak, found.speed[best], steady_peak, speed[top],
        peak / steady_peak - 1.0, lag,
    )  # fmt: skip
