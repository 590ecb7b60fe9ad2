"""Machines for the tests of switching transients, and a general integrator as their truth."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp

from vibecalc.excitation.inertia_forces import reciprocating_excitation
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.matrices import Matrices
from vibecalc.response.modes import modes
from vibecalc.response.switching.motion import Segment, follow_profile
from vibecalc.response.switching.system import Loads, ModalSystem, SpeedSegment, modal_loads

INCH, POUND_FORCE, POUND = 0.0254, 4.4482216152605, 0.45359237
SPEED = 361.0
RADIUS, ROD = 0.5 * INCH, 2.375 * INCH
MASS = (0.659 + 0.075 + 0.131 * 0.625 / 2.375) * POUND
BOTH, ONLY_A, ONLY_B, IDLE = range(4)
REVERSAL = [
    SpeedSegment(0.4, SPEED, 0.0, BOTH),
    SpeedSegment(0.1, 0.0, 0.0, BOTH),
    SpeedSegment(0.3, 0.0, -SPEED, ONLY_A),
    SpeedSegment(0.2, -SPEED, -SPEED, ONLY_A),
]
THROUGH_ZERO = [
    SpeedSegment(0.5, SPEED, -0.6 * SPEED, ONLY_A),
    SpeedSegment(0.1, -0.6 * SPEED, 0.0, BOTH),
]


def compressor_matrices() -> Matrices:
    """Mass and stiffness of Ong's two-cylinder compressor (2000, chapter 4), in SI."""
    mass = np.diag([0.206, 0.206, 0.206, 3.37, 2.97, 1.45])
    mass[4, 5] = mass[5, 4] = -0.49
    stiffness = np.array(
        [
            [1328.0, 18.9, 14.1, 101.0, -2123.0, 385.0],
            [18.9, 1355.0, 36.4, 2246.0, -141.0, 96.7],
            [14.1, 36.4, 1079.0, -115.0, -159.0, 32.9],
            [101.0, 2246.0, -115.0, 23046.0, -903.0, 382.0],
            [-2123.0, -141.0, -159.0, -903.0, 30870.0, -2006.0],
            [385.0, 96.7, 32.9, 382.0, -2006.0, 14486.0],
        ]
    )
    length = np.array([1.0] * 3 + [INCH] * 3)
    # every rotation, as row or column, brings a lever in inches
    scale = POUND_FORCE / INCH * np.outer(length, length)
    none = np.zeros((6, 6))
    return Matrices(mass * scale, stiffness * scale, none, none, none, none, none, none)


def compressor(ratio: float | np.ndarray = 0.03) -> ModalSystem:
    """Its modes, with one damping ratio for all or one each."""
    found = modes(compressor_matrices())
    ratios = np.broadcast_to(np.asarray(ratio, dtype=float), (6,)).copy()
    return ModalSystem(found.shape, found.natural_frequency, ratios)


def compressor_loads(highest_order: int = 24, rotor: float = 0.0) -> Loads:
    """Pistons A and B, only A, only B, none; `rotor` in kg m^2 turns about z with the crank."""
    harmonics = motion_harmonics(RADIUS / ROD, highest_order)
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
    both = np.concatenate([excitation.force, excitation.couple], axis=-1)
    push = np.zeros((4, 6))
    push[:, 5] = -rotor
    return Loads(np.arange(1, highest_order + 1), both, push)


def one_mode(
    frequency: float, ratio: float, orders: Sequence[int], loads: np.ndarray
) -> tuple[ModalSystem, Loads]:
    """A unit mass on a spring; loads (operations, orders) complex in kg m."""
    system = ModalSystem(np.eye(1), np.array([frequency]), np.array([ratio]))
    values = np.asarray(loads, dtype=complex)[..., None]
    return system, Loads(np.array(orders), values, np.zeros((len(values), 1)))


def crank_angle_and_speed(
    profile: Sequence[SpeedSegment], angle: float
) -> Callable[[float], tuple[float, float, float, int]]:
    """Angle, speed, acceleration and operation at a time, by adding up profile."""
    starts, angles = [0.0], [angle]
    for segment in profile:
        angles.append(
            angles[-1] + 0.5 * (segment.start_speed + segment.end_speed) * segment.duration
        )
        starts.append(starts[-1] + segment.duration)

    def at(time: float) -> tuple[float, float, float, int]:
        number = max(n for n in range(len(profile)) if starts[n] <= time or n == 0)
        segment, since = profile[number], time - starts[number]
        acceleration = (segment.end_speed - segment.start_speed) / segment.duration
        speed = segment.start_speed + acceleration * since
        turned = angles[number] + segment.start_speed * since + 0.5 * acceleration * since**2
        return turned, speed, acceleration, segment.operation

    return at


def integrate(
    system: ModalSystem,
    loads: Loads,
    profile: Sequence[SpeedSegment],
    times: np.ndarray,
    *,
    angle: float = 0.0,
    before: int | None = None,
    tolerance: float = 1e-12,
) -> np.ndarray:
    """Body displacement and velocity (times, 2 coordinates) by a general integrator.

    In coordinates, with matrices put together from the modes; the load is minus the second
    derivative of its place-like sum by time, by the chain rule.
    """
    back = np.linalg.inv(system.shape)
    mass_inverse = system.shape @ system.shape.T
    stiffness = back.T @ np.diag(system.frequency**2) @ back
    damping = back.T @ np.diag(2.0 * system.damping_ratio * system.frequency) @ back
    orders, count = loads.orders, len(system.shape)
    at = crank_angle_and_speed(profile, angle)
    place = loads.per_speed_squared / orders[:, None] ** 2  # m n^2 X over n^2

    def force(time: float, which: int, slot: float) -> np.ndarray:
        turned, speed, acceleration, _ = at(slot if time < slot else time)
        wave = np.exp(1j * orders * turned)[:, None] * place[which]
        bend = -(orders[:, None] ** 2) * wave
        slope = 1j * orders[:, None] * wave
        moved = np.sum(bend * speed**2 + slope * acceleration, axis=0).real
        return -moved + loads.per_acceleration[which] * acceleration

    start = profile[0].start_speed
    first = profile[0].operation if before is None else before
    state = np.zeros(2 * count)
    for n, row in zip(orders.tolist(), loads.per_speed_squared[first], strict=True):
        rate = n * start
        dynamic = stiffness + 1j * rate * damping - rate**2 * np.linalg.inv(mass_inverse)
        wave = np.linalg.solve(dynamic, row * start**2) * np.exp(1j * n * angle)
        state = state + np.concatenate([wave.real, (1j * rate * wave).real])
    result = np.empty((len(times), 2 * count))
    begin = 0.0
    for segment in profile:
        end = begin + segment.duration
        last = segment is profile[-1]
        mine = (times >= begin) & ((times <= end) if last else (times < end))

        def law(time: float, y: np.ndarray, which: int = segment.operation, slot: float = begin,
                stop: float = end) -> np.ndarray:  # fmt: skip
            inside = min(time, stop - 1e-15 * stop) if stop > slot else time
            load = force(inside, which, slot)
            pull = stiffness @ y[:count] + damping @ y[count:]
            return np.concatenate([y[count:], mass_inverse @ (load - pull)])

        ends = np.append(times[mine], end)
        done = solve_ivp(
            law, (begin, end), state, method="DOP853", t_eval=np.unique(ends),
            rtol=tolerance, atol=1e-12 * max(np.max(np.abs(state)), 1e-9),
        )  # fmt: skip
        assert done.success
        index = np.searchsorted(done.t, times[mine])
        result[mine] = done.y.T[index]
        state, begin = done.y[:, -1], end
    return result


def followed(
    system: ModalSystem, loads: Loads, profile: list[SpeedSegment], angle: float, before: int
) -> list[Segment]:
    """Segments of a course, times at most a hundredth of a second apart."""
    modal = modal_loads(system, loads)
    return follow_profile(system, modal, profile, angle=angle, before=before, longest=0.01)
