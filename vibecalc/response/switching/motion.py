"""The motion of all modes over a course of crank speeds, panel by panel."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.errors import with_errors
from vibecalc.response.switching.system import (
    ModalLoads,
    ModalSystem,
    SpeedSegment,
    free_motion,
    modal_size,
    poles,
    steady_amplitude,
    steady_state,
)

# ----------------------------------------------------------------------------
# A course: stretches of time in which the crank accelerates evenly, with the load in each.
# ----------------------------------------------------------------------------

#: phase in rad that the fastest part of the motion may turn within a panel
PANEL_PHASE = 2.0
#: more panels than this are refused
MOST_PANELS = 1_000_000
#: panels or times that are taken together, so that memory stays small
BLOCK = 1 << 13


@dataclass(frozen=True)
class Course:
    """Segments of a profile one after the other, and the loads on the modes in them.

    `time` (runs + 1,) are their ends in s; crank `angle` and `speed` those at the start of each,
    with its even `acceleration` and its `operation`. At first the body is in the steady motion of
    the operation `before`. `amplitude` (operations, orders, modes) are loads per speed squared.
    """

    system: ModalSystem
    orders: np.ndarray
    amplitude: Any
    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    operation: np.ndarray
    before: int

    def angle_at(self, run: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Crank angles (...) at times (...) of runs (...)."""
        passed = time - self.time[run]
        gained = 0.5 * self.acceleration[run] * passed
        return np.asarray(self.angle[run] + passed * (self.speed[run] + gained))

    def speed_at(self, run: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Crank speeds at times of runs."""
        return np.asarray(self.speed[run] + self.acceleration[run] * (time - self.time[run]))

    def load_at(self, run: np.ndarray, time: np.ndarray, rate: bool = False) -> np.ndarray:
        """Modal loads (..., modes) at times (...) of runs (...), or their rates of change.

        Re sum p_n (w^2 - i w'/n) exp(i n theta), whose rate is, w' being constant,
        Re sum p_n (i n w^3 + 3 w w') exp(i n theta).
        """
        shape = np.broadcast_shapes(np.shape(run), np.shape(time))
        kinds = np.unique(self.operation[run])
        run, time = (np.broadcast_to(one, shape).ravel() for one in (run, time))
        turned = turns(self.angle_at(run, time), self.orders)
        found = np.empty((2, run.size, self.amplitude.shape[-1]))
        for operation in kinds:
            mine = slice(None) if len(kinds) == 1 else self.operation[run] == operation
            load = self.amplitude[operation]
            other = load * self.orders[:, None] if rate else load / self.orders[:, None]
            # real and imaginary part of the sum, from cosines and sines
            table = np.block([[load.real, other.imag], [-load.imag, other.real]])
            found[:, mine] = np.hsplit(turned[:, mine].T @ table, 2)
        real, imaginary = found
        speed, gain = self.speed_at(run, time)[:, None], self.acceleration[run][:, None]
        if rate:
            total = 3.0 * speed * gain * real - speed**3 * imaginary
        else:
            total = speed**2 * real + gain * imaginary
        return np.asarray(total).reshape(*shape, total.shape[-1])


def turns(angle: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Cosines of n angle (t,) for ascending whole orders n (m,), then their sines, (2 m, t).

    By the addition theorem from order to order: it costs n roundings, as many as n angle does.
    """
    wave, single, before = np.ones(angle.shape, dtype=complex), np.exp(1j * angle), 0
    found = np.empty((2, len(orders), len(angle)))
    for place, order in enumerate(orders.tolist()):
        wave = wave * (single if order - before == 1 else single ** (order - before))
        found[0, place], found[1, place], before = wave.real, wave.imag, order
    return found.reshape(2 * len(orders), len(angle))


def course_of(
    system: ModalSystem,
    loads: ModalLoads,
    profile: Sequence[SpeedSegment],
    angle: float,
    before: int,
) -> Course:
    """The course of a profile from a crank angle on; its loads are `Bounded`."""
    duration, first, last, operation = (np.array(part) for part in zip(*profile, strict=True))
    turned = angle + np.cumsum(0.5 * (first + last) * duration)
    return Course(
        system, loads.orders, loads.amplitude, np.concatenate([[0.0], np.cumsum(duration)]),
        np.concatenate([[angle], np.mod(turned[:-1], 2.0 * np.pi)]), first,
        (last - first) / duration, operation, before,
    )  # fmt: skip


class Panels(NamedTuple):
    """Ends (panels + 1,) in s of the panels of a course, and the run of each of them."""

    node: np.ndarray
    run: np.ndarray


def panels_of(course: Course, longest: float, phase: float = PANEL_PHASE) -> Panels:
    """Panels of equal length in each run, no longer than `longest` in s.

    Over a panel the highest order, the fastest pole and the change of speed together turn by
    `phase` at most. Raises NumericalFailure if that takes more than a million panels.
    """
    acts = course.amplitude.value != 0.0
    highest = np.max(course.orders * np.any(acts, axis=(0, 2)), initial=0)
    slow, gap = poles(course.system)
    fastest = np.max(np.abs(slow - gap) * np.any(acts, axis=(0, 1)))
    duration, gain = np.diff(course.time), np.abs(course.acceleration)
    speed = np.maximum(np.abs(course.speed), np.abs(course.speed + course.acceleration * duration))
    rate = fastest + np.sqrt(highest * gain) + highest * speed
    count = np.ceil(duration * (rate / phase + 1.0 / longest))
    if not np.sum(count) <= MOST_PANELS:
        raise NumericalFailure(
            f"the transient of {course.time[-1]:.6g} s would take {np.sum(count):.3g} steps, more "
            f"than can be followed ({MOST_PANELS}): the fastest order or mode turns too often; "
            f"shorten it, keep fewer orders, or see whether a mode is meant to be so stiff or so "
            f"strongly damped"
        )
    run = np.repeat(np.arange(len(count)), count.astype(int))
    share = np.concatenate([np.arange(each) / each for each in count])
    return Panels(np.append(course.time[run] + duration[run] * share, course.time[-1]), run)


# ----------------------------------------------------------------------------
# Modes under a load of changing speed: exact free motion, Gauss quadrature of the load.
#
# Over a panel y(h) = E(h) y(0) + integral of E(h - t) (0, f(t)) dt, with E the free motion in
# closed form. The integral is taken by Gauss-Legendre rules with 7 points, and with 6 for the
# error: on panels in which everything turns by two radians at most, the first misses less than
# 3e-15 of what the fastest part adds, the second less than 2e-12. Slower parts miss far less.
# ----------------------------------------------------------------------------

_POINTS = 7


def driven_part(
    course: Course,
    run: np.ndarray | int,
    begin: np.ndarray,
    step: np.ndarray | float,
    points: int = _POINTS,
) -> np.ndarray:
    """What the load adds to the states (n, modes, 2) from `begin` (n,) over `step` in a `run`.

    Run and step are (n,), or one for all: what a push leaves behind is then formed once.
    """
    place, weight = np.polynomial.legendre.leggauss(points)
    place, weight = 0.5 * (1.0 + place), 0.5 * weight
    modes = np.ones_like(course.system.frequency)
    push = np.stack([0.0 * modes, modes], axis=-1)

    def left(length: np.ndarray) -> np.ndarray:
        after = free_motion(course.system, length * (1.0 - place), push)
        return np.asarray(after * (length * weight)[..., None, None])

    added = np.zeros((len(begin), len(modes), 2))
    run, length = np.asarray(run)[..., None], np.asarray(step)[..., None]
    even = length.ndim == 1
    once = left(length) if even else added
    for start in range(0, len(begin), BLOCK):
        part = slice(start, start + BLOCK)
        own, over = (run, length) if even else (run[part], length[part])
        force = course.load_at(own, begin[part, None] + over * place)
        if even:
            added[part] = np.einsum("npm,pmk->nmk", force, once)
        else:
            added[part] = np.einsum("npm,npmk->nmk", force, left(over))
    return added


def march(course: Course, panels: Panels, points: int = _POINTS) -> np.ndarray:
    """States (panels + 1, modes, 2) at the ends of the panels.

    In each run, whose panels are of one length, what each adds is summed up over spans that double,
    the free motion over each span being one step. Nothing is ever amplified.
    """
    steady = steady_amplitude(
        course.system, course.orders, course.amplitude[course.before], course.speed[0]
    )
    begin = steady_state(steady.value, course.orders, course.speed[0], course.angle[0])
    states = [begin[None]]
    for run in np.unique(panels.run).tolist():
        own = np.flatnonzero(panels.run == run)
        node = panels.node[own]
        step = (panels.node[own[-1] + 1] - node[0]) / len(own)
        total = np.concatenate([states[-1][-1:], driven_part(course, run, node, step, points)])
        span = 1
        while span < len(total):
            total[span:] += free_motion(course.system, span * step, total[:-span])
            span *= 2
        states.append(total[1:])
    return np.concatenate(states)


class Followed(NamedTuple):
    """A course that has been followed: states (panels + 1, modes, 2) at the ends of its panels.

    `error` (modes,) bounds the error of the size sqrt(q'^2 + w^2 q^2) throughout.
    """

    course: Course
    panels: Panels
    state: np.ndarray
    error: np.ndarray

    def motion_at(self, panel: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Modal displacement and its three derivatives (4, n, modes) at times (n,) in panels."""
        course, run, begin = self.course, self.panels.run[panel], self.panels.node[panel]
        system, step = course.system, time - begin
        state = free_motion(system, step, self.state[panel]) + driven_part(course, run, begin, step)
        return self.motion_of(state, run, time)

    def motion_of(self, state: np.ndarray, run: np.ndarray, time: np.ndarray) -> np.ndarray:
        """The same of states (n, modes, 2) at times in runs."""
        course, system = self.course, self.course.system
        damping, stiffness = 2.0 * system.damping_ratio * system.frequency, system.frequency**2
        displacement, velocity = state[..., 0], state[..., 1]
        acceleration = course.load_at(run, time) - damping * velocity - stiffness * displacement
        rate = course.load_at(run, time, rate=True)
        jerk = rate - damping * acceleration - stiffness * velocity
        return np.stack([displacement, velocity, acceleration, jerk])

    def panel_at(self, time: np.ndarray) -> np.ndarray:
        """Panels (...) of times (...)."""
        after = np.searchsorted(self.panels.node, time, side="right")
        return np.clip(after - 1, 0, len(self.panels.run) - 1)


def follow_profile(
    system: ModalSystem,
    loads: ModalLoads,
    profile: Sequence[SpeedSegment],
    *,
    angle: float,
    before: int,
    longest: float,
) -> Followed:
    """The motion over a speed profile that begins in the steady motion of the operation `before`.

    `longest` in s bounds the length of panels. Raises NumericalFailure if there would be too many.
    What the dropped orders do by themselves counts twice, for what is between the panels' ends.
    """
    kept, dropped = loads.some(slice(loads.retained)), loads.some(slice(loads.retained, None))
    course = course_of(system, kept, profile, angle, before)
    panels = panels_of(course, longest)
    states = with_errors(march, course, panels, coarser=partial(march, points=_POINTS - 1))
    course = replace(course, amplitude=course.amplitude.value)
    alone = replace(course, orders=dropped.orders, amplitude=dropped.amplitude.value)
    off = np.max(modal_size(system, states.error), axis=0)
    off += 2.0 * np.max(modal_size(system, march(alone, panels)), axis=0)
    return Followed(course, panels, states.value, off)
