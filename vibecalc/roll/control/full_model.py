"""The full machine where a controller feeds the motor: rates, running state, stability."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import Torque, slip_torque
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import floquet_multipliers
from vibecalc.numerics.periodic.panels import PeriodicProblem, PeriodicSolution, evaluate
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.roll.mechanism import AngleTerms, RollDrive, RollMachine, is_mounted, smooth_angles
from vibecalc.roll.rates import Bare, RollRates, demand, mounted_scale, turn_of
from vibecalc.roll.steady import resting_momentum, still_momentum
from vibecalc.roll.turn import Turn, shell_harmonics

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


class ControlledRates(RollRates):
    """`RollRates` of a machine under control; with a lag of the actuator u follows behind."""

    def __init__(
        self, machine: RollMachine, drive: RollDrive, law: Law, momentum: FloatArray | None
    ):
        super().__init__(machine, drive, momentum)
        self.law, self.states = law, self.rigid + (law.lag > 0.0)

    def at(
        self, place: AngleTerms, state: FloatArray, interval: IntArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """As that of any motor: the torque is no function of the crank's speed alone."""
        return self._of_all(place, state, interval)

    def slip(self, state: FloatArray) -> FloatArray:
        """Slip at states (B, P, s, n) of an actuator with a lag."""
        return np.asarray(state[..., -1] - state[..., 0])

    def further(
        self, state: FloatArray, shell: FloatArray, shell_by: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """What the actuator does."""
        asked, by = self._asked(state[..., 0], shell, shell_by)
        by[..., -1] -= 1.0
        lag = self.law.lag
        return ((asked - state[..., -1]) / lag)[..., None], (by / lag)[..., None, :]

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

    def driving(self, bare: Bare, state: FloatArray, interval: IntArray | None) -> Torque:
        """Torque of the motor whose field the actuator sets, and its slopes by the states."""
        return self.motor(bare, state, interval)[1]

    def motor(
        self, bare: Bare, state: FloatArray, interval: IntArray | None = None
    ) -> tuple[FloatArray, Torque]:
        """Slip (B, k), rad/s, with the torque and its slopes."""
        law, scale = self.law, self.machine.motor_scale[..., None]
        speed = state[..., 0]
        if law.lag > 0.0:
            slip = state[..., -1] - speed
            curve = slip_torque(self.drive.motor, slip, interval)
            by = np.zeros(state.shape)
            by[..., 0], by[..., -1] = -scale * curve.slope, scale * curve.slope
            return slip, Torque(scale * curve.value, by)
        asked, by = self._asked(speed, bare.shell, bare.shell_by)
        back = law.gain * law.acceleration_feedback * bare.shell_gain * scale
        slip = self._implicit(asked - speed, back)
        curve = slip_torque(self.drive.motor, slip, interval)
        by[..., 0] -= 1.0
        # a loop that answers itself more than once has no motion of its own
        firm = 1.0 + back * curve.slope
        slope = np.where(firm > 0.0, scale * curve.slope / firm, np.nan)
        return slip, Torque(scale * curve.value, slope[..., None] * by)

    def slip_at(self, angle: FloatArray, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Slip and torque (B, k) at crank angles (B, P, s) and states (B, k, n)."""
        slip, torque = self.motor(self.bare(self.place(angle), state), state)
        return slip, torque.value

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

    def level_of_turn(closed: ClosedLoopTurn) -> ComplexArray:
        return np.asarray(shell_harmonics(machine, drive, closed.turn, orders)[0])

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
    size = np.max(np.abs(closed.torque)) / float(machine.shell_inertia[0])
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
    momentum = resting_momentum(machine, constant[:, 0]) if free else None
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
            rates.slip if switched else None,
            drive.motor.threshold if switched else None,
            scale,
        )
        solution = solve_periodic(problem, points, guess)
        turn = turn_of(rates, solution)
        if not solution.converged[0] or not np.all(turn.crank_speed > 0.0):
            raise NumericalFailure(
                "control: Newton's method found no running state of the full model under control, "
                f"with a gain of {law.gain:g} and a feedback of {law.acceleration_feedback:g} s: "
                "the motor may not be able to give the torque that this asks for. Feed less back, "
                "or set full_model = false"
            )
        guess, still = solution, True
        if momentum is not None:
            wanted = still_momentum(machine, turn.crank_angle, turn.weight, turn.crank_speed)
            still = bool(abs(wanted[0] - momentum[0]) <= _STILL * abs(wanted[0]))
            momentum = wanted
        if kinked and not lagged:
            moved = _with_kinks(base, rates, solution)
            same = moved.shape == edges.shape
            still &= same and bool(np.max(np.abs(moved - edges)) <= _EDGES_STAND)
            edges = moved
        if still:
            break
    slip, torque = rates.slip_at(solution.nodes, solution.stages.reshape(1, -1, rates.states))
    return ClosedLoopTurn(turn._replace(motor_torque=torque), slip, torque, problem, solution)


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


def _with_kinks(base: FloatArray, rates: ControlledRates, solution: PeriodicSolution) -> FloatArray:
    """The edges with every angle at which the slip meets a node of the motor's curve."""

    def slip(angle: FloatArray) -> FloatArray:
        return np.asarray(rates.slip_at(angle[None, None], evaluate(solution, angle))[0][0])

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
        'back, give a longer table, or set machine.motor.extrapolation = "hold" to keep its last '
        "torque"
    )
