"""Accuracy of a start-up: its motion and its largest shaking, against scipy from kink to kink."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import march_fixed, march_scipy
from vibecalc.core.accuracy.topic import Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.numerics.runge_kutta_march import march
from vibecalc.roll.adapters.start_up import BUCKETS, COARSEST, FINEST, SHARE, load_of
from vibecalc.roll.between_kinks import ActingTorques, acting_at, edges_around, slot_at, slots_of
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.start_up import start_up
from vibecalc.roll.start_up_readings import QUANTITIES
from vibecalc.roll.start_up_system import (
    ANGLE,
    SHELL_ANGLE,
    SHELL_SPEED,
    SPEED,
    STATES,
    LoadSteps,
    StartUpSystem,
)

# ----------------------------------------------------------------------------
# A start-up followed by scipy from kink to kink: the reference of the march in steps of order 5.
#
# DOP853 integrates each smooth piece; events of its own stop it at nodes of the gas tables, at
# those of the motor's curve and where the load changes. Equations are those in plain floats.
# ----------------------------------------------------------------------------

#: of DOP853; pieces after which the march counts as lost
_RTOL, _MOST_PIECES = 1e-13, 5000
#: speed over the synchronous one at which a crank with dry friction is at rest
_REST = 1e-10
#: examines the shell's acceleration within each piece
_SAMPLES = 24


class StartPlan(NamedTuple):
    """One machine from `start` (crank angle, crank speed, shell angle, shell speed) for `end` s."""

    machine: RollMachine
    drive: RollDrive
    load: LoadSteps
    start: FloatArray
    end: float


class Followed(NamedTuple):
    """State (4,) at the end; largest shell acceleration with its time; evaluations."""

    state: FloatArray
    peak: float
    peak_time: float
    evaluations: int


def follow(plan: StartPlan) -> Followed:
    """March of a crank that turns forward, or without dry friction either way.

    Raises NumericalFailure where a crank with dry friction comes to rest, which is not followed.
    """
    from scipy.integrate import solve_ivp

    slots = slots_of(plan.machine, plan.drive)
    acting = acting_at(plan.machine, plan.drive, slots)
    nodes = np.concatenate([[-np.inf], plan.drive.motor.threshold, [np.inf]])
    synchronous = float(plan.drive.synchronous_speed)
    stops = [float(t) for t in plan.load.time[1:] if t < plan.end] + [plan.end]
    time, state, evaluations = 0.0, plan.start.astype(float), 0
    slot = int(slot_at(slots, state[:1])[0])
    part = int(np.searchsorted(nodes[1:-1], synchronous - state[1], side="right"))
    best = (-np.inf, 0.0)
    dry = _is_dry(plan.machine)
    for row, stop in enumerate(stops):
        factor = float(plan.load.factor[row])
        for _ in range(_MOST_PIECES):
            low, high = (float(edge[0]) for edge in edges_around(slots, np.array([slot])))

            def rates(_: float, y: FloatArray, slot=slot, part=part, factor=factor) -> FloatArray:  # type: ignore[no-untyped-def]
                b, w, theta, s = y.tolist()
                found = acting(b, w, theta, s, slot, part, 1, factor)
                return np.array([y[1], found.crank, y[3], found.shell])

            # the crank angle between nodes of the gas, the slip between those of the motor's curve
            events = [
                _event(0, 1.0, low, -1.0),
                _event(0, 1.0, high, 1.0),
                _event(1, -1.0, float(nodes[part]) - synchronous, -1.0),
                _event(1, -1.0, float(nodes[part + 1]) - synchronous, 1.0),
            ]
            if dry:
                events.append(_event(1, 1.0, 0.0, -1.0))
            size = np.array([1.0, synchronous, 1e-3, 1.0])
            found = solve_ivp(
                rates, (time, stop), state, "DOP853", rtol=_RTOL, atol=_RTOL * size,
                events=events, dense_output=True,
            )  # fmt: skip
            if found.status < 0:
                raise NumericalFailure(f"DOP853 gives up from kink to kink: {found.message}")
            evaluations += int(found.nfev)
            last = float(found.t[-1])
            best = max(best, _highest(found.sol, rates, time, last))
            time, state = last, found.y[:, -1]
            if found.status == 0:
                break
            which = next(k for k, times in enumerate(found.t_events) if len(times))
            # tables of motors end at standstill, so that both stops may come at once
            if dry and state[1] <= _REST * synchronous:
                raise NumericalFailure("a crank with dry friction comes to rest on the way")
            slot += (-1, 1, 0, 0)[which]
            part += (0, 0, -1, 1)[which]
        else:
            raise NumericalFailure("from kink to kink DOP853 does not come to the end")
    return Followed(state, best[0], best[1], evaluations)


def plain_rates(plan: StartPlan) -> Callable[[float, FloatArray], FloatArray]:
    """The same equations as a user writes them: every table looked up at every evaluation."""
    slots = slots_of(plan.machine, plan.drive)
    acting = acting_at(plan.machine, plan.drive, slots)
    threshold, synchronous = plan.drive.motor.threshold, float(plan.drive.synchronous_speed)
    times, factors = plan.load.time, plan.load.factor
    edge, turn = slots.edge[1:-1], 2.0 * np.pi

    def at(time: float, y: FloatArray) -> ActingTorques:
        b, w, theta, s = y.tolist()
        whole, local = divmod(b, turn)
        slot = int(whole) * (len(edge) + 1) + int(np.searchsorted(edge, local, side="right"))
        part = int(np.searchsorted(threshold, synchronous - w, side="right"))
        row = int(np.searchsorted(times, time, side="right")) - 1
        way = 1 if w >= 0.0 else -1
        return acting(b, w, theta, s, slot, part, way, float(factors[row]))

    def rates(time: float, y: FloatArray) -> FloatArray:
        found = at(time, y)
        return np.array([y[1], found.crank, y[3], found.shell])

    return rates


def _is_dry(machine: RollMachine) -> bool:
    return bool(machine.friction_torque > 0.0 or machine.piston_friction > 0.0)


def _event(column: int, sign: float, border: float, direction: float) -> Any:
    """Stops where `sign` times a state passes a border, rising (+1) or falling (-1)."""

    def watched(time: float, y: FloatArray) -> float:
        found = sign * float(y[column]) - border
        # a border at infinity is far away, and no root search shall multiply with it
        return float(np.clip(found, -1e9, 1e9))

    watched.terminal = True  # type: ignore[attr-defined]
    watched.direction = direction  # type: ignore[attr-defined]
    return watched


def _highest(sol: Any, rates: Any, begin: float, end: float) -> tuple[float, float]:
    """Largest shell acceleration of a piece and its time: looks, then Brent's method."""
    from scipy.optimize import minimize_scalar

    times = np.linspace(begin, end, _SAMPLES)

    def shaking(time: float) -> float:
        return abs(float(rates(time, sol(time))[3]))

    values = [shaking(time) for time in times.tolist()]
    best = int(np.argmax(values))
    if best in (0, len(times) - 1) or end <= begin:
        return values[best], float(times[best])
    found = minimize_scalar(
        lambda time: -shaking(time), bounds=(times[best - 1], times[best + 1]), method="bounded",
        options={"xatol": 1e-9 * (end - begin)},
    )  # fmt: skip
    return max((values[best], float(times[best])), (-float(found.fun), float(found.x)))


# ----------------------------------------------------------------------------
# Topics of a start-up: the motion after its first tenth of a second, and the largest shaking.
# ----------------------------------------------------------------------------

#: s of the start that are followed
_FIRST = 0.1
#: what the second march of a run has: its share of the tolerance, its steps between two kinks
_FINER, _PARTS = 0.125, 2
#: rates in a step of order 5, and looks that a run takes at each step
_RATES, _LOOKS = 6, 7
_COLUMNS = [ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED]
_SHAKING = QUANTITIES.index("shell_acceleration")
_DORMAND = "Dormand and Prince (1980); Hairer, Norsett and Wanner (1993), section II.5"


def start_up_topics(scene: Scene) -> list[Topic]:
    """What [response.start_up] asks; none without it."""
    response = scene.case.response
    if response is None or response.start_up is None:
        return []
    options, parts = response.start_up, build_roll(scene.case)
    start = np.array([options.crank_angle, options.speed, 0.0, 0.0])
    end = min(options.duration, _FIRST)
    plan = StartPlan(parts.machine, roll_drive(parts), _within(load_of(options), end), start, end)
    tolerance = min(max(SHARE * scene.case.accuracy.rtol, FINEST), COARSEST)
    return [_motion(plan, tolerance), _shaking(plan, tolerance)]


def _within(load: LoadSteps, end: float) -> LoadSteps:
    """The load of the first part; a change that comes later is brought forward to its middle."""
    if len(load.time) > 1 and load.time[1] > end:
        return LoadSteps(np.array([0.0, 0.5 * end]), load.factor[:2])
    return load


def _said(plan: StartPlan) -> str:
    changes = ", the load changing on the way" if np.any(plan.load.time[1:] < plan.end) else ""
    return f"{plan.end:g} s{changes}"


def _motion(plan: StartPlan, tolerance: float) -> Topic:
    own = tuple(sorted({1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, tolerance}, reverse=True))
    fixed = [
        Solver(
            name, "even steps, blind to kinks", "time step [s]",
            (2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5),
            lambda step, method=method: _stepped(plan, method, step),  # type: ignore[misc]
            theory=theory,
        )
        for name, method, theory in (("Euler", "euler", "order 1"), ("Runge-Kutta", "rk4", ""))
    ]  # fmt: skip
    free = [
        Solver(
            f"scipy {method}", "steps of its own, blind to kinks", "relative tolerance",
            tolerances, lambda rtol, method=method: _scipy(plan, method, rtol),  # type: ignore[misc]
        )
        for method, tolerances in (
            ("RK45", (1e-3, 1e-5, 1e-7, 1e-9)),
            ("DOP853", (1e-3, 1e-5, 1e-7, 1e-9)),
            ("Radau", (1e-3, 1e-5)),
            ("LSODA", (1e-3, 1e-5, 1e-7, 1e-9)),
        )
    ]  # fmt: skip
    return Topic(
        stage="start-up",
        name="motion",
        words=f"speeds of crank and shell at the end of the first {_said(plan)}",
        quantity="response/start_up/history/crank_speed_low",
        unit="rad/s",
        work="evaluations of the equations of motion",
        reference=lambda: _end_reference(plan),
        solvers=(
            Solver(
                "two marches",
                "order 5, steps ending on kinks, to the tolerance and an eighth of it; as run",
                "tolerance of a step", own, lambda tol: _twice(plan, tol), default=tolerance,
                citation=_DORMAND,
            ),
            Solver(
                "one march", "order 5, steps ending on kinks, to the tolerance alone",
                "tolerance of a step", own, lambda tol: _marched(plan, tol, 1), citation=_DORMAND,
            ),
            *fixed,
            *free,
        ),
        default_extra=4.0,
        default_why="a second march to an eighth of the tolerance proves the error",
    )  # fmt: skip


def _shaking(plan: StartPlan, tolerance: float) -> Topic:
    own = tuple(sorted({1e-4, 1e-6, 1e-8, 1e-10, tolerance}, reverse=True))
    run = _Peaks(plan)
    fixed = [
        Solver(
            f"{name}, largest sample", "the largest value at the end of even steps",
            "time step [s]", (2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5),
            lambda step, method=method: _sampled(plan, method, step),  # type: ignore[misc]
        )
        for name, method in (("Euler", "euler"), ("Runge-Kutta", "rk4"))
    ]  # fmt: skip
    return Topic(
        stage="start-up",
        name="shaking",
        words=f"largest acceleration of the shell in the first {_said(plan)}, and when",
        quantity="response/start_up/shell_acceleration_peak",
        unit="rad/s^2",
        work="evaluations of the equations of motion",
        reference=lambda: _peak_reference(plan),
        solvers=(
            Solver(
                "two marches and parabolas",
                "each step examined in seven places, a parabola through the best; as a run does",
                "tolerance of a step", own, run, default=tolerance, citation=_DORMAND,
            ),
            *fixed,
        ),
        position="time [s]",
        default_extra=2.0,
        default_why="a second march to an eighth of the tolerance proves the error",
    )  # fmt: skip


def _speeds(state: FloatArray) -> FloatArray:
    return np.asarray(state)[[1, 3]]


def _marched(plan: StartPlan, tolerance: float, parts: int) -> Answer:
    system = StartUpSystem(plan.machine, plan.drive, plan.load, tolerance)
    first = np.zeros((1, STATES))
    first[0, _COLUMNS] = plan.start
    found = march(
        system, np.zeros(1), first, system.first_intervals(first, 0.0), np.array([plan.end]),
        absolute=tolerance * system.scale, stops=plan.load.time[None, :], parts=parts, keep=False,
    )  # fmt: skip
    work = _RATES * (int(found.steps[0]) + int(found.rejected[0])) + 1
    return Answer(_speeds(found.state[0, _COLUMNS]), float(work))


def _twice(plan: StartPlan, tolerance: float) -> Answer:
    coarse = _marched(plan, tolerance, 1)
    fine = _marched(plan, tolerance * _FINER, _PARTS)
    return fine._replace(work=coarse.work + fine.work)


class _Peaks:
    """The peak as a run finds it; what its marches take is counted once for each tolerance."""

    def __init__(self, plan: StartPlan):
        self._plan = plan
        self._work: dict[float, float] = {}

    def __call__(self, tolerance: float) -> Answer:
        plan = self._plan
        angle, speed = plan.start[:2].tolist()
        found = start_up(
            plan.machine, plan.drive, duration=plan.end, crank_angle=angle, speed=speed,
            load=plan.load, tolerance=tolerance, buckets=BUCKETS,
        )  # fmt: skip
        if tolerance not in self._work:
            rates = _twice(plan, tolerance).work
            self._work[tolerance] = rates * (1.0 + _LOOKS / _RATES)
        top = found.peaks
        value, time = top.value[_SHAKING], float(top.time[_SHAKING])
        return Answer(np.array([value]), self._work[tolerance], time)


def _stepped(plan: StartPlan, method: str, step: float) -> Answer:
    steps = max(round(plan.end / step), 1)
    found = march_fixed(plain_rates(plan), plan.start, 0.0, plan.end, steps, method)
    return Answer(_speeds(found.states[-1]), float(found.evaluations))


def _scipy(plan: StartPlan, method: str, rtol: float) -> Answer:
    size = np.array([1.0, float(plan.drive.synchronous_speed), 1e-3, 1.0])
    times = np.array([0.0, plan.end])
    found = march_scipy(plain_rates(plan), plan.start, times, rtol, rtol * size, method)
    return Answer(_speeds(found.states[-1]), float(found.evaluations))


def _sampled(plan: StartPlan, method: str, step: float) -> Answer:
    rates = plain_rates(plan)
    steps = max(round(plan.end / step), 1)
    found = march_fixed(rates, plan.start, 0.0, plan.end, steps, method)
    shaking = [
        abs(float(rates(time, state)[3]))
        for time, state in zip(found.times.tolist(), found.states, strict=True)
    ]
    best = int(np.argmax(shaking))
    # the first rate of a step is the one that is examined
    return Answer(np.array([shaking[best]]), float(found.evaluations + 1), float(found.times[best]))


def _end_reference(plan: StartPlan) -> Reference:
    exact, other = follow(plan), _marched(plan, 1e-11, 4)
    values = _speeds(exact.state)
    apart = float(np.max(np.abs(values - other.values)) / np.max(np.abs(values)))
    return Reference(
        values, max(apart, 64.0 * EPSILON),
        "DOP853 from kink to kink, against a march of order 5 to 1e-11",
    )  # fmt: skip


def _peak_reference(plan: StartPlan) -> Reference:
    exact, fine = follow(plan), _Peaks(plan)(1e-11)
    apart = abs(float(fine.values[0]) - exact.peak) / exact.peak
    return Reference(
        np.array([exact.peak]), max(apart, 64.0 * EPSILON),
        "DOP853 from kink to kink with Brent's method in each piece, against a march to 1e-11",
        exact.peak_time,
    )  # fmt: skip
