"""Stability margins of the loop broken at the controller, in gain, phase and time."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.roll_control.count import status
from vibecalc.response.roll_control.crossings import Crossings, crossings
from vibecalc.response.roll_control.gain_margin import gain_margin
from vibecalc.response.roll_control.model import Loop, feedthrough

_TURN = 2.0 * math.pi


class Margins(NamedTuple):
    """Margins of the loops (...), with absolute errors inside each pair.

    `status`: index into `vibecalc.response.roll_control.count.STATUS`; `stable`: it is 0 or 1.
    `gain` (1, > 1): factor by which the gain may grow; `gain_lower` (1, < 1): down to which it
    may fall, 0 for any; `gain_frequency`, `gain_lower_frequency` where (rad/s).
    `phase` (rad): lag or lead, the smaller, that reaches the limit, met at `phase_frequency`.
    `delay` (s): further delay that reaches the limit, met at `delay_frequency`. Both are zero
    where any delay does, because the gain at high frequency, `feedthrough`, is one or more.
    `bandwidth` (rad/s): highest frequency at which the loop still has gain one; the actuator
    has to work up to there. Zero if the gain is below one everywhere.
    Infinite: no such limit exists (frequency infinite too), for the bandwidth: no end of it.
    A loop that is not stable has no margins: gain and gain_lower are 1, phase and delay 0.
    """

    status: np.ndarray
    stable: np.ndarray
    gain: WithError
    gain_frequency: np.ndarray
    gain_lower: WithError
    gain_lower_frequency: np.ndarray
    phase: WithError
    phase_frequency: np.ndarray
    delay: WithError
    delay_frequency: np.ndarray
    feedthrough: np.ndarray
    bandwidth: WithError


def margins(loop: Loop) -> Margins:
    """All margins of every loop, in closed form but for the phase crossovers of a delayed loop."""
    cross = crossings(loop)
    found = status(loop, cross)
    stable = found <= 1
    level = feedthrough(loop)
    gain = gain_margin(loop, cross)
    phase, phase_at = _phase_margin(cross)
    late, late_at = _delay_margin(cross)

    # the gain stays above one however high the frequency, and there any delay turns the phase
    never = (loop.p2 == 0.0) & (np.abs(level) >= 1.0)
    phase = WithError(np.where(never, 0.0, phase.value), np.where(never, 0.0, phase.error))
    late = WithError(np.where(never, 0.0, late.value), np.where(never, 0.0, late.error))
    late_at = np.where(never, np.inf, late_at)

    nothing = np.where(cross.present, cross.frequency, 0.0)
    highest = np.argmax(nothing, axis=-1)[..., None]
    width = np.take_along_axis(nothing, highest, axis=-1)[..., 0]
    width_error = np.take_along_axis(cross.frequency_error, highest, axis=-1)[..., 0]
    bandwidth = WithError(
        np.where(never, np.inf, width), np.where(never | (width == 0.0), 0.0, width_error)
    )
    return Margins(
        found, stable,
        _only(stable, gain.upper, gain.upper_error, 1.0),
        np.where(stable, gain.upper_frequency, np.inf),
        _only(stable, gain.lower, gain.lower_error, 1.0),
        np.where(stable, gain.lower_frequency, 0.0),
        _only(stable, phase.value, phase.error, 0.0), np.where(stable & ~never, phase_at, np.inf),
        _only(stable, late.value, late.error, 0.0), np.where(stable, late_at, np.inf),
        level, bandwidth,
    )  # fmt: skip


def _only(stable: np.ndarray, value: np.ndarray, error: np.ndarray, other: float) -> WithError:
    return WithError(np.where(stable, value, other), np.where(stable, error, 0.0))


def _phase_margin(cross: Crossings) -> tuple[WithError, np.ndarray]:
    lag = np.where(cross.present, np.minimum(cross.slack, _TURN - cross.slack), np.inf)
    return _least(lag, cross.phase_error, cross)


def _delay_margin(cross: Crossings) -> tuple[WithError, np.ndarray]:
    time = np.where(cross.present, cross.slack / cross.frequency, np.inf)
    error = cross.phase_error + cross.slack * cross.frequency_error / cross.frequency
    return _least(time, error / cross.frequency + 2.0 * UNIT_ROUNDOFF * cross.slack, cross)


def _least(value: np.ndarray, error: np.ndarray, cross: Crossings) -> tuple[WithError, np.ndarray]:
    which = np.argmin(value, axis=-1)[..., None]
    least, doubt, at = (
        np.take_along_axis(a, which, axis=-1)[..., 0] for a in (value, error, cross.frequency)
    )
    some = np.isfinite(least)
    return WithError(least, np.where(some, doubt, 0.0)), np.where(some, at, np.inf)
