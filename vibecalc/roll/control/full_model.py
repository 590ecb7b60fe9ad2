"""The full machine where a controller feeds the motor: rates, running state, stability."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import floquet_multipliers
from vibecalc.numerics.periodic.panels import (
    PeriodicProblem,
    PeriodicSolution,
    evaluate,
    running_integral,
)
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.roll.mechanism import (
    AngleTerms,
    RollDrive,
    RollMachine,
    inertia,
    is_mounted,
    place_at,
    smooth_angles,
)
from vibecalc.roll.rates import demand, mounted_scale, shell_speed
from vibecalc.roll.turn import Turn, harmonics, readings

# ----------------------------------------------------------------------------
# Rates over the crank angle where a controller sets the speed of the motor's field.
#
# The controller asks for u* = K (R - k_R w - k_S ds/dt), with w the speed of the crank against the
# shell and ds/dt the acceleration of the shell. The actuator follows with a first-order lag,
# tau du/dt = u* - u, and the slip of the motor is u - w (Herold 1977, Fig. 26, in the equations of
# `inertia.py`). The acceleration is linear in the torque of the motor, and the torque a function of
# the slip: without a lag, u = u* is one equation for the slip at every angle.
# ----------------------------------------------------------------------------

_NEWTON_STEPS = 80


class Law(NamedTuple):
    """Gain K (1), speed feedback k_R (1), acceleration feedback k_S (s), reference R (rad/s), lag
    tau of the actuator (s), zero for none.
    """

    gain: float
    speed_feedback: float
    acceleration_feedback: float
    reference: float
    lag: float = 0.0


class DrivenMotor(NamedTuple):
    """What the motor does (..., k): slip in rad/s and torque in N m, with its slopes by the states
    (..., k, n).
    """

    slip: FloatArray
    torque: FloatArray
    torque_by: FloatArray


class _Bare(NamedTuple):
    """Accelerations without the torque of the motor, their slopes by the states, and what one N m
    of it adds.
    """

    shell: FloatArray
    crank: FloatArray
    shell_by: FloatArray
    crank_by: FloatArray
    shell_gain: FloatArray
    crank_gain: FloatArray


class ControlledRates:
    """dy/db at (B, P, s) crank angles for a machine under control.

    y = (w,) of a free shell, with `momentum` (B,) its angular momentum, or (w, shell angle, shell
    speed) with mounts, `momentum` being None; with a lag of the actuator u follows behind.
    """

    def __init__(
        self, machine: RollMachine, drive: RollDrive, law: Law, momentum: FloatArray | None
    ):
        self.machine, self.drive, self.law, self.momentum = machine, drive, law, momentum
        self.states = (1 if momentum is not None else 3) + (law.lag > 0.0)
        self._angles: FloatArray | None = None
        self._place: AngleTerms | None = None

    def __call__(
        self, crank_angle: FloatArray, state: FloatArray, interval: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        members, panels, points = crank_angle.shape
        flat = state.reshape(members, panels * points, self.states)
        flat = np.where(flat[..., :1] > 0.0, flat, np.nan)
        chosen = None if interval is None else np.repeat(interval, points, axis=1)
        value, jacobian = self._rates(self.place(crank_angle), flat, chosen)
        return value.reshape(state.shape), jacobian.reshape(*state.shape, self.states)

    def place(self, crank_angle: FloatArray) -> AngleTerms:
        """Inertia and torques at the angles (B, P, s), as (B, P s)."""
        if self._place is None or self._angles is not crank_angle:
            flat = crank_angle.reshape(len(crank_angle), -1)
            self._place = place_at(self.machine, self.drive, flat)
            self._angles = crank_angle
        return self._place

    def driven(
        self, place: AngleTerms, state: FloatArray, interval: IntArray | None = None
    ) -> DrivenMotor:
        """Slip and torque at states (B, k, n)."""
        return self._driven(self._bare(place, state), state, interval)

    def lagged_slip(self, state: FloatArray) -> FloatArray:
        """Slip at states (B, P, s, n) of an actuator with a lag."""
        return np.asarray(state[..., -1] - state[..., 0])

    def _rates(
        self, place: AngleTerms, state: FloatArray, interval: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        law, speed = self.law, state[..., 0]
        bare = self._bare(place, state)
        motor = self._driven(bare, state, interval)
        shell = bare.shell + bare.shell_gain * motor.torque
        crank = bare.crank + bare.crank_gain * motor.torque
        shell_by = bare.shell_by + bare.shell_gain[..., None] * motor.torque_by
        crank_by = bare.crank_by + bare.crank_gain[..., None] * motor.torque_by
        value, by = np.empty_like(state), np.zeros((*state.shape, self.states))
        value[..., 0], by[..., 0, :] = crank, crank_by
        if self.momentum is None:
            value[..., 1], by[..., 1, 2] = state[..., 2], 1.0
            value[..., 2], by[..., 2, :] = shell, shell_by
        if law.lag > 0.0:
            asked, asked_by = self._asked(speed, shell, shell_by)
            value[..., -1] = (asked - state[..., -1]) / law.lag
            by[..., -1, :] = asked_by / law.lag
            by[..., -1, -1] -= 1.0 / law.lag
        value /= speed[..., None]
        by /= speed[..., None, None]
        by[..., :, 0] -= value / speed[..., None]
        return value, by

    def _asked(
        self, speed: FloatArray, shell: FloatArray, shell_by: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """What the controller asks of the actuator, rad/s, and its slopes by the states."""
        law = self.law
        asked = law.gain * (
            law.reference - law.speed_feedback * speed - law.acceleration_feedback * shell
        )
        by = -law.gain * law.acceleration_feedback * shell_by
        by[..., 0] -= law.gain * law.speed_feedback
        return asked, by

    def _driven(self, bare: _Bare, state: FloatArray, interval: IntArray | None) -> DrivenMotor:
        law, scale = self.law, self.machine.motor_scale[..., None]
        speed = state[..., 0]
        if law.lag > 0.0:
            slip = state[..., -1] - speed
            curve = slip_torque(self.drive.motor, slip, interval)
            by = np.zeros(state.shape)
            by[..., 0], by[..., -1] = -scale * curve.slope, scale * curve.slope
            return DrivenMotor(slip, scale * curve.value, by)
        asked, by = self._asked(speed, bare.shell, bare.shell_by)
        back = law.gain * law.acceleration_feedback * bare.shell_gain * scale
        slip = self._implicit(asked - speed, back)
        curve = slip_torque(self.drive.motor, slip, interval)
        by[..., 0] -= 1.0
        # a loop that answers itself more than once has no motion of its own
        firm = 1.0 + back * curve.slope
        slope = np.where(firm > 0.0, scale * curve.slope / firm, np.nan)
        return DrivenMotor(slip, scale * curve.value, slope[..., None] * by)

    def _implicit(self, free: FloatArray, back: FloatArray) -> FloatArray:
        """The slip (...,) that solves slip + back torque(slip) = free."""
        motor = self.drive.motor
        if not len(motor.threshold):
            offset, gain = motor.coefficient[0, 0], motor.coefficient[0, 1]
            return np.asarray((free - back * offset) / (1.0 + back * gain))
        most = float(np.max(np.abs(slip_torque(motor, _samples(motor.threshold)).value)))
        reach = 1.5 * np.abs(back) * most
        low, high = free - reach, free + reach
        slip = free - back * slip_torque(motor, free).value
        for _ in range(_NEWTON_STEPS):
            slip = np.where((slip > low) & (slip < high), slip, 0.5 * (low + high))
            curve = slip_torque(motor, slip)
            over = slip + back * curve.value - free
            low, high = np.where(over < 0.0, slip, low), np.where(over > 0.0, slip, high)
            step = over / (1.0 + back * curve.slope)
            if not np.any(np.abs(step) > 1e-15 * (1.0 + np.abs(slip))):
                break
            slip = slip - step
        return np.asarray(slip)

    def _bare(self, place: AngleTerms, state: FloatArray) -> _Bare:
        """Rotor, shell and load, all but the motor; the equations are those of `inertia.py`."""
        moved, speed = place.moved, state[..., 0]
        outer, outer_by = np.zeros_like(speed), np.zeros(state.shape)
        inner_by = np.zeros(state.shape)
        if self.momentum is not None:
            shell = shell_speed(place, self.momentum, speed)
        else:
            shell = state[..., 2]
            stiffness, damping = (
                field[..., None]
                for field in (self.machine.shell_stiffness, self.machine.shell_damping)
            )
            outer = -stiffness * state[..., 1] - damping * shell
            outer_by[..., 1], outer_by[..., 2] = -stiffness, -damping
        outer = outer - moved.shell_slope * speed * shell - moved.coupling_slope * speed**2
        inner = place.load - place.drag * speed
        inner = inner + 0.5 * (moved.shell_slope * shell**2 - moved.crank_slope * speed**2)
        outer_by[..., 0] -= moved.shell_slope * shell + 2.0 * moved.coupling_slope * speed
        inner_by[..., 0] = -place.drag - moved.crank_slope * speed
        # the speed of a free shell is no state: it follows the crank's
        free = self.momentum is not None
        row = 0 if free else 2
        rate = -moved.coupling / moved.shell if free else np.ones_like(speed)
        outer_by[..., row] -= moved.shell_slope * speed * rate
        inner_by[..., row] += moved.shell_slope * shell * rate
        j, n, q, over = moved.shell, moved.coupling, moved.crank, moved.determinant
        wide = [part[..., None] for part in np.broadcast_arrays(j, n, q, over)]
        return _Bare(
            (q * outer - n * inner) / over,
            (j * inner - n * outer) / over,
            (wide[2] * outer_by - wide[1] * inner_by) / wide[3],
            (wide[0] * inner_by - wide[1] * outer_by) / wide[3],
            np.asarray(-n / over),
            np.asarray(j / over),
        )


def _samples(threshold: FloatArray) -> FloatArray:
    """Slips that show how large a motor's torque gets, from its pieces."""
    return np.asarray(np.linspace(threshold[0], threshold[-1], 40 * len(threshold)))


# ----------------------------------------------------------------------------
# The running state of a machine whose motor a controller feeds, and whether it is stable.
# ----------------------------------------------------------------------------

_POINT_LEVELS = (6, 8, 10, 13, 16, 20)
#: part of the tolerance at which the levels end, for the sake of small harmonics
_SMALL = 1e-2
#: rounds until edges at kinks and the momentum of a free shell stand, and what counts as standing
_ROUNDS, _EDGES_STAND, _STILL = 12, 1e-8, 1e-13
#: examines each panel for a slip that meets a node of the motor's curve
_SAMPLES, _HALVINGS = 24, 48


class ClosedLoopTurn(NamedTuple):
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

    harmonics: Bounded
    speed: Bounded
    multiplier: ComplexArray
    multiplier_error: FloatArray
    stable: bool
    largest_slip: Bounded
    closed: ClosedLoopTurn


def closed_loop(
    machine: RollMachine, drive: RollDrive, law: Law, *, rtol: float, orders: int
) -> ClosedLoop:
    """The running state of one machine (B = 1) under control, by Gauss collocation.

    Raises NumericalFailure where there is none, none is found, or its slip leaves the table.
    """
    numbers = np.arange(1.0, orders + 1)

    def level_of_turn(closed: ClosedLoopTurn) -> ComplexArray:
        read = readings(machine, drive, closed.turn, closed.torque, pistons=False)
        return np.asarray(harmonics(closed.turn, read.shell_acceleration, numbers)[0])

    check = _state(machine, drive, law, _POINT_LEVELS[0], None)
    closed, before = check, level_of_turn(check)
    level, apart = before, np.full(orders, np.inf)
    for points in _POINT_LEVELS[1:]:
        check, before = closed, level
        closed = _state(machine, drive, law, points, check.solution)
        level = level_of_turn(closed)
        apart = np.abs(level - before)
        if np.max(apart) <= _SMALL * rtol * np.max(np.abs(level)):
            break
    _check_slip(closed, drive)
    speed = [2.0 * np.pi / float(one.turn.period[0]) for one in (closed, check)]
    slip = [float(np.max(np.abs(one.slip))) for one in (closed, check)]
    value, error = floquet_multipliers(closed.problem, closed.solution)
    size = np.abs(closed.torque).max() / float(machine.shell_inertia[0])
    return ClosedLoop(
        Bounded(level, apart + 1e-14 * size),
        Bounded(np.asarray(speed[0]), np.asarray(abs(speed[0] - speed[1]) + 1e-14 * speed[0])),
        value[0],
        error[0],
        bool(np.all(np.abs(value[0]) + error[0] < 1.0)),
        Bounded(np.asarray(slip[0]), np.asarray(abs(slip[0] - slip[1]) + 1e-12)),
        closed,
    )


def _state(
    machine: RollMachine, drive: RollDrive, law: Law, points: int, near: PeriodicSolution | None
) -> ClosedLoopTurn:
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
    return ClosedLoopTurn(turn, motor.slip, motor.torque, problem, solution)


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

    angle = (
        base[:-1, None] + np.diff(base)[:, None] * np.linspace(0.0, 1.0, _SAMPLES)[:-1]
    ).ravel()
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
    edges = every[np.concatenate([[True], np.diff(every) > 1e-9])]
    edges[-1] = base[-1]
    return np.asarray(edges)


def _check_slip(closed: ClosedLoopTurn, drive: RollDrive) -> None:
    largest = float(np.max(np.abs(closed.slip)))
    if drive.holds or largest <= drive.motor.largest:
        return
    rpm = 30.0 / np.pi
    raise NumericalFailure(
        f"control: under the controller the slip reaches {largest * rpm:.6g} rpm, beyond the "
        f"motor's table, which ends at {drive.motor.largest * rpm:.6g} rpm; feed less "
        'back, give a longer table, or set machine.motor.beyond = "hold" to keep its last torque'
    )
