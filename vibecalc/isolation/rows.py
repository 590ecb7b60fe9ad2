"""Rows of a readout as functions of crank speed, with their slopes: what a run-up looks at."""

from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.isolation.readout import Readout

#: stands for what was not asked for
EMPTY = np.zeros(0)


class Jet(NamedTuple):
    """Harmonics of the rows at some speeds, each array (speeds, rows, components, orders).

    `slope` and `curvature` are the first and second derivative by crank speed; errors are
    absolute. What was not asked for has no size.
    """

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


class HarmonicsAt(Protocol):
    """Harmonics of some rows at crank speeds (speeds,), as much of the jet as is asked for."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet: ...


class Motion(NamedTuple):
    """Coordinates (speeds, orders, coordinates), derivatives by speed, errors."""

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


def read(readout: Readout, order: np.ndarray, rate: np.ndarray, motion: Motion) -> Jet:
    """Apply the readout to a motion and its derivatives, as far as they are there."""
    rows, components, width = readout.spring.shape
    spring = readout.spring.reshape(rows * components, width).T
    damper = readout.damper.reshape(rows * components, width).T
    frequency = rate[..., None]
    each_order = order[:, None]

    def laid_out(flat: np.ndarray) -> np.ndarray:
        """(speeds, orders, rows * components) to (speeds, rows, components, orders)."""
        return flat.swapaxes(1, 2).reshape(len(flat), rows, components, len(order))

    damped = motion.value @ damper
    value = motion.value @ spring + 1j * frequency * damped
    error = slope = slope_error = curvature = EMPTY
    if motion.slope is not EMPTY:
        damped_slope = motion.slope @ damper
        slope = motion.slope @ spring + 1j * (frequency * damped_slope + each_order * damped)
        curvature = motion.curvature @ spring + 1j * (
            frequency * (motion.curvature @ damper) + 2.0 * each_order * damped_slope
        )
        slope, curvature = laid_out(slope), laid_out(curvature)
    if motion.error is not EMPTY:
        spring_size, damper_size = np.abs(spring), np.abs(damper)
        spread = motion.error + readout.doubt * np.abs(motion.value)
        damped_spread = spread @ damper_size
        error = laid_out(spread @ spring_size + frequency * damped_spread)
        if motion.slope is not EMPTY:
            steeper = motion.slope_error + readout.doubt * np.abs(motion.slope)
            slope_error = steeper @ spring_size + frequency * (steeper @ damper_size)
            slope_error = laid_out(slope_error + each_order * damped_spread)
    return Jet(laid_out(value), error, slope, slope_error, curvature)
