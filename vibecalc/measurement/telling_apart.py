"""Which further reading would tell two motions apart that the readings so far allow."""

from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level import DECIBEL
from vibecalc.numerics.typing import ComplexArray, FloatArray


class TellingApart(NamedTuple):
    """Place in the list of readings, and the two levels' difference there in dB (first less other).

    The amplitudes (2,) are those of both motions, in the unit of the reading.
    """

    place: int
    difference: float
    amplitudes: FloatArray


def most_telling(
    motions: ComplexArray, rows: FloatArray, quietest: float = 0.0
) -> TellingApart | None:
    """The row of (m, 3) where the levels of two motions (2, 3) differ most; None without rows.

    Rows where either amplitude does not exceed `quietest` are passed over: a reading next to a
    node tells two motions apart on paper only.
    """
    sizes = np.abs(rows @ motions.T)
    loud = np.min(sizes, axis=1, initial=np.inf) > quietest
    if not np.any(loud):
        return None
    safe = np.where(loud[:, None], sizes, 1.0)
    difference = DECIBEL * np.log(safe[:, 0] / safe[:, 1])
    place = int(np.argmax(np.where(loud, np.abs(difference), -1.0)))
    return TellingApart(place, float(difference[place]), sizes[place])
