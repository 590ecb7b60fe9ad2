"""Accuracy of switching: the motion after a change at once, and during a run-down to rest."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import Marched, Rates, march_fixed, march_scipy
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import add, as_loads
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import LinearSystem, forcing_of, linear_system, ratios_of
from vibecalc.response.switching.motion import PANEL_PHASE, driven_part, panel_grid, runs_of
from vibecalc.response.switching.system import (
    Loads,
    ModalLoads,
    ModalSystem,
    SpeedSegment,
    modal_loads,
    propagator,
    steady_motion,
    steady_state,
)

# ----------------------------------------------------------------------------
# The change between two operations as plain arrays: physical matrices, loads and course.
# ----------------------------------------------------------------------------


class Change(NamedTuple):
    """From the first to the second operation of the case, at the case's crank angle.

    `inverse` (6, 6) is the inverse of the mass matrix; `stiffness`, `damping` (6, 6) carry each
    mode's own damping alone, as the stage takes it; `load` (2, orders, 6) per crank speed squared
    of `orders` (orders,); `start` (12,) the steady displacements and velocities at the change.
    """

    system: ModalSystem
    loads: Loads
    modal: ModalLoads
    speed: float
    angle: float
    inverse: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    load: np.ndarray
    orders: np.ndarray
    start: np.ndarray


def change_of(scene: Scene) -> Change | None:
    """What `[response.switching]` asks for, the dropped orders left out; None without it."""
    response = scene.case.response
    if response is None or response.switching is None:
        return None
    options = response.switching
    known = {operation.name: operation for operation in response.operations}
    found = operation_loads(scene, [known[name] for name in options.between])
    each = [
        as_loads(add(shaking, residual[0]))
        for shaking, residual in zip(found.shaking, found.residual, strict=True)
    ]
    kept = forcing_of(scene).retained
    load = np.stack([one.value[:kept] for one in each])
    uncertainty = np.stack([one.error[:kept] for one in each])
    load = np.where(np.abs(load) > 4.0 * uncertainty, load, 0.0)
    matrices, shapes = linear_system(scene)
    ratio = ratios_of(scene, LinearSystem(matrices, shapes)).value
    system = ModalSystem(shapes.shape, shapes.natural_frequency, ratio)
    orders = np.arange(1, kept + 1)
    loads = Loads(orders, load, np.zeros((2, 6)))
    modal = modal_loads(system, loads)
    speed, angle = scene.case.machine.speed, options.crank_angle
    momentum = matrices.mass @ shapes.shape
    own = 2.0 * ratio * shapes.natural_frequency
    steady = steady_state(
        steady_motion(system, modal, 0, speed), modal.orders, speed, np.asarray(angle)
    )
    return Change(
        system,
        loads,
        modal,
        speed,
        angle,
        shapes.shape @ shapes.shape.T,
        (momentum * np.square(shapes.natural_frequency)) @ momentum.T,
        (momentum * own) @ momentum.T,
        load,
        orders,
        np.concatenate([shapes.shape @ steady[:, 0], shapes.shape @ steady[:, 1]]),
    )


def rates_of(change: Change, operation: int, acceleration: float = 0.0) -> tuple[np.ndarray, Rates]:
    """State matrix (12, 12) and right-hand side of (x, x') under one operation.

    `acceleration` is that of the crank, rad/s^2, from the operating speed on. Each order loads the
    body with P (w^2 - i w'/n) exp(i n theta).
    """
    matrix = np.block(
        [
            [np.zeros((6, 6)), np.eye(6)],
            [-change.inverse @ change.stiffness, -change.inverse @ change.damping],
        ]
    )
    pushes = change.inverse @ change.load[operation].T
    used = np.any(pushes != 0.0, axis=0)
    pushes, orders = pushes[:, used], change.orders[used]

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        speed = change.speed + acceleration * time
        theta = change.angle + time * (change.speed + 0.5 * acceleration * time)
        wave = (speed * speed - 1j * acceleration / orders) * np.exp(1j * orders * theta)
        result: np.ndarray = matrix @ state
        result[6:] += (pushes @ wave).real
        return result

    return matrix, rates


# ----------------------------------------------------------------------------
# Topics of switching: the motion after a change at once, and during a run-down to rest.
# ----------------------------------------------------------------------------

#: turns after a change at once, times in each
TURNS, PER_TURN = 2, 16
#: a run-down is watched for a part of it, so long that it passes some modes
PASSAGE = 0.1
PASSAGE_TIMES = 20
TIGHT = 3e-14
#: points of the quadrature on a panel, and those that check it
GAUSS = 7.0 + 6.0


def switching_topics(scene: Scene) -> list[Topic]:
    """The change from the first to the second operation, and the beginning of the real one."""
    change = change_of(scene)
    response = scene.case.response
    if change is None or response is None or response.switching is None:
        return []
    found = [_at_once(change)]
    if response.switching.run_down > 0.0:
        found.append(_run_down(change, float(response.switching.run_down)))
    return found


def _at_once(change: Change) -> Topic:
    count = TURNS * PER_TURN
    times = 2.0 * np.pi / (PER_TURN * change.speed) * np.arange(1, count + 1)
    march = marcher(change, 1, 0.0, times)

    def closed(_: float) -> Answer:
        old, new = (steady_motion(change.system, change.modal, k, change.speed) for k in (0, 1))
        here = np.asarray(change.angle)
        first, second = (
            steady_state(motion, change.modal.orders, change.speed, here) for motion in (old, new)
        )
        angle = change.angle + change.speed * times
        forced = steady_state(new, change.modal.orders, change.speed, angle)
        free = propagator(change.system, times)(first - second)
        moved = (forced + free)[..., 0] @ change.system.shape.T
        return Answer(moved[:, :3], count)

    def reference() -> Reference:
        values = exact_change(change, times)
        agreement = _apart(values, march("DOP853", TIGHT).values)
        return Reference(
            values,
            agreement,
            f"modal closed form in {DIGITS} digits (mpmath); DOP853 at rtol {TIGHT:g} on the "
            f"equations of motion agrees to {agreement:.1e}",
        )

    steps = tuple(float(count * 2**k) for k in range(7))
    return Topic(
        stage="switching",
        name="change at once",
        words=f"translations of the body at {count} times of the first {TURNS} turns after the "
        f"change of operation",
        quantity="response/switching/instant/translation_high, translation_low",
        unit="m",
        work="evaluations of the right-hand side",
        reference=reference,
        solvers=(
            Solver(
                "closed form of modes",
                "steady motion under the second operation and the free motion of each mode",
                "",
                NOTHING_TO_SET,
                closed,
                default=1.0,
                citation="docs/theory.md; cf. Goloskokow and Filippow (1971)",
            ),
            *integrator_solvers(march, steps),
        ),
    )


def _apart(values: np.ndarray, other: np.ndarray) -> float:
    return float(np.max(np.abs(other - values)) / np.max(np.abs(values)))


def _run_down(change: Change, duration: float) -> Topic:
    span = PASSAGE * duration
    acceleration = -change.speed / duration
    times = span / PASSAGE_TIMES * np.arange(1, PASSAGE_TIMES + 1)
    march = marcher(change, 0, acceleration, times)
    turns = span * (change.speed + 0.5 * acceleration * span) / (2.0 * np.pi)
    profile = [SpeedSegment(span, change.speed, change.speed + acceleration * span, 0)]

    def quadrature(phase: float) -> Answer:
        run = runs_of(profile, change.angle)[0]
        grid = panel_grid(change.system, change.modal, run, span, phase)
        grid = np.union1d(grid, times[times < span])
        first = steady_motion(change.system, change.modal, 0, change.speed)
        state = steady_state(first, change.modal.orders, change.speed, np.asarray(change.angle))
        step = np.diff(grid)
        gained = driven_part(change.system, change.modal, run, grid[:-1], step)
        moved = propagator(change.system, step)
        shown = []
        for k in range(len(step)):
            own = type(moved)(*(part[k] for part in moved))
            state = own(state) + gained[k]
            if np.any(np.abs(times - grid[k + 1]) <= 1e-12 * span):
                shown.append(change.system.shape @ state[:, 0])
        return Answer(np.array(shown)[:, :3], GAUSS * len(step))

    coarse = PASSAGE_TIMES * int(np.ceil(8.0 * turns / PASSAGE_TIMES))
    steps = tuple(float(coarse * 2**k) for k in range(6))

    def reference() -> Reference:
        values = quadrature(0.5 * PANEL_PHASE).values
        agreement = _apart(values, superposed(change, 0, acceleration, times))
        return Reference(
            values,
            agreement,
            "quadrature of the exact propagator on panels of half the length; Duhamel's integral "
            "with matrix exponentials of the equations of motion, without modes, agrees to "
            f"{agreement:.1e}",
        )

    return Topic(
        stage="switching",
        name="run-down",
        words=f"translations of the body at {PASSAGE_TIMES} times of the first {span:.3g} s of "
        f"the run-down, {turns:.3g} turns",
        quantity="response/switching/reversal/translation_high, translation_low",
        unit="m",
        work="evaluations of the load",
        reference=reference,
        solvers=(
            Solver(
                "quadrature of the propagator",
                "free motion in closed form, loads by Gauss's rule on panels",
                "phase of a panel [rad]",
                (32.0, 16.0, 8.0, 4.0, PANEL_PHASE, 0.5 * PANEL_PHASE),
                quadrature,
                default=PANEL_PHASE,
                theory="geometric",
                citation="docs/theory.md; cf. Goloskokow and Filippow (1971)",
            ),
            *integrator_solvers(march, steps),
        ),
        default_extra=2.0,
        default_why="panels are safe for a load all at the fastest rate, of which twice as long "
        "ones would miss 4e-11, and short enough to bound the peaks between them",
    )


# ----------------------------------------------------------------------------
# The motion after a change at once, by modes in many digits.
# ----------------------------------------------------------------------------

DIGITS = 34


def exact_change(change: Change, times: np.ndarray) -> np.ndarray:
    """Translations (times, 3): modal closed form by mpmath; modes, loads, ratios as stored."""
    import mpmath

    with mpmath.workdps(DIGITS):
        speed, angle = mpmath.mpf(float(change.speed)), mpmath.mpf(float(change.angle))
        modal, system = change.modal, change.system
        orders = [int(n) for n in modal.orders]
        courses = [
            _exact_mode(
                [[mpmath.mpc(complex(x)) for x in modal.amplitude[k, :, m]] for k in (0, 1)],
                orders,
                mpmath.mpf(float(system.frequency[m])),
                mpmath.mpf(float(system.damping_ratio[m])),
                speed,
                angle,
                [mpmath.mpf(float(t)) for t in times],
            )
            for m in range(len(system.frequency))
        ]
        shape = [[mpmath.mpf(float(x)) for x in row] for row in system.shape[:3]]
        return np.array(
            [
                [
                    float(
                        mpmath.fsum(s * course[k] for s, course in zip(row, courses, strict=True))
                    )
                    for row in shape
                ]
                for k in range(len(times))
            ]
        )


def _exact_mode(
    loads: list[list[Any]],
    orders: list[int],
    frequency: Any,
    ratio: Any,
    speed: Any,
    angle: Any,
    times: list[Any],
) -> list[Any]:
    """Displacements of one mode: steady motion before, steady and free motion after."""
    import mpmath

    def steady(load: list[Any], at: Any) -> tuple[Any, Any]:
        place = rate = mpmath.mpf(0)
        for order, part in zip(orders, load, strict=True):
            w = order * speed
            amplitude = part * speed**2 / (frequency**2 - w**2 + 2j * ratio * frequency * w)
            wave = amplitude * mpmath.expj(order * at)
            place, rate = place + wave.real, rate + (1j * w * wave).real
        return place, rate

    before, after = steady(loads[0], angle), steady(loads[1], angle)
    place, rate = before[0] - after[0], before[1] - after[1]
    root = mpmath.sqrt(mpmath.mpc(ratio**2 - 1)) * frequency
    first, second = -ratio * frequency + root, -ratio * frequency - root
    apart = first - second
    if apart == 0:
        parts = [(place + (rate - first * place) * t) * mpmath.exp(first * t) for t in times]
    else:
        one, two = (rate - second * place) / apart, (first * place - rate) / apart
        parts = [one * mpmath.exp(first * t) + two * mpmath.exp(second * t) for t in times]
    return [
        steady(loads[1], angle + speed * t)[0] + mpmath.re(part)
        for t, part in zip(times, parts, strict=True)
    ]


# ----------------------------------------------------------------------------
# Integrators on the equations of motion of a change, by steps and by tolerance.
# ----------------------------------------------------------------------------

RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
#: the implicit method takes too many steps beyond
LEAST_OF_RADAU = 1e-7
#: panels between two times of a superposition, and Gauss points on each
_PANELS, _POINTS = 8, 16

#: a method's name and its number of steps or rtol to translations (times, 3)
March = Callable[[str, float], Answer]


def integrator_solvers(march: March, steps: tuple[float, ...]) -> list[Solver]:
    """Euler and RK4 with these numbers of steps, scipy's methods with falling tolerances."""
    found = [
        Solver(name, words, "steps", steps, partial(march, way), theory=theory)
        for name, way, words, theory in (
            ("Euler", "euler", "explicit Euler on the equations of motion", "order 1"),
            ("RK4", "rk4", "classical Runge-Kutta on the equations of motion", "order 4"),
        )
    ]
    for name, words in (
        ("RK45", "scipy's pair of Dormand and Prince"),
        ("DOP853", "scipy's pair of order 8"),
        ("Radau", "scipy's implicit method of order 5"),
    ):
        mine = tuple(rtol for rtol in RTOLS if name != "Radau" or rtol >= LEAST_OF_RADAU)
        found.append(Solver(name, words, "rtol", mine, partial(march, name)))
    return found


def marcher(change: Change, operation: int, acceleration: float, times: np.ndarray) -> March:
    """Translations at `times` from the change on, the crank speeding up by `acceleration`.

    The number of fixed steps is a multiple of that of the times.
    """
    matrix, rates = rates_of(change, operation, acceleration)
    length = np.maximum(np.abs(change.start[:6]), 1e-3 * np.max(np.abs(change.start[:3])))
    scale = np.concatenate([length, length * change.speed])
    grid = np.concatenate([[0.0], times])

    def march(way: str, setting: float) -> Answer:
        if way in ("euler", "rk4"):
            run: Marched = march_fixed(
                rates, change.start, 0.0, float(times[-1]), int(setting), way
            )
            every = int(setting) // len(times)
            return Answer(run.states[every::every, :3], run.evaluations)
        jacobian = matrix if way == "Radau" else None
        run = march_scipy(rates, change.start, grid, setting, setting * scale, way, jacobian)
        return Answer(run.states[1:, :3], run.evaluations)

    return march


def superposed(
    change: Change, operation: int, acceleration: float, times: np.ndarray
) -> np.ndarray:
    """Translations (k, 3) at k evenly spaced `times` by Duhamel's integral in place of steps.

    The state matrix is taken as it is, without modes: its exponential moves the state over a panel,
    and the load of every Gauss point from there to the panel's end. Only rounding is left.
    """
    from scipy.linalg import expm

    matrix, rates = rates_of(change, operation, acceleration)
    length = float(times[0]) / _PANELS
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    places = 0.5 * length * (1.0 + nodes)
    gains = 0.5 * length * weights[:, None, None] * expm(matrix * (length - places)[:, None, None])
    over, rest = expm(matrix * length), np.zeros(len(matrix))
    state, shown = change.start, []
    for panel in range(_PANELS * len(times)):
        loads = np.array([rates(panel * length + place, rest) for place in places])
        state = over @ state + np.einsum("pij,pj->i", gains, loads)
        shown.append(state[:3])
    return np.array(shown[_PANELS - 1 :: _PANELS])
