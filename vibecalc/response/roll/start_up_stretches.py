"""What happens between one change of load and the next."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.start_up_states import Load
from vibecalc.response.roll.start_up_view import (
    QUANTITIES,
    Peak,
    Seen,
    Turns,
    mean_speed,
    peaks,
    steps_between,
)


class Stretches(NamedTuple):
    """The k stretches of constant load that a start-up has come to.

    `begin` (k,) in s and `factor` (k,) are rows of the load's table. `speed` (k,) is the mean of
    the last whole turn within each, rad/s, 0 without one; `peaks` has the fields of `Peak`, (k, q).
    """

    begin: FloatArray
    factor: FloatArray
    speed: FloatArray
    peaks: Peak


def stretches(shown: Seen, found: Turns, load: Load) -> Stretches:
    """Peaks and speeds of a history between the changes of its load."""
    last = float(shown.time[-1])
    count = int(np.sum(load.time < last))
    ends = np.append(load.time[1:count], np.inf)
    done, mean = found.begin + found.period, mean_speed(found)
    speeds, tops = [], []
    for begin, end in zip(load.time[:count], ends, strict=True):
        within = np.nonzero((found.begin >= begin) & (done <= end))[0]
        speeds.append(float(mean[within[-1]]) if len(within) else 0.0)
        tops.append(peaks(steps_between(shown, float(begin), float(end))))
    rows = Peak(*(np.stack(column) for column in zip(*tops, strict=True))) if tops else _none()
    return Stretches(load.time[:count], load.factor[:count], np.array(speeds), rows)


def _none() -> Peak:
    return Peak(*(np.zeros((0, len(QUANTITIES))) for _ in Peak._fields))
