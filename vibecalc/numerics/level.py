"""Levels in dB and the amplitudes they stand for, with what errors become on the way."""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded, Operand, pair
from vibecalc.numerics.rounding import EPSILON, FloatArray

#: dB for each unit of the natural logarithm of an amplitude
DECIBEL = 20.0 / math.log(10.0)


def amplitude_of(level: ArrayLike, reference: float) -> FloatArray:
    """Amplitude, in the unit of `reference`, of a level of an amplitude in dB."""
    return reference * np.exp(np.asarray(level, dtype=float) / DECIBEL)


def level_of(amplitude: Operand, reference: float) -> Bounded:
    """Level in dB of an amplitude.

    An amplitude that does not exceed its error is zero: its level is minus infinity, error 0.
    The error is that of the lower end, which is the larger one.
    """
    value, error = pair(amplitude)
    size, uncertainty = np.broadcast_arrays(np.abs(value), error)
    there = size > uncertainty
    safe = np.where(there, size, 1.0)
    level = np.where(there, DECIBEL * np.log(safe / reference), -np.inf)
    share = np.where(there, uncertainty / safe, 0.0)
    off = np.where(there, -DECIBEL * np.log1p(-share), 0.0)
    off = off + np.where(there, 4.0 * EPSILON * (np.abs(np.where(there, level, 0.0)) + DECIBEL), 0)
    return Bounded(level, off)
