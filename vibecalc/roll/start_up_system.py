"""Rotor, pistons and shell in time, in smooth segments between kinks, for many starts."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome
from vibecalc.roll.between_kinks import acting_at, edges_around, forces_in, slot_at, slots_of
from vibecalc.roll.mechanism import (
    Inertia,
    RollDrive,
    RollMachine,
    accelerations,
    gas_torque,
    inertia,
    mount_torque,
)

# ----------------------------------------------------------------------------
# What a start-up carries along in time, and the names of its columns.
# ----------------------------------------------------------------------------

#: the states of a member; the last four are work done, in J
ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED, MOTOR_WORK, GAS_WORK, FRICTION_WORK, MOUNT_WORK = range(8)
STATES = 8

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
    """Members that pass crank angle 2 pi `turn` going forward, at their times in s."""

    member: IntArray
    turn: IntArray
    time: FloatArray


# ----------------------------------------------------------------------------
# Rotor, pistons and shell in time, in the smooth intervals between kinks, for many starts at once.
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
        self.closeness = max(1e-4 * tolerance, 2e-12) * np.array([1.0, fast, fast])
        self._acting = acting_at(machine, drive, self.slots)
        self._nodes = np.concatenate([[-np.inf], drive.motor.threshold, [np.inf]])
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
        interval[:, DIRECTION] = np.sign(state[:, SPEED])
        still = np.nonzero(state[:, SPEED] == 0.0)[0]
        interval[still, DIRECTION] = self._direction_from_standstill(state[still], interval[still])
        self._refuse_slip(interval[:, CURVE], start, state)
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

    def rates(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        if len(state) == 1:
            return self._rates_of_one(state[0].tolist(), interval[0].tolist())
        moved = inertia(self.machine, state[:, ANGLE])
        acting = self.torques(moved, state, interval)
        speed, shell = state[:, SPEED], state[:, SHELL_SPEED]
        driving = acting.motor + acting.gas + acting.viscous + acting.dry
        accelerated = accelerations(moved, speed, shell, acting.mounts, driving)
        result = np.empty_like(state)
        result[:, ANGLE], result[:, SPEED] = speed, accelerated.crank
        result[:, SHELL_ANGLE], result[:, SHELL_SPEED] = shell, accelerated.shell
        result[:, MOTOR_WORK], result[:, GAS_WORK] = acting.motor * speed, acting.gas * speed
        result[:, FRICTION_WORK] = (acting.viscous + acting.dry) * speed
        result[:, MOUNT_WORK] = -self.machine.shell_damping * shell * shell
        if self.dry:
            held = interval[:, DIRECTION] == 0
            if np.any(held):
                # shell and crank turn as one body
                result[held, ANGLE] = result[held, SPEED] = 0.0
                result[held, SHELL_SPEED] = acting.mounts[held] / moved.shell[held]
                result[held, MOTOR_WORK : FRICTION_WORK + 1] = 0.0
        return result

    def _rates_of_one(self, state: list[float], interval: list[int]) -> FloatArray:
        """The same in plain floats, which for a single member are several times faster."""
        angle, speed, shell_angle, shell, *_ = state
        slot, curve, direction, row = interval
        held = self.dry and direction == 0
        acting = self._acting(
            angle, speed, shell_angle, shell, slot, curve, direction, float(self.load.factor[row])
        )
        loss = -self._damping * shell * shell
        if held:
            turned = acting.mounts / acting.shell_inertia
            return np.array([[0.0, 0.0, shell, turned, 0.0, 0.0, 0.0, loss]])
        friction = (acting.viscous - (direction * acting.dry if self.dry else 0.0)) * speed
        return np.array(
            [
                [
                    speed, acting.crank, shell, acting.shell,
                    acting.motor * speed, acting.gas * speed, friction, loss,
                ]
            ]
        )  # fmt: skip

    def watched(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> FloatArray:
        speed = state[:, SPEED]
        last = speed
        if self.dry:
            held = interval[:, DIRECTION] == 0
            if np.any(held):
                # the share of dry friction that holding takes, as a speed to have its unit
                last = speed.copy()
                last[held] = self._holding(state[held], interval[held]) * self.scale[SPEED]
        values = np.empty((len(state), 3))
        values[:, 0], values[:, 1], values[:, 2] = state[:, ANGLE], self.synchronous - speed, last
        return values

    def borders(self, member: IntArray, interval: IntArray) -> tuple[FloatArray, FloatArray]:
        lower, upper = np.empty((len(member), 3)), np.empty((len(member), 3))
        lower[:, 0], upper[:, 0] = edges_around(self.slots, interval[:, SLOT])
        nodes = self._nodes
        lower[:, 1], upper[:, 1] = nodes[interval[:, CURVE]], nodes[interval[:, CURVE] + 1]
        lower[:, 2], upper[:, 2] = -np.inf, np.inf
        if self.dry:
            fast, direction = self.scale[SPEED], interval[:, DIRECTION]
            lower[:, 2] = np.where(direction == 0, -fast, np.where(direction > 0, 0.0, -np.inf))
            upper[:, 2] = np.where(direction == 0, fast, np.where(direction < 0, 0.0, np.inf))
        return lower, upper

    def crossed(
        self,
        member: IntArray,
        time: FloatArray,
        state: FloatArray,
        interval: IntArray,
        which: IntArray,
        direction: IntArray,
    ) -> EventOutcome:
        state, interval = state.copy(), interval.copy()
        finished = np.zeros(len(member), dtype=bool)
        at_edge = which == 0
        interval[at_edge, SLOT] += direction[at_edge]
        count = len(self.slots.edge) - 1
        passes = at_edge & (direction > 0) & (interval[:, SLOT] % count == 0)
        if np.any(passes):
            finished[passes] = self._note(
                member[passes], interval[passes, SLOT] // count, time[passes]
            )
        curve = which == 1
        interval[curve, CURVE] += direction[curve]
        if np.any(curve):
            self._refuse_slip(interval[curve, CURVE], float(time[curve][0]), state[curve])
        turns = np.nonzero(which == 2)[0]
        if len(turns):
            held = interval[turns, DIRECTION] == 0
            self._stop(state, turns[~held])
            # more than friction holds: the crank goes where it is pushed, against which it was held
            interval[turns[held], DIRECTION] = -direction[turns[held]]
            stopped = turns[~held]
            interval[stopped, DIRECTION] = self._direction_from_standstill(
                state[stopped], interval[stopped]
            )
            finished[stopped] |= self._rests_for_good(interval[stopped])
        return EventOutcome(state, interval, finished)

    def stopped(
        self, member: IntArray, time: FloatArray, state: FloatArray, interval: IntArray
    ) -> EventOutcome:
        interval = interval.copy()
        interval[:, LOAD] += 1
        still = np.nonzero((interval[:, DIRECTION] == 0) & self.dry)[0]
        interval[still, DIRECTION] = self._direction_from_standstill(state[still], interval[still])
        finished = self._rests_for_good(interval)
        return EventOutcome(state, interval, finished)

    def _dry_size(self, moved: Inertia, interval: IntArray) -> FloatArray:
        if not self.dry:
            return np.zeros(len(interval))
        heading = self.slots.heading[interval[:, SLOT] % (len(self.slots.edge) - 1)]
        strokes = np.sum(heading * moved.stroke, axis=-1)
        return np.asarray(self.machine.friction_torque + self.machine.piston_friction * strokes)

    def _holding(self, state: FloatArray, interval: IntArray) -> FloatArray:
        """Torque that holds a crank at rest, as a share of dry friction (b,); positive forward."""
        moved = inertia(self.machine, state[:, ANGLE])
        acting = self.torques(moved, state, interval)
        shell = state[:, SHELL_SPEED]
        needed = (
            moved.coupling * acting.mounts / moved.shell
            - 0.5 * moved.shell_slope * shell * shell
            - (acting.motor + acting.gas)
        )
        least = 1e-12 * self.torque_scale
        return np.asarray(needed / np.maximum(self._dry_size(moved, interval), least))

    def _stop(self, state: FloatArray, rows: IntArray) -> None:
        """Take what is left of the crank's speed against the shell; the momentum stays."""
        moved = inertia(self.machine, state[rows, ANGLE])
        state[rows, SHELL_SPEED] += moved.coupling / moved.shell * state[rows, SPEED]
        state[rows, SPEED] = 0.0

    def _direction_from_standstill(self, state: FloatArray, interval: IntArray) -> IntArray:
        if not self.dry:
            return np.ones(len(interval), dtype=np.int64)
        share = self._holding(state, interval)
        return np.where(np.abs(share) <= 1.0, 0, -np.sign(share)).astype(np.int64)

    def _rests_for_good(self, interval: IntArray) -> BoolArray:
        """Held, with nothing to come that could move it: no mounts, no further change of load."""
        rests = (
            (interval[:, DIRECTION] == 0)
            & (interval[:, LOAD] == len(self.load.time) - 1)
            & self.dry
        )
        mounted = bool(self.machine.shell_stiffness > 0.0 or self.machine.shell_damping > 0.0)
        return np.asarray(rests & (not mounted))

    def _refuse_slip(self, curve: IntArray, time: float, state: FloatArray) -> None:
        last = len(self.drive.motor.threshold)
        if self.drive.holds or not last:
            return
        beyond = (curve == 0) | (curve == last)
        if np.any(beyond):
            speed = float(state[np.argmax(beyond), SPEED])
            back = speed < self.synchronous
            why = "the gas turns it backward" if back else "it is driven beyond the table"
            raise NumericalFailure(
                f"at {time:.6g} s the crank runs at {speed:.6g} rad/s and {why}: the slip is more "
                f"than {self.drive.motor.largest:.6g} rad/s, the last of the motor's table; "
                f'continue the table, or keep its last torque with beyond = "hold"'
            )

    def started(self, count: int) -> BoolArray:
        """Which of the members have run a whole turn at `until_speed`."""
        return np.isin(np.arange(count), sorted(self._fast))

    def _note(self, member: IntArray, turn: IntArray, time: FloatArray) -> BoolArray:
        self.sections.append(TurnPassage(member, turn, time.copy()))
        done = np.zeros(len(member), dtype=bool)
        every = zip(member.tolist(), turn.tolist(), time.tolist(), strict=True)
        for place, (who, number, when) in enumerate(every):
            before, since = self._passed.get(who, (number, when))
            if number == before + 1 and TURN / (when - since) >= self._until:
                done[place] = True
                self._fast.add(who)
            if number >= before:
                self._passed[who] = (number, when)
        return done
