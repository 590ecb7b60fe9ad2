"""A shaft line solved another way: full matrices in the stations' own angles, gears as constraints.

Nothing is referred to the crankshaft: rigid gears are equations between angles, which the basis of
their null space takes out; a harmonic of a torque is a vector, its response one full solve.
"""

from typing import Any, NamedTuple

import numpy as np


class Harmonic(NamedTuple):
    """Order of the reference shaft or frequency in rad/s; station, complex amplitude in N m."""

    order: float
    frequency: float
    station: str
    amplitude: complex
    cycle: str


class DenseLine:
    """Stations, shafts and gears of a validated case (SI), constants only."""

    def __init__(self, case: Any) -> None:
        self.case, line = case, case.machine.shaft_line
        self.names = [one.name for one in line.stations]
        self.at = {name: place for place, name in enumerate(self.names)}
        n = len(self.names)
        self.inertia = np.diag([float(one.inertia) for one in line.stations])
        self.damping = np.diag([float(one.absolute_damping) for one in line.stations])
        self.stiffness = np.diag([float(one.ground_stiffness) for one in line.stations]).astype(
            complex
        )
        ends = [one.between for one in line.shafts]
        if not any(ends):
            ends = list(zip(self.names, self.names[1:], strict=False))
        self.shafts = []
        for shaft, (first, second) in zip(line.shafts, ends, strict=True):
            row = np.zeros(n)
            row[self.at[first]], row[self.at[second]] = 1.0, -1.0
            self.add(row, shaft.stiffness * (1.0 + 1j * shaft.loss_factor), shaft.damping or 0.0)
            stiffness = shaft.stiffness * (1.0 + 1j * shaft.loss_factor)
            self.shafts.append((shaft.name, row, stiffness, shaft.damping or 0.0))
        rigid = []
        for gear in line.gears:
            first, second = (self.at[name] for name in gear.between)
            size = gear.ratio or gear.teeth[0] / gear.teeth[1]
            row = np.zeros(n)
            row[second], row[first] = 1.0, size if gear.reverses else -size
            if gear.mesh_stiffness is None:
                rigid.append(row)
            else:  # along the line of action, by the radius of the second wheel
                self.add(row * gear.pitch_radius / size, gear.mesh_stiffness, 0.0)
        self.basis = np.eye(n)
        if rigid:
            _, _, v = np.linalg.svd(np.array(rigid))
            self.basis = v[len(rigid) :].T
        self.ratio = self.speeds(line)

    def add(self, row: np.ndarray, stiffness: complex, damping: float) -> None:
        """A spring and a dashpot on a combination of angles."""
        self.stiffness += stiffness * np.outer(row, row)
        self.damping += damping * np.outer(row, row)

    def speeds(self, line: Any) -> np.ndarray:
        """Own speeds over that of the reference: what no spring and no gear resists."""
        free = self.basis.T @ self.stiffness.real @ self.basis
        values, vectors = np.linalg.eigh(free)
        rigid = self.basis @ vectors[:, 0]
        assert abs(values[0]) < 1e-9 * values[-1]
        start = next(
            (k for k, one in enumerate(line.stations) if one.cylinder or one.cylinders),
            self.at[line.speed_of or self.names[0]],
        )
        return np.asarray(rigid / rigid[start])

    def frequencies(self) -> np.ndarray:
        """Undamped natural frequencies in rad/s, ascending."""
        from scipy.linalg import eigh

        inertia = self.basis.T @ self.inertia @ self.basis
        values = eigh(self.basis.T @ self.stiffness.real @ self.basis, inertia, eigvals_only=True)
        return np.sqrt(np.maximum(values, 0.0))

    def angles(self, w: float, station: str, amplitude: complex) -> np.ndarray:
        """Own angles (n,) for one torque at one frequency, positive as its station turns."""
        dynamic = self.stiffness - w**2 * self.inertia + 1j * w * self.damping
        load = np.zeros(len(self.names), dtype=complex)
        load[self.at[station]] = amplitude * np.sign(self.ratio[self.at[station]])
        basis = self.basis
        return np.asarray(basis @ np.linalg.solve(basis.T @ dynamic @ basis, basis.T @ load))

    def torques(self, w: float, angle: np.ndarray) -> np.ndarray:
        """Of the shafts (e,)."""
        return np.array([(k + 1j * w * c) * (row @ angle) for _, row, k, c in self.shafts])

    def by_cycle(self, speed: float, harmonics: list[Harmonic]) -> dict[str, dict[float, Any]]:
        """Torques (e,) of shafts by cycle and the order in it: own order, or frequency."""
        found: dict[str, dict[float, Any]] = {}
        for one in harmonics:
            w = one.frequency or one.order * speed
            torque = self.torques(w, self.angles(w, one.station, one.amplitude))
            rows = found.setdefault(one.cycle, {})
            rows[w] = rows.get(w, 0.0) + torque
        return found

    def half_ranges(
        self, speed: float, harmonics: list[Harmonic], samples: int = 1 << 17
    ) -> np.ndarray:
        """Half ranges (e,) of shaft torques: of each cycle by samples, all cycles together."""
        total = np.zeros(len(self.shafts))
        for rows in self.by_cycle(speed, harmonics).values():
            base = min(rows)
            multiples = [w / base for w in rows]
            # halves, if any
            base = base / 2.0 if any(abs(m - round(m)) > 1e-6 for m in multiples) else base
            number = np.rint(np.array(list(rows)) / base)
            angle = np.linspace(0.0, 2.0 * np.pi, samples, endpoint=False)
            wave = np.exp(1j * np.outer(angle, number)) @ np.array(list(rows.values()))
            total += 0.5 * (_highest(wave.real) + _highest(-wave.real))
        return total


def _highest(signal: np.ndarray) -> np.ndarray:
    """Highest values of periodic signals (s, e): the vertex of a parabola through three samples."""
    top = np.argmax(signal, axis=0)
    column = np.arange(signal.shape[1])
    before, here, after = (signal[(top + step) % len(signal), column] for step in (-1, 0, 1))
    bend = before - 2.0 * here + after
    safe = np.where(bend < 0.0, bend, -1.0)
    return np.asarray(np.where(bend < 0.0, here - (after - before) ** 2 / (8.0 * safe), here))
