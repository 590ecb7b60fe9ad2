"""Rotor, pistons and shell in time, in smooth segments between kinks, for many starts."""

from collections.abc import Sequence
from math import copysign
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome, Interval, State
from vibecalc.roll.between_kinks import acting_at, forces_in, slot_at, slots_of
from vibecalc.roll.mechanism import (
    Inertia,
    RollDrive,
    RollMachine,
    gas_torque,
    inertia,
    mount_torque,
)

# ----------------------------------------------------------------------------
# What a start-up carries along in time, and the names of its columns.
# ----------------------------------------------------------------------------

#: the states of a member; the last four, which may be left out, are work done, in J
ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED, MOTOR_WORK, GAS_WORK, FRICTION_WORK, MOUNT_WORK = range(8)
STATES, MOVING = 8, 4

#: columns of `interval`
SLOT, CURVE, DIRECTION, LOAD = range(4)


class LoadSteps(NamedTuple):
    """Factor on the gas forces: `factor`[i] from `time`[i] (s) on; the first time is 0."""

    time: FloatArray
    factor: FloatArray


FULL_LOAD = LoadSteps(np.zeros(1), np.ones(1))


class Torques(NamedTuple):
    """Torques of b members in N m: on the crankshaft motor, gas, friction; of the mounts."""

    motor: FloatArray
    gas: FloatArray
    viscous: FloatArray
    dry: FloatArray
    mounts: FloatArray


class TurnPassage(NamedTuple):
    """A member that passes crank angle 2 pi `turn` going forward, at a time in s."""

    member: int
    turn: int
    time: float


# ----------------------------------------------------------------------------
# Rotor, pistons and shell in time, in the smooth intervals between kinks, for one start or several.
#
# The intervals of a member are the slot of the crank angle (between nodes of the gas tables), the
# interval of the motor's curve, the direction of the crank (+1, -1, or 0: held by dry friction),
# and the row of the load's table. Dry friction is taken as it is: while the crank turns it has its
# full size against the motion; at rest it is whatever holds the crank, until that is more than its
# size.
# ----------------------------------------------------------------------------


class StartUpSystem:
    """The `System` of `runge_kutta_march` for one machine with B starts.

    `sections` collects passages of crank angle zero. With `until_speed` a member finishes once
    its mean speed over a whole turn reaches it.
    """

    def __init__(
        self,
        machine: RollMachine,
        drive: RollDrive,
        load: LoadSteps,
        tolerance: float,
        until_speed: float = np.inf,
    ):
        if machine.crank_radius.ndim:
            raise ValueError("one machine at a time")
        self.machine, self.drive, self.load = machine, drive, load
        self.slots = slots_of(machine, drive)
        self.synchronous = float(drive.synchronous_speed)
        self.dry = bool(machine.friction_torque > 0.0 or machine.piston_friction > 0.0)
        still = inertia(machine, np.linspace(0.0, TURN, 73))
        ratio = float(np.max(np.abs(still.coupling) / still.shell))
        fast = max(abs(self.synchronous), 1.0)
        energy = float(np.max(still.crank)) * fast * fast
        self.scale = np.array([1.0, fast, ratio, ratio * fast, energy, energy, energy, energy])
        self.torque_scale = energy
        self.closeness = (max(1e-4 * tolerance, 2e-12) * np.array([1.0, fast, fast])).tolist()
        # held by friction, the crank watches what holds it
        self.leading = MOVING if self.dry else SPEED + 1
        self._fastness, self._least_torque = fast, 1e-12 * energy
        self._acting = acting_at(machine, drive, self.slots)
        self._nodes = [-np.inf, *drive.motor.threshold.tolist(), np.inf]
        self._edge: list[float] = self.slots.edge.tolist()
        self._factor: list[float] = load.factor.tolist()
        self._damping = float(machine.shell_damping)
        self._until = until_speed
        self.sections: list[TurnPassage] = []
        self._passed: dict[int, tuple[int, float]] = {}
        self._fast: set[int] = set()

    def first_intervals(self, state: FloatArray, start: float) -> IntArray:
        """Intervals (b, 4) of members that start in `state` (b, n) at the time `start`."""
        interval = np.zeros((len(state), 4), dtype=np.int64)
        interval[:, SLOT] = slot_at(self.slots, state[:, ANGLE])
        slip = self.synchronous - state[:, SPEED]
        # on a node: the interval towards smaller slip
        slightly = slip - np.sign(slip) * self.closeness[1]
        interval[:, CURVE] = np.searchsorted(self.drive.motor.threshold, slightly, side="right")
        interval[:, LOAD] = np.searchsorted(self.load.time, start, side="right") - 1
        for member, chosen in zip(state.tolist(), interval, strict=True):
            chosen[DIRECTION] = self._direction(member, chosen.tolist())
            self._refuse_slip(int(chosen[CURVE]), start, member)
        return interval

    def torques(self, moved: Inertia, state: FloatArray, interval: IntArray) -> Torques:
        """What acts on the members in their intervals; dry friction as if it had its full size."""
        machine = self.machine
        slip = self.synchronous - state[:, SPEED]
        motor = machine.motor_scale * slip_torque(self.drive.motor, slip, interval[:, CURVE]).value
        forces = forces_in(machine, self.drive, self.slots, state[:, ANGLE], interval[:, SLOT])
        gas = gas_torque(moved, forces) * self.load.factor[interval[:, LOAD]]
        viscous = -machine.friction_damping * state[:, SPEED]
        dry = self._dry_size(moved, interval) * -np.sign(interval[:, DIRECTION])
        mounts = mount_torque(machine, state[:, SHELL_ANGLE], state[:, SHELL_SPEED])
        return Torques(motor, gas, viscous, dry, mounts)

    def rates(self, time: float, state: State, interval: Interval) -> State:
        angle, speed, shell_angle, shell, *works = state
        slot, curve, direction, row = interval
        held = self.dry and direction == 0
        acting = self._acting(
            angle, speed, shell_angle, shell, slot, curve, direction, self._factor[row]
        )
        if held:
            # shell and crank turn as one body
            speed, moving = 0.0, [0.0, 0.0, shell, acting.mounts / acting.shell_inertia]
        else:
            moving = [speed, acting.crank, shell, acting.shell]
        if not works:
            return moving
        friction = acting.viscous - (direction * acting.dry if self.dry else 0.0)
        return [
            *moving,
            acting.motor * speed,
            acting.gas * speed,
            friction * speed,
            -self._damping * shell * shell,
        ]

    def watched(
        self, time: float, state: Sequence[float], interval: Interval
    ) -> tuple[float, float, float]:
        angle, speed = state[ANGLE], state[SPEED]
        last = speed
        if self.dry and interval[DIRECTION] == 0:
            # the share of dry friction that holding takes, as a speed to have its unit
            last = self._holding(state, interval) * self._fastness
        return angle, self.synchronous - speed, last

    def borders(self, interval: Interval) -> tuple[tuple[float, ...], tuple[float, ...]]:
        slot, curve, direction, _ = interval
        turn, place = divmod(slot, len(self._edge) - 1)
        low, high = -np.inf, np.inf
        if self.dry:
            fast = self._fastness
            low = 0.0 if direction > 0 else -fast if direction == 0 else -np.inf
            high = 0.0 if direction < 0 else fast if direction == 0 else np.inf
        return (
            (TURN * turn + self._edge[place], self._nodes[curve], low),
            (TURN * turn + self._edge[place + 1], self._nodes[curve + 1], high),
        )

    def crossed(
        self,
        member: int,
        time: float,
        state: State,
        interval: Interval,
        which: int,
        direction: int,
    ) -> EventOutcome:
        slot, curve, heading, row = interval
        if which == 0:
            slot += direction
            turn, place = divmod(slot, len(self._edge) - 1)
            finished = direction > 0 and place == 0 and self._note(member, turn, time)
            return EventOutcome(state, [slot, curve, heading, row], finished)
        if which == 1:
            curve += direction
            self._refuse_slip(curve, time, state)
            return EventOutcome(state, [slot, curve, heading, row], False)
        if heading == 0:
            # more than friction holds: the crank goes where it is pushed, against which it was held
            return EventOutcome(state, [slot, curve, -direction, row], False)
        state = self._at_rest(state)
        interval = [slot, curve, self._direction(state, interval), row]
        return EventOutcome(state, interval, self._rests_for_good(interval))

    def stopped(self, member: int, time: float, state: State, interval: Interval) -> EventOutcome:
        slot, curve, direction, row = interval
        interval = [slot, curve, direction, row + 1]
        if self.dry and direction == 0:
            interval[DIRECTION] = self._direction(state, interval)
        return EventOutcome(state, interval, self._rests_for_good(interval))

    def _dry_size(self, moved: Inertia, interval: IntArray) -> FloatArray:
        if not self.dry:
            return np.zeros(len(interval))
        heading = self.slots.heading[interval[:, SLOT] % (len(self.slots.edge) - 1)]
        strokes = np.sum(heading * moved.stroke, axis=-1)
        return np.asarray(self.machine.friction_torque + self.machine.piston_friction * strokes)

    def _holding(self, state: Sequence[float], interval: Interval) -> float:
        """Torque that holds a crank at rest, as a share of dry friction; positive forward."""
        angle, _, shell_angle, shell = state[:MOVING]
        slot, curve, _, row = interval
        acting = self._acting(angle, 0.0, shell_angle, shell, slot, curve, 0, self._factor[row])
        return acting.holding / max(acting.dry, self._least_torque)

    def _at_rest(self, state: State) -> State:
        """The state without the crank's speed against the shell; the momentum stays."""
        moved = inertia(self.machine, np.array(state[: ANGLE + 1]))
        turned = float(moved.coupling[0] / moved.shell[0]) * state[SPEED]
        state = [*state]
        state[SHELL_SPEED] += turned
        state[SPEED] = 0.0
        return state

    def _direction(self, state: State, interval: Interval) -> int:
        """Where the crank turns, or would from rest: +1, -1, or 0 where dry friction holds it."""
        if state[SPEED]:
            return int(copysign(1.0, state[SPEED]))
        if not self.dry:
            return 1
        share = self._holding(state, interval)
        return 0 if abs(share) <= 1.0 else -int(copysign(1.0, share))

    def _rests_for_good(self, interval: Interval) -> bool:
        """Held, with nothing to come that could move it: no mounts, no further change of load."""
        if not self.dry or interval[DIRECTION] or interval[LOAD] < len(self._factor) - 1:
            return False
        return not (self.machine.shell_stiffness > 0.0 or self.machine.shell_damping > 0.0)

    def _refuse_slip(self, curve: int, time: float, state: State) -> None:
        last = len(self.drive.motor.threshold)
        if self.drive.holds or not last or 0 < curve < last:
            return
        speed = state[SPEED]
        back = speed < self.synchronous
        why = "the gas turns it backward" if back else "it is driven beyond the table"
        raise NumericalFailure(
            f"at {time:.6g} s the crank runs at {speed:.6g} rad/s and {why}: the slip is more "
            f"than {self.drive.motor.largest:.6g} rad/s, the last of the motor's table; "
            f'continue the table, or keep its last torque with extrapolation = "hold"'
        )

    def started(self, count: int) -> BoolArray:
        """Which of the members have run a whole turn at `until_speed`."""
        return np.isin(np.arange(count), sorted(self._fast))

    def _note(self, member: int, turn: int, time: float) -> bool:
        """Keep a passage of crank angle zero; whether the turn that it ends was a fast one."""
        self.sections.append(TurnPassage(member, turn, time))
        before, since = self._passed.get(member, (turn, time))
        done = turn == before + 1 and TURN / (time - since) >= self._until
        if done:
            self._fast.add(member)
        if turn >= before:
            self._passed[member] = turn, time
        return done
