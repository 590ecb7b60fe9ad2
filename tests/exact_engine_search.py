"""Highest values of a line over a range of speeds, by a search of its own: grids, then long digits.

A fine grid with places about every resonance, dense solves in double precision, a bounded search on
the best of it, and at the end parabolas through values in long arithmetic.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import mpmath
import numpy as np
from mpmath import mp, mpf

#: samples of a cycle on the grid, how many times finer than the sweep it is, most points of that
SAMPLES, FINER, MOST = 512, 8, 500
#: places about a resonance in half its width; share of the best that is refined, and how many
NEARBY = np.array([-3.0, -1.5, -0.7, -0.3, 0.0, 0.3, 0.7, 1.5, 3.0])
RIVAL, FEW = 0.9, 4
#: steps towards a maximum at most
TRIES = 24


class Highest(NamedTuple):
    """Place and height; `inside` the range, not at its end."""

    speed: mpf
    value: mpf
    inside: bool


class Grid:
    """A state in double precision over a range of speeds."""

    def __init__(self, state: Any, start: float, stop: float, points: int) -> None:
        self.state, self.start, self.stop = state, start, stop
        line = state.line
        self.order = np.array([float(q) for q in state.drive.orders])
        parts = (line.inertia, state.damped, line.ground)
        self.inertia, self.damped, self.ground = (
            np.array([float(v) for v in part]) for part in parts
        )
        columns = list(zip(*state.elements, strict=True))
        self.first, self.second = (np.array(c, dtype=int) for c in columns[:2])
        self.k, self.c, self.eta, self.s = (np.array([float(v) for v in c]) for c in columns[2:])
        self.points = min(FINER * points, MOST)

    def twist(self, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Twists and torques (s, m, e) at speeds (s,)."""
        n, state = len(self.inertia), self.state
        w = speed[:, None] * self.order
        k = self.k + np.square(speed)[:, None, None] * self.s + 0.0 * w[..., None]
        z = k * (1.0 + 1j * self.eta) + 1j * w[..., None] * self.c
        right = self._loads(speed)
        if state.ratios is not None:
            modes = state.modes
            shape = np.array([[float(x) for x in one] for one in modes.shape])
            own = np.array([float(x) for x in modes.frequency])
            inertia = np.array([float(x) for x in modes.inertia])
            ratio = np.array([float(x) for x in state.ratios])
            bottom = own**2 - w[..., None] ** 2 + 2j * ratio * own * w[..., None]
            angle = ((right @ shape.T) / (inertia * bottom)) @ shape
        else:
            matrix = np.zeros((*w.shape, n, n), dtype=complex)
            place = np.arange(n)
            wide = w[..., None]
            matrix[..., place, place] = (
                self.ground + 1j * wide * self.damped - wide**2 * self.inertia
            )
            for e, (a, b) in enumerate(zip(self.first.tolist(), self.second.tolist(), strict=True)):
                matrix[..., a, a] += z[..., e]
                matrix[..., b, b] += z[..., e]
                matrix[..., a, b] -= z[..., e]
                matrix[..., b, a] -= z[..., e]
            angle = np.linalg.solve(matrix, right[..., None])[..., 0]
        twist = angle[..., self.first] - angle[..., self.second]
        return twist, z * twist

    @cached_property
    def _parts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gas by card and inertia on the freedoms, cards' speeds."""
        drive, line = self.state.drive, self.state.line
        n, m = len(self.inertia), len(self.order)
        gas = np.zeros((len(drive.cards), m, n), dtype=complex)
        inertia = np.zeros((m, n), dtype=complex)
        rows = zip(line.built.cylinder_station.tolist(), drive.scale, drive.mass, drive.firing,
                   strict=True)  # fmt: skip
        for station, scale, mass, angle in rows:
            f, r = int(line.built.freedom[station]), float(line.ratio[station])
            turn = np.exp(-1j * self.order * float(angle))
            for card, (own, _) in enumerate(drive.gas):
                gas[card, :, f] += r * float(scale) * np.array([complex(g) for g in own]) * turn
            inertia[:, f] += r * np.array([complex(i) for i in drive.own_inertia(mass)]) * turn
        return gas, inertia, np.array([float(v) for v in drive.speeds])

    def _loads(self, speed: np.ndarray) -> np.ndarray:
        gas, inertia, knots = self._parts
        if len(gas) == 1:
            own = np.repeat(gas, len(speed), axis=0)
        else:
            share = np.array([np.interp(speed, knots, row) for row in np.eye(len(knots))]).T
            own = np.tensordot(share, gas, 1)
        return own + np.square(speed)[:, None, None] * inertia

    @cached_property
    def speed(self) -> np.ndarray:
        """The grid: equal steps, and places about each resonance of each order."""
        n = len(self.inertia)
        found = [np.linspace(self.start, self.stop, self.points)]
        middle = 0.5 * (self.start + self.stop)
        for q in self.order.tolist():
            stiffness, damping = np.diag(self.ground).astype(complex), np.diag(self.damped)
            k = self.k + middle**2 * self.s
            loss = k * self.eta / max(q * middle, 1e-9)
            for e, (a, b) in enumerate(zip(self.first.tolist(), self.second.tolist(), strict=True)):
                pair = np.ix_([a, b], [a, b])
                ends = np.array([[1.0, -1.0], [-1.0, 1.0]])
                stiffness[pair] += k[e] * ends
                damping[pair] += (self.c[e] + loss[e]) * ends
            lower = -np.hstack([stiffness, damping]) / self.inertia[:, None]
            poles = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), lower]))
            poles = poles[poles.imag > 1e-9]
            if self.state.ratios is not None:
                own = np.array([float(w) for w in self.state.modes.frequency])
                poles = own * (1j - np.array([float(r) for r in self.state.ratios]))
            at, width = poles.imag / q, np.maximum(np.abs(poles.real) / q, 1e-9 * poles.imag / q)
            found.append((at[:, None] + width[:, None] * NEARBY).ravel())
            if not np.any(self.s) and self.state.ratios is None and not np.any(self.eta):
                rest = [(p.imag / o, abs(p.real) / o) for p in poles for o in self.order.tolist()]
                found += [x + max(w, 1e-9 * x) * NEARBY for x, w in rest]
                break
        every = np.unique(np.concatenate(found))
        return every[(every >= self.start) & (every <= self.stop)]

    @cached_property
    def halves(self) -> np.ndarray:
        """Sampled half ranges (s, e) of the torques on the grid."""
        parts = []
        for begin in range(0, len(self.speed), 128):
            _, torque = self.twist(self.speed[begin : begin + 128])
            spectrum = np.zeros((*torque.shape[::2], SAMPLES // 2 + 1), dtype=complex)
            spectrum[..., np.rint(2.0 * self.order).astype(int)] = 0.5 * np.moveaxis(torque, 1, -1)
            signal = np.fft.irfft(spectrum, SAMPLES, axis=-1) * SAMPLES
            parts.append(0.5 * (signal.max(axis=-1) - signal.min(axis=-1)))
        return np.concatenate(parts)

    def half(self, speed: float, section: int) -> float:
        """Half range of one section, sharp to double precision."""
        _, torque = self.twist(np.array([speed]))
        row = torque[0, :, section]
        return 0.5 * (_top(self.order, row) + _top(self.order, -row))


def _top(order: np.ndarray, row: np.ndarray) -> float:
    number = np.rint(2.0 * order).astype(int)
    spectrum = np.zeros(1025, dtype=complex)
    spectrum[number] = 0.5 * row
    signal = np.fft.irfft(spectrum, 2048) * 2048
    best = -np.inf
    for place in np.argsort(-signal)[:4].tolist():
        at = 2.0 * np.pi * place / 2048
        for _ in range(4):
            turned = row * np.exp(1j * number * at)
            slope, bend = -(number @ turned.imag), -(number**2 @ turned.real)
            at -= slope / bend if bend < 0 else 0.0
        best = max(best, float(np.sum((row * np.exp(1j * number * at)).real)))
    return best


def highest(
    grid: Grid, section: int, exact: Callable[[mpf], mpf], scale: Callable[[float], float],
    hint: float = float("nan"),
) -> Highest:  # fmt: skip
    """Of half range times `scale` over the range; `exact` is the same in long arithmetic.

    The place of a `hint` is examined as well: of two peaks of one height each search finds one.
    """
    from scipy.optimize import minimize_scalar

    speed = grid.speed
    curve = grid.halves[:, section] * np.array([scale(v) for v in speed.tolist()])
    inner = np.flatnonzero((curve[1:-1] >= curve[:-2]) & (curve[1:-1] >= curve[2:])) + 1
    inner = inner[curve[inner] >= RIVAL * curve.max()]
    inner = inner[np.argsort(-curve[inner], kind="stable")][:FEW]
    found = [Highest(mpf(v), exact(mpf(v)), False) for v in (grid.start, grid.stop)]
    tried = []
    for k in inner.tolist():
        low, high = speed[k - 1], speed[k + 1]
        own = minimize_scalar(
            lambda v: -grid.half(v, section) * scale(v),
            bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)},
        )  # fmt: skip
        tried.append((-float(own.fun), float(own.x), float(high - low)))
    for value, at, wide in sorted(tried, reverse=True)[:2]:
        if value >= 0.999 * max(one[0] for one in tried):
            found.append(sharpened(exact, at, wide))
    if grid.start < hint < grid.stop:
        found.append(sharpened(exact, hint, 1e-4 * hint))
    inside = [one for one in found if grid.start <= one.speed <= grid.stop]
    return max(inside, key=lambda one: one.value)


def sharpened(exact: Callable[[mpf], mpf], at: float, wide: float) -> Highest:
    """The maximum next to a place, by parabolas: a value that is there."""
    place, step = mpf(at), mpf(wide) * mpf(10) ** -4
    middle = exact(place)
    for _ in range(6):  # a step that the values show, but that is small next to the resonance
        fall = (2 * middle - exact(place - step) - exact(place + step)) / 2
        if middle == 0:
            return Highest(place, middle, False)
        if abs(fall) > mpf(10) ** -7 * middle:
            step /= mpmath.sqrt(abs(fall) / (mpf(10) ** -8 * middle))
        else:
            break
    for _ in range(TRIES):
        before, after = exact(place - step), exact(place + step)
        bend = before - 2 * middle + after
        if bend >= 0:  # a kink: at a corner of a limit, or where the greatest angle changes
            step /= 8
            continue
        move = max(mpf(-3), min(mpf(3), (before - after) / (2 * bend)))
        there = exact(place + step * move)
        if there < middle:  # the parabola spans a kink
            step /= 8
            continue
        place, middle = place + step * move, there
        step = step / 30 if abs(move) <= 1 else 4 * step
        if abs(move) < mpf(10) ** -6 and step < mpf(10) ** (5 - mp.dps // 3) * place:
            return Highest(place, middle, True)
        if step < mpf(10) ** (4 - mp.dps // 2) * place:
            break
    return Highest(place, middle, abs(after - before) < mpf(10) ** -6 * abs(bend))


def root(function: Callable[[mpf], mpf], at: float, wide: float) -> mpf:
    """Zero next to a place, by secants."""
    one, two = mpf(at), mpf(at) + mpf(wide)
    low, high = function(one), function(two)
    for _ in range(8):
        if high == low or abs(two - one) <= mpf(10) ** -22 * abs(two):
            break
        one, two, low = two, two - high * (two - one) / (high - low), high
        high = function(two)
    return two
