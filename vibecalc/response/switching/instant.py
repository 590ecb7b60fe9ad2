"""An ideal change of operation within no time, and the crank angle at which it does worst."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.follow import Transient, follow
from vibecalc.response.switching.readings import (
    columns,
    linear_rows,
    read_bound,
    read_error,
    reading_peak,
    reading_peaks,
    steady_peaks,
)
from vibecalc.response.switching.system import (
    Loads,
    ModalSystem,
    SpeedSegment,
    decay_bound,
    modal_loads,
    modal_size,
    propagator,
    steady_motion,
    steady_state,
)

# ----------------------------------------------------------------------------
# An ideal change from one operation to another at constant speed, within no time.
# ----------------------------------------------------------------------------

#: turns that are shown at least, and at most without being asked
_TURNS, _MOST_TURNS = 8, 5000


def instantaneous(
    system: ModalSystem,
    loads: Loads,
    before: int,
    after: int,
    speed: float,
    *,
    angle: float = 0.0,
    duration: float | None = None,
    buckets: int = 400,
    tolerance: float = 0.05,
) -> Transient:
    """Change from the operation `before` to `after` at the crank angle `angle`, time 0.

    The body has moved steadily under the first; from time 0 the second loads it. The motion is
    the steady one under the second plus the free motion from the difference of the two states,
    in closed form, for modes below, at and above critical damping. Parameters and errors are those
    of `follow`; without a `duration` (s) it is as long as the free motion may take to settle.

    Raises
    ------
    NumericalFailure
        As `follow`, or settling takes more than 5000 turns and no duration is given.
    """
    if duration is None:
        duration = _until_settled(system, loads, before, after, speed, angle, tolerance)
    profile = [SpeedSegment(duration, speed, speed, after)]
    return follow(
        system, loads, profile, angle=angle, before=before, buckets=buckets, tolerance=tolerance
    )


def _until_settled(
    system: ModalSystem,
    loads: Loads,
    before: int,
    after: int,
    speed: float,
    angle: float,
    tolerance: float,
) -> float:
    modal = modal_loads(system, loads)
    old, new = (steady_motion(system, modal, which, speed) for which in (before, after))
    at = np.asarray(angle)
    states = [steady_state(motion, modal.orders, speed, at) for motion in (old, new)]
    size = modal_size(system, states[0] - states[1])
    peaks: Bounded = steady_peaks(system, new, modal.orders, speed)
    whole = np.sqrt(2.0 * peaks.value[columns(len(system.shape)).energy])
    whole = max(float(whole), float(np.sqrt(np.sum(modal_size(system, states[0]) ** 2))))
    turn = 2.0 * np.pi / abs(speed)
    factor, rate = decay_bound(system)
    # each mode down to its share of the tolerance
    excess = factor * size * np.sqrt(len(size))
    level = tolerance * whole
    lasting = excess > level
    times = np.log(excess[lasting] / level) / rate[lasting] if np.any(lasting) else np.zeros(1)
    longest = float(np.max(times))
    if not longest <= _MOST_TURNS * turn:
        raise NumericalFailure(
            f"after the change the body swings for about {longest:.3g} s before it settles, "
            f"{longest / turn:.3g} turns; give the duration to be followed, or more damping"
        )
    return max(1.2 * longest, _TURNS * turn)


# ----------------------------------------------------------------------------
# The crank angle at which an instantaneous change does worst.
# ----------------------------------------------------------------------------

#: share of a reading's size that its envelope may rise between two times, at first
_COARSE = 0.03
_BLOCK, _MOST_BLOCKS = 128, 40
_DIVIDED, _LEVELS, _MOST_CELLS = 8, 8, 256
#: what may be left below the peak, as a share of a reading's size
_FINE = 1e-11


class WorstReading(NamedTuple):
    """Largest magnitude (columns,) of each reading over all angles of change, with its error.

    `angle` is the crank angle at the change in [0, 2 pi), `time` in s from it to the peak (0 and
    0 where no change is felt beyond the steady motion).
    """

    value: np.ndarray
    error: np.ndarray
    angle: np.ndarray
    time: np.ndarray


class _Change(NamedTuple):
    """Modal amplitudes (orders, modes) of the motion after, and of the difference of the two."""

    system: ModalSystem
    orders: np.ndarray
    rates: np.ndarray
    after: np.ndarray
    difference: np.ndarray


def worst_instant(
    system: ModalSystem, loads: Loads, before: int, after: int, speed: float
) -> WorstReading:
    """Peaks of `instantaneous` for the angle at which each is largest; columns as in `readings`.

    At a time t after the change, a reading is a sum of orders of the angle of change: its largest
    over all angles, the envelope at t, is a peak over a cycle. A bound on the second derivative
    says how far the envelope may rise between two times; those next to which it may be highest are
    divided again. Later than a time at which the free motion left cannot add to the peak, nothing
    is sought. What is not decided by then stands in the error: with hardly any damping the free
    motion of several modes may still come together much later, and the error is a bound on that.
    Raises NumericalFailure for a driven mode that is not held or not damped.
    """
    modal = modal_loads(system, loads)
    rates = 1j * (modal.orders * speed)[:, None]
    old, new = (steady_motion(system, modal, which, speed) for which in (before, after))
    change = _Change(system, modal.orders, rates, new.amplitude, old.amplitude - new.amplitude)
    height, bend = _sizes(change)
    final = steady_peaks(system, new, modal.orders, speed)
    lost = np.hypot(system.frequency * np.abs(change.difference), np.abs(rates * change.difference))
    start_size = np.sum(lost, axis=0)

    def left(time: float) -> np.ndarray:
        """Bound (columns,) on what free motion still adds; for energies on their roots."""
        factor, rate = decay_bound(system)
        bound = read_bound(system, start_size * np.minimum(1.0, factor * np.exp(-rate * time)))
        bound[-3:] = np.sqrt(bound[-3:])
        return bound

    if not np.any(start_size > 0.0):
        none = np.zeros(len(height))
        return WorstReading(final.value, final.error, none, none)
    curved = bend > 0.0
    step = float(np.min(np.sqrt(8.0 * _COARSE * height[curved] / bend[curved])))
    times, tops, angles, beyond = _survey(change, _lengths(final.value), left, step)
    value, time, angle, slack = (np.empty(len(height)) for _ in range(4))
    for column in range(len(height)):
        allowed = bend[column] * step**2 / 8.0
        value[column], time[column], angle[column], slack[column] = _narrow(
            change, column, times, tops[:, column], angles[:, column], step, allowed, height[column]
        )
    quiet = value <= _lengths(final.value)
    value = np.where(quiet, _lengths(final.value), value)
    slack = np.maximum(slack, beyond - value)
    # a change that is hardly felt: never more than the steady motion and all of the free one
    slack = np.maximum(np.minimum(slack, _lengths(final.value) + left(0.0) - value), 0.0)
    uncertainty = new.error + old.error
    size = start_size + np.sum(
        np.hypot(system.frequency * np.abs(new.amplitude), np.abs(rates * new.amplitude)), axis=0
    )
    energy = slice(-3, None)
    slack[energy] = value[energy] * slack[energy] * 2.0 + slack[energy] ** 2
    value[energy] = value[energy] ** 2
    error = read_error(system, value, 2.0 * uncertainty + 16.0 * EPSILON * size, size) + slack
    return WorstReading(value, error, np.where(quiet, 0.0, angle), np.where(quiet, 0.0, time))


def _lengths(peaks: np.ndarray) -> np.ndarray:
    """Readings with energies as their roots, which are lengths and scale with the motion."""
    lengths: np.ndarray = peaks.copy()
    lengths[..., -3:] = np.sqrt(peaks[..., -3:])
    return lengths


def _motion(change: _Change, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orders of the angle of change (times, orders, modes) in q and q' at times after it."""
    state = np.stack([change.difference, change.rates * change.difference], axis=-1)
    # the angle counts from the change: the final motion has turned since
    turned = np.exp(change.rates * time[:, None, None]) * change.after
    free = propagator(change.system, time[:, None])(state)
    place, rate = turned + free[..., 0], change.rates * turned + free[..., 1]
    return place, rate


def _envelope(change: _Change, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Largest readings (times, columns) over all angles of change, and these angles."""
    value, angle, _ = reading_peaks(change.system, *_motion(change, time), change.orders)
    return _lengths(value), angle


def _sizes(change: _Change) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (columns,) on readings and on their second derivatives by time, energies as roots."""
    system = change.system
    rate, frequency = np.abs(change.rates), system.frequency
    forced = np.abs(change.after)
    free = np.abs(change.difference) * np.hypot(frequency, rate)
    lean = 1.0 + 2.0 * system.damping_ratio
    held = np.where(frequency > 0.0, frequency, 1.0)
    # free motion of size e: |q| <= e / w, |q'| <= e, and so on through its equation
    place = np.sum(forced + free / held, axis=0)
    speed = np.sum(rate * forced + free, axis=0)
    bent_place = np.sum(rate**2 * forced + lean * frequency * free, axis=0)
    bent_speed = np.sum(rate**3 * forced + (lean * frequency) ** 2 * free, axis=0)
    on_place, on_velocity = (np.abs(rows) for rows in linear_rows(system))

    def column(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        kinetic, potential = np.sum(v**2) / 2.0, np.sum((frequency * q) ** 2) / 2.0
        roots = np.sqrt([kinetic, potential, kinetic + potential])
        return np.concatenate([on_place @ q + on_velocity @ v, roots])

    return column(place, speed), column(bent_place, bent_speed)


def _survey(
    change: _Change, final: np.ndarray, left: Callable[[float], np.ndarray], step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times from 0, envelope and angles there, and what may come later (columns,)."""
    tops, angles, later = [], [], final
    for block in range(_MOST_BLOCKS):
        top, angle = _envelope(change, step * np.arange(block * _BLOCK, (block + 1) * _BLOCK))
        tops.append(top)
        angles.append(angle)
        later = final + left(step * ((block + 1) * _BLOCK - 1))
        if np.all(later <= np.max([np.max(part, axis=0) for part in tops], axis=0)):
            break
    values = np.concatenate(tops)
    return step * np.arange(len(values)), values, np.concatenate(angles), later


def _narrow(
    change: _Change,
    column: int,
    times: np.ndarray,
    tops: np.ndarray,
    angles: np.ndarray,
    step: float,
    allowed: float,
    scale: float,
) -> tuple[float, float, float, float]:
    """Highest envelope of one column, its time and angle, and what may be missing."""
    first = int(np.argmax(tops))
    best, at, angle, missed = float(tops[first]), float(times[first]), float(angles[first]), 0.0
    for _ in range(_LEVELS):
        if len(times) == 0 or allowed <= _FINE * scale:
            break
        rank = np.argsort(-tops, kind="stable")
        rank = rank[tops[rank] + allowed >= best]
        if len(rank) > _MOST_CELLS:
            missed = max(missed, float(tops[rank[_MOST_CELLS]]) + allowed)
            rank = rank[:_MOST_CELLS]
        step /= _DIVIDED
        allowed /= _DIVIDED**2
        offsets = step * (np.arange(_DIVIDED) - 0.5 * (_DIVIDED - 1))
        times = np.ravel(times[rank][:, None] + offsets)
        times = times[times >= 0.0]
        if len(times) == 0:
            break
        tops, where = reading_peak(change.system, *_motion(change, times), change.orders, column)
        tops = np.sqrt(tops) if column >= 2 * len(change.system.shape) else tops
        top = int(np.argmax(tops))
        if tops[top] > best:
            best, at, angle = float(tops[top]), float(times[top]), float(where[top])
    return best, at, angle, max(missed - best, 0.0) + allowed
