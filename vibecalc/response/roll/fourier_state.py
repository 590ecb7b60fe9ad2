"""The running state by Fourier collocation: evenly spaced crank angles, kinks or no kinks."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.fourier import solve_fourier
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.problem import RollRates
from vibecalc.response.roll.rates import shell_speed
from vibecalc.response.roll.turn import Turn


class FourierState(NamedTuple):
    """Turn of one machine (B = 1) at the points, and evaluations of the right-hand side."""

    turn: Turn
    evaluations: int


def fourier_state(
    machine: RollMachine, drive: RollDrive, points: int, momentum: FloatArray
) -> FourierState:
    """Running state with an odd number of points; `momentum` (1,) counts for a free machine.

    Kinks leave an error that falls with a power of the number of points only. Raises
    NumericalFailure where Newton's method does not converge.
    """
    free = not is_mounted(machine)
    need = demand(machine, drive)
    speed = drive.synchronous_speed - np.where(need.possible, need.slip, 0.0)
    rates = RollRates(machine, drive, momentum if free else None)
    guess = np.zeros((1, 1 if free else 3))
    guess[:, 0] = speed
    found = solve_fourier(rates, points, guess)
    if not found.converged[0]:
        raise NumericalFailure(
            f"roll: Fourier collocation with {points} points finds no running state; "
            'the default method = "collocation" says whether there is one'
        )
    crank = found.values[..., 0]
    if free:
        place = rates.place(found.x[None, None, :])
        shell = shell_speed(place, momentum, crank)
        angle = np.zeros_like(shell)
    else:
        shell, angle = found.values[..., 2], found.values[..., 1]
    time, period = _time(found.x, 1.0 / crank)
    weight = np.full_like(crank, 2.0 * np.pi / points)
    turn = Turn(found.x[None], weight, time, crank, shell, angle, period)
    return FourierState(turn, rates.evaluations)


def _time(x: FloatArray, slowness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integral of the trigonometric interpolant of 1/w (1, N) from 0, and over the turn (1,)."""
    points = len(x)
    share = np.fft.rfft(slowness, axis=-1) / points
    order = np.arange(1, share.shape[-1])
    wave = np.zeros_like(share)
    wave[..., 1:] = share[..., 1:] / (1j * order)
    swing = np.fft.irfft(wave * points, n=points, axis=-1)
    mean = share[..., :1].real
    return mean * x + swing - swing[..., :1], 2.0 * np.pi * mean[..., 0]
