"""Curves of a mount: stiffness over frequency and load, load over deflection with its stops."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.gauss import GaussRule, gauss_rule
from vibecalc.numerics.rounding import EPSILON, FloatArray

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
        orders = range(derivative + 1)
        stiff = [self._of(self.factor, place, order, 1.0) for order in orders]
        lossy = [1j * self._of(self.loss_factor, place, order, self.loss) for order in orders]
        lossy[0] = 1.0 + lossy[0]
        terms = [comb(derivative, k) * stiff[k] * lossy[derivative - k] for k in orders]
        return np.asarray(np.sum(terms, axis=0))

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

_FEW, _MANY, _ROUNDS = 8, 16, 60


class TangentByLoad:
    """Load over the deflection of a mount whose tangent stiffness k follows its load P.

    dP/du = k(P) from P = 0 on, so that u = int dF / k(F) and the work is int F dF / k(F), by Gauss
    rules on panels that are halved until two of them agree; beyond the rows k is level.
    """

    def __init__(self, stiffness: Level):
        self._stiffness = stiffness
        ends = np.unique([0.0, *stiffness.at])
        few, many = gauss_rule(_FEW), gauss_rule(_MANY)
        for _ in range(_ROUNDS):
            rough, fine = (self._integrals(ends[:-1], ends[1:], rule) for rule in (few, many))
            poor = np.any(np.abs(fine - rough) > 4.0 * EPSILON * np.abs(fine), axis=0)
            if not np.any(poor):
                break
            ends = np.sort(np.concatenate([ends, 0.5 * (ends[:-1] + ends[1:])[poor]]))
        start = int(np.searchsorted(ends, 0.0))
        whole = np.concatenate([np.zeros((2, 1)), np.cumsum(fine, axis=1)], axis=1)
        self._load = ends
        self._at, self._work = whole - whole[:, [start]]

    def _integrals(self, low: FloatArray, high: FloatArray, rule: GaussRule) -> FloatArray:
        """Deflection and work (2, panels) from one load to another, their sign with them."""
        width = high - low
        load = low[:, None] + width[:, None] * rule.nodes
        one = 1.0 / self._stiffness(load)
        return np.stack([width * (one @ rule.weights), width * ((load * one) @ rule.weights)])

    def __call__(self, deflection: float) -> tuple[float, float, float]:
        """Load, tangent stiffness and work at a deflection."""
        place = int(np.searchsorted(self._at, deflection))
        if place in (0, len(self._at)):  # beyond the rows, or on the first
            end = min(place, len(self._at) - 1)
            load, away = float(self._load[end]), deflection - float(self._at[end])
            slope = float(self._stiffness(load))
            work = float(self._work[end]) + (load + 0.5 * slope * away) * away
            return load + slope * away, slope, work
        low, high = self._load[place - 1 : place + 1]
        left, right = self._at[place - 1 : place + 1]
        load = low + (high - low) * (deflection - left) / (right - left)
        rule, best = gauss_rule(_MANY), np.inf
        while True:  # Newton's method from within a panel: what is left falls until it is rounding
            more, work = self._integrals(np.array([low]), np.array([load]), rule)[:, 0]
            off = deflection - left - more
            if not abs(off) < 0.5 * best:
                break
            best = abs(off)
            load = min(max(load + off * float(self._stiffness(load)), low), high)
        return float(load), float(self._stiffness(load)), float(self._work[place - 1] + work)

    def bend(self, deflection: float) -> float:
        """Change of the tangent stiffness with the deflection, N/m^2."""
        load, slope, _ = self(deflection)
        return float(self._stiffness(load, 1)) * slope


class Law:
    """Load of a mount along its axis: a line and a cube, or rows, or a tangent by load, with stops.

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
        by_load: TangentByLoad | None = None,
    ):
        self.linear, self.cubic, self.down, self.up, self.stop = linear, cubic, down, up, stop
        self.range, self._by_load = (-np.inf, np.inf), by_load
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
        if self._by_load is not None:
            return abs(self._by_load.bend(deflection))
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
        if self._by_load is not None:
            return self._by_load(u)
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
