"""Couplings by the full matrices of `dense_line.py`, brackets halved for what heats.

Nothing of the program takes part but the torques of its cylinders, which a result file holds.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from dense_line import Array, Conditions, DenseLine, ends, half_range
from scipy.optimize import brentq


class Standing(NamedTuple):
    """Torques (m,) of the coupling and angles (stations, m) by order, power loss, conditions."""

    order: Array
    torque: Array
    angle: Array
    power: float
    conditions: Conditions

    @property
    def lowest(self) -> float:
        return float(ends(self.order, self.torque)[0])

    @property
    def highest(self) -> float:
        return float(ends(self.order, self.torque)[1])

    @property
    def half_range(self) -> float:
        return float(half_range(self.order, self.torque))


class CoupledLine(DenseLine):
    """A line with one coupling, of a resolved case."""

    def __init__(self, case: Mapping[str, Any]):
        super().__init__(dict(case))
        shafts = self.line["shafts"]
        self.place = next(n for n, one in enumerate(shafts) if "coupling" in one)
        self.given = shafts[self.place]["coupling"]

    def in_conditions(self, speed: float, order: Array, load: Array, now: Conditions) -> Standing:
        """For torques (stations, m)."""
        found = self.under(speed, order * speed, load, np.zeros(self.count), now)
        heat = self.heat(found, speed)[0][self.place]
        return Standing(order, found.torque[self.place], found.angle, float(heat), now)

    def standing(self, speed: float, order: Array, load: Array, mean: float) -> Standing:
        """With the temperature and the vibratory torque that stand."""
        given = self.given
        air = given.get("ambient_temperature", 0.0)
        permitted = given.get("power_loss")
        if "power_loss_over_temperature" in given:
            rows = given["power_loss_over_temperature"]
            permitted = np.interp(air, rows["temperature"], rows["power_loss"])
        resistance = given.get("thermal_resistance", 0.0)
        if "temperature_rise" in given:
            resistance = given["temperature_rise"] / permitted
        start = given.get("temperature", air)

        def at(temperature: float) -> Standing:
            def missing(amplitude: float) -> float:
                now = Conditions(mean, temperature, amplitude)
                return self.in_conditions(speed, order, load, now).half_range - amplitude

            amplitude = 0.0
            if "over_amplitude" in given:
                amplitude = _root(missing, 0.0, 2.0 * given["over_amplitude"]["torque"][-1])
            return self.in_conditions(speed, order, load, Conditions(mean, temperature, amplitude))

        if not resistance or "over_temperature" not in given:
            found = at(start)
            warm = found.conditions._replace(temperature=start + resistance * found.power)
            return found._replace(conditions=warm)
        top = given["over_temperature"]["temperature"][-1]
        return at(_root(lambda one: air + resistance * at(one).power - one, air, top))

    def natural(self, now: Conditions, number: int) -> float:
        """Frequency of an undamped mode, counted from 0, of the line at this frequency itself."""
        w = 0.0
        for _ in range(200):
            w = float(self.undamped(self.speed, w, now)[number])
        return w


def _root(missing: Callable[[float], float], low: float, high: float) -> float:
    """The first root from below: steps until the sign changes, then a bracket closed."""
    steps = np.linspace(low, high, 41)
    for left, right in pairwise(steps.tolist()):
        if missing(right) <= 0.0:
            return float(brentq(missing, left, right, xtol=1e-12, rtol=1e-14))
    raise AssertionError("no root")
