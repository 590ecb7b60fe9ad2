"""Phases of a measured motion against one another."""

import math

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.spread import Spread
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.stages.measured_motion import Found, signal


def phase_between(one: Found, row: FloatArray, other: FloatArray) -> WithError:
    """Phase (rad) of the signal of a row (3,) against that of another; 0 where there is none."""
    try:
        return phase_of(one.motion, one.rounding, row, other)
    except NumericalFailure as failure:
        raise NumericalFailure(f"harmonic {one.harmonic.order}: {failure}") from failure


def phase_of(
    motion: ComplexArray, rounding: Spread, row: FloatArray, other: FloatArray
) -> WithError:
    """The same for any motion, in (-pi, pi]."""
    both, errors = signal(motion, rounding, np.stack([row, other]))
    if abs(both[1]) <= errors[1]:
        raise NumericalFailure("the signal that phases refer to is zero: a phase has no meaning")
    if abs(both[0]) <= errors[0]:
        return WithError(np.array(0.0), np.array(0.0))
    phase = float(np.angle(both[0] * np.conj(both[1])))
    error = float(errors[0] / abs(both[0]) + errors[1] / abs(both[1])) + 8.0 * EPSILON
    if phase <= -math.pi + error:
        phase += 2.0 * math.pi
    return WithError(np.array(phase), np.array(error))
