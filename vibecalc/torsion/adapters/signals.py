"""What named sections and stations of a shaft line do by order, and where that is largest."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.numerics.rounding import FloatArray, IntArray, distinct
from vibecalc.torsion.adapters.critical import STILL, UndampedResonances
from vibecalc.torsion.adapters.curves import (
    SAMPLES,
    OrderSolution,
    actual_per_referred,
    gear_torques,
    speeds_at_once,
)
from vibecalc.torsion.adapters.loads import endless_loads
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.critical_speeds import (
    NEARBY_NARROW_RESONANCE,
    REFINED,
    SHOWN,
    Maxima,
    Value,
    largest,
)
from vibecalc.torsion.curve_tables import OF_SECTIONS

# ----------------------------------------------------------------------------
# Torque, stress and twist of sections, angle, angular speed and acceleration of stations.
# ----------------------------------------------------------------------------


class Signal(NamedTuple):
    """One quantity of places (r,) among the sections, stations or gears of a line."""

    name: str
    place: IntArray

    @property
    def of_sections(self) -> bool:
        """Whether the places are sections."""
        return self.name in OF_SECTIONS

    def of(self, setup: Setup, state: OrderSolution) -> Any:
        """By order (..., m, r), complex, 0-to-peak, actual; bounded where the state is."""
        shaft, place = setup.shaft, self.place
        if self.name == "gear":
            torque = gear_torques(shaft, setup.drive, setup.model, state)
            return (torque * actual_per_referred(shaft))[..., place]
        if self.of_sections:
            ratio = shaft.section_ratio[place]
            if self.name == "twist":
                return state.twist[..., place] * ratio
            modulus = shaft.section_modulus[place] if self.name == "stress" else 1.0
            return state.torque[..., place] / (ratio * modulus)
        angle = state.angle[..., shaft.freedom[place]] * shaft.station_ratio[place]
        w = state.frequency[..., None]
        if self.name == "unevenness":  # twice the angular speed over the mean one, as half ranges
            mean = np.abs(shaft.station_ratio[place]) * state.speed[:, None, None]
            return angle * (2j * w / mean)
        if self.name == "angular_speed":
            return angle * (1j * w)
        return angle * -np.square(w) if self.name == "angular_acceleration" else angle

    def endless(self, setup: Setup, undamped: UndampedResonances) -> FloatArray:
        """The lowest speeds (r,) at which nothing damps the places, NaN for none."""
        if self.name == "gear":
            return endless_loads(setup, undamped)[len(setup.shaft.section_names) :][self.place]
        found = np.full(len(self.place), np.nan)
        for at, moves in self.moved(setup, undamped)[::-1]:
            found[moves] = at
        return found

    def moved(self, setup: Setup, undamped: UndampedResonances) -> list[tuple[float, Any]]:
        """For each undamped resonance its speed, and which of the places move in its mode."""
        line, shape = setup.model.line, setup.natural().shape[undamped.mode - 1]
        if self.of_sections:
            size, place = np.abs(shape[:, line.first] - shape[:, line.second]), self.place
        else:
            size, place = np.abs(shape), setup.shaft.freedom[self.place]
        rows = size[:, place] > STILL * np.max(size, axis=1, initial=0.0)[:, None]
        return list(zip(undamped.speed.tolist(), rows, strict=True))


def stations_of(setup: Setup, named: Sequence[str]) -> IntArray:
    """Places of stations by their names."""
    return np.array([setup.shaft.station_names.index(one) for one in named])


# ----------------------------------------------------------------------------
# The largest of many curves over a range, between the speeds of a sweep too.
# ----------------------------------------------------------------------------


def with_narrow(setup: Setup, speed: FloatArray, order: FloatArray) -> FloatArray:
    """The speeds (s,) with those about resonances of some orders (m,) too narrow for their steps.

    Without those that nothing damps.
    """
    natural = setup.natural()
    some = np.flatnonzero(~natural.silent & (natural.damping_ratio > 0.0))
    at = (natural.frequency[some, None] / order).ravel()
    width = np.repeat(natural.damping_ratio[some], len(order)) * at
    step = np.diff(speed, append=speed[-1] + (speed[-1] - speed[-2] if len(speed) > 1 else 1.0))
    here = step[np.clip(np.searchsorted(speed, at) - 1, 0, len(speed) - 1)]
    narrow = (width < SHOWN * here) & (width > 1e-11 * at)
    extra = at[narrow, None] + width[narrow, None] * NEARBY_NARROW_RESONANCE
    return distinct(np.concatenate([speed, extra[(extra > speed[0]) & (extra < speed[-1])]]))


def some_rows(at: Callable[[FloatArray], FloatArray]) -> Callable[[IntArray], Value]:
    """Values of chosen rows, each at speeds of its own, from all rows (r, s) at speeds (s,)."""

    def make(row: IntArray) -> Value:
        def value(speed: FloatArray) -> FloatArray:
            flat, place = np.unique(speed, return_inverse=True)
            return np.asarray(at(flat)[row[:, None], place.reshape(speed.shape)])

        return value

    return make


def some_speeds(speed: FloatArray) -> FloatArray:
    """Speeds at equal steps, at which errors of curves are read."""
    place = np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)
    return np.asarray(speed[place])


def tops(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    undamped: FloatArray,
    endless: FloatArray,
) -> Maxima:
    """The largest of each row of `curve` (s, r) at any speed.

    `undamped` (u,) and `endless` (r,) are as in `largest`; `make` gives the values of some rows at
    speeds of their own.
    """
    parts = []
    for start in range(0, curve.shape[1], REFINED):
        rows = np.arange(start, min(start + REFINED, curve.shape[1]))

        def some(chosen: IntArray, rows: IntArray = rows) -> Value:
            return make(rows[chosen])

        parts.append(largest(some, curve[:, rows], speed, undamped, endless[rows]))
    joined = [np.concatenate(each) for each in zip(*parts, strict=True)]
    return Maxima(np.arange(curve.shape[1]), *joined[1:])


def blocks(model: Model, drive: Drive, count: int, copies: int = 1) -> list[slice]:
    """Parts of so many speeds that are solved at once, for so many loads at once."""
    size = max(1, speeds_at_once(model, drive) // copies)
    size = max(1, -(-count // max(1, -(-count // size))))
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
