"""Machines for the tests of switching transients, and a general integrator as their truth."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import ong_tables as ong
from impact_machines import INCH, LENGTH, MASS, RADIUS, SPEED
from scipy.integrate import solve_ivp

from vibecalc.excitation.inertia_forces import reciprocating_excitation
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded, bounded
from vibecalc.response.modes import modes
from vibecalc.response.switching.follow import Transient, follow, worst_instant
from vibecalc.response.switching.motion import Followed, follow_profile
from vibecalc.response.switching.system import ModalLoads, ModalSystem, SpeedSegment
from vibecalc.response.switching.system import modal_loads as loads_on_modes

BOTH, ONLY_A, ONLY_B, IDLE = range(4)
REVERSAL = [
    SpeedSegment(0.4, SPEED, 0.0, BOTH),
    SpeedSegment(0.1, 0.0, 0.0, BOTH),
    SpeedSegment(0.3, 0.0, -SPEED, ONLY_A),
    SpeedSegment(0.2, -SPEED, -SPEED, ONLY_A),
]


class Loads(NamedTuple):
    """Orders (orders,), and loads (operations, orders, coordinates) per speed squared."""

    orders: np.ndarray
    per_speed_squared: Any
    retained: int | None = None


def modal_loads(system: ModalSystem, loads: Loads) -> ModalLoads:
    """Loads on modes; without `retained` all orders move the body."""
    count = len(loads.orders) if loads.retained is None else loads.retained
    return loads_on_modes(system, loads.orders, bounded(loads.per_speed_squared), count)


def compressor(ratio: float | np.ndarray = 0.03) -> ModalSystem:
    """Its modes, with one damping ratio for all or one each."""
    found = modes(ong.si_matrices())
    ratios = np.broadcast_to(np.asarray(ratio, dtype=float), (6,)).copy()
    return ModalSystem(found.shape, found.natural_frequency, ratios)


def compressor_loads(highest_order: int = 24) -> Loads:
    """Pistons A and B, only A, only B, none."""
    harmonics = motion_harmonics(RADIUS / LENGTH, highest_order)
    working = np.array([[1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    excitation = reciprocating_excitation(
        harmonics,
        crank_radius=np.full(4, RADIUS),
        reciprocating_mass=MASS * working,
        crank_phase=np.broadcast_to([0.0, np.pi], (4, 2)),
        bank_angle=np.zeros((4, 2)),
        position=np.broadcast_to([-3.835 * INCH, -5.710 * INCH], (4, 2)),
        origin=np.zeros(3),
        axis=np.array([0.0, 0.0, 1.0]),
        stroke=np.array([0.0, 1.0, 0.0]),
        across=np.array([1.0, 0.0, 0.0]),
    )
    return Loads(np.arange(1, highest_order + 1), excitation.value)


def one_mode(
    frequency: float, ratio: float, orders: Sequence[int], loads: np.ndarray
) -> tuple[ModalSystem, Loads]:
    """A unit mass on a spring; loads (operations, orders) complex in kg m."""
    system = ModalSystem(np.eye(1), np.array([frequency]), np.array([ratio]))
    values = np.asarray(loads, dtype=complex)[..., None]
    return system, Loads(np.array(orders), values)


class Body(NamedTuple):
    """Mass, stiffness and damping in coordinates (n, n)."""

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


#: on the body (n,), of what is at work, crank angle, speed and acceleration
Load = Callable[[Any, float, float, float], np.ndarray]
#: of a way: duration, speeds at its ends, what is at work
Course = Sequence[tuple[float, float, float, Any]]


def steady(body: Body, load: Load, working: Any, angle: float, speed: float) -> np.ndarray:
    """Place and velocity (2 n,) of the steady motion at a crank angle, by samples of the load."""
    count = 256
    turns = np.arange(count) * (2.0 * np.pi / count)
    waves = np.fft.fft([load(working, a, speed, 0.0) for a in turns], axis=0) / count
    state = np.zeros(2 * len(body.mass))
    for n in range(1, count // 2):
        rate = n * speed
        dynamic = body.stiffness + 1j * rate * body.damping - rate**2 * body.mass
        moved = np.linalg.solve(dynamic, 2.0 * waves[n]) * np.exp(1j * n * angle)
        state += np.concatenate([moved.real, (1j * rate * moved).real])
    return state


def marched(
    body: Body,
    load: Load,
    course: Course,
    times: np.ndarray,
    *,
    before: Any,
    angle: float = 0.0,
    rtol: float = 1e-12,
) -> np.ndarray:
    """Place and velocity (times, 2 n) from the steady motion before, by a general integrator."""
    inverse, n = np.linalg.inv(body.mass), len(body.mass)
    state, begin = steady(body, load, before, angle, course[0][1]), 0.0
    result = np.empty((len(times), 2 * n))
    for number, (duration, first, last, working) in enumerate(course):
        gain, end = (last - first) / duration, begin + duration
        mine = (times >= begin) & ((times < end) | (number == len(course) - 1))

        def law(
            t: float,
            y: np.ndarray,
            first: float = first,
            gain: float = gain,
            angle: float = angle,
            working: Any = working,
        ) -> np.ndarray:
            force = load(working, angle + first * t + 0.5 * gain * t * t, first + gain * t, gain)
            pull = body.stiffness @ y[:n] + body.damping @ y[n:]
            return np.concatenate([y[n:], inverse @ (force - pull)])

        own = np.minimum(times[mine] - begin, duration)
        points = np.unique(np.append(own, duration))
        done = solve_ivp(
            law,
            (0.0, duration),
            state,
            method="DOP853",
            t_eval=points,
            rtol=rtol,
            atol=rtol * max(np.max(np.abs(state)), 1e-9),
        )
        assert done.success
        result[mine] = done.y.T[np.searchsorted(points, own)]
        state, begin = done.y[:, -1], end
        angle += 0.5 * (first + last) * duration
    return result


def integrate(
    system: ModalSystem,
    loads: Loads,
    profile: Sequence[SpeedSegment],
    times: np.ndarray,
    *,
    angle: float = 0.0,
    before: int | None = None,
) -> np.ndarray:
    """The same of a system of modes.

    Its matrices are put together from the modes; the load is minus the second derivative of its
    place-like sum by time, by the chain rule.
    """
    back = np.linalg.inv(system.shape)
    body = Body(
        back.T @ back,
        back.T @ np.diag(system.frequency**2) @ back,
        back.T @ np.diag(2.0 * system.damping_ratio * system.frequency) @ back,
    )
    orders = loads.orders[:, None]
    place = np.asarray(loads.per_speed_squared) / orders**2  # m n^2 X over n^2

    def load(working: int, turned: float, speed: float, gain: float) -> np.ndarray:
        wave = np.exp(1j * orders * turned) * place[working]
        moved = np.sum(-(orders**2) * wave * speed**2 + 1j * orders * wave * gain, axis=0).real
        return np.asarray(-moved)

    first = profile[0].operation if before is None else before
    return marched(body, load, profile, times, before=first, angle=angle)


def followed(
    system: ModalSystem, loads: Loads, profile: list[SpeedSegment], angle: float, before: int
) -> Followed:
    """A course with panels of at most a hundredth of a second."""
    modal = modal_loads(system, loads)
    return follow_profile(system, modal, profile, angle=angle, before=before, longest=0.01)


def motion(found: Followed, times: np.ndarray) -> np.ndarray:
    """Modal displacement and its three derivatives (4, times, modes)."""
    return found.motion_at(found.panel_at(times), times)


def transient(
    system: ModalSystem, loads: Loads, profile: Sequence[SpeedSegment], **options: Any
) -> Transient:
    """A course from the steady motion of its first operation, if no other is named."""
    options = {"before": profile[0].operation, **options}
    return follow(system, modal_loads(system, loads), profile, **options)


def at_once(
    system: ModalSystem,
    loads: Loads,
    before: int,
    after: int,
    duration: float = 1.5,
    **options: Any,
) -> Transient:
    """A change within no time at the usual speed."""
    profile = [SpeedSegment(duration, SPEED, SPEED, after)]
    return transient(system, loads, profile, before=before, **options)


def at_worst(system: ModalSystem, loads: Loads, before: int, after: int) -> tuple[Bounded, float]:
    """The largest kinetic energy over all angles of that change, and the angle."""
    return worst_instant(system, modal_loads(system, loads), before, after, SPEED)
