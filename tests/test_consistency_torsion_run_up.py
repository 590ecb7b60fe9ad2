"""Claim: a run through several gas cards is the motion that an integrator finds.

The torque follows the momentary speed: between two cards its harmonics are linear in the speed, a
fan takes its power of the speed. Here the harmonics are integrals over the straight lines of
the cards, the equations are those of the stations' angles, and DOP853 solves them with rtol 1e-10.
"""

from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from long_but import long_but
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vibecalc.core.study.execute import execute, load_checked

ANGLES = np.deg2rad([-180.0, -40.0, 0.0, 12.0, 60.0, 180.0])
#: gauge pressures in bar by speed in rad/s: combustion grows, and shrinks again
CARDS = {20.0: [0, 15, 40, 44, 6, 0], 31.0: [0, 24, 70, 95, 12, 0], 40.0: [0, 20, 60, 66, 16, 0]}
RADIUS, ROD, BORE, MASS = 0.2, 0.6, 0.25, 30.0
INERTIA, BETWEEN = np.array([9.0, 9.0, 40.0]), ((0, 1), (1, 2))
STIFFNESS, DAMPING, ABSOLUTE = np.array([9e4, 6e4]), np.array([60.0, 90.0]), np.array([4.0, 4.0, 9])
HIGHEST, SPEED, TAKEN, POWER = 6, 40.0, 900.0, 2.3
ORDER = np.arange(1, HIGHEST + 1)
FIRING = np.array([0.0, np.pi])
#: from and to in rad/s, seconds of the change, of the time after it
RUNS = {"run_up": (20.0, 40.0, 0.4, 0.05), "run_down": (39.0, 22.0, 0.7, 0.05)}


def case(kind: str) -> str:
    begin, end, lasts, after = RUNS[kind]
    degrees = [f"{a:.12g} deg" for a in np.rad2deg(ANGLES)]
    cards = ", ".join(
        f"{{ speed = {speed}, gas_pressure = {{ crank_angle = {degrees}, "
        f"pressure = {[f'{p} bar' for p in row]} }} }}"
        for speed, row in CARDS.items()
    )  # fmt: skip
    stations = ", ".join(
        f'{{ name = "{k}", inertia = {j}, absolute_damping = {c}'
        + (f', cylinder = "{k}" }}' if k < 2 else " }")
        for k, (j, c) in enumerate(zip(INERTIA, ABSOLUTE, strict=True))
    )
    shafts = ", ".join(
        f'{{ name = "s{a}", between = ["{a}", "{b}"], stiffness = {k}, damping = {c} }}'
        for (a, b), k, c in zip(BETWEEN, STIFFNESS, DAMPING, strict=True)
    )
    return f"""schema = 1
title = "two cylinders and a wheel"
[machine]
kind = "engine"
cycle = "two_stroke"
speed = {SPEED}
[machine.crank_train]
crank_radius = {RADIUS}
rod_length = {ROD}
bore = {BORE}
reciprocating_mass = {MASS}
cylinders = [{{ name = "0" }}, {{ name = "1" }}]
firing_order = ["0", "1"]
gas_cards = [{cards}]
[machine.shaft_line]
stations = [{stations}]
shafts = [{shafts}]
load = "2"
loads = [{{ on = "1", torque = {TAKEN}, exponent = {POWER} }}]
[response.torsion]
orders = {{ highest = {HIGHEST} }}
[response.torsion.transient]
kind = "{kind}"
from = {begin}
to = {end}
duration = {lasts}
after = {after}
"""


def slope(angle: np.ndarray) -> np.ndarray:
    """ds/dt of the wrist pin's place against the angle from the top dead centre."""
    across = RADIUS * np.sin(angle)
    return -across * (1.0 + RADIUS * np.cos(angle) / np.sqrt(ROD**2 - across**2))


def gas(pressure: list[float]) -> np.ndarray:
    """Mean and harmonics of -p A s' of one cylinder over its own angle."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    total = np.zeros(HIGHEST + 1, dtype=complex)
    for low, high in pairwise(np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in
                                              pairwise(ANGLES)] + [ANGLES[-1:]])):  # fmt: skip
        at = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        torque = -1e5 * np.interp(at, ANGLES, pressure) * 0.25 * np.pi * BORE**2 * slope(at)
        wave = np.exp(-1j * np.append(0, ORDER)[:, None] * at)
        total += wave @ (torque * weights) * (high - low) / (4.0 * np.pi)
    return total * np.append(1.0, np.full(HIGHEST, 2.0))


def moved() -> np.ndarray:
    """Harmonics of -m s' s'' at one rad/s, the half square of s' derived in the Fourier sum."""
    angle = 2.0 * np.pi * np.arange(512) / 512
    square = np.fft.fft(-0.5 * MASS * slope(angle) ** 2) / 512
    return 2.0 * (1j * np.arange(512) * square)[1 : HIGHEST + 1]


class Motion:
    """The prescribed motion and the balanced torques on the three stations."""

    def __init__(self, kind: str) -> None:
        self.begin, self.end, self.lasts, self.after = RUNS[kind]
        self.speeds = np.array(list(CARDS))
        self.cards = np.array([gas(row) for row in CARDS.values()])
        self.inertial = moved()
        link = np.zeros((2, 3))
        for k, (a, b) in enumerate(BETWEEN):
            link[k, a], link[k, b] = 1.0, -1.0
        self.link = link
        self.stiffness = link.T @ np.diag(STIFFNESS) @ link
        self.damping = link.T @ np.diag(DAMPING) @ link + np.diag(ABSOLUTE)

    def course(self, time: float) -> tuple[float, float, float]:
        """Angle, speed, acceleration: it grows over a tenth of the time and fades over a tenth."""
        ramp = 0.1 * self.lasts
        top = (self.end - self.begin) / (0.9 * self.lasts)
        if time <= ramp:
            grown = top / ramp * time
            return self.begin * time + grown * time**2 / 6, self.begin + grown * time / 2, grown
        if time <= self.lasts - ramp:
            since = time - ramp
            speed = self.begin + 0.5 * top * ramp
            angle = self.begin * ramp + top * ramp**2 / 6
            return angle + (speed + top * since / 2) * since, speed + top * since, top
        whole = 0.5 * (self.begin + self.end) * self.lasts
        left = self.lasts - time
        if left < 0.0:
            return whole - self.end * left, self.end, 0.0
        fade = top / ramp * left
        return whole - self.end * left + fade * left**2 / 6, self.end - fade * left / 2, fade

    def waves(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """Mean torque and complex torques (orders, 3), the cylinders at their firing angles."""
        place = min(int(np.searchsorted(self.speeds, speed, side="right")), 2) - 1
        low, high = self.speeds[place : place + 2]
        share = (speed - low) / (high - low)
        card = (1.0 - share) * self.cards[place] + share * self.cards[place + 1]
        own = (card[1:] + speed**2 * self.inertial)[:, None] * np.exp(-1j * np.outer(ORDER, FIRING))
        return card[0].real, np.concatenate([own, np.zeros((HIGHEST, 1))], axis=1)

    def force(self, angle: float, speed: float, acceleration: float) -> np.ndarray:
        mean, waves = self.waves(speed)
        steady = mean * np.array([1.0, 1.0, 0.0]) - INERTIA * acceleration
        steady[1] -= TAKEN * (speed / SPEED) ** POWER
        # the wheel takes what is left
        steady[2] -= steady.sum()
        return np.asarray((np.exp(1j * ORDER * angle) @ waves).real + steady)

    def start(self) -> np.ndarray:
        """Angles and speeds of the steady vibration at the first speed, at crank angle zero."""
        _, waves = self.waves(self.begin)
        still = self.force(0.0, self.begin, 0.0) - waves.sum(axis=0).real
        state = np.append(np.linalg.lstsq(self.stiffness, still, rcond=1e-12)[0], np.zeros(3))
        for order, wave in zip(ORDER * self.begin, waves, strict=True):
            matrix = self.stiffness - order**2 * np.diag(INERTIA) + 1j * order * self.damping
            angle = np.linalg.solve(matrix, wave)
            state += np.append(angle.real, (1j * order * angle).real)
        return state

    def rates(self, time: float, state: np.ndarray) -> np.ndarray:
        force = self.force(*self.course(time))
        force = force - self.stiffness @ state[:3] - self.damping @ state[3:]
        return np.append(state[3:], force / INERTIA)

    def torque(self, wanted: np.ndarray) -> np.ndarray:
        """Torques (t, 2) of the shafts at rising times, DOP853 from corner to corner."""
        ramp, total = 0.1 * self.lasts, self.lasts + self.after
        passed = [
            brentq(lambda t, c=card: self.course(t)[1] - c, 0.0, self.lasts, xtol=1e-15)
            for card in self.speeds
            if min(self.begin, self.end) < card < max(self.begin, self.end)
        ]
        corners = sorted([0.0, ramp, self.lasts - ramp, self.lasts, total, *passed])
        state, found = self.start(), []
        for low, high in pairwise(corners):
            inside = wanted[(wanted > low) & (wanted <= high)]
            part = solve_ivp(
                self.rates, (low, high), state, "DOP853", np.union1d(inside, high),
                rtol=1e-10, atol=1e-12,
            )  # fmt: skip
            state = part.y[:, -1]
            found.append(part.y[:, : inside.size])
        angle, rate = np.split(np.concatenate(found, axis=1), 2)
        torque = STIFFNESS[:, None] * (self.link @ angle) + DAMPING[:, None] * (self.link @ rate)
        return np.asarray(torque.T)


@pytest.mark.parametrize("kind", long_but(RUNS, "run_up"))
def test_a_run_over_several_cards_is_that_of_the_equations(kind: str) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "engine.toml"
        path.write_text(case(kind), encoding="utf-8")
        record = execute(load_checked([path])[0]).record
    peak, when = (record[f"response/torsion/transient/peak{name}"] for name in ("", "_time"))
    motion = Motion(kind)
    wanted = np.union1d(np.linspace(0.0, motion.lasts + motion.after, 2001)[1:], when.values)
    torque = np.abs(motion.torque(wanted))
    # what the integrator may be off
    slack = 1e-8 * torque.max()
    there = torque[np.searchsorted(wanted, when.values), [0, 1]]
    assert np.all(np.abs(there - peak.values) <= peak.error_estimate + slack)
    assert np.all(torque.max(axis=0) <= peak.values + peak.error_estimate + slack)
    assert peak.error_estimate < 1e-6 * peak.values.min()
