"""Curves of a mount: stiffness over frequency and load, load over deflection with its stops."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# Values over rows: monotone where the rows are, level beyond the first and the last.
# ----------------------------------------------------------------------------


class Level:
    """Rows as a cubic with continuous slopes that overshoots no row, level at and beyond the ends.

    Slopes at the rows between are those of F. N. Fritsch and J. Butland (1984), A method for
    constructing local monotone piecewise cubic interpolants, SIAM J. Sci. Stat. Comput. 5.
    """

    def __init__(self, at: ArrayLike, values: ArrayLike):
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

        self.at, self.values = np.array(at, dtype=float), np.array(values, dtype=float)
        slopes = PchipInterpolator(self.at, self.values).derivative()(self.at)
        slopes[0] = slopes[-1] = 0.0
        self._curves = [CubicHermiteSpline(self.at, self.values, slopes)]
        self._curves += [self._curves[0].derivative(1), self._curves[0].derivative(2)]

    def __call__(self, at: Any, derivative: int = 0) -> FloatArray:
        """Values (...) or their first or second derivatives at places (...)."""
        place = np.asarray(at, dtype=float)
        within = np.clip(place, self.at[0], self.at[-1])
        found = np.asarray(self._curves[derivative](within))
        return np.where(within == place, found, 0.0) if derivative else found


# ----------------------------------------------------------------------------
# Stiffness and loss factor of several mounts over frequency.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Factors on the stiffness of n mounts, and their loss factors, over frequency.

    A mount without a curve has a factor of 1, and the loss factor of `loss` (n,).
    """

    factor: tuple[Level | None, ...]
    loss_factor: tuple[Level | None, ...]
    loss: FloatArray

    def rows(self) -> FloatArray:
        """All frequencies of rows, ascending, rad/s."""
        curves = [one for one in (*self.factor, *self.loss_factor) if one is not None]
        return np.asarray(np.unique(np.concatenate([one.at for one in curves])))

    def __call__(self, rate: Any, derivative: int = 0) -> np.ndarray:
        """Complex factors (..., n) on the stiffness at rates (...), s (1 + i eta), or derivatives.

        Derivatives are by the rate in rad/s.
        """
        place = np.asarray(rate, dtype=float)
        s = [self._of(self.factor, place, order, 1.0) for order in range(derivative + 1)]
        eta = [
            self._of(self.loss_factor, place, order, self.loss) for order in range(derivative + 1)
        ]
        if derivative == 0:
            return np.asarray(s[0] * (1.0 + 1j * eta[0]))
        if derivative == 1:
            return np.asarray(s[1] * (1.0 + 1j * eta[0]) + 1j * s[0] * eta[1])
        bent = s[2] * (1.0 + 1j * eta[0]) + 1j * (2.0 * s[1] * eta[1] + s[0] * eta[2])
        return np.asarray(bent)

    def _of(
        self, curves: tuple[Level | None, ...], place: FloatArray, derivative: int, usual: Any
    ) -> FloatArray:
        found = np.zeros((*place.shape, len(curves)))
        if derivative == 0:
            found[...] = usual
        for curve in {id(one): one for one in curves if one is not None}.values():
            same = np.array([one is curve for one in curves])
            found[..., same] = curve(place, derivative)[..., None]
        return found


# ----------------------------------------------------------------------------
# The static load of one mount over its deflection, both positive in compression.
# ----------------------------------------------------------------------------


class Law:
    """Load of a mount along its axis: a line and a cube, or rows, with stops.

    Rows are joined as by `Level`, with the slopes of the rows at the ends, and go on straight.
    """

    def __init__(
        self,
        linear: float,
        cubic: float = 0.0,
        rows: tuple[Sequence[float], Sequence[float]] | None = None,
        down: float = np.inf,
        up: float = np.inf,
        stop: float = 0.0,
    ):
        self.linear, self.cubic, self.down, self.up, self.stop = linear, cubic, down, up, stop
        self.range = (-np.inf, np.inf)
        self._curve: Any = None
        if rows is not None:
            from scipy.interpolate import PchipInterpolator

            at, load = (np.array(one, dtype=float) for one in rows)
            self.range = (float(at[0]), float(at[-1]))
            self._curve = PchipInterpolator(at, load)
            self._slope, self._work = self._curve.derivative(), self._curve.antiderivative()
            self._beyond = (
                (load[1] - load[0]) / (at[1] - at[0]),
                (load[-1] - load[-2]) / (at[-1] - at[-2]),
            )

    def touched(self, deflection: float) -> float:
        """Stiffness in N/m of the stop that the mount stands on, 0 between the stops."""
        return self.stop if deflection > self.down or -deflection > self.up else 0.0

    def load(self, deflection: float) -> float:
        """Load in N, stops included."""
        return self._of_mount(deflection)[0] + self.stop * self._in_stop(deflection)

    def slope(self, deflection: float) -> float:
        """Tangent stiffness in N/m of the mount alone."""
        return self._of_mount(deflection)[1]

    def bend(self, deflection: float) -> float:
        """Change of the tangent stiffness with the deflection, N/m^2, by its size."""
        if self._curve is None:
            return 6.0 * self.cubic * abs(deflection)
        low, high = self.range
        return abs(float(self._slope.derivative()(min(max(deflection, low), high))))

    def work(self, deflection: float) -> float:
        """Energy in J from the reference on, stops included."""
        return self._of_mount(deflection)[2] + 0.5 * self.stop * self._in_stop(deflection) ** 2

    def _in_stop(self, deflection: float) -> float:
        return max(deflection - self.down, 0.0) - max(-deflection - self.up, 0.0)

    def _of_mount(self, u: float) -> tuple[float, float, float]:
        if self._curve is None:
            load = (self.linear + self.cubic * u * u) * u
            work = (0.5 * self.linear + 0.25 * self.cubic * u * u) * u * u
            return load, self.linear + 3.0 * self.cubic * u * u, work
        low, high = self.range
        at = min(max(u, low), high)
        load, work = float(self._curve(at)), float(self._work(at))
        if at == u:
            return load, float(self._slope(u)), work
        slope, away = self._beyond[u > high], u - at
        return load + slope * away, slope, work + (load + 0.5 * slope * away) * away
