"""What the machine asks of its motor on average, and the slip at which the motor gives it."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.slip_torque import breakdown, rising_branch
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.rates import place_at
from vibecalc.response.roll.torques import smooth_angles, steady_curve
from vibecalc.response.roll.turn import Turn

_POINTS = 4
#: slips looked at, over that of the summit
_GRID = np.linspace(-1.0, 1.0, 201)


class Demand(NamedTuple):
    """Mean torque over a turn that gas and friction ask for, the most there is (...,), N m.

    `slip` is where the motor gives it on its steady branch, rad/s; NaN where it never does.
    """

    torque: FloatArray
    breakdown: FloatArray
    slip: FloatArray

    @property
    def possible(self) -> np.ndarray:
        """Where the motor can give what is asked for; elsewhere no running state exists."""
        return np.isfinite(self.slip)


def steady_breakdown(drive: RollDrive) -> tuple[float, float]:
    """Slip (rad/s) and torque (N m) of the summit of a motor's steady curve, infinite if linear."""
    return breakdown(drive.motor) if drive.circuit is None else drive.circuit.breakdown


def surely_fastest(machine: RollMachine, drive: RollDrive, turn: Turn) -> BoolArray:
    """Where (B,) no faster running state of a free machine can exist, from this one alone.

    Two periodic motions cannot cross and need the same mean torque over the crank angle. Where the
    torque of the motor falls with the speed all the way up from one, a faster one has less of it.
    Of machines on mounts, whose motions may cross, nothing is asked, nor of fluxes.
    """
    if is_mounted(machine) or drive.fluxes:
        return np.ones(len(turn.period), dtype=bool)
    slip = drive.synchronous_speed[..., None] - turn.crank_speed
    if drive.circuit is None:
        summit, least = rising_branch(drive.motor)
    else:
        summit, least = steady_breakdown(drive)[0], 0.0
    # far above synchronous speed the torque that brakes falls again
    braking = steady_curve(drive, np.min(slip, axis=-1)).value
    return np.asarray((np.max(slip, axis=-1) <= summit) & (braking >= -least))


def demand(machine: RollMachine, drive: RollDrive, edges: FloatArray | None = None) -> Demand:
    """Mean demand of the machines (B,) and the slip that meets it.

    The mean over the crank angle of all torques between shell and crankshaft is zero in a periodic
    motion, so a demand above the breakdown torque rules one out. `edges` are the smooth angles of
    these machines, if they are known.
    """
    edges = smooth_angles(machine, drive) if edges is None else edges
    rule = gauss_rule(_POINTS)
    widths = np.diff(edges)[:, None]
    angles = (edges[:-1, None] + widths * rule.nodes).ravel()
    weights = (widths * rule.weights).ravel() / (2.0 * np.pi)
    place = place_at(
        machine, drive, np.broadcast_to(angles, (*machine.crank_radius.shape, len(angles)))
    )
    asked = -(place.load @ weights)
    speed = np.broadcast_to(drive.synchronous_speed, asked.shape)
    summit, most = steady_breakdown(drive)
    if not np.isfinite(summit):
        gain = machine.motor_scale * drive.motor.coefficient[0, 1]
        slip = (asked + machine.friction_damping * speed) / (gain + machine.friction_damping)
        return Demand(asked, np.full(asked.shape, np.inf), np.where(slip < speed, slip, np.nan))
    slips = summit * _GRID
    torque = steady_curve(drive, slips).value
    drag = machine.friction_damping[..., None] * (speed[..., None] - slips)
    spare = machine.motor_scale[..., None] * torque - drag - asked[..., None]
    # the steady branch: the smallest slip at which the motor gives enough
    enough = spare >= 0.0
    at = np.maximum(enough.argmax(axis=-1), 1)
    row = np.arange(len(at))
    low, high = spare[row, at - 1], spare[row, at]
    share = np.where(high > low, -low / np.where(high > low, high - low, 1.0), 1.0)
    share = np.minimum(np.maximum(share, 0.0), 1.0)
    slip = slips[at - 1] + share * (slips[at] - slips[at - 1])
    able = enough.any(axis=-1) & (slip < speed)
    return Demand(asked, machine.motor_scale * most, np.where(able, slip, np.nan))
