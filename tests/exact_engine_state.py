"""Forced vibration of an engine's line in long arithmetic, and sums over its orders."""

from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import numpy as np
from exact_engine_drive import EngineDrive
from exact_engine_line import ExactLine, ExactModes, solve
from mpmath import mpc, mpf

from vibecalc.schema import Case

#: samples of a period of the highest order, where a sum over orders is examined first
SAMPLES = 24


class Moved(NamedTuple):
    """By order: frequencies, referred angles, twists and torques of sections, loads by cylinder."""

    frequency: list[mpf]
    angle: list[list[mpc]]
    twist: list[list[mpc]]
    torque: list[list[mpc]]
    load: list[list[mpc]]


class State:
    """A line with its damping and a drive."""

    def __init__(self, case: Case, line: ExactLine, drive: EngineDrive) -> None:
        self.case, self.line, self.drive = case, line, drive
        self.operating = mpf(case.machine.speed)
        self.modes = ExactModes(line, self.operating)
        self.damped = list(line.damped)
        self.elements = list(line.elements)
        self.ratios: list[mpf] | None = None
        model = case.response.torsion.damping_model  # type: ignore[union-attr]
        if model is not None:
            of_inertia = of_stiffness = mpf(0)
            if model.kind == "rayleigh":
                of_inertia, of_stiffness = self._rayleigh(model)
            else:
                given = [mpf(r) for r in model.ratios]
                moving = [w > 0 for w in self.modes.frequency]
                if len(given) == 1:
                    self.ratios = [given[0] if on else mpf(0) for on in moving]
                else:
                    self.ratios = given + [mpf(0)] * (len(moving) - len(given))
            self.damped = [
                of_inertia * j + of_stiffness * g
                for j, g in zip(line.inertia, line.ground, strict=True)
            ]
            self.elements = [
                (a, b, k, of_stiffness * k, mpf(0), s) for a, b, k, _, _, s in line.elements
            ]
        self.rayleigh = (mpf(0), mpf(0)) if model is None else (of_inertia, of_stiffness)
        self.at = lru_cache(maxsize=64)(self._at)

    def _rayleigh(self, model: Any) -> tuple[mpf, mpf]:
        low, high = (self.modes.frequency[number - 1] for number in model.modes)
        given = [mpf(r) for r in model.ratios] * (2 if len(model.ratios) == 1 else 1)
        matrix = mpmath.matrix([[1 / low, low], [1 / high, high]])
        found = mpmath.lu_solve(matrix, mpmath.matrix([2 * r for r in given]))
        return found[0], found[1]

    def element_stiffness(self, speed: mpf, w: mpf) -> list[mpc]:
        return [
            mpc(k + s * speed**2, (k + s * speed**2) * eta + w * c)
            for _, _, k, c, eta, s in self.elements
        ]

    def _at(self, speed: mpf) -> Moved:
        rows, n = self.drive.torques(speed), self.line.count
        built = self.line.built
        ratio = [self.line.ratio[int(s)] for s in built.cylinder_station]
        parts: list[Any] = []
        for place, order in enumerate(self.drive.orders):
            w = order * speed
            load = [row[place] * r for row, r in zip(rows, ratio, strict=True)]
            right = [mpc(0)] * n
            for f, one in zip(built.cylinder_freedom.tolist(), load, strict=True):
                right[f] += one
            z = self.element_stiffness(speed, w)
            angle = self._by_modes(w, right) if self.ratios else self._direct(w, z, right)
            twist = [angle[a] - angle[b] for a, b, *_ in self.elements]
            torque = [k * t for k, t in zip(z, twist, strict=True)]
            parts.append((w, angle, twist, torque, load))
        return Moved(*(list(part) for part in zip(*parts, strict=True)))

    def _direct(self, w: mpf, z: list[mpc], right: list[mpc]) -> list[mpc]:
        line = self.line
        own = [
            mpc(g - w**2 * j, w * c)
            for g, j, c in zip(line.ground, line.inertia, self.damped, strict=True)
        ]
        links = [(a, b, k) for (a, b, *_), k in zip(self.elements, z, strict=True)]
        return solve(own, links, right)

    def _by_modes(self, w: mpf, right: list[mpc]) -> list[mpc]:
        angle, modes = [mpc(0)] * self.line.count, self.modes
        assert self.ratios is not None
        for own, shape, inertia, ratio in zip(
            modes.frequency, modes.shape, modes.inertia, self.ratios, strict=True
        ):
            drive = mpmath.fsum(x * t for x, t in zip(shape, right, strict=True))
            part = drive / (inertia * mpc(own**2 - w**2, 2 * ratio * own * w))
            angle = [a + part * x for a, x in zip(angle, shape, strict=True)]
        return angle

    def sections(self, speed: mpf, what: str) -> list["Sums"]:
        """Sums of the twists, torques or loads of all sections, referred."""
        rows = getattr(self.at(speed), what)
        return [self.sum_of([row[e] for row in rows]) for e in range(len(rows[0]))]

    def half(self, speed: mpf, section: int) -> mpf:
        """Referred half range of the torque of one section."""
        return self.sum_of([row[section] for row in self.at(speed).torque]).half

    def sum_of(self, amplitude: list[mpc]) -> "Sums":
        return sums(self.drive.orders, amplitude)


class Sums(NamedTuple):
    """Highest and lowest value over the cycle, sum of magnitudes."""

    highest: mpf
    lowest: mpf
    bound: mpf

    @property
    def half(self) -> mpf:
        return (self.highest - self.lowest) / 2

    @property
    def peak(self) -> mpf:
        return max(abs(self.highest), abs(self.lowest))


def sums(orders: list[mpf], amplitude: list[mpc]) -> Sums:
    """Of Re sum X exp(i q t): examined on a grid, then by Newton's method."""
    bound = mpmath.fsum(abs(x) for x in amplitude)
    if bound == 0:
        return Sums(mpf(0), mpf(0), mpf(0))
    number = [int(2 * q) for q in orders]
    high = _highest(number, amplitude, bound)
    return Sums(high, -_highest(number, [-x for x in amplitude], bound), bound)


def _highest(number: list[int], amplitude: list[mpc], bound: mpf) -> mpf:
    top = max(number)
    count = 1 << int(np.ceil(np.log2(SAMPLES * top)))
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    scaled = np.array([complex(x / bound) for x in amplitude])
    spectrum[number] = 0.5 * scaled
    signal = np.fft.irfft(spectrum, count) * count
    step = 2.0 * np.pi / count
    # between samples it rises by no more than its curvature allows
    rise = 0.125 * step**2 * float(np.abs(scaled) @ np.array(number, dtype=float) ** 2)
    near = np.flatnonzero(
        (signal >= signal.max() - rise - 1e-12)
        & (signal >= np.roll(signal, 1)) & (signal >= np.roll(signal, -1))
    )  # fmt: skip
    return max(_climbed(number, amplitude, scaled, step * one) for one in near.tolist())


def _climbed(number: list[int], amplitude: list[mpc], scaled: np.ndarray, start: float) -> mpf:
    orders, at = np.array(number, dtype=float), start
    for _ in range(60):
        turned = scaled * np.exp(1j * orders * at)
        slope, bend = -(orders @ turned.imag), -(orders**2 @ turned.real)
        step = -slope / bend if bend < 0 else np.sign(slope) * 1e-3
        step = float(np.clip(step, -1.0 / orders[-1], 1.0 / orders[-1]))
        at += step
        if abs(step) < 1e-11:
            break
    place, value = mpf(at), mpf(0)
    for _ in range(2):
        slope = bend = value = mpf(0)
        unit = mpmath.expj(place)
        powers = _powers(unit, number)
        for q, x, turn in zip(number, amplitude, powers, strict=True):
            term = x * turn
            value += term.real
            slope -= q * term.imag
            bend -= q * q * term.real
        if bend >= 0:
            return value
        # what is left of the way counts squared
        value -= slope**2 / (2 * bend)
        place -= slope / bend
    return value


def _powers(unit: mpc, number: list[int]) -> list[mpc]:
    found, power, at = [], mpc(1), 0
    for q in number:
        while at < q:
            power *= unit
            at += 1
        found.append(power)
    return found
