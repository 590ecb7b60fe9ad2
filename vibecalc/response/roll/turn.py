"""One turn of a running machine at quadrature points, whatever method has found it."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray


class Turn(NamedTuple):
    """A periodic motion over one turn of the crank, at k points that ascend with the crank angle.

    `crank_angle`, `weight`, `time`, `crank_speed`, `shell_speed` and `shell_angle` (..., k) in rad,
    rad, s, rad/s, rad/s, rad. `weight` integrates over the crank angle, `time` counts from crank
    angle zero; `period` (...,) is that of the turn in s. `motor_torque` (..., k) in N m is None
    where it follows from the speed.
    """

    crank_angle: FloatArray
    weight: FloatArray
    time: FloatArray
    crank_speed: FloatArray
    shell_speed: FloatArray
    shell_angle: FloatArray
    period: FloatArray
    motor_torque: FloatArray | None = None


def harmonics(turn: Turn, values: FloatArray, orders: FloatArray) -> ComplexArray:
    """Harmonics in time of `values` (..., k): complex, zero-to-peak, (..., orders).

    x(t) = Re sum X_n exp(i n W t), W = 2 pi / period, t = 0 where the crank angle is 0; `orders`
    ascend, order 0 is the mean. With the lag phi of Herold (1977), equations 92 to 96,
    X_n = C_n exp(-i phi_n).
    """
    rate = 2.0 * np.pi / turn.period[..., None]
    shares = values * turn.weight / turn.crank_speed * (2.0 / turn.period[..., None])
    numbers = np.asarray(orders)
    found = np.empty((*shares.shape[:-1], len(numbers)), dtype=complex)
    steps = np.diff(numbers, prepend=0.0)
    # powers of one wave: an exponential of every order would cost most of the work
    wave, single = np.ones(shares.shape, dtype=complex), np.exp(-1j * (rate * turn.time))
    for place, (order, step) in enumerate(zip(numbers, steps, strict=True)):
        wave = wave * (single if step == 1.0 else single**step)
        total = np.einsum("...k,...k->...", shares, wave)
        found[..., place] = 0.5 * total if order == 0 else total
    return found


def mean(turn: Turn, values: FloatArray) -> FloatArray:
    """Mean in time of `values` (..., k)."""
    return np.asarray(np.sum(values * turn.weight / turn.crank_speed, axis=-1) / turn.period)


def level(amplitude: ComplexArray) -> FloatArray:
    """20 log10 of magnitudes, dB against one unit; minus infinity for zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.abs(amplitude)))
