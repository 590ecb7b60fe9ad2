"""The running state of one machine to a tolerance, or in words why there is none."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.march import March, march_turns
from vibecalc.numerics.periodic.panels import PeriodicSolution, constant_start
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.roll.course import course_of_state
from vibecalc.response.roll.demand import Demand, steady_breakdown, surely_fastest
from vibecalc.response.roll.dynamic_start import dynamic_start
from vibecalc.response.roll.hidden import hides
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.problem import roll_problem
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.steady import (
    Steady,
    multipliers,
    started_momentum,
    steady_state,
)
from vibecalc.response.roll.torques import widest_panel
from vibecalc.response.roll.turn import harmonics

#: Gauss points on each panel, in turn, until two neighbours agree; from the first tolerance met
LADDERS = ((1e-5, (3, 4, 6, 8, 11, 14)), (0.0, (6, 7, 9, 12, 15, 18)))
#: a march begins at this many synchronous speeds, and ends at this part of one
_ABOVE, _FLOOR = 1.5, 1e-3
_RPM = 30.0 / np.pi
#: crank angles at which two courses over a turn are compared
_LOOKS = 145


class Running(NamedTuple):
    """A running state and the same with fewer (or more) points, whose difference is its error.

    `coarse`, where it is there, has fewer points than both: it tells how fast errors fall.
    """

    state: Steady
    check: Steady
    multiplier: ComplexArray
    multiplier_error: FloatArray
    coarse: Steady | None = None


def running_state(
    machine: RollMachine,
    drive: RollDrive,
    *,
    rtol: float,
    orders: int,
    started_at: float | None = None,
    points: int | None = None,
    course: bool = False,
) -> Running:
    """The running state of a machine (B = 1) whose spectrum is within `rtol`, or with `points`.

    With `course` what happens between the points of the method shall be as good, if more points can
    do that. More points are also tried while they bring out harmonics that seem to be zero.

    Raises
    ------
    NumericalFailure
        No running state exists (the demand is above the breakdown torque, or every start ends in a
        stall), none was found, it is unstable, its slip leaves the table, or no number of points
        meets the tolerance.
    """
    rungs = ladder(rtol) if points is None else (points, points + 2)
    first = _first(machine, drive, rungs[0], started_at)
    widest = widest_panel(orders)
    if widest < first.widest:
        first = _with_points(machine, drive, rungs[0], started_at, first, widest)
    coarse: Steady | None = None
    check, state, reached, met = first, first, np.inf, None
    for rung in rungs[1:]:
        coarse = None if rung == rungs[1] else check
        check, state = state, _with_points(machine, drive, rung, started_at, state)
        reached = _apart(machine, drive, check, state, orders)
        if reached <= rtol and (not course or _course_apart(machine, drive, check, state) <= rtol):
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


def ladder(rtol: float) -> tuple[int, ...]:
    """Numbers of Gauss points to try in turn for a tolerance."""
    return next(rungs for least, rungs in LADDERS if rtol >= least)


def _first(machine: RollMachine, drive: RollDrive, points: int, started_at: float | None) -> Steady:
    if drive.fluxes:
        return dynamic_start(machine, drive, points, started_at, _first)
    found = steady_state(machine, drive, points, started_at=started_at)
    if found.found[0] and surely_fastest(machine, drive, found.turn)[0]:
        return found
    _check_demand(machine, drive, found)
    march = _march(machine, drive, found, started_at)
    if march is None:
        raise NumericalFailure(
            "roll: no running state of the machine on its mounts was found from the constant speed "
            f"at which the motor meets the mean demand of {found.demand.torque[0]:.6g} N*m; follow "
            "it in time with [response.start_up]"
        )
    if march.stalled[0]:
        raise NumericalFailure(_stall(found.demand, march))
    again = steady_state(
        machine, drive, points, started_at=started_at, start=_marched(found, march)
    )
    if not again.found[0]:
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


def _check_demand(machine: RollMachine, drive: RollDrive, found: Steady) -> None:
    need = found.demand
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
    machine: RollMachine, drive: RollDrive, found: Steady, started_at: float | None
) -> March | None:
    """Turn after turn from above; None for a machine on mounts, where it would prove nothing."""
    if is_mounted(machine):
        return None
    momentum = found.momentum if started_at is None else started_momentum(machine, started_at)
    if not np.all(np.isfinite(momentum)):
        momentum = started_momentum(machine, drive.synchronous_speed)
    problem, rates = roll_problem(machine, drive, momentum)
    top = float(np.max(drive.synchronous_speed))
    return march_turns(rates, problem.edges, np.array([_ABOVE * top]), floor=_FLOOR * top)


def _marched(found: Steady, march: March) -> Steady:
    """A start for Newton's method through the values that marching left at the edges."""
    blank = constant_start(found.problem, found.points, march.path[:, :1])
    steps = np.diff(march.path)[..., None, None]
    share = (blank.nodes - blank.edges[:, :-1, None]) / np.diff(blank.edges)[..., None]
    left = march.path[:, :-1, None]
    solution: PeriodicSolution = blank._replace(
        left=left, stages=left[:, :, None] + share[..., None] * steps
    )
    return found._replace(solution=solution)


def _with_points(
    machine: RollMachine,
    drive: RollDrive,
    points: int,
    started_at: float | None,
    near: Steady,
    widest: float | None = None,
) -> Steady:
    found = steady_state(machine, drive, points, started_at=started_at, start=near, widest=widest)
    if found.found[0]:
        return found
    march = None if drive.fluxes else _march(machine, drive, near, started_at)
    if march is not None and march.stalled[0]:
        raise NumericalFailure(_stall(near.demand, march))
    raise NumericalFailure(
        f"roll: the running state was found with {near.points} points on each panel and lost with "
        f"{points}; it is near to where it ceases to exist"
    )


def _coarser(
    machine: RollMachine, drive: RollDrive, started_at: float | None, near: Steady
) -> Steady | None:
    """The state with one point less on each panel; None where that is not enough to find it."""
    found = steady_state(machine, drive, near.points - 1, started_at=started_at, start=near)
    return found if found.found[0] else None


def _apart(
    machine: RollMachine, drive: RollDrive, one: Steady, other: Steady, orders: int
) -> float:
    """Largest difference of the spectra of the shell's acceleration, over the largest harmonic."""
    each = [
        harmonics(
            state.turn,
            readings(machine, drive, state.turn, pistons=False).shell_acceleration,
            np.arange(1.0, orders + 1),
        )
        for state in (one, other)
    ]
    return float(np.max(np.abs(each[1] - each[0])) / np.max(np.abs(each[1])))


def _course_apart(machine: RollMachine, drive: RollDrive, one: Steady, other: Steady) -> float:
    """The same between the points: largest difference of that acceleration over a turn."""
    angles = np.linspace(0.0, 2.0 * np.pi, _LOOKS)
    each = []
    for state in (one, other):
        turn = course_of_state(machine, drive, state)(angles)
        each.append(readings(machine, drive, turn, pistons=False).shell_acceleration)
    return float(np.max(np.abs(each[1] - each[0])) / np.max(np.abs(each[1])))


def _check_stable(value: ComplexArray, error: FloatArray) -> None:
    size = np.abs(value[0])
    if np.any(size > 1.0 + error[0]):
        raise NumericalFailure(
            "roll: the running state is unstable: a disturbance grows by the factor "
            f"{size.max():.6g} in each turn (largest Floquet multiplier)"
        )


def _check_slip(state: Steady, drive: RollDrive) -> None:
    slip = drive.synchronous_speed[..., None] - state.turn.crank_speed
    largest = float(np.max(np.abs(slip)))
    if drive.circuit is not None or drive.holds or largest <= drive.motor.largest:
        return
    raise NumericalFailure(
        f"roll: the slip reaches {largest * _RPM:.6g} rpm, beyond the motor's table, which ends at "
        f"{drive.motor.largest * _RPM:.6g} rpm; give a longer table, or machine.motor.beyond = "
        '"hold" to keep its last torque'
    )
