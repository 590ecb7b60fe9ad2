"""A coarse running state of one free machine in some hundred microseconds, and its spectrum.

The energy of the machine over the crank angle, E = mu w^2 / 2 + H^2 / (2 J), obeys dE/db = torque
(`rates.py`). What depends on the angle alone is taken at evenly spaced angles in one go; the energy
is then marched over them in plain floats by the rule of Adams and Bashforth of second order, until
a turn repeats. Good to some tenths of a decibel, without any error estimate: a start for better
methods, and a first look for searches.
"""

from bisect import bisect_right
from math import sqrt
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.rates import Place, place_at

#: angles of a turn, further turns at most, and the change of the energy at which a turn repeats
POINTS = 72
_MOST_TURNS = 12
_REPEATS = 1e-4
_TURN = 2.0 * np.pi


class QuickTurn(NamedTuple):
    """Crank angles (k,), crank speed and torque of the motor there (k,), and the place (1, k).

    `momentum` is the angular momentum, N m s.
    """

    crank_angle: FloatArray
    crank_speed: FloatArray
    motor_torque: FloatArray
    place: Place
    momentum: float


def quick_turn(
    machine: RollMachine,
    drive: RollDrive,
    speed: float,
    momentum: float | None = None,
    points: int = POINTS,
) -> QuickTurn | None:
    """The turn of one machine (B = 1) without mounts that a march from `speed`, rad/s, comes to.

    The `momentum` is by default that of a shell at rest at crank angle zero. None where the
    crank stalls or no turn repeats. For motors with a steady curve by pieces.
    """
    angle = np.linspace(0.0, _TURN, points, endpoint=False, dtype=np.float64)
    place = place_at(machine, drive, angle[None])
    moved = place.moved
    shell = moved.shell[0]
    kept = float(moved.coupling[0, 0]) * speed if momentum is None else momentum
    still = (0.5 * kept**2) / shell
    double = 2.0 * shell / moved.determinant[0]
    rows = list(zip(place.load[0].tolist(), still.tolist(), double.tolist(), strict=True))
    motor = _motor(machine, drive)
    start = rows[0][1] + speed * speed / rows[0][2]
    drag, step = float(place.drag[0, 0]), _TURN / points
    found = _march(rows, motor, drag, step, start)
    for _ in range(_MOST_TURNS):
        if found is None:
            return None
        before, found = found, _march(rows, motor, drag, step, found.energy, found.last)
        if found is not None and abs(found.energy - before.energy) <= _REPEATS * before.energy:
            speeds, torques = np.array(found.speeds), np.array(found.torques)
            return QuickTurn(angle, speeds, torques, place, kept)
    return None


class _Motor(NamedTuple):
    """Thresholds in slip; polynomials of each piece in the speed itself, highest power first."""

    threshold: list[float]
    origin: list[float]
    rows: list[list[float]]
    synchronous: float


def _motor(machine: RollMachine, drive: RollDrive) -> _Motor:
    curve, scale = drive.motor, float(machine.motor_scale[0])
    synchronous = float(drive.synchronous_speed.max())
    rows = (scale * curve.coefficient[:, ::-1]).tolist()
    return _Motor(curve.threshold.tolist(), (synchronous - curve.base).tolist(), rows, synchronous)


class _Marched(NamedTuple):
    """Energy after a turn, the last torque on it; speed and torque of the motor at its angles."""

    energy: float
    last: float | None
    speeds: list[float]
    torques: list[float]


def _march(
    rows: list[tuple[float, float, float]],
    motor: _Motor,
    drag: float,
    step: float,
    energy: float,
    last: float | None = None,
) -> _Marched | None:
    threshold, origin, pieces, synchronous = motor
    straight = len(pieces[0]) == 2
    speeds, torques = [], []
    for load, still, double in rows:
        square = (energy - still) * double
        if not square > 0.0:
            return None
        w = sqrt(square)
        part = bisect_right(threshold, synchronous - w)
        away, row = origin[part] - w, pieces[part]
        if straight:
            torque = row[0] * away + row[1]
        else:
            torque = 0.0
            for factor in row:
                torque = torque * away + factor
        now = torque + load - drag * w
        energy += step * (now if last is None else 1.5 * now - 0.5 * last)
        last = now
        speeds.append(w)
        torques.append(torque)
    return _Marched(energy, last, speeds, torques)


def quick_spectrum(turn: QuickTurn, orders: int) -> ComplexArray:
    """Harmonics 1 to `orders` in time of the shell's acceleration, as `turn.harmonics` has them."""
    moved, speed = turn.place.moved, turn.crank_speed
    square, shell = speed * speed, moved.shell[0]
    share = moved.coupling[0] / shell
    drift = turn.momentum / shell
    shell_slope, coupling_slope = moved.shell_slope[0], moved.coupling_slope[0]
    steep = moved.crank_slope[0] - share * (2.0 * coupling_slope - share * shell_slope)
    torque = turn.motor_torque + turn.place.load[0] - turn.place.drag[0, 0] * speed
    torque = torque + 0.5 * (drift * drift * shell_slope - steep * square)
    crank = torque * shell / moved.determinant[0]
    rate = (shell_slope * (drift - share * speed) * speed + coupling_slope * square) / shell
    acceleration = -rate - share * crank
    slow = (_TURN / len(speed)) / speed
    time = np.cumsum(slow) - 0.5 * (slow + slow[0])
    period = slow.sum()
    wave = np.exp((-1j * _TURN / period) * time)
    powers = np.multiply.accumulate(np.broadcast_to(wave, (orders, len(wave))), axis=0)
    return np.asarray(powers @ (acceleration * slow) * (2.0 / period))
