"""Peaks of a change that goes on for ever after the time in which it is followed."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.follow import Transient
from vibecalc.response.switching.peaks import Peaks


def lasting_peaks(found: Transient) -> Peaks:
    """The larger of the peaks on the way and of the steady motion that the body settles into.

    A peak below that of the steady motion would only say that the time was too short for it. Where
    the steady motion is the larger one by more than the errors, the body comes up to it later than
    it is followed: the time and the speed are those of the end, exactly by that definition.
    """
    peaks, final = found.peaks, found.final
    larger = final.value > peaks.value
    clear = final.value - final.error > peaks.value + peaks.error
    end = float(found.history.time[-1])
    # the error bounds the larger of two, whichever it truly is
    return Peaks(
        np.where(larger, final.value, peaks.value),
        np.where(clear, final.error, np.maximum(peaks.error, final.error)),
        np.where(clear, end, peaks.time),
        np.where(clear, 4.0 * EPSILON * end, peaks.time_error),
        np.where(clear, found.history.speed[-1], peaks.speed),
    )
