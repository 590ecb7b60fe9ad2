"""A shaft line with elastic couplings a second way: dense matrices, brackets halved for what heats.

Nothing of the program takes part but the torques of its cylinders, which a result file holds: the
line is read from the resolved case, rows are interpolated here, sums over the cycle are searched
here, and temperatures and vibratory torques are brackets halved or plain repetition.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

Array = np.ndarray


class Conditions(NamedTuple):
    """What a coupling is taken at: mean torque and half range in N m, temperature in K."""

    mean: float
    temperature: float
    amplitude: float


def _between(x: float, at: Any, values: Any) -> float:
    """Linear between rows, constant beyond them."""
    at, values = list(at), list(values)
    if x <= at[0]:
        return float(values[0])
    for left in range(len(at) - 1):
        if x <= at[left + 1]:
            share = (x - at[left]) / (at[left + 1] - at[left])
            return float(values[left] * (1.0 - share) + values[left + 1] * share)
    return float(values[-1])


def coupling_value(given: Mapping[str, Any], now: Conditions, frequency: float) -> complex:
    """k (1 + i psi / 2 pi) of a coupling of a resolved case at a frequency in rad/s."""
    found = {"stiffness": given.get("stiffness"), "relative_damping": given.get("relative_damping")}
    factor = dict.fromkeys(found, 1.0)
    for key, axis, x in (
        ("over_mean_torque", "torque", abs(now.mean)),
        ("over_temperature", "temperature", now.temperature),
        ("over_frequency", "frequency", frequency),
        ("over_amplitude", "torque", now.amplitude),
    ):
        rows = given.get(key, {})
        for name in found:
            if name in rows:
                found[name] = _between(x, rows[axis], rows[name])
            elif f"{name}_factor" in rows:
                factor[name] *= _between(x, rows[axis], rows[f"{name}_factor"])
    k, psi = (found[name] * factor[name] for name in ("stiffness", "relative_damping"))
    return complex(k * (1.0 + 1j * psi / (2.0 * np.pi)))


class Solved(NamedTuple):
    """Torques (m,) of the coupling by order, power loss, conditions."""

    order: Array
    torque: Array
    power: float
    conditions: Conditions

    @property
    def highest(self) -> float:
        return _extreme(self.order, self.torque)

    @property
    def lowest(self) -> float:
        return -_extreme(self.order, -self.torque)

    @property
    def half_range(self) -> float:
        return half_range(self.order, self.torque)


class DenseLine:
    """A row of stations with one coupling, of a resolved case."""

    def __init__(self, case: Mapping[str, Any]):
        line = case["machine"]["shaft_line"]
        self.inertia = np.array([one["inertia"] for one in line["stations"]])
        self.absolute = np.array([one.get("absolute_damping", 0.0) for one in line["stations"]])
        self.shafts = line["shafts"]
        self.place = next(n for n, one in enumerate(self.shafts) if "coupling" in one)
        self.given = self.shafts[self.place]["coupling"]

    def stiffness(self, now: Conditions, frequency: float) -> list[complex]:
        """Complex stiffness of every shaft, dashpots in it."""
        return [
            coupling_value(one["coupling"], now, frequency)
            if "coupling" in one
            else one["stiffness"] + 1j * frequency * one.get("damping", 0.0)
            for one in self.shafts
        ]

    def angles(self, speed: float, order: Array, load: Array, now: Conditions) -> Array:
        """Of the stations (m, n), complex, for torques (m, n) on them."""
        found = []
        for q, on in zip(order, load, strict=True):
            w, n = q * speed, len(self.inertia)
            matrix = np.diag(-(w**2) * self.inertia + 1j * w * self.absolute)
            for place, k in enumerate(self.stiffness(now, w)):
                ends = np.zeros(n)
                ends[place], ends[place + 1] = 1.0, -1.0
                matrix = matrix + k * np.outer(ends, ends)
            found.append(np.linalg.solve(matrix, on))
        return np.array(found)

    def torques(self, speed: float, order: Array, load: Array, now: Conditions) -> Array:
        """Of the coupling (m,), complex, for torques (m, n) on the stations."""
        angle = self.angles(speed, order, load, now)
        k = np.array([self.stiffness(now, q * speed)[self.place] for q in order])
        return k * (angle[:, self.place] - angle[:, self.place + 1])

    def under(self, speed: float, order: Array, load: Array, now: Conditions) -> Solved:
        """Everything under given conditions."""
        torque = self.torques(speed, order, load, now)
        power = sum(
            0.5
            * q
            * speed
            * abs(one) ** 2
            * (1.0 / coupling_value(self.given, now, q * speed)).imag
            for q, one in zip(order, torque, strict=True)
        )
        return Solved(order, torque, -float(power), now)

    def standing(self, speed: float, order: Array, load: Array, mean: float) -> Solved:
        """With the temperature and the vibratory torque that stand."""
        given = self.given
        air = given.get("ambient_temperature", 0.0)
        permitted = given.get("power_loss")
        if "power_loss_over_temperature" in given:
            rows = given["power_loss_over_temperature"]
            permitted = _between(air, rows["temperature"], rows["power_loss"])
        resistance = given.get("thermal_resistance", 0.0)
        if "temperature_rise" in given:
            resistance = given["temperature_rise"] / permitted
        start = given.get("temperature", air)

        def at(temperature: float) -> Solved:
            def missing(amplitude: float) -> float:
                now = Conditions(mean, temperature, amplitude)
                return self.under(speed, order, load, now).half_range - amplitude

            amplitude = 0.0
            if "over_amplitude" in given:
                amplitude = _root(missing, 0.0, 2.0 * given["over_amplitude"]["torque"][-1])
            return self.under(speed, order, load, Conditions(mean, temperature, amplitude))

        if not resistance or "over_temperature" not in given:
            found = at(start)
            warm = found.conditions._replace(temperature=start + resistance * found.power)
            return found._replace(conditions=warm)
        top = given["over_temperature"]["temperature"][-1]
        return at(_root(lambda one: air + resistance * at(one).power - one, air, top))

    def natural(self, now: Conditions, number: int) -> float:
        """Frequency of an undamped mode, counted from 0, of the line at this frequency itself."""

        def at(w: float) -> float:
            n, k = len(self.inertia), np.real(self.stiffness(now, w))
            ends = np.eye(n)[:-1] - np.eye(n)[1:]
            square = eigh(ends.T @ (k[:, None] * ends), np.diag(self.inertia), eigvals_only=True)
            return float(np.sqrt(max(square[number], 0.0)))

        w = at(0.0)
        for _ in range(200):
            w = at(w)
        return w


def _root(missing: Callable[[float], float], low: float, high: float) -> float:
    """The first root from below: steps until the sign changes, then a bracket closed."""
    steps = np.linspace(low, high, 41)
    for left, right in pairwise(steps.tolist()):
        if missing(right) <= 0.0:
            return float(brentq(missing, left, right, xtol=1e-12, rtol=1e-14))
    raise AssertionError("no root")


def half_range(order: Array, amplitude: Array) -> float:
    """(highest - lowest) / 2 over the cycle."""
    return 0.5 * (_extreme(order, amplitude) + _extreme(order, -amplitude))


def _extreme(order: Array, amplitude: Array) -> float:
    """Highest value over the cycle: samples, then Newton's method on the slope."""
    angle = np.linspace(0.0, 4.0 * np.pi, 2001)
    wave = np.real(amplitude @ np.exp(1j * np.outer(order, angle)))
    best = -np.inf
    for place in np.argsort(-wave)[:8]:
        at = angle[place]
        for _ in range(30):
            turned = amplitude * np.exp(1j * order * at)
            slope, bend = np.real(1j * order @ turned), np.real(-(order**2) @ turned)
            at -= slope / bend if bend < 0.0 else 0.0
        best = max(best, float(np.real(np.sum(amplitude * np.exp(1j * order * at)))), wave[place])
    return best
