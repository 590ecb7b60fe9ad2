"""Numbers of a shaft line and its torques as doubles, formed anew from a case."""

from typing import Any

import mpmath
import numpy as np
from exact_engine_drive import EngineDrive
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
        self.cycle = 2.0 * np.pi * turns
        with mpmath.workdps(DIGITS):
            line, drive = ExactLine(case), EngineDrive(case, self.order.tolist(), all_fire=True)
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
            firing = [float(v) for v in drive.firing]
            own = [
                np.array([complex(v) for v in drive.own_inertia(mass)])
                * np.exp(-1j * self.order * f)
                for mass, f in zip(drive.mass, firing, strict=True)
            ]
            gas = [np.array([complex(v) for v in (mean, *waves)]) for waves, mean in drive.gas]
        self.card_speed = np.array([float(v) for v in drive.speeds])
        n, m = len(self.inertia), len(self.order)
        freedom = self.built.freedom[self.built.cylinder_station]
        #: of each card, cylinder and order (mean first): gas; of all: inertia per squared speed
        self.gas_of = np.zeros((len(gas), len(freedom), n, m + 1), dtype=complex)
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
