"""The highest points of run-ups: maxima over speed of the peaks over the cycle."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import Jet
from vibecalc.isolation.run_up_samples import (
    SPARSE,
    Machines,
    Samples,
    angle_grid,
    exact_peaks,
    in_blocks,
    sparse_samples,
    squares,
)
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.maxima import SURE, Maxima, first_highest, top_errors
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.resonances import MaskedSpeeds

# ----------------------------------------------------------------------------
# The peak over the cycle as a curve over speed: the highest of the branches f(speed, angle) of a
# row. Its kinks are in valleys, so that a maximum is a smooth point of one branch, where both
# slopes vanish, or an end of the range. On a branch the angle follows the speed, and half the
# squared length h has the slope h_v and the second derivative h_vv - h_va^2 / h_aa.
# ----------------------------------------------------------------------------

_NONE = np.zeros(0)
#: share of the highest square of the length from which branches are climbed, steps on them, and
#: the longest step as a share of the speeds that are searched
_HIGH, _STEPS, _PART = 0.8, 14, 0.25
#: promised relative gain below which a step tells what is left, to a quarter, and what a quick look
#: at heights cannot tell apart; share of the searched speeds up to which two climbs have met
_NEAR, _ARRIVED, _LOOK, _MET = 0.01, 1e-12, 1e-6, 1e-9


class _Branch(NamedTuple):
    """The highest branches (n,) of rows: half the squared length with slopes and second
    derivatives by speed and crank angle, and uncertainties of the length and of both slopes."""

    angle: np.ndarray
    h: np.ndarray
    slope: np.ndarray
    turn: np.ndarray
    vv: np.ndarray
    va: np.ndarray
    aa: np.ndarray
    off: np.ndarray = _NONE
    slope_off: np.ndarray = _NONE
    turn_off: np.ndarray = _NONE

    @property
    def bend(self) -> np.ndarray:
        """Second derivative by speed along the branch."""
        steep = self.aa < 0.0
        return self.vv - np.where(steep, np.square(self.va) / np.where(steep, self.aa, 1.0), 0.0)


def _branch(jet: Jet, orders: np.ndarray, angle: np.ndarray | None = None) -> _Branch:
    """Of jets (n, components, orders), with uncertainties where they have errors; at angles (n,),
    or at those of the peak over the cycle."""
    order = np.asarray(orders, dtype=float)
    if angle is None:
        angle = vector_cycle_peak(jet.value, orders).angle
    turn = np.exp(1j * angle[:, None] * order)[:, None, :]
    around, slope = jet.value * turn, jet.slope * turn
    f, f_v, f_a = around.real.sum(axis=-1), slope.real.sum(axis=-1), -(around.imag @ order)
    f_vv, f_va = (jet.curvature * turn).real.sum(axis=-1), -(slope.imag @ order)
    f_aa = -(around.real @ np.square(order))
    found = _Branch(
        angle, 0.5 * _dot(f, f), _dot(f, f_v), _dot(f, f_a), _dot(f_v, f_v) + _dot(f, f_vv),
        _dot(f_v, f_a) + _dot(f, f_va), _dot(f_a, f_a) + _dot(f, f_aa),
    )  # fmt: skip
    if not jet.error.size:
        return found
    # the angle is rounded, and each order turns by a multiple of it
    rounding = (len(order) + 6.0 + 4.0 * np.pi * order) * UNIT_ROUNDOFF
    uncertainty = jet.error + rounding * np.abs(jet.value)
    steeper = jet.slope_error + rounding * np.abs(jet.slope)
    off, off_v = _length(uncertainty.sum(axis=-1)), _length(steeper.sum(axis=-1))
    turned = uncertainty @ order + (jet.turn_error if jet.turn_error.size else 0.0)
    size = _length(f)
    return found._replace(
        off=off,
        slope_off=size * off_v + off * _length(f_v),
        turn_off=size * _length(turned) + off * _length(f_a),
    )


def _dot(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.asarray((left * right).sum(axis=-1))


def _length(vector: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(_dot(vector, vector)))


class Tops(NamedTuple):
    """Highest points (n,) of rows next to speeds that were sampled, with the crank angle and the
    jets there; `sample` tells next to which, `inner` that they are not where the search ended."""

    sample: np.ndarray
    row: np.ndarray
    place: Bounded
    height: Bounded
    inner: np.ndarray
    angle: np.ndarray
    jet: Jet


def tops_of(
    machines: Machines, samples: Samples, high: np.ndarray, beside: int, within: bool = False
) -> Tops:
    """Tops from samples (n, rows) that are `high` and as many `beside` each, or `within` these.

    All high branches over the angle are climbed by Newton's method: a kink may part two tops
    between two samples. None is sought across a masked interval. The samples next to the ends of
    the range, and of such an interval, are candidates themselves.
    """
    at, own = np.nonzero(high)
    row = samples.machine[at] * machines.rows + own
    masked = machines.masked
    between = np.searchsorted(masked.centre, samples.speed)
    part = samples.machine * (len(masked.low) + 1) + between
    near = at[:, None] + np.arange(-beside, beside + 1)
    place = np.clip(near, 0, len(part) - 1)
    same = (place == near) & (part[place] == part[at][:, None])
    seeds = np.where(same, samples.speed[place], samples.speed[at][:, None])
    low, top = seeds.min(axis=1, initial=np.inf), seeds.max(axis=1, initial=0.0)
    reach = top - low
    if not within:
        low = np.append(machines.start, masked.high)[between[at]]
        top = np.append(masked.low, machines.stop)[between[at]]
    which, column = np.nonzero(same)
    which, speed = _climbed(machines, row, which, seeds[which, column], reach, low, top)
    last = np.flatnonzero(~same[:, beside - 1] | ~same[:, beside + 1])
    which, speed = np.concatenate([last, which]), np.concatenate([samples.speed[at[last]], speed])
    return _polished(machines, at[which], row[which], speed, low[which], top[which])


def _climbed(
    machines: Machines, row: np.ndarray, which: np.ndarray, speed: np.ndarray,
    reach: np.ndarray, low: np.ndarray, high: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Where all high branches of rows lead from speeds (n,), those of one of the rows `which` (n,)
    each, by steps of the order of its `reach` within `low` and `high`.

    Those that are not concave, or promise too little, are left.
    """
    jets, orders = machines.look or machines.jets_at, machines.orders
    grid, most = angle_grid(orders), np.zeros(len(row))
    height = squares(jets(speed, row[which]).value, orders, grid)
    highest = height.max(axis=1, initial=0.0)
    np.maximum.at(most, which, 0.5 * highest)
    around = np.maximum(np.roll(height, 1, axis=1), np.roll(height, -1, axis=1))
    each, turn = np.nonzero((height >= around) & (height >= _HIGH * highest[:, None]))
    which, speed, angle = which[each], speed[each], grid[turn]
    done = []
    for _ in range(_STEPS):
        here = _branch(jets(speed, row[which]), orders, angle)
        step, turned, concave, gain = _step(here, reach[which], float(np.max(orders)))
        np.maximum.at(most, which, here.h)
        angle, speed = angle + turned, np.clip(speed + step, low[which], high[which])
        may = ~concave | (gain > _NEAR * here.h)
        may |= here.h + 4.0 * gain >= (1.0 - _LOOK) * most[which]
        last = concave & (gain <= _ARRIVED * here.h)
        done.append((which[may & last], speed[may & last]))
        which, speed, angle = (part[may & ~last] for part in (which, speed, angle))
    which, speed = (np.concatenate(part) for part in zip(*done, strict=True))
    # those that have met are one
    order = np.lexsort((speed, which))
    which, speed = which[order], speed[order]
    apart = (np.diff(which) > 0) | (np.diff(speed) > _MET * reach[which[1:]])
    new = np.concatenate([np.ones(min(len(which), 1), dtype=bool), apart])
    return which[new], speed[new]


def _step(
    here: _Branch, reach: np.ndarray, highest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Newton's steps in speed and angle, turned upwards where a branch is not concave, if it is,
    and what the whole step promises of `h`; steps are no longer than a share of the `reach`, and of
    a wave of the highest order."""
    scale = 1.0 / np.where(here.h > 0.0, here.h, 1.0)
    v, a = here.slope * reach * scale, here.turn / highest * scale
    vv, va = here.vv * np.square(reach) * scale, here.va * reach / highest * scale
    aa = here.aa / highest**2 * scale
    # along the axes of the curvature
    middle, spread = 0.5 * (vv + aa), np.hypot(0.5 * (vv - aa), va)
    lean = 0.5 * np.arctan2(2.0 * va, vv - aa)
    cosine, sine = np.cos(lean), np.sin(lean)
    least = 1e-6 * (np.abs(middle) + spread) + 1e-300
    along = (cosine * v + sine * a) / np.maximum(np.abs(middle + spread), least)
    across = (cosine * a - sine * v) / np.maximum(np.abs(middle - spread), least)
    step_v, step_a = cosine * along - sine * across, sine * along + cosine * across
    concave = middle + spread < 0.0
    longest = np.where(concave, np.abs(step_v), np.hypot(step_v, step_a)) / _PART
    part = 1.0 / np.maximum(longest, 1.0)
    gain = 0.5 * (v * step_v + a * step_a) / scale
    return part * step_v * reach, part * step_a / highest, concave, gain


def _polished(
    machines: Machines, sample: np.ndarray, row: np.ndarray, speed: np.ndarray,
    low: np.ndarray, high: np.ndarray,
) -> Tops:  # fmt: skip
    """Tops of rows (n,) from speeds next to them, by two steps of Newton between two speeds."""
    for last in (False, True):
        jet = machines.jets_at(speed, row, errors=last)
        here = _branch(jet, machines.orders)
        falls = here.bend < 0.0
        step = np.where(falls, -here.slope / np.where(falls, here.bend, 1.0), 0.0)
        left = np.clip(speed + step, low, high) - speed
        speed = speed if last else speed + left
    value, span = np.sqrt(2.0 * here.h), machines.stop - machines.start
    inside = ((speed > low) & (speed < high)) | (np.abs(here.slope) <= here.slope_off)
    # what the uncertainties of both slopes make of the speed, at most the range
    bends = np.abs(here.vv * here.aa - here.va * here.va)
    off = np.abs(here.aa) * here.slope_off + np.abs(here.va) * here.turn_off
    off = np.where(off < span * bends, off / np.maximum(bends, 1e-300), span)
    place = np.where(inside, off + np.abs(left), 0.0) + 2.0 * UNIT_ROUNDOFF * speed
    gain = 0.5 * np.abs(here.slope * left) / np.maximum(value, 1e-300)
    inner = (speed > low) & (speed < high)
    return Tops(
        sample, row, Bounded(speed, place), Bounded(value, here.off + gain), inner, here.angle, jet
    )


# ----------------------------------------------------------------------------
# The highest of each row. Errors of the harmonics may lift a row anywhere: then the whole curve
# says what they leave open of the highest point.
# ----------------------------------------------------------------------------

#: orders above the highest one whose resonances are looked at for what is left out
_BEYOND = 24


class RunUpPeak(NamedTuple):
    """Highest peak of each row (rows,) and its speed in rad/s, with absolute errors.

    The value is infinite, with the speed of the first such resonance, where a driven undamped
    natural frequency lies in the range and shows in the row.
    """

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray


def highest_of(peaks: Sequence[RunUpPeak]) -> RunUpPeak:
    """The highest of several parts of a run-up, row by row; of equals the first."""
    first = np.argmax([peak.value for peak in peaks], axis=0)
    rows = np.arange(len(first))
    best = RunUpPeak(*(np.stack(part)[first, rows] for part in zip(*peaks, strict=True)))
    # another part whose errors reach above leaves the value open so far, and the speed
    above = np.max([np.where(p.error > 0.0, p.value + p.error, 0.0) for p in peaks], axis=0)
    finite = np.isfinite(best.value)
    height = np.where(finite, best.value, 0.0)
    higher = np.where(finite, above - height, 0.0)
    unsure, level = finite & (best.error > SURE * height), height - best.error
    away = [
        (unsure & (p.value + p.error >= level)) * (np.abs(p.speed - best.speed) + p.speed_error)
        for p in peaks
    ]
    return best._replace(
        error=np.maximum(best.error, higher),
        speed_error=np.maximum(best.speed_error, np.max(away, axis=0)),
    )


def highest_peaks(machines: Machines) -> RunUpPeak:
    """The highest peak (machines * rows,) of each row from few speeds."""
    return highest(machines, sparse_samples(machines), SPARSE, 2)


def highest(machines: Machines, samples: Samples, threshold: float, beside: int) -> RunUpPeak:
    """The highest next to local maxima of samples from a share of the highest of each row on.

    Among few speeds a kink may part two peaks within a step, or one may hide next to the maximum:
    then those next to it are looked at `beside` it, too.
    """
    value, total = samples.value, len(machines.infinite)
    first = np.flatnonzero(np.diff(samples.machine, prepend=-1))
    top = np.maximum.reduceat(value, first, axis=0)[samples.machine]
    bounded = ~machines.infinite.reshape(-1, machines.rows)[samples.machine]
    high = local_maxima(samples) & (value >= threshold * top) & (value > 0.0) & bounded
    found = tops_of(machines, samples, high, beside)
    every = Maxima(found.row, found.place, found.height, np.zeros(len(found.row)))
    best = first_highest([every])
    peak = RunUpPeak(np.zeros(total), np.zeros(total), np.full(total, machines.start),
                     np.zeros(total))  # fmt: skip
    for part, known in zip(peak, (*best.height, *best.place), strict=True):
        part[best.row] = known
    peak = over_all(peak, lambda row: _curve(machines, samples, found, row))
    return with_unbounded(peak, machines.masked, machines.meets)


def with_unbounded(peak: RunUpPeak, masked: MaskedSpeeds, meets: np.ndarray) -> RunUpPeak:
    """With an infinite peak of each row at the first resonance that it `meets` (masked, rows)."""
    for row in np.flatnonzero(np.any(meets, axis=0)):
        first = int(np.argmax(meets[:, row]))
        peak.value[row], peak.speed[row] = np.inf, masked.centre[first]
        peak.speed_error[row] = masked.centre_error[first]
    return peak


def over_all(peak: RunUpPeak, curve_of: Callable[[int], tuple[np.ndarray, Bounded]]) -> RunUpPeak:
    """The same with errors that count the whole curve of each row that is not known to rounding:
    speeds (n,), rising, and the row there (n,)."""
    error, speed_error = peak.error.copy(), peak.speed_error.copy()
    for row in np.flatnonzero(peak.error > SURE * peak.value).tolist():
        top = Bounded(peak.speed[row], peak.speed_error[row])
        height = Bounded(peak.value[row], peak.error[row])
        speed_error[row], error[row] = top_errors(top, height, *curve_of(row))
    return peak._replace(error=error, speed_error=speed_error)


def local_maxima(samples: Samples) -> np.ndarray:
    """Which samples (n, rows) are no lower than those next to them."""
    value, machine = samples.value, samples.machine
    edge = np.diff(machine) > 0
    rises = (np.diff(value, axis=0) >= 0.0) | edge[:, None]
    falls = (np.diff(value, axis=0) <= 0.0) | edge[:, None]
    ends = np.ones((1, value.shape[1]), dtype=bool)
    return np.asarray(np.concatenate([ends, rises]) & np.concatenate([falls, ends]))


def _curve(
    machines: Machines, samples: Samples, tops: Tops, row: int
) -> tuple[np.ndarray, Bounded]:
    """Speeds of a row, rising, and its curve there: the samples, all maxima found, and where orders
    above the highest one meet modes with damping."""
    machine = row // machines.rows
    met, orders = machines.resonances, machines.orders
    damped = np.where(met.exposed()[machine] > 0.0, np.nan, met.frequency[machine])
    beyond = damped[:, None] / (np.max(orders) + np.arange(1.0, _BEYOND + 1.0))
    known = samples.speed[samples.machine == machine]
    more = tops.place.value[tops.row == row], beyond.ravel(), known[: 0 if samples.curve else None]
    speed = np.concatenate(more)
    speed = speed[machines.outside(speed)]

    def peaks(part: np.ndarray) -> Bounded:
        return exact_peaks(machines.jets_at(part, np.full(len(part), row), errors=True), orders)

    curve = Bounded(*in_blocks(peaks, speed, orders))
    if samples.curve:
        speed = np.concatenate([speed, known])
        curve = concatenate([curve, samples.curve[:, row]])
    rising = np.argsort(speed, kind="stable")
    return speed[rising], curve[rising]
