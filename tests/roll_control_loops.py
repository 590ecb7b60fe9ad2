"""Controlled machines for tests, and what is true of them by other means than the package's."""

import numpy as np
from mpmath import mp, mpc, mpf
from roll_machines import GRAVITY, SYNCHRONOUS, source_drive, source_machine

from vibecalc.roll.control.gains import LoopLoad
from vibecalc.roll.control.loop import Controller, Loop, ReducedModel, source_model
from vibecalc.roll.mechanism import Inertia, gas_forces, gas_torque, inertia

MOTOR_GAIN = 203.4
SOURCE = source_model(20.7 / GRAVITY, 1488.0 / GRAVITY, MOTOR_GAIN)
TARGET = 94.25 - 303.3 / MOTOR_GAIN


def source_load(first: float = 345.6, second: float = 472.2) -> LoopLoad:
    """The torque of the source's eq. 97; its phases are lags, so they are subtracted."""
    phase = np.exp(-1j * np.radians([271.0, 64.7]))
    return LoopLoad(94.25, -303.3, np.array([first, second]) * phase)


def load_by_hand(speed: float) -> tuple[LoopLoad, Inertia]:
    """Of gas and inertia at a constant speed, the shell held still, and the inertias of the turn.

    Sums over even angles: kinks of the gas tables leave some 1e-5 of the torque.
    """
    angle = np.arange(7200) * np.pi / 3600.0
    machine, drive = source_machine(), source_drive()
    part = inertia(machine, angle)
    torque = gas_torque(part, gas_forces(machine, drive, angle)) - 0.5 * speed**2 * part.crank_slope
    harmonic = np.fft.rfft(torque) / len(angle)
    return LoopLoad(SYNCHRONOUS, harmonic[0].real, 2.0 * harmonic[1:11]), part


def random_loops(seed: int, count: int, late: bool) -> tuple[ReducedModel, Controller]:
    """Machines and gains of all signs and sizes, some with a delay, a lag or neither."""
    draw = np.random.default_rng(seed)
    model = ReducedModel(
        draw.uniform(0.5, 5.0, count), draw.uniform(0.005, 0.2, count),
        10.0 ** draw.uniform(1.0, 3.0, count), draw.uniform(0.0, 5.0, count),
    )  # fmt: skip
    gain = 10.0 ** draw.uniform(-0.5, 1.7, count)
    # feedback through the shell, in parts of the rotor's inertia
    share = draw.choice([-1.0, 1.0], count, p=[0.7, 0.3]) * 10.0 ** draw.uniform(-1.5, 1.2, count)
    feedback = share * model.inertia / (gain * model.motor_gain * model.ratio)
    lag = np.where(draw.uniform(size=count) < 0.75, 10.0 ** draw.uniform(-4, -1.5, count), 0.0)
    delay = 10.0 ** draw.uniform(-4.5, -1.5, count) if late else np.zeros(count)
    speed = draw.uniform(-0.3, 1.2, count)
    return model, Controller(gain, speed, feedback, lag, delay)


def exact_terms(loop: Loop, place: int, s: mpc) -> tuple[mpc, mpc]:
    """P(s) and Q(s) exp(-s delay) of one loop, to the digits of mpmath."""
    p2, p1, p0, q1, q0, delay = (mpf(float(a[place])) for a in loop)
    return (p2 * s + p1) * s + p0, (q1 * s + q0) * mp.exp(-s * delay)


def winding(loop: Loop, place: int) -> int:
    """Poles to the right of one loop by the argument principle, along a half disc that holds them.

    The loop must have a lag, or no more than a gain of one at high frequency.
    """
    p2, p1, p0, q1, q0, delay = (float(a[place]) for a in loop)
    # to the right |P| < |Q| is needed, which bounds |s|
    low = abs(p1) if p2 == 0.0 else abs(p2)
    if p2 == 0.0:
        radius = 2.0 * (abs(p0) + abs(q0)) / (low - abs(q1)) + 1.0
    else:
        radius = 2.0 * max((abs(p1) + abs(q1)) / low, np.sqrt((abs(p0) + abs(q0)) / low)) + 1.0
    axis = radius * np.sinh(np.linspace(-9.0, 9.0, 4001)) / np.sinh(9.0)
    arc = radius * np.exp(1j * np.linspace(np.pi / 2, -np.pi / 2, 4001))
    turned = 0.0
    for path in (1j * axis, arc):
        for _ in range(40):
            value = (p2 * path + p1) * path + p0 + (q1 * path + q0) * np.exp(-path * delay)
            angle = np.angle(value[1:] / value[:-1])
            # no delay may turn unseen between two points, and no step may turn far
            coarse = (np.abs(angle) > 0.5) | (np.abs(np.diff(path)) * delay > 0.5)
            if not np.any(coarse):
                break
            middle = 0.5 * (path[1:] + path[:-1])[coarse]
            path = np.insert(path, np.flatnonzero(coarse) + 1, middle)
        assert not np.any(coarse), "a pole stands on the path"
        turned += float(np.sum(angle))
    return -round(turned / (2.0 * np.pi))
