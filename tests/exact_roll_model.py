"""One roll machine in plain floats: masses, torques and what links energy and speed.

Nothing here is taken from vibecalc but the coefficients of the curves; see `exact_roll`.
"""

from itertools import pairwise
from math import asin, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from vibecalc.roll.mechanism import RollDrive, RollMachine

TURN = 2.0 * pi


class Stall(Exception):
    """The crank comes to rest: no running state above the speed of the start."""


class Masses(NamedTuple):
    """J, N, Q at one crank angle with their slopes, and dr/db of the pistons."""

    shell: float
    coupling: float
    crank: float
    shell_slope: float
    coupling_slope: float
    crank_slope: float
    strokes: list[float]


class Model:
    """One machine and its drive in plain floats."""

    def __init__(self, machine: RollMachine, drive: RollDrive, place: tuple[int, ...] = ()):
        taken = {name: np.asarray(value)[place] for name, value in machine._asdict().items()}
        self.__dict__.update({k: v.tolist() for k, v in taken.items()})
        self.drive = drive
        every, shape = drive.synchronous_speed, np.shape(machine.crank_radius)
        # one speed may stand for all machines
        self.synchronous = float(
            every.flat[0] if every.size == 1 else np.broadcast_to(every, shape)[place]
        )
        edges = {0.0, TURN}
        if not any(gas is not None and len(gas.node) for gas in drive.gas):
            # a long stretch would follow a piece of the motor's curve far beyond its end
            edges |= {*np.linspace(0.0, TURN, 37).tolist()}
        straight = asin(self.wrist_pin_offset / (self.rod_length + self.crank_radius))
        folded = asin(self.wrist_pin_offset / (self.rod_length - self.crank_radius))
        for gas, offset in zip(drive.gas, self.crank_angle_offset, strict=True):
            if gas is not None:
                edges |= {float(x) for x in np.mod(gas.node - offset, TURN)}
            if self.piston_friction:
                edges |= {(dead - offset) % TURN for dead in (straight, pi + folded)}
        ordered = sorted(edges)
        self.edges = [a for a, b in pairwise(ordered) if b - a > 1e-9]
        self.edges = [0.0, *self.edges[1:], TURN]

    def masses(self, beta: float) -> Masses:
        j, n, q = self.shell_inertia + self.rotor_inertia, self.rotor_inertia, self.rotor_inertia
        j1 = n1 = q1 = 0.0
        strokes = []
        e = self.wrist_pin_offset
        for phase, m, d in zip(
            self.crank_angle_offset,
            self.reciprocating_mass,
            self.rod_inertia_difference,
            strict=True,
        ):
            x, y = self.crank_radius * cos(beta + phase), self.crank_radius * sin(beta + phase)
            # the rod leans by phi with tan(phi) = (y - e) / c, and its angle in the shell is -phi
            c = sqrt((self.rod_length - (y - e)) * (self.rod_length + (y - e)))
            r, lean = x + c, (y - e) / c
            r1 = -y - lean * x
            lean1 = (x + lean * lean * x) / c
            r2 = -x - lean1 * x + lean * y
            turn = -x / c
            turn1 = y / c - x * lean * x / c**2
            j += m * (r * r + e * e) + d
            n += d * turn - m * e * r1
            q += m * r1 * r1 + d * turn * turn
            j1 += 2.0 * m * r * r1
            n1 += d * turn1 - m * e * r2
            q1 += 2.0 * (m * r1 * r2 + d * turn * turn1)
            strokes.append(r1)
        return Masses(j, n, q, j1, n1, q1, strokes)

    def gas_pieces(self, middle: float) -> list[tuple[float, list[float]] | None]:
        """For the piece with that middle: the angle at which each polynomial begins, its terms."""
        found: list[tuple[float, list[float]] | None] = []
        for gas, offset in zip(self.drive.gas, self.crank_angle_offset, strict=True):
            if gas is None or not len(gas.node):
                found.append(None)
                continue
            own = middle + offset
            ahead = np.mod(own - gas.node, TURN)
            place = int(np.argmin(ahead))
            found.append((own - float(ahead[place]) - offset, gas.coefficient[place].tolist()))
        return found

    def gas_torque(self, beta: float, strokes: list[float], pieces: list) -> float:
        total = 0.0
        for piece, stroke, scale, gas, offset in zip(
            pieces,
            strokes,
            self.gas_scale,
            self.drive.gas,
            self.crank_angle_offset,
            strict=True,
        ):
            if piece is not None:
                force = horner(piece[1], beta - piece[0])
            elif gas is not None:
                k = np.arange(len(gas.harmonics))
                force = float(np.real(np.exp(1j * k * (beta + offset)) @ gas.harmonics))
            else:
                force = 0.0
            total -= scale * force * stroke
        return total

    def motor(self, speed: float, piece: int) -> float:
        curve = self.drive.motor
        return self.motor_scale * horner(
            curve.coefficient[piece].tolist(), self.synchronous - speed - float(curve.base[piece])
        )

    def motor_slope(self, speed: float, piece: int) -> float:
        """Torque by slip, N m s/rad."""
        curve = self.drive.motor
        away = self.synchronous - speed - float(curve.base[piece])
        rows = curve.coefficient[piece].tolist()
        return self.motor_scale * horner([k * row for k, row in enumerate(rows)][1:], away)

    def speed(
        self, beta: float, energy: float, momentum: float, now: Masses | None = None
    ) -> float:
        now = self.masses(beta) if now is None else now
        square = 2.0 * energy - momentum**2 / now.shell
        if square <= 0.0:
            raise Stall(f"at a crank angle of {beta:.3f} rad")
        return sqrt(square / (now.crank - now.coupling**2 / now.shell))

    def energy(self, beta: float, speed: float, momentum: float) -> float:
        now = self.masses(beta)
        effective = now.crank - now.coupling**2 / now.shell
        return 0.5 * (effective * speed**2 + momentum**2 / now.shell)

    def friction(self, speed: float, strokes: list[float]) -> float:
        slid = sum(abs(stroke) for stroke in strokes)
        return self.friction_torque + self.piston_friction * slid + self.friction_damping * speed


def horner(terms: list[float], x: float) -> float:
    value = 0.0
    for term in reversed(terms):
        value = value * x + term
    return value
