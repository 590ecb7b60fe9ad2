"""The running state of a machine whose motor a controller feeds, and whether it is stable."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import floquet_multipliers
from vibecalc.numerics.periodic.panels import (
    PeriodicProblem,
    PeriodicSolution,
    evaluate,
    running_integral,
)
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.roll.controlled import ControlledRates, Law
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.inertia import inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.problem import mounted_scale
from vibecalc.response.roll.rates import shell_speed
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.torques import smooth_angles
from vibecalc.response.roll.turn import Turn, harmonics

_LADDER = (6, 8, 10, 13, 16, 20)
#: part of the tolerance at which the ladder ends, for the sake of small harmonics
_SMALL = 1e-2
#: rounds until edges at kinks and the momentum of a free shell stand, and what counts as standing
_ROUNDS, _EDGES_STAND, _STILL = 12, 1e-8, 1e-13
#: looks at each panel for a slip that meets a node of the motor's curve
_LOOKS, _HALVINGS = 24, 48


class Closed(NamedTuple):
    """One turn of a controlled machine (B = 1); `slip` and `torque` (1, k) of its motor."""

    turn: Turn
    slip: FloatArray
    torque: FloatArray
    problem: PeriodicProblem
    solution: PeriodicSolution


class ClosedLoop(NamedTuple):
    """Harmonics (orders,) of the shell's acceleration, mean speed, multipliers, all with errors.

    `largest_slip` rad/s, in size, at the points of the turn.

    `stable` is false where a multiplier is not inside the unit circle by its error. The harmonics
    are those of the motion that the equations allow, whether it is ever reached or not.
    """

    harmonics: WithError
    speed: WithError
    multiplier: ComplexArray
    multiplier_error: FloatArray
    stable: bool
    largest_slip: WithError
    closed: Closed


def closed_loop(
    machine: RollMachine, drive: RollDrive, law: Law, *, rtol: float, orders: int
) -> ClosedLoop:
    """The running state of one machine (B = 1) under control, by Gauss collocation.

    Raises NumericalFailure where there is none, none is found, or its slip leaves the table.
    """
    numbers = np.arange(1.0, orders + 1)

    def look(closed: Closed) -> ComplexArray:
        read = readings(machine, drive, closed.turn, closed.torque, pistons=False)
        return np.asarray(harmonics(closed.turn, read.shell_acceleration, numbers)[0])

    check = _state(machine, drive, law, _LADDER[0], None)
    closed, before = check, look(check)
    found, apart = before, np.full(orders, np.inf)
    for points in _LADDER[1:]:
        check, before = closed, found
        closed = _state(machine, drive, law, points, check.solution)
        found = look(closed)
        apart = np.abs(found - before)
        if np.max(apart) <= _SMALL * rtol * np.max(np.abs(found)):
            break
    _check_slip(closed, drive)
    speed = [2.0 * np.pi / float(one.turn.period[0]) for one in (closed, check)]
    slip = [float(np.max(np.abs(one.slip))) for one in (closed, check)]
    value, error = floquet_multipliers(closed.problem, closed.solution)
    size = np.abs(closed.torque).max() / float(machine.shell_inertia[0])
    return ClosedLoop(
        WithError(found, apart + 1e-14 * size),
        WithError(np.asarray(speed[0]), np.asarray(abs(speed[0] - speed[1]) + 1e-14 * speed[0])),
        value[0],
        error[0],
        bool(np.all(np.abs(value[0]) + error[0] < 1.0)),
        WithError(np.asarray(slip[0]), np.asarray(abs(slip[0] - slip[1]) + 1e-12)),
        closed,
    )


def _state(
    machine: RollMachine, drive: RollDrive, law: Law, points: int, near: PeriodicSolution | None
) -> Closed:
    free, lagged = not is_mounted(machine), law.lag > 0.0
    constant = _guess(machine, drive, law)
    guess: FloatArray | PeriodicSolution = constant if near is None else near
    base = edges = smooth_angles(machine, drive)
    momentum = constant[0, :1] * _momentum(machine, base, None) if free else None
    kinked = len(drive.motor.threshold) > 0
    scale = None
    if not free:
        scale = mounted_scale(machine, drive)
        scale = np.append(scale, scale[0]) if lagged else scale
    for _ in range(_ROUNDS):
        rates = ControlledRates(machine, drive, law, momentum)
        switched = kinked and lagged
        problem = PeriodicProblem(
            rates,
            edges,
            rates.lagged_slip if switched else None,
            drive.motor.threshold if switched else None,
            scale,
        )
        solution = solve_periodic(problem, points, guess)
        turn = _turn(machine, rates, solution)
        if not solution.converged[0] or not np.all(turn.crank_speed > 0.0):
            raise NumericalFailure(
                "control: Newton's method found no running state of the full model under control, "
                f"with a gain of {law.gain:g} and a feedback of {law.acceleration_feedback:g} s: "
                "the motor may not be able to give the torque that this asks for. Feed less back, "
                "or set full_model = false"
            )
        guess, still = solution, True
        if momentum is not None:
            wanted = _momentum(machine, turn.crank_angle, turn)
            still = bool(abs(wanted[0] - momentum[0]) <= _STILL * abs(wanted[0]))
            momentum = wanted
        if kinked and not lagged:
            moved = _with_kinks(base, rates, solution)
            same = moved.shape == edges.shape
            still &= same and bool(np.max(np.abs(moved - edges)) <= _EDGES_STAND)
            edges = moved
        if still:
            break
    place = rates.place(solution.nodes)
    motor = rates.driven(place, solution.stages.reshape(1, -1, rates.states))
    return Closed(turn, motor.slip, motor.torque, problem, solution)


def _guess(machine: RollMachine, drive: RollDrive, law: Law) -> FloatArray:
    """Constant speed at which motor and mean demand balance under the controller."""
    need = demand(machine, drive)
    if not need.possible[0]:
        raise NumericalFailure(
            f"control: no running state exists: gas and friction ask for {need.torque[0]:.6g} N*m "
            f"on average, more than the motor gives ({need.breakdown[0]:.6g} N*m at breakdown)"
        )
    slip = float(need.slip[0])
    speed = (law.gain * law.reference - slip) / (1.0 + law.gain * law.speed_feedback)
    if not speed > 0.0:
        raise NumericalFailure(
            f"control: with a speed feedback of {law.speed_feedback:g} no mean speed balances"
        )
    rigid = [speed] if not is_mounted(machine) else [speed, 0.0, 0.0]
    return np.array([[*rigid, speed + slip] if law.lag > 0.0 else rigid])


def _turn(machine: RollMachine, rates: ControlledRates, solution: PeriodicSolution) -> Turn:
    members = len(solution.edges)
    speed = solution.stages[..., 0]
    time, ends = running_integral(solution.edges, 1.0 / speed)
    flat = speed.reshape(members, -1)
    if rates.momentum is None:
        angle, shell = (solution.stages[..., i].reshape(members, -1) for i in (1, 2))
    else:
        shell = shell_speed(rates.place(solution.nodes), rates.momentum, flat)
        rate = shell.reshape(speed.shape) / speed
        angle = running_integral(solution.edges, rate)[0].reshape(members, -1)
    return Turn(
        solution.nodes.reshape(members, -1),
        solution.weights.reshape(members, -1),
        time.reshape(members, -1),
        flat,
        shell,
        angle,
        ends[:, -1],
    )


def _momentum(machine: RollMachine, angle: FloatArray, turn: Turn | None) -> FloatArray:
    """Angular momentum (1,) with which a free shell stands still on average.

    Without a turn: for each rad/s of a constant crank speed, from the edges `angle` (k,).
    """
    if turn is None:
        middle = 0.5 * (angle[1:] + angle[:-1])[None]
        moved, weight, speed = inertia(machine, middle), np.diff(angle)[None], np.ones(middle.shape)
    else:
        moved, weight, speed = inertia(machine, angle), turn.weight, turn.crank_speed
    share = np.sum(weight * moved.coupling / moved.shell, axis=-1)
    return np.asarray(share / np.sum(weight / (moved.shell * speed), axis=-1))


def _with_kinks(base: FloatArray, rates: ControlledRates, solution: PeriodicSolution) -> FloatArray:
    """The edges with every angle at which the slip meets a node of the motor's curve."""

    def slip(angle: FloatArray) -> FloatArray:
        state = evaluate(solution, angle)
        return np.asarray(rates.driven(rates.place(angle[None, None]), state).slip[0])

    angle = (base[:-1, None] + np.diff(base)[:, None] * np.linspace(0.0, 1.0, _LOOKS)[:-1]).ravel()
    angle = np.append(angle, base[-1])
    over = slip(angle)[:, None] - rates.drive.motor.threshold
    row, column = np.nonzero(np.sign(over[1:]) * np.sign(over[:-1]) < 0.0)
    if not len(row):
        return base
    order = np.argsort(row, kind="stable")
    row, column = row[order], column[order]
    low, high = angle[row], angle[row + 1]
    sense = np.sign(over[row, column])
    node = rates.drive.motor.threshold[column]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        place = np.argsort(middle, kind="stable")
        at = np.empty_like(middle)
        at[place] = slip(middle[place])
        same = (at - node) * sense > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    every = np.sort(np.concatenate([base, 0.5 * (low + high)]))
    kept = every[np.concatenate([[True], np.diff(every) > 1e-9])]
    kept[-1] = base[-1]
    return np.asarray(kept)


def _check_slip(closed: Closed, drive: RollDrive) -> None:
    largest = float(np.max(np.abs(closed.slip)))
    if drive.holds or largest <= drive.motor.largest:
        return
    rpm = 30.0 / np.pi
    raise NumericalFailure(
        f"control: under the controller the slip reaches {largest * rpm:.6g} rpm, beyond the "
        f"motor's table, which ends at {drive.motor.largest * rpm:.6g} rpm; feed less "
        'back, give a longer table, or set machine.motor.beyond = "hold" to keep its last torque'
    )
