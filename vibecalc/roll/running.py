"""The running state of one machine to a tolerance, at any crank angle of its turn."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.other_methods import March, march_turns
from vibecalc.numerics.periodic.panels import (
    PeriodicSolution,
    constant_start,
    evaluate,
    running_integral,
)
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    inertia,
    is_mounted,
    motor_torque,
    widest_panel,
)
from vibecalc.roll.rates import (
    Demand,
    demand,
    driving_torque,
    motor_of,
    roll_problem,
    steady_breakdown,
    surely_fastest,
    with_steady_flux,
)
from vibecalc.roll.steady import (
    SteadyTurn,
    multipliers,
    started_momentum,
    steady_state,
    within_table,
)
from vibecalc.roll.turn import Turn, hides, readings, shell_harmonics, trapezoids

# ----------------------------------------------------------------------------
# A turn at any crank angle: from collocation polynomials exactly, from samples by cubics.
# ----------------------------------------------------------------------------

#: the motion of one machine (B = 1) at crank angles (k,) that ascend within one turn
TurnMotion = Callable[[FloatArray], Turn]
_FULL = 2.0 * np.pi
#: points that are nearer to each other, over their mean distance, count as one
_NEAR = 0.05


def motion_of_state(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> TurnMotion:
    """The motion between the collocation points; its error is that of the points or little more.

    The angle of a free shell is interpolated from the points.
    """
    solution = state.solution
    passed, ends = running_integral(solution.edges, 1.0 / solution.stages[..., 0])
    clock = solution._replace(left=ends[:, :-1, None], stages=passed[..., None])
    between = _between(state.turn)

    def at(angles: FloatArray) -> Turn:
        values = evaluate(state.solution, angles)
        speed = values[..., 0]
        if is_mounted(machine):
            shell_angle, shell_speed = values[..., 1], values[..., 2]
        else:
            moved = inertia(machine, angles[None])
            shell_angle = between(angles, ("shell_angle",))["shell_angle"]
            shell_speed = (state.momentum[:, None] - moved.coupling * speed) / moved.shell
        return Turn(
            angles[None],
            trapezoids(angles)[None],
            period=state.turn.period,
            time=evaluate(clock, angles)[..., 0],
            crank_speed=speed,
            shell_angle=shell_angle,
            shell_speed=shell_speed,
            motor_torque=driving_torque(machine, drive, values),
        )

    return at


def speed_of_state(state: SteadyTurn) -> Callable[[FloatArray], FloatArray]:
    """Crank speed (k,) of one machine (B = 1) at crank angles (k,), without all the rest."""
    return lambda angles: np.asarray(evaluate(state.solution, angles)[0, :, 0])


def torque_of_state(
    machine: RollMachine, drive: RollDrive, state: SteadyTurn
) -> Callable[[FloatArray], FloatArray]:
    """Motor torque (k,) of one machine (B = 1) at crank angles (k,), N m, without all the rest."""

    def at(angles: FloatArray) -> FloatArray:
        values = evaluate(state.solution, angles)
        torque = driving_torque(machine, drive, values)
        if torque is None:
            torque = motor_torque(machine, drive, values[..., 0]).value
        return np.asarray(torque[0])

    return at


def motion_of_turn(turn: Turn) -> TurnMotion:
    """The motion between samples, by the cubic through four neighbours."""
    between, names = _between(turn), ("time", "crank_speed", "shell_speed", "shell_angle")
    return lambda angles: Turn(
        angles[None], trapezoids(angles)[None], period=turn.period, **between(angles, names)
    )


def _between(turn: Turn) -> Callable[[FloatArray, Sequence[str]], dict[str, FloatArray]]:
    """Variables (1, k) of a turn at crank angles (k,), by the cubic through four neighbours."""
    sampled = turn.crank_angle[0]
    keep = _apart(sampled)
    grown = float(np.sum(turn.weight * turn.shell_speed / turn.crank_speed))
    per_turn = {"time": float(turn.period[0]), "shell_angle": grown}

    def at(angles: FloatArray, names: Sequence[str]) -> dict[str, FloatArray]:
        return {
            name: _cubic(
                sampled[keep], getattr(turn, name)[0][keep], per_turn.get(name, 0.0), angles
            )[None]
            for name in names
        }

    return at


def _apart(angles: FloatArray) -> BoolArray:
    """Which of the ascending angles (k,) to keep, so that no two of the turn nearly coincide.

    A march has the end of its turn next to its start, and steps may fall next to both. Differences
    of such values are nothing but errors, which a cubic would blow up.
    """
    least = _NEAR * _FULL / len(angles)
    keep = np.zeros(len(angles), dtype=bool)
    last, end = -np.inf, float(angles[0]) + _FULL - least
    for place, angle in enumerate(angles.tolist()):
        if angle - last > least and angle <= end:
            keep[place], last = True, angle
    return keep


def _cubic(known: FloatArray, values: FloatArray, per_turn: float, at: FloatArray) -> FloatArray:
    """Cubic through the four nearest points; values grow by `per_turn` from turn to turn."""
    reach = 3
    x = np.concatenate([known[-reach:] - _FULL, known, known[:reach] + _FULL])
    y = np.concatenate([values[-reach:] - per_turn, values, values[:reach] + per_turn])
    place = np.clip(np.searchsorted(x, at, side="right") - 2, 0, len(x) - 4)
    index = place[:, None] + np.arange(4)
    nodes, data = x[index], y[index]
    basis = np.ones_like(nodes)
    for i in range(4):
        for j in range(4):
            if i != j:
                basis[:, i] *= (at - nodes[:, j]) / (nodes[:, i] - nodes[:, j])
    return np.asarray(np.sum(basis * data, axis=1))


# ----------------------------------------------------------------------------
# A start for a motor with transients: the state with its steady curve, or that of a heavy rotor.
#
# A rotor that is heavy enough hardly changes its speed, and its motor runs at a steady slip.
# Followed to the inertia of the machine, the state gets there or folds back at an inertia below
# which there is none on this branch: the machine then needs that much.
# ----------------------------------------------------------------------------

#: a breakdown torque for a whole turn changes the speed of a heavy rotor by this part of it
_STEADY_SPEED = 0.025
#: steps down to the inertia of the machine, at first and at most; the least, as a logarithm
_STEPS, _MOST_STEPS, _LEAST = 3, 60, 1e-3


def steady_drive(drive: RollDrive) -> RollDrive:
    """The same with the motor's steady torque at every slip."""
    return drive._replace(circuit=motor_of(drive)._replace(transient=False))


def dynamic_start(
    machine: RollMachine,
    drive: RollDrive,
    points: int,
    started_at: float | None,
    first: Callable[[RollMachine, RollDrive, int, float | None], SteadyTurn],
) -> SteadyTurn:
    """The running state of a machine (B = 1) whose motor's fluxes are states.

    `first` finds it with the steady curve, or raises NumericalFailure.

    Raises
    ------
    NumericalFailure
        Followed from a heavy rotor the state ceases to exist, or there is none at the start.
    """
    try:
        near = lifted(drive, first(machine, steady_drive(drive), points, started_at))
    except NumericalFailure:  # which tells of the steady curve alone
        return _from_heavy(machine, drive, points, started_at)
    state = steady_state(machine, drive, points, started_at=started_at, start=near)
    if not state.solved[0]:
        return _from_heavy(machine, drive, points, started_at)
    if np.any(np.abs(multipliers(state)[0]) > 1.0):
        # near a fold there are two: the stable one is that of the heavy rotor
        try:
            return _from_heavy(machine, drive, points, started_at)
        except NumericalFailure:
            return state
    return state


def lifted(drive: RollDrive, near: SteadyTurn) -> SteadyTurn:
    """A state found with a steady curve, with the steady fluxes of the slip at every point."""
    solution = near.solution
    left, stages = (with_steady_flux(drive, part) for part in (solution.left, solution.stages))
    return near._replace(solution=solution._replace(left=left, stages=stages, interval=None))


def _from_heavy(
    machine: RollMachine, drive: RollDrive, points: int, started_at: float | None
) -> SteadyTurn:
    """The state followed from a heavy rotor; steps that fail are halved."""
    need = demand(machine, drive)
    if not need.possible[0]:
        raise NumericalFailure(
            f"roll: no running state: gas and friction ask for {need.torque[0]:.6g} N*m on "
            f"average, more than the motor gives in steady running ({need.breakdown[0]:.6g} N*m at "
            "breakdown)"
        )
    speed = float(np.max(drive.synchronous_speed))
    actual = float(machine.rotor_inertia[0])
    heavy = 2.0 * np.pi * float(need.breakdown[0]) / (_STEADY_SPEED * speed**2)
    target, at = float(np.log(actual)), float(np.log(max(heavy, 2.0 * actual)))
    state = steady_state(_with_rotor(machine, at), drive, points, started_at=started_at)
    step, steps = (at - target) / _STEPS, 0
    while state.solved[0] and at > target and step > _LEAST and steps < _MOST_STEPS:
        aim = max(at - step, target) if at - step > target + 1e-9 else target
        there = machine if aim == target else _with_rotor(machine, aim)
        trial = steady_state(there, drive, points, started_at=started_at, start=state)
        if trial.solved[0]:
            state, at, step = trial, aim, 1.5 * step
        else:
            step *= 0.5
        steps += 1
    if at == target:
        return state
    if not state.solved[0]:
        raise NumericalFailure(
            "roll: no running state was found with the transients of the motor, even with a rotor "
            f"of {np.exp(at):.4g} kg*m^2, for a mean demand of {need.torque[0]:.6g} N*m and a "
            f"steady breakdown torque of {need.breakdown[0]:.6g} N*m"
        )
    raise NumericalFailure(
        "roll: no running state was found with the transients of the motor: followed from a heavy "
        f"rotor it ceases to exist below an inertia of about {np.exp(at):.4g} kg*m^2 (the rotor "
        f"has {actual:.4g} kg*m^2), although the mean demand of {need.torque[0]:.6g} N*m is below "
        f"the steady breakdown torque of {need.breakdown[0]:.6g} N*m"
    )


def _with_rotor(machine: RollMachine, logarithm: float) -> RollMachine:
    inertia: FloatArray = np.full_like(machine.rotor_inertia, np.exp(logarithm))
    return machine._replace(rotor_inertia=inertia)


# ----------------------------------------------------------------------------
# The running state of one machine to a tolerance, or in words why there is none.
# ----------------------------------------------------------------------------

#: Gauss points on each panel, in turn, until two neighbours agree; from the first tolerance met
POINT_LEVELS = ((1e-5, (3, 4, 6, 8, 11, 14)), (0.0, (6, 7, 9, 12, 15, 18)))
#: a march begins at this many synchronous speeds, and ends at this part of one
_ABOVE, _FLOOR = 1.5, 1e-3
_RPM = 30.0 / np.pi
#: crank angles at which two courses over a turn are compared
_SAMPLES = 145


class Running(NamedTuple):
    """A running state and the same with fewer (or more) points, whose difference is its error.

    `coarse`, where it is there, has fewer points than both: it tells how fast errors fall.
    """

    state: SteadyTurn
    check: SteadyTurn
    multiplier: ComplexArray
    multiplier_error: FloatArray
    coarse: SteadyTurn | None = None


def running_state(
    machine: RollMachine,
    drive: RollDrive,
    *,
    rtol: float,
    orders: int,
    started_at: float | None = None,
    points: int | None = None,
    between_points: bool = False,
) -> Running:
    """The running state of a machine (B = 1) whose spectrum is within `rtol`, or with `points`.

    With `between_points` what happens between the points of the method shall be as good, if more
    points can do that. More points are also tried while they bring out harmonics that seem to be
    zero.

    Raises
    ------
    NumericalFailure
        No running state exists (the demand is above the breakdown torque, or every start ends in a
        stall), none was found, it is unstable, its slip leaves the table, or no number of points
        meets the tolerance.
    """
    levels = point_levels(rtol) if points is None else (points, points + 2)
    first = _first(machine, drive, levels[0], started_at)
    widest = widest_panel(orders)
    if widest < first.widest:
        first = _with_points(machine, drive, levels[0], started_at, first, widest)
    coarse: SteadyTurn | None = None
    check, state, reached, met = first, first, np.inf, None
    for level in levels[1:]:
        coarse = None if level == levels[1] else check
        check, state = state, _with_points(machine, drive, level, started_at, state)
        reached = _spectra_apart(machine, drive, check, state, orders)
        if reached <= rtol and (
            not between_points or _motion_apart(machine, drive, check, state) <= rtol
        ):
            met = coarse, check, state, reached
            if points or not hides(machine, drive, check.turn, state.turn, orders):
                break
        elif met is not None:
            break
    if met is not None:
        coarse, check, state, reached = met
    if points is not None:
        state, check, coarse = check, state, None
    elif reached > max(rtol, 1e-12):
        raise NumericalFailure(
            f"roll: with {state.points} points on each of {state.solution.edges.shape[1] - 1} "
            f"panels the spectrum is known to {reached:.1e} of its largest harmonic, not to "
            f"{rtol:.1e}; allow that much with [accuracy] rtol"
        )
    value, error = multipliers(state)
    _check_stable(value, error)
    _check_slip(state, drive)
    if coarse is None and points is None:
        coarse = _coarser(machine, drive, started_at, check)
    return Running(state, check, value, error, coarse)


def point_levels(rtol: float) -> tuple[int, ...]:
    """Numbers of Gauss points to try in turn for a tolerance."""
    return next(levels for least, levels in POINT_LEVELS if rtol >= least)


def _first(
    machine: RollMachine, drive: RollDrive, points: int, started_at: float | None
) -> SteadyTurn:
    if drive.fluxes:
        return dynamic_start(machine, drive, points, started_at, _first)
    state = steady_state(machine, drive, points, started_at=started_at)
    if state.solved[0] and surely_fastest(machine, drive, state.turn)[0]:
        return state
    _check_demand(machine, drive, state)
    march = _march(machine, drive, state, started_at)
    if march is None:
        raise NumericalFailure(
            "roll: no running state of the machine on its mounts was found from the constant speed "
            f"at which the motor meets the mean demand of {state.demand.torque[0]:.6g} N*m; follow "
            "it in time with [response.start_up]"
        )
    if march.stalled[0]:
        raise NumericalFailure(_stall(state.demand, march))
    again = steady_state(
        machine, drive, points, started_at=started_at, start=_marched(state, march)
    )
    if not again.solved[0]:
        raise NumericalFailure(
            "roll: Newton's method did not find the running state that marching came near to; its "
            f"speed varies between {march.path.min() * _RPM:.6g} and "
            f"{march.path.max() * _RPM:.6g} rpm in a turn"
        )
    return again


def _stall(need: Demand, march: March) -> str:
    angle = np.degrees(march.stalled_at[0])
    return (
        "roll: no running state exists: from any speed the machine comes to a standstill, "
        f"beyond a crank angle of {angle:.0f} degrees, although the mean demand of "
        f"{need.torque[0]:.6g} N*m is below the breakdown torque of "
        f"{need.breakdown[0]:.6g} N*m; a heavier rotor carries it through"
    )


def _check_demand(machine: RollMachine, drive: RollDrive, state: SteadyTurn) -> None:
    need = state.demand
    if need.possible[0]:
        return
    asked = float(need.torque[0])
    if np.isfinite(need.breakdown[0]):
        # viscous friction at the speed of breakdown; at any other the motor lacks more
        left = float(drive.synchronous_speed.max()) - steady_breakdown(drive)[0]
        asked += float(machine.friction_damping[0]) * left
        limit = f"more than the motor gives ({need.breakdown[0]:.6g} N*m at breakdown)"
    else:
        limit = "which the linear motor gives only with more slip than its synchronous speed"
    raise NumericalFailure(
        f"roll: no running state exists: gas and friction ask for {asked:.6g} N*m on average, "
        f"{limit}"
    )


def _march(
    machine: RollMachine, drive: RollDrive, state: SteadyTurn, started_at: float | None
) -> March | None:
    """Turn after turn from above; None for a machine on mounts, where it would prove nothing."""
    if is_mounted(machine):
        return None
    momentum = state.momentum if started_at is None else started_momentum(machine, started_at)
    if not np.all(np.isfinite(momentum)):
        momentum = started_momentum(machine, drive.synchronous_speed)
    problem, rates = roll_problem(machine, drive, momentum)
    top = float(np.max(drive.synchronous_speed))
    return march_turns(rates, problem.edges, np.array([_ABOVE * top]), floor=_FLOOR * top)


def _marched(state: SteadyTurn, march: March) -> SteadyTurn:
    """A start for Newton's method through the values that marching left at the edges."""
    blank = constant_start(state.problem, state.points, march.path[:, :1])
    steps = np.diff(march.path)[..., None, None]
    share = (blank.nodes - blank.edges[:, :-1, None]) / np.diff(blank.edges)[..., None]
    left = march.path[:, :-1, None]
    solution: PeriodicSolution = blank._replace(
        left=left, stages=left[:, :, None] + share[..., None] * steps
    )
    return state._replace(solution=solution)


def _with_points(
    machine: RollMachine,
    drive: RollDrive,
    points: int,
    started_at: float | None,
    near: SteadyTurn,
    widest: float | None = None,
) -> SteadyTurn:
    state = steady_state(machine, drive, points, started_at=started_at, start=near, widest=widest)
    if state.solved[0]:
        return state
    march = None if drive.fluxes else _march(machine, drive, near, started_at)
    if march is not None and march.stalled[0]:
        raise NumericalFailure(_stall(near.demand, march))
    raise NumericalFailure(
        f"roll: the running state was found with {near.points} points on each panel and lost with "
        f"{points}; it is near to where it ceases to exist"
    )


def _coarser(
    machine: RollMachine, drive: RollDrive, started_at: float | None, near: SteadyTurn
) -> SteadyTurn | None:
    """The state with one point less on each panel; None where that is not enough to find it."""
    found = steady_state(machine, drive, near.points - 1, started_at=started_at, start=near)
    return found if found.solved[0] else None


def _spectra_apart(
    machine: RollMachine, drive: RollDrive, one: SteadyTurn, other: SteadyTurn, orders: int
) -> float:
    """Largest difference of the spectra of the shell's acceleration, over the largest harmonic."""
    first, second = (
        shell_harmonics(machine, drive, state.turn, orders, state.place) for state in (one, other)
    )
    return float(np.max(np.abs(second - first)) / np.max(np.abs(second)))


def _motion_apart(
    machine: RollMachine, drive: RollDrive, one: SteadyTurn, other: SteadyTurn
) -> float:
    """The same between the points: largest difference of that acceleration over a turn."""
    angles = np.linspace(0.0, 2.0 * np.pi, _SAMPLES)
    each = []
    for state in (one, other):
        turn = motion_of_state(machine, drive, state)(angles)
        each.append(readings(machine, drive, turn, pistons=False).shell_acceleration)
    return float(np.max(np.abs(each[1] - each[0])) / np.max(np.abs(each[1])))


def _check_stable(value: ComplexArray, error: FloatArray) -> None:
    size = np.abs(value[0])
    if np.any(size > 1.0 + error[0]):
        raise NumericalFailure(
            "roll: the running state is unstable: a disturbance grows by the factor "
            f"{size.max():.6g} in each turn (largest Floquet multiplier)"
        )


def _check_slip(state: SteadyTurn, drive: RollDrive) -> None:
    if within_table(state, drive)[0]:
        return
    largest = float(np.max(np.abs(drive.synchronous_speed[..., None] - state.turn.crank_speed)))
    raise NumericalFailure(
        f"roll: the slip reaches {largest * _RPM:.6g} rpm, beyond the motor's table, which ends at "
        f"{drive.motor.largest * _RPM:.6g} rpm; give a longer table, or "
        'machine.motor.extrapolation = "hold" to keep its last torque'
    )
