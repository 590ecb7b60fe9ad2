"""Supports of a run-up as functions of the speed, with a count of the speeds looked at."""

from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.grids import Function
from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up import cycle_peaks, run_up_peak
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.isolation_common import isolation_of
from vibecalc.pipeline.stages.run_up import sections
from vibecalc.response.resonance import Resonances

#: supports whose maxima and speeds agree to this are alike by symmetry
ALIKE = 1e-9


class Counted:
    """Rows of a run-up that count the speeds at which they were asked for."""

    def __init__(self, rows: HarmonicsAt) -> None:
        self._rows, self.asked = rows, 0

    def __call__(self, speed: FloatArray, slopes: bool = False, errors: bool = False) -> Jet:
        self.asked += len(speed)
        return self._rows(speed, slopes=slopes, errors=errors)


class Peaks:
    """Peaks over the cycle of some rows; the same speeds asked again, for another row, are kept."""

    def __init__(self, rows: HarmonicsAt, orders: IntArray, which: IntArray) -> None:
        self._rows, self._orders, self._which = rows, orders, which
        self._last: tuple[FloatArray, FloatArray] = np.zeros(0), np.zeros((0, len(which)))

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Peaks (speeds, rows)."""
        if not np.array_equal(speed, self._last[0]):
            found = cycle_peaks(self._rows, self._orders, speed).value[:, self._which]
            self._last = speed, found
        return self._last[1]

    def row(self, number: int) -> Function:
        """The peak of one row (speeds,) as a function of the speed."""
        return lambda speed: self(np.asarray(speed))[:, number]


class Asked(NamedTuple):
    """What a run-up of a case is asked.

    `rows` : those whose maxima are finite and that differ, as places in what the model gives.
    `known`, `height` : speeds and values of their maxima as a run finds them; `first` is the place
        of the largest among them.
    """

    model: HarmonicsAt
    orders: IntArray
    resonances: Resonances
    shows: np.ndarray
    start: float
    stop: float
    rows: IntArray
    known: tuple[float, ...]
    height: FloatArray
    first: int

    def counted(self) -> Counted:
        """The model's rows with a count of their own."""
        return Counted(self.model)

    def peaks(self) -> Peaks:
        """Peaks of the rows that are asked for."""
        return Peaks(self.model, self.orders, self.rows)


def asked_of(scene: Scene) -> Asked | None:
    """The supports of the case; None without a run-up or without a support of finite maximum."""
    if isolation_of(scene).run_up is None:
        return None
    peaks = []
    for part in sections(scene):
        given = (part.setup.harmonics, part.setup.resonances, part.start, part.stop)
        peaks.append((part, run_up_peak(part.setup.rows, *given, part.setup.shows)))
    # of a range in parts the one with the largest force
    (setup, start, stop), found = max(peaks, key=lambda pair: float(pair[1].value.max()))
    chosen: list[int] = []
    # a couple over a lever stands before the supports
    for row in dict.fromkeys(setup.row_of[setup.lever_rows :].tolist()):
        value, speed = found.value[row], found.speed[row]
        new = all(
            abs(value - found.value[one]) > ALIKE * value
            or abs(speed - found.speed[one]) > ALIKE * speed
            for one in chosen
        )
        if np.isfinite(value) and value > 0.0 and new:
            chosen.append(int(row))
    if not chosen:
        return None
    rows = np.array(chosen)
    height = found.value[rows]
    known = tuple(float(one) for one in found.speed[rows])
    return Asked(setup.rows, setup.harmonics, setup.resonances, setup.shows, start, stop, rows,
                 known, height, int(np.argmax(height)))  # fmt: skip
