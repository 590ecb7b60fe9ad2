"""Kernel: mean squares of the responses to a motion of the base that is a spectrum."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.on_mounts import rising
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.gauss import integral
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# With the one-sided density S(f) of the acceleration of the base and the response H(f) to a unit
# of it, the mean square is the integral of |H|^2 S over the table. |H|^2 is rational in f and S is
# smooth between two rows of the table: panels end at the rows and stand densely around each
# resonance.
# ----------------------------------------------------------------------------

#: of the largest of its kind: the square of what rounding leaves where nothing moves
_NOTHING = 1e-24
#: in half widths of a resonance, where panels end on either side of it
_STEPS = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0])
#: frequencies at which a density is drawn, and relative distances of more of them from a resonance
_DRAWN, _BESIDE = 320, np.array([-0.02, -0.005, 0.005, 0.02])


class Density(NamedTuple):
    """One-sided density (rows,) for each hertz at frequencies (rows,) in rad/s, both ascending.

    It is that of the acceleration, or of the velocity.
    """

    frequency: FloatArray
    density: FloatArray
    logarithmic: bool
    by_velocity: bool

    def at(self, frequency: FloatArray) -> FloatArray:
        """Densities of the acceleration at frequencies in rad/s, zero outside of the table."""
        if self.logarithmic:
            drawn = np.interp(np.log(frequency), np.log(self.frequency), np.log(self.density))
            found = np.exp(drawn)
        else:
            found = np.interp(frequency, self.frequency, self.density)
        inside = (frequency >= self.frequency[0]) & (frequency <= self.frequency[-1])
        return np.where(inside, found * frequency**2 if self.by_velocity else found, 0.0)


def panel_ends(densities: list[Density], natural: FloatArray, ratio: FloatArray) -> FloatArray:
    """First ends of panels in rad/s: rows of the tables, and steps around the resonances."""
    rows = np.concatenate([one.frequency for one in densities])
    width = np.maximum(ratio, 1e-7)[:, None] * _STEPS
    around = natural[:, None] * np.concatenate([1.0 - width, 1.0 + width], axis=1)
    even = np.geomspace(rows.min(), rows.max(), 9)
    return rising([rows, even, _within(around, even)], 1e-12)


def curve_frequencies(ends: FloatArray, natural: FloatArray) -> FloatArray:
    """Frequencies in rad/s at which a density between the `ends` is drawn."""
    even = np.geomspace(ends[0], ends[-1], _DRAWN)
    return rising([even, _within(natural[:, None] * (1.0 + _BESIDE), even)], 1e-9)


def _within(around: FloatArray, range_: FloatArray) -> FloatArray:
    """Those of all entries that lie between the first and the last of a range."""
    return np.asarray(around[(around > range_[0]) & (around < range_[-1])])


#: of frequencies (n,) in rad/s to what is integrated, each (n, its own axes)
Powers = Callable[[FloatArray], Mapping[str, FloatArray]]


def mean_squares(powers: Powers, ends: FloatArray, tolerance: float) -> dict[str, Bounded]:
    """Integral over f (Hz) of each of the `powers`.

    `ends` (panels + 1,) in rad/s. Each entry is good to `tolerance` of itself, or to what rounding
    leaves of the largest in its array.

    Raises NumericalFailure where that takes too many panels.
    """
    shapes = {name: part.shape[1:] for name, part in powers(ends[:1]).items()}
    alike = np.repeat(np.arange(len(shapes)), [np.prod(one, dtype=int) for one in shapes.values()])

    def values_at(frequency: FloatArray) -> FloatArray:
        every = [part.reshape(len(frequency), -1) for part in powers(frequency).values()]
        return np.concatenate(every, axis=-1) / (2.0 * np.pi)

    def nothing(whole: FloatArray) -> FloatArray:
        return _NOTHING * np.array([whole[alike == one].max() for one in range(len(shapes))])[alike]

    found = integral(
        values_at,
        ends,
        lambda whole: np.maximum(tolerance / 32.0, 4.0 * EPSILON) * whole + nothing(whole),
        "the mean squares of the responses to the spectrum of the base do not settle: a resonance "
        "within the spectrum has next to no damping; give the mounts damping or a loss factor",
    )
    each = Bounded(found.value, found.error + nothing(found.value))
    named = ((name, each[alike == place]) for place, name in enumerate(shapes))
    return {name: Bounded(*(part.reshape(shapes[name]) for part in one)) for name, one in named}
