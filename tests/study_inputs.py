"""Numbers of a shaft line and its torques as doubles, formed anew from a case."""

from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from exact_engine_drive import exact_firing, masses_of
from exact_engine_line import ExactLine

from vibecalc.schema import Case

DIGITS = 24


class StudyInputs:
    """n freedoms, e elements, m orders; names and numbers of freedoms are those of the case."""

    def __init__(self, case: Case) -> None:
        torsion, machine = case.response.torsion, case.machine
        asked = torsion.orders
        self.order = asked.step * np.arange(1, asked.count + 1)
        self.speed, self.torsion = float(machine.speed), torsion
        turns = 1 if machine.cycle == "two_stroke" else 2
        with mpmath.workdps(DIGITS):
            line = ExactLine(case)
            self.built = line.built
            self.inertia, self.absolute, self.ground = (
                np.array([float(v) for v in part])
                for part in (line.inertia, line.damped, line.ground)
            )
            rows = line.at(mpmath.mpf(self.speed))
            self.first, self.second = (np.array([row[k] for row in rows]) for k in (0, 1))
            self.stiffness, self.damping = (
                np.array([float(row[k]) for row in rows]) for k in (2, 3)
            )
            self.section_ratio = np.array([float(r) for r in line.section_ratio])
            self.ratio = np.array([float(r) for r in line.ratio])
            firing = [float(v) for v in exact_firing(case, 2 * mpmath.mp.pi * turns)[1]]
            mass = [float(v) for v in masses_of(case)[0]]
        train, self.cycle = machine.crank_train, 2.0 * np.pi * turns
        own = [m * self._moved(train) * np.exp(-1j * self.order * f)
               for m, f in zip(mass, firing, strict=True)]  # fmt: skip
        cards = [card.gas_pressure for card in train.gas_cards] or [train.gas_pressure]
        self.card_speed = np.array([card.speed for card in train.gas_cards])
        gas = [self._gas(train, card) for card in cards]
        n, m = len(self.inertia), len(self.order)
        freedom = self.built.freedom[self.built.cylinder_station]
        #: of each card, cylinder and order (mean first): gas; of all: inertia per squared speed
        self.gas_of = np.zeros((len(cards), len(freedom), n, m + 1), dtype=complex)
        self.inertial = np.zeros((n, m + 1), dtype=complex)
        for c, f in enumerate(freedom):
            r = self.ratio[self.built.cylinder_station[c]]
            self.inertial[f, 1:] += r * own[c]
            turned = np.append(1.0, np.exp(-1j * self.order * firing[c]))
            for k, values in enumerate(gas):
                self.gas_of[k, c, f] = r * values * turned
        self.element = np.zeros((len(self.first), n))
        index = np.arange(len(self.first))
        self.element[index, self.first] += 1.0
        self.element[index, self.second] -= 1.0

    def _path(self, train: Any, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivative of the pin's place by the angle."""
        r, across = train.crank_radius, train.crank_radius * np.sin(angle) - train.wrist_pin_offset
        rod, along = np.sqrt(train.rod_length**2 - across**2), r * np.cos(angle)
        tilt = along * across / rod
        first = -r * np.sin(angle) - tilt
        return first, -along - (along**2 - across * r * np.sin(angle) + tilt**2) / rod

    def _moved(self, train: Any) -> np.ndarray:
        """Harmonics of -s' s'', the inertia torque of one kilogram at one rad/s."""
        angle = np.arange(256) * (2.0 * np.pi / 256)
        first, second = self._path(train, angle)
        wave = np.exp(-1j * self.order[:, None] * angle)
        return np.where(self.order % 1.0 == 0.0, -2.0 * (wave @ (first * second)) / 256, 0.0)

    def _gas(self, train: Any, card: Any) -> np.ndarray:
        """Mean and harmonics of -p A s', by Gauss's rule between the rows of a card."""
        at, value = np.array(card.crank_angle), np.array(card.pressure)
        at[-1], value[-1] = at[0] + self.cycle, value[0]
        nodes, weights = np.polynomial.legendre.leggauss(24)
        edges = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(at)] + [at[-1:]])
        wide = np.diff(edges)[:, None]
        angle = (edges[:-1, None] + 0.5 * wide * (nodes + 1.0)).ravel()
        area = 0.25 * np.pi * train.bore**2
        torque = -area * np.interp(angle, at, value) * self._path(train, angle)[0]
        torque = torque * (0.5 * wide * weights).ravel() / self.cycle
        wave = np.exp(-1j * self.order[:, None] * angle)
        return np.append(torque.sum(), 2.0 * wave @ torque)

    def weights(self, speed: Any) -> np.ndarray:
        """Of the cards at speeds (...), (..., c)."""
        if len(self.card_speed) == 0:
            return np.ones((*np.shape(speed), 1))
        unit = np.eye(len(self.card_speed))
        return np.stack([np.interp(speed, self.card_speed, row) for row in unit], axis=-1)

    def by_cylinder(self, speed: float) -> np.ndarray:
        """Gas torque (cylinders, n, m + 1), the mean first."""
        return np.tensordot(self.weights(speed), self.gas_of, 1)

    def gas(self, speed: float) -> np.ndarray:
        return self.by_cylinder(speed).sum(axis=0)

    def taken(self, speed: Any) -> np.ndarray:
        """What `loads` take from each freedom at speeds (...), (..., n), braking."""
        out = np.zeros((*np.shape(speed), len(self.inertia)))
        for station, torque, power in zip(
            self.built.taken_station, self.built.taken_torque, self.built.taken_exponent,
            strict=True,
        ):  # fmt: skip
            own = abs(self.ratio[station]) * torque * (speed / self.speed) ** power
            out[..., self.built.freedom[station]] += own
        return out

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """K and C (n, n)."""
        stiffness = (self.element.T * self.stiffness) @ self.element + np.diag(self.ground)
        damping = (self.element.T * self.damping) @ self.element + np.diag(self.absolute)
        return stiffness, damping
