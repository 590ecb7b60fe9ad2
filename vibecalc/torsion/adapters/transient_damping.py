"""Dashpots in place of the loss factors of a shaft line, for a change in time."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.torsion.adapters.motion import solved
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# A loss factor has no form in time: k (1 + i eta) is of a steady vibration. A dashpot
# c = eta k / w has the same complex stiffness at the frequency w, magnitude and heat, so that a
# resonance there keeps its height. Each element has its own w:
#
# - of a change that passes speeds, and of the onset of a misfire, the frequency at which one order
#   twists the element most in the steady vibration at the speeds on the way, to five digits: a
#   flat maximum has no more, and the dashpots shall not hang on a rounding;
# - of a jolt, after which the line swings by itself, and where no order twists the element, the
#   natural frequency of the mode in which it has its largest share of the strain energy.
# ----------------------------------------------------------------------------

#: speeds of the first look; speeds about the best of it, each time this many times closer
_SPEEDS, _CLOSE, _CLOSER = 601, 17, 8


class Equivalent(NamedTuple):
    """`frequency` (e,) in rad/s and `damping` (e,) in N m s/rad, referred, 0 without loss.

    `resonance` (e,) says of which the frequency is a natural one.
    """

    frequency: FloatArray
    damping: FloatArray
    resonance: BoolArray


def without_loss(
    setup: Setup, speed: float, between: tuple[float, float] | None
) -> tuple[Line, Equivalent | None]:
    """The line at a crank speed with dashpots for loss factors, and these; None without any.

    `between` two speeds in rad/s orders count, None after a jolt.
    """
    line = setup.model.at(speed)
    lossy = line.loss_factor > 0.0
    if not np.any(lossy):
        return line, None
    natural = _most_strained(setup, line)
    frequency = natural if between is None else _most_twisted(setup, between)
    resonance = (frequency == 0.0) | (between is None)
    frequency = np.where(lossy, np.where(frequency > 0.0, frequency, natural), 0.0)
    of_loss = lossy & (frequency > 0.0)
    damping = np.where(
        of_loss, line.loss_factor * line.stiffness / np.where(of_loss, frequency, 1.0), 0.0
    )
    plain = line._replace(
        damping=line.damping + damping, loss_factor=np.zeros_like(line.loss_factor)
    )
    return plain, Equivalent(frequency, damping, resonance & lossy)


def _most_strained(setup: Setup, line: Line) -> FloatArray:
    """Natural frequency (e,) of the mode in which each element has its largest share of energy."""
    modes = setup.modes
    twist = modes.shape[:, line.first] - modes.shape[:, line.second]
    energy = line.stiffness * twist**2
    total = energy.sum(axis=1, keepdims=True)
    moving = (modes.frequency > 0.0)[:, None] & (total > 0.0)
    share = np.where(moving, energy / np.where(moving, total, 1.0), 0.0)
    found: FloatArray = modes.frequency[np.argmax(share, axis=0)]
    return found


def _most_twisted(setup: Setup, between: tuple[float, float]) -> FloatArray:
    """Frequency (e,) at which a single order twists each element most, 0 where none does."""
    low, high = min(between), max(between)
    low = max(low, 1e-3 * high)
    cards = setup.drive.card_speed
    if len(cards) > 1:
        low, high = (float(np.clip(one, cards[0], cards[-1])) for one in (low, high))
    speeds = np.linspace(low, high, _SPEEDS if high > low else 1)
    order, natural = setup.drive.order, setup.modes.frequency
    critical = np.divide.outer(natural[natural > 0.0], order).ravel()
    inside = critical[(critical > low) & (critical < high)]
    speeds = np.union1d(speeds, inside)

    def largest(speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest twist (s, e) of one order at speeds (s,) and its frequency (s, e)."""
        state = solved(setup.model, setup.drive, speed)
        twist = np.where(np.isfinite(state.twist), np.abs(state.twist), 0.0)
        best = np.argmax(twist, axis=1)
        return np.max(twist, axis=1), np.take_along_axis(state.frequency, best, axis=1)

    size, frequency = largest(speeds)
    top = np.argmax(size, axis=0)
    section = np.arange(size.shape[1])
    best, found = size[top, section], frequency[top, section]
    for one in section[setup.model.line.loss_factor > 0.0]:
        at = float(speeds[top[one]])
        width = float(speeds[1] - speeds[0]) if len(speeds) > 1 else 0.0
        while width > 1e-7 * high:
            near = np.clip(at + width * np.linspace(-1.0, 1.0, _CLOSE), low, high)
            size, frequency = largest(near)
            place = int(np.argmax(size[:, one]))
            if size[place, one] > best[one]:
                best[one], found[one] = size[place, one], frequency[place, one]
                at = float(near[place])
            width /= _CLOSER
    return np.array([float(f"{one:.5g}") for one in np.where(best > 0.0, found, 0.0)])
