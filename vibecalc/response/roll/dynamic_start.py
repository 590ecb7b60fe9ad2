"""A start for a motor with transients: the state with its steady curve, or that of a heavy rotor.

A rotor that is heavy enough hardly changes its speed, and its motor runs at a steady slip. Followed
to the inertia of the machine, the state gets there or folds back at an inertia below which there is
none on this branch: the machine then needs that much.
"""

from collections.abc import Callable

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.dynamic_rates import motor_of, with_steady_flux
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.steady import Steady, multipliers, steady_state

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
    first: Callable[[RollMachine, RollDrive, int, float | None], Steady],
) -> Steady:
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
    found = steady_state(machine, drive, points, started_at=started_at, start=near)
    if not found.found[0]:
        return _from_heavy(machine, drive, points, started_at)
    if np.any(np.abs(multipliers(found)[0]) > 1.0):
        # near a fold there are two: the stable one is that of the heavy rotor
        try:
            return _from_heavy(machine, drive, points, started_at)
        except NumericalFailure:
            return found
    return found


def lifted(drive: RollDrive, near: Steady) -> Steady:
    """A state found with a steady curve, with the steady fluxes of the slip at every point."""
    solution = near.solution
    left, stages = (with_steady_flux(drive, part) for part in (solution.left, solution.stages))
    return near._replace(solution=solution._replace(left=left, stages=stages, piece=None))


def _from_heavy(
    machine: RollMachine, drive: RollDrive, points: int, started_at: float | None
) -> Steady:
    """The state followed from a heavy rotor; steps that fail are halved."""
    need = demand(machine, drive)
    if not need.possible[0]:
        raise NumericalFailure(
            f"roll: no running state: gas and friction ask for {need.torque[0]:.6g} N*m on "
            f"average, more than the motor gives in steady running ({need.breakdown[0]:.6g} N*m at "
            "breakdown)"
        )
    speed = float(np.max(drive.synchronous_speed))
    own = float(machine.rotor_inertia[0])
    heavy = 2.0 * np.pi * float(need.breakdown[0]) / (_STEADY_SPEED * speed**2)
    target, at = float(np.log(own)), float(np.log(max(heavy, 2.0 * own)))
    found = steady_state(_with_rotor(machine, at), drive, points, started_at=started_at)
    step, steps = (at - target) / _STEPS, 0
    while found.found[0] and at > target and step > _LEAST and steps < _MOST_STEPS:
        aim = max(at - step, target) if at - step > target + 1e-9 else target
        there = machine if aim == target else _with_rotor(machine, aim)
        trial = steady_state(there, drive, points, started_at=started_at, start=found)
        if trial.found[0]:
            found, at, step = trial, aim, 1.5 * step
        else:
            step *= 0.5
        steps += 1
    if at == target:
        return found
    if not found.found[0]:
        raise NumericalFailure(
            "roll: no running state was found with the transients of the motor, even with a rotor "
            f"of {np.exp(at):.4g} kg*m^2, for a mean demand of {need.torque[0]:.6g} N*m and a "
            f"steady breakdown torque of {need.breakdown[0]:.6g} N*m"
        )
    raise NumericalFailure(
        "roll: no running state was found with the transients of the motor: followed from a heavy "
        f"rotor it ceases to exist below an inertia of about {np.exp(at):.4g} kg*m^2 (the rotor "
        f"has {own:.4g} kg*m^2), although the mean demand of {need.torque[0]:.6g} N*m is below the "
        f"steady breakdown torque of {need.breakdown[0]:.6g} N*m"
    )


def _with_rotor(machine: RollMachine, logarithm: float) -> RollMachine:
    inertia: FloatArray = np.full_like(machine.rotor_inertia, np.exp(logarithm))
    return machine._replace(rotor_inertia=inertia)
