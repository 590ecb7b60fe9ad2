"""Every order against every mode: critical speeds, separation, resonances that nothing damps."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import major_orders
from vibecalc.numerics.bounded import Bounded, where
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.rounding import EPSILON, SINGULAR, BoolArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters.motion import ROWS, solved
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.damped_modes import NO_PEAK
from vibecalc.torsion.line import Line
from vibecalc.torsion.poles import all_poles, all_poles_by_order, mode_number, refined_pole
from vibecalc.torsion.results import NAMES, ROOT
from vibecalc.torsion.stress_limits import separation

# ----------------------------------------------------------------------------
# Critical speeds of a shaft line: every order against every mode.
# ----------------------------------------------------------------------------

#: freedoms up to which the poles of the damped line are computed; else modes without coupling
FREEDOMS = 200
#: secant steps to where a pole that follows the speed meets an order
_ROUNDS = 30


def emit_critical(scene: Scene, setup: Setup) -> None:
    """Speeds (mode, order) in rad/s; 0 for a mode that does not vibrate, infinite where none is."""
    path = f"{ROOT}/critical/speed"
    if not scene.wants(path):
        return
    speed = critical(setup)
    axes = {"mode": np.arange(1, len(speed.value) + 1), "order": setup.drive.order}
    scene.emit(path, speed, axes=axes)


def critical(setup: Setup) -> Bounded:
    """Critical speeds (m, q), infinite where there is none.

    A mode that is damped so strongly that no response peaks near its frequency has none.
    """
    modes, order = setup.natural(), setup.drive.order
    held = setup.drive.orders.fixed > 0.0  # a frequency that does not follow meets none
    if setup.model.couplings is not None:
        return where(held, np.inf, setup.model.couplings.critical())
    follows = modes.damped and setup.model.over_speed is not None
    if follows or np.any(setup.model.speed_stiffness):
        return where(held, np.inf, _met(setup))
    speed = Bounded(modes.frequency, modes.frequency_error)[:, None] / order
    none = modes.silent & (modes.frequency > 0.0)
    return where(none[:, None] | held, np.inf, speed)


# ----------------------------------------------------------------------------
# Speeds at which |s| = q speed, of a line that is another one at every speed: secant steps with the
# pole of the line as it is there.
# ----------------------------------------------------------------------------

#: of couplings, by how much a first guess may lie outside the range; what counts as met
_NEAR, _MET = 0.1, 1e-12


def asked_range(setup: Setup) -> tuple[float, float]:
    """Lowest and highest crank speed that a case asks for, rad/s."""
    speeds = setup.torsion.speeds
    every = [setup.speed] if speeds is None else [setup.speed, speeds.start, speeds.stop]
    return min(every), max(every)


def met_criticals(setup: Setup) -> Bounded:
    """Of a line with couplings, critical speeds (m, q); infinite near which nothing peaks.

    Outside the speeds that a case asks for, loads and heat are nobody's: near them those at the
    nearest end count, farther away the modes of the operating speed.
    """
    modes, order, (first, last) = setup.natural(), setup.drive.order, asked_range(setup)
    low, high = first * (1.0 - _NEAR), last * (1.0 + _NEAR)
    speed = modes.frequency[:, None] / order
    error = modes.frequency_error[:, None] / order
    speed[modes.silent & (modes.frequency > 0.0)] = np.inf
    pairs = np.argwhere((speed >= low) & (speed <= high)).tolist()
    due = {
        (mode, place): _Crossing(setup, float(order[place]), complex(modes.pole[mode]), low, high)
        for mode, place in pairs
    }
    for key, one in _crossed(setup, due).items():
        speed[key], error[key] = one.at, one.error
    return Bounded(speed, np.where(np.isfinite(speed), error, 0.0))


def _met(setup: Setup) -> Bounded:
    """Of a line with pendulums, or dampings that follow the speed, critical speeds (m, q).

    On s = i q speed pendulums take S / q^2 off the inertia, which tells where to begin. The
    frequency of a mode over the speed falls as the speed rises, so each mode is met once at most.
    """
    model, natural, order = setup.model, setup.natural(), setup.drive.order
    none = np.where(natural.frequency > 0.0, np.inf, 0.0)
    speed = np.repeat(none[:, None], len(order), axis=1)
    error = np.zeros_like(speed)
    begin = all_poles_by_order(_as_its_modes(setup, 0.0, 0.0), model.speed_stiffness, order)
    due = {}
    for number, place in enumerate(begin.order.tolist()):
        guess, one = complex(begin.pole[number]), float(order[place])
        # what the field of a pendulum turns unstable is no motion of the line
        if guess.imag >= 0.5 * abs(guess) and guess.real <= 0.1 * abs(guess):
            due[number, place] = _Crossing(setup, one, guess, 0.0, 1e3 * abs(guess) / one)
    for (_, place), found in _crossed(setup, due).items():
        there = _as_its_modes(setup, found.at, 0.0)
        mode = mode_number(there, found.pole, len(natural.frequency))
        speed[mode, place], error[mode, place] = found.at, found.error
    return Bounded(speed, error)


def _as_its_modes(setup: Setup, speed: float, frequency: float) -> Line:
    """The line at a speed and a frequency, without damping where its modes are those without."""
    line = setup.model.at(speed, frequency) if speed else setup.model.line
    if setup.natural().damped:
        return line
    none = np.zeros(len(line.first))
    still = np.zeros(line.inertia.shape[-1])
    return line._replace(absolute_damping=still, damping=none, loss_factor=none)


class _Crossing:
    """The search for the speed at which a pole meets an order; its error is below 0 in vain."""

    def __init__(self, setup: Setup, order: float, pole: complex, low: float, high: float) -> None:
        self.setup, self.order, self.pole, self.low, self.high = setup, order, pole, low, high
        self.at = abs(pole) / order
        self.last: tuple[float, float] | None = None
        self.error = -1.0

    def step(self) -> bool:
        """Go on; False once it is over."""
        at, order = self.at, self.order
        line = _as_its_modes(self.setup, at, order * at)
        try:
            self.pole, uncertainty = refined_pole(line, self.pole)
        except NumericalFailure:
            return False
        frequency = abs(self.pole)
        left, slope = frequency - order * at, -order
        if self.last is not None and at != self.last[0]:
            slope = (left - self.last[1]) / (at - self.last[0])
        uncertainty += 4.0 * EPSILON * frequency
        none = -self.pole.real >= NO_PEAK * frequency
        if slope >= 0.0 or uncertainty > 1e-4 * frequency or none:
            return False
        if abs(left) <= max(4.0 * uncertainty, _MET * frequency):
            states = self.setup.model.couplings
            off = 0.0 if states is None else 0.5 * frequency * states.spread()
            self.error = (uncertainty + abs(left) + off) / -slope + 4.0 * EPSILON * at
            return False
        self.last, self.at = (at, left), at - left / slope
        return self.low < self.at < self.high


def _crossed(
    setup: Setup, every: dict[tuple[int, int], _Crossing]
) -> dict[tuple[int, int], _Crossing]:
    """Those of some searches that are met."""
    due = every
    for _ in range(_ROUNDS):
        if not due:
            break
        # conditions of couplings are found together
        setup.model.at(np.array([one.at for one in due.values()]))
        due = {key: one for key, one in due.items() if one.step()}
    return {key: one for key, one in every.items() if one.error >= 0.0}


# ----------------------------------------------------------------------------
# Adapter: how far the modes of a shaft line are from its orders.
#
# What a rule asks of that (`stress_limits.py`) is reported where the case names the rule.
# ----------------------------------------------------------------------------


def beyond(setup: Setup, highest_speed: float) -> BoolArray:
    """Modes (m,) that no order of the case is near, or that none makes resonate.

    That is rigid modes, those damped so strongly that no response peaks near them, and those above
    the highest order. Above it is where the next order, which the case leaves out, would be nearer.
    """
    natural, order = setup.natural(), setup.drive.order
    if not (np.any(setup.drive.fires) or setup.drive.given):  # a step in time alone
        return np.ones(len(natural.frequency), dtype=bool)
    step = order[-1] - order[-2] if len(order) > 1 else order[-1]
    above = natural.frequency > (order[-1] + 0.5 * step) * highest_speed
    return np.asarray(natural.silent | above)


def emit_separation(scene: Scene, setup: Setup, where: str, low: float, high: float) -> None:
    """Margins (mode, class) from speeds `low` to `high` in rad/s.

    Infinite, with order 0 and kept, for modes `beyond` and for a class without orders.
    """
    rule, firing = setup.torsion.separation, setup.drive.firing
    modes, order = setup.natural(), setup.drive.order
    verdict = separation(modes.frequency, order, low, high, rule or "api_618")
    blank, drive = beyond(setup, high), setup.drive
    major = drive.fires & major_orders(firing.angle, order, firing.bank)
    follows = (drive.orders.fixed == 0.0) | (low == high)
    classes = NAMES["order_class"]
    shape = (len(modes.frequency), len(classes))
    margin, nearest, sufficient = (
        np.full(shape, np.inf),
        np.zeros(shape),
        np.ones(shape, dtype=np.int64),
    )
    error = np.zeros(shape)
    uncertainty: FloatArray = modes.frequency_error[:, None] / (
        order * (low if low > 0.0 else high)
    )
    for column, chosen in enumerate((major, follows & ~major)):
        places = np.flatnonzero(chosen)
        if not len(places):
            continue
        by_order = verdict.margin[:, places]
        best = np.argmin(by_order, axis=1)
        row = np.arange(len(by_order))
        margin[:, column] = np.where(blank, np.inf, by_order[row, best])
        nearest[:, column] = np.where(blank, 0.0, order[places][best])
        sufficient[:, column] = np.where(blank, True, np.all(verdict.kept[:, places], axis=1))
        rounding = 8.0 * EPSILON * (1.0 + np.abs(by_order[row, best]))
        error[:, column] = uncertainty[:, places][row, best] + rounding
    axes = {"mode": np.arange(1, shape[0] + 1), "order_class": classes}
    place = f"{ROOT}/separation/{where}"
    scene.emit(f"{place}/margin", margin, np.where(np.isfinite(margin), error, 0.0), axes)
    scene.emit(f"{place}/order", nearest, 0.0, axes)
    if rule is not None:
        scene.emit(f"{place}/sufficient", sufficient, 0.0, axes)


# ----------------------------------------------------------------------------
# Speeds of a range at which an order meets a mode that nothing damps.
# ----------------------------------------------------------------------------

#: part of a mode's largest twist below which a section counts as still
STILL = 1e-11


class UndampedResonances(NamedTuple):
    """By rising speed (u,) in rad/s; `mode` from 1; `low` and `high` enclose what has no digits."""

    speed: FloatArray
    low: FloatArray
    high: FloatArray
    mode: IntArray
    order: FloatArray
    error: FloatArray


#: damping ratio above which a mode is far from none
CLEARLY = 1e-6


def none_undamped(setup: Setup) -> UndampedResonances | None:
    """What `undamped_speeds` finds where all poles are clearly damped; None where they are not.

    In a small part of the time that the modes of the line take. Of many machines, those with a pole
    that is not are left to runs of their own.
    """
    model = setup.model
    if model.modal is not None or model.over_speed is not None or model.couplings is not None:
        return None
    if np.any(model.speed_stiffness) or model.line.inertia.shape[-1] > FREEDOMS:
        return None
    poles = all_poles(model.line)
    unclear = ~(-poles.pole.real >= CLEARLY * np.abs(poles.pole))
    if model.machines:
        leave_alone(np.bincount(poles.machine[unclear], minlength=model.machines) > 0)
    if np.any(unclear):
        return None
    none, places = np.zeros(0), np.zeros(0, dtype=np.int64)
    return UndampedResonances(none, none, none, places, none, none)


def undamped_speeds(setup: Setup, first: float, last: float) -> UndampedResonances:
    """Those from `first` to `last` whose order drives the mode, in rad/s."""
    modes, drive = setup.natural(), setup.drive
    natural = np.where(modes.frequency > 0.0, modes.frequency, 1.0)
    # as near as this, and with as little damping, fewer than four digits are left
    exposed = (modes.frequency_error / natural + 4.0 * EPSILON) / SINGULAR
    free = (modes.frequency > 0.0) & (modes.damping_ratio < exposed)
    none = np.zeros((len(free), len(drive.order)))
    speed, uncertainty = critical(setup) if np.any(free) else Bounded(none, none)
    inside = free[:, None] & (speed >= first) & (speed <= last)
    mode, place = np.nonzero(inside)
    at = speed[mode, place]
    row = np.arange(len(at))
    torque, error = drive.torque(at)[row, place]
    shape = modes.shape[mode][:, drive.freedom]
    driven = np.abs(np.sum(shape * torque, axis=1))
    least = np.sum(np.abs(shape) * error, axis=1)
    least = least + (modes.shape_error[mode] + 16.0 * EPSILON) * np.abs(torque).sum(axis=1)
    keep = np.flatnonzero(driven > 2.0 * least)
    keep = keep[np.argsort(at[keep], kind="stable")]
    at, mode, place = at[keep], mode[keep], place[keep]
    width = exposed[mode] * at
    return UndampedResonances(
        speed=at,
        low=at - width,
        high=at + width,
        mode=mode + 1,
        order=drive.order[place],
        error=uncertainty[mode, place] + 4.0 * EPSILON * at,
    )


# ----------------------------------------------------------------------------
# Which order and mode make a maximum of a shaft line's curve: the one that resonates there.
# ----------------------------------------------------------------------------

#: relative distances at which a maximum is examined from both sides
SCALES = np.array([0.0025, 0.005, 0.01, 0.02, 0.04])
#: relative distance up to which a maximum belongs to a critical of a mode, without its damping,
#: and what each unit of damping ratio adds
NEAR, WIDER = 0.03, 2.0


class MeetingOrder(NamedTuple):
    """At each maximum (r,): order and mode (from 1); 0: none."""

    order: FloatArray
    mode: IntArray


def meeting(setup: Setup, speed: FloatArray, section: IntArray, end: BoolArray) -> MeetingOrder:
    """What resonates in sections (r,) at the speeds (r,) of their maxima; nothing at an `end` (r,).

    The curve itself says how wide a maximum is: the least distance at which half of what it stands
    out at any is there. The order is the one whose own amplitude stands out most at this distance;
    the largest of all may be on a flank. The mode is the one of most torque among those that the
    order meets near by.
    """
    if not len(speed):
        return MeetingOrder(np.zeros(0), np.zeros(0, dtype=np.int64))
    order = setup.drive.order
    sides = np.concatenate([[1.0], 1.0 - SCALES, 1.0 + SCALES])
    unique, place = np.unique(speed, return_inverse=True)
    at, known = unique[:, None] * sides, setup.drive.card_speed
    if len(known):  # beyond the speeds of the gas nobody knows the torque
        at = np.clip(at, known[0], known[-1])
    size, half, masked = _half_ranges_at(setup, at, place, section)
    low, high = slice(1, 1 + len(SCALES)), slice(1 + len(SCALES), None)
    out = half[:, :1] - 0.5 * (half[:, low] + half[:, high])
    wide = np.argmax(out >= 0.5 * out.max(axis=1, keepdims=True), axis=1)
    row = np.arange(len(speed))
    gain = size[:, 0] - 0.5 * (size[:, low] + size[:, high])[row, wide]
    gain = np.where(masked, np.inf, np.where(end[:, None], 0.0, gain))
    best = np.argmax(gain, axis=1)
    mode = _modes(setup, speed, section, best)
    meets = (gain[row, best] > 0.0) & (mode > 0)
    return MeetingOrder(np.where(meets, order[best], 0.0), np.where(meets, mode, 0))


def _half_ranges_at(
    setup: Setup, speeds: FloatArray, place: IntArray, section: IntArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Amplitudes (r, k, m) and half ranges (r, k) of torques, masked (r, m).

    Speeds (u, k), those of maximum r in row place[r]; the first of a row is its middle.
    """
    model, drive = setup.model, setup.drive
    rows, each = speeds.shape
    torque = np.empty((len(place), each, len(drive.order)), dtype=np.complex128)
    masked = np.empty((len(place), len(drive.order)), dtype=bool)
    step = max(1, ROWS // each)
    for start in range(0, rows, step):
        at = solved(model, drive, speeds[start : start + step].ravel())
        shape = (-1, each, *at.torque.shape[1:])
        held = np.flatnonzero((place >= start) & (place < start + step))
        row, of = place[held] - start, section[held]
        # an order without bound next to a maximum stands out from nothing
        clear = np.where(at.masked[..., None], 0.0, at.torque).reshape(shape)
        torque[held] = clear[row[:, None], np.arange(each), :, of[:, None]]
        masked[held] = at.masked.reshape(shape[:3])[row, 0]
    half = synthesis(drive.cycles, torque).half_range
    return np.abs(torque), half, masked


def _modes(setup: Setup, speed: FloatArray, section: IntArray, order: IntArray) -> IntArray:
    """Number (r,), from 1, of the mode that an order (place) drives most there; 0: none is near."""
    modes, drive, line = setup.natural(), setup.drive, setup.model.line
    met = critical(setup).value[:, order]
    ratio = np.abs(modes.damping_ratio)[:, None]
    finite = np.isfinite(met) & (met > 0.0)
    share = np.where(finite, met, 1.0) / speed
    near = finite & (np.abs(share - 1.0) <= NEAR + WIDER * ratio)
    row = np.arange(len(speed))
    torque = drive.load(speed)[row, order]
    drives = np.abs(modes.shape[:, drive.freedom] @ torque.T)
    twist = np.abs(modes.shape[:, line.first[section]] - modes.shape[:, line.second[section]])
    away = np.hypot(share**2 - 1.0, 2.0 * ratio * share) + 1e-12
    inertia = np.where(modes.inertia > 0.0, modes.inertia, np.inf)[:, None]
    height = np.where(near, drives * twist / (inertia * away), -1.0)
    best = np.argmax(height, axis=0)
    return np.where(height[best, row] >= 0.0, best + 1, 0)
