"""How the state of the machine changes with the crank angle: the periodic problem and its means."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.induction_motor_flux import (
    CircuitMotor,
    flux_rates,
    flux_torque,
    steady_flux,
)
from vibecalc.excitation.slip_torque import Torque, breakdown, rising_branch
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.panels import PeriodicProblem, PeriodicSolution, running_integral
from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray
from vibecalc.roll.mechanism import (
    AngleTerms,
    RollDrive,
    RollMachine,
    accelerations,
    is_mounted,
    motor_torque,
    mount_torque,
    place_at,
    smooth_angles,
    steady_curve,
)
from vibecalc.roll.turn import Turn

# ----------------------------------------------------------------------------
# How the state of the machine changes with the crank angle: what a periodic motion solves.
#
# While the crank turns one way, the crank angle b can stand for time: a motion that repeats every
# turn is then a solution of dy/db = f(b, y) of period 2 pi, with the period in time as a result and
# no phase left open. A free shell drops out with its angular momentum H:
#
#     mu w dw/db + mu' w^2 / 2 - H^2 J' / (2 J^2) = torque,   mu = Q - N^2 / J,   s = (H - N w) / J,
#
# one equation for the speed w of the crank. With mounts the state is w, the angle of the shell and
# s. (Own derivation; inertias as in `inertia.py`.)
# ----------------------------------------------------------------------------


#: Gauss points of a panel at which terms of a turn are taken
POINTS_OF_TERMS = 4


class TermsOfTurn(NamedTuple):
    """Angle terms (..., k) at the Gauss points of all panels between `edges` (P + 1,), k = P s."""

    edges: FloatArray
    angle: FloatArray
    weight: FloatArray
    place: AngleTerms


def terms_of_turn(
    machine: RollMachine, drive: RollDrive, edges: FloatArray, points: int = POINTS_OF_TERMS
) -> TermsOfTurn:
    """What depends on the crank angle alone, over a turn whose smooth angles are `edges`."""
    rule = gauss_rule(points)
    widths = np.diff(edges)[:, None]
    angle = (edges[:-1, None] + widths * rule.nodes).ravel()
    every = np.broadcast_to(angle, (*machine.crank_radius.shape, len(angle)))
    weight = (widths * rule.weights).ravel()
    return TermsOfTurn(edges, angle, weight, place_at(machine, drive, every))


def free_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: AngleTerms,
    momentum: FloatArray,
    speed: FloatArray,
    interval: IntArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """dw/db and its derivative by w (..., k) for a free shell with angular momentum (...,).

    The form of `RollRates.at` that sweeps of machines with a steady curve run.
    """
    moved = place.moved
    motor, slope = motor_torque(machine, drive, speed, interval)
    share = moved.coupling / moved.shell
    effective = moved.determinant / moved.shell
    steep = (
        moved.crank_slope - 2.0 * share * moved.coupling_slope + share * share * moved.shell_slope
    )
    drift = momentum[..., None] / moved.shell
    torque = motor + place.load - place.drag * speed + 0.5 * drift * drift * moved.shell_slope
    rate = (torque / speed - 0.5 * steep * speed) / effective
    change = (-torque / speed - slope - place.drag) / speed - 0.5 * steep
    return rate, change / effective


def shell_speed(place: AngleTerms, momentum: FloatArray, speed: FloatArray) -> FloatArray:
    """Angular speed s of a free shell with angular momentum (...,), at crank speeds (..., k)."""
    return np.asarray((momentum[..., None] - place.moved.coupling * speed) / place.moved.shell)


def driving_torque(machine: RollMachine, drive: RollDrive, state: FloatArray) -> FloatArray | None:
    """Torque of the motor (..., k), N m, from states (..., k, n); None if it follows from the slip.

    The fluxes are the last states.
    """
    if drive.circuit is None or not drive.fluxes:
        return None
    flux = state[..., state.shape[-1] - drive.fluxes :]
    return np.asarray(
        machine.motor_scale[..., None] * flux_torque(drive.circuit.system, flux).value
    )


def with_steady_flux(drive: RollDrive, state: FloatArray) -> FloatArray:
    """States (..., n) whose first is w, with the fluxes that a steady slip would have, if any."""
    if drive.circuit is None or not drive.fluxes:
        return state
    slip = np.max(drive.synchronous_speed) - state[..., 0]
    return np.concatenate([state, steady_flux(drive.circuit.motor, slip).value], axis=-1)


def motor_of(drive: RollDrive) -> CircuitMotor:
    """The motor whose fluxes are states; ValueError if there is none."""
    assert drive.circuit is not None
    return drive.circuit


# ----------------------------------------------------------------------------
# The periodic problem of a roll machine, as `numerics.periodic_panels` takes it.
# ----------------------------------------------------------------------------


class Bare(NamedTuple):
    """Accelerations (..., k) without the torque of the motor, their slopes by the states
    (..., k, n), and what one N m of it adds.
    """

    shell: FloatArray
    crank: FloatArray
    shell_by: FloatArray
    crank_by: FloatArray
    shell_gain: FloatArray
    crank_gain: FloatArray


class RollRates:
    """dy/db at (B, P, s) crank angles; what depends on the angle alone is kept with it.

    For a free shell y = (w,) and `momentum` (B,) is its angular momentum; else y = (w, shell angle,
    shell speed) and `momentum` is None. The fluxes of a motor with transients follow behind: their
    equations hold in time, df/dt = (A + w B) f + u with T = f' S f / 2
    (`excitation/induction_motor_flux.py`), and reach the machine through the torque alone.
    """

    def __init__(self, machine: RollMachine, drive: RollDrive, momentum: FloatArray | None):
        self.machine, self.drive, self.momentum = machine, drive, momentum
        self.rigid = 3 if momentum is None else 1
        self.evaluations = 0
        self._angles: FloatArray | None = None
        self._place: AngleTerms | None = None

    def place(self, crank_angle: FloatArray) -> AngleTerms:
        """Inertia and torques at the angles (B, P, s), as (B, P s)."""
        known = self._angles
        same = known is crank_angle or (known is not None and np.array_equal(known, crank_angle))
        if self._place is None or not same:
            flat = crank_angle.reshape(len(crank_angle), -1)
            self._place = place_at(self.machine, self.drive, flat)
            self._angles = crank_angle
        return self._place

    def __call__(
        self, crank_angle: FloatArray, state: FloatArray, interval: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        members, panels, points = crank_angle.shape
        self.evaluations += crank_angle.size
        flat = state.reshape(members, panels * points, -1)
        flat = np.where(flat[..., :1] > 0.0, flat, np.nan)
        chosen = None if interval is None else np.repeat(interval, points, axis=1)
        value, jacobian = self.at(self.place(crank_angle), flat, chosen)
        return value.reshape(state.shape), jacobian.reshape(*state.shape, state.shape[-1])

    def at(
        self, place: AngleTerms, state: FloatArray, interval: IntArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """dy/db (B, k, n) and its Jacobian (B, k, n, n) at places of known terms."""
        if self.momentum is not None and state.shape[-1] == 1:
            parts = (self.machine, self.drive, place, self.momentum, state[..., 0], interval)
            rate, change = free_rates(*parts)
            return rate[..., None], change[..., None, None]
        return self._of_all(place, state, interval)

    def _of_all(
        self, place: AngleTerms, state: FloatArray, interval: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        speed, bare = state[..., 0], self.bare(place, state)
        torque, torque_by = self.driving(bare, state, interval)
        shell = bare.shell + bare.shell_gain * torque
        shell_by = bare.shell_by + bare.shell_gain[..., None] * torque_by
        value, by = np.empty_like(state), np.zeros((*state.shape, state.shape[-1]))
        value[..., 0] = bare.crank + bare.crank_gain * torque
        by[..., 0, :] = bare.crank_by + bare.crank_gain[..., None] * torque_by
        if self.momentum is None:
            value[..., 1], by[..., 1, 2] = state[..., 2], 1.0
            value[..., 2], by[..., 2, :] = shell, shell_by
        if state.shape[-1] > self.rigid:
            further = self.further(state, shell, shell_by)
            value[..., self.rigid :], by[..., self.rigid :, :] = further
        value /= speed[..., None]
        by /= speed[..., None, None]
        by[..., :, 0] -= value / speed[..., None]
        return value, by

    def bare(self, place: AngleTerms, state: FloatArray) -> Bare:
        """Rotor, shell and load at states (B, k, n), all but the motor."""
        moved, speed = place.moved, state[..., 0]
        outer, outer_by = np.zeros_like(speed), np.zeros(state.shape)
        inner_by = np.zeros(state.shape)
        # the speed of a free shell is no state: it follows the crank's
        row, rate = 2, np.ones_like(speed)
        if self.momentum is not None:
            shell = shell_speed(place, self.momentum, speed)
            row, rate = 0, np.asarray(-moved.coupling / moved.shell)
        else:
            shell = state[..., 2]
            outer = mount_torque(self.machine, state[..., 1], shell)
            outer_by[..., 1] = -self.machine.shell_stiffness[..., None]
            outer_by[..., 2] = -self.machine.shell_damping[..., None]
        inner = place.load - place.drag * speed
        outer_by[..., 0] -= moved.shell_slope * shell + 2.0 * moved.coupling_slope * speed
        inner_by[..., 0] = -place.drag - moved.crank_slope * speed
        outer_by[..., row] -= moved.shell_slope * speed * rate
        inner_by[..., row] += moved.shell_slope * shell * rate
        j, n, q, over = moved.shell, moved.coupling, moved.crank, moved.determinant
        wide = [part[..., None] for part in np.broadcast_arrays(j, n, q, over)]
        return Bare(
            *accelerations(moved, speed, shell, outer, inner),
            (wide[2] * outer_by - wide[1] * inner_by) / wide[3],
            (wide[0] * inner_by - wide[1] * outer_by) / wide[3],
            np.asarray(-n / over),
            np.asarray(j / over),
        )

    def driving(self, bare: Bare, state: FloatArray, interval: IntArray | None) -> Torque:
        """Torque of the motor (B, k), N m, and its slopes by the states (B, k, n)."""
        by = np.zeros(state.shape)
        if self.drive.fluxes:
            scale = self.machine.motor_scale[..., None]
            pull = flux_torque(motor_of(self.drive).system, state[..., self.rigid :])
            by[..., self.rigid :] = scale[..., None] * pull.by_flux
            return Torque(scale * pull.value, by)
        motor = motor_torque(self.machine, self.drive, state[..., 0], interval)
        by[..., 0] = -motor.slope
        return Torque(motor.value, by)

    def further(
        self, state: FloatArray, shell: FloatArray, shell_by: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Rates in time of the states behind those of crank and shell, and their slopes by all.

        `shell` is the acceleration of the shell with its slopes `shell_by`.
        """
        circuit = motor_of(self.drive)
        moving = flux_rates(circuit.system, state[..., self.rigid :], state[..., 0])
        by = np.zeros((*moving.rates.shape, state.shape[-1]))
        by[..., 0], by[..., self.rigid :] = moving.by_speed, moving.by_flux
        return moving.rates / circuit.pace, by / circuit.pace

    def slip(self, state: FloatArray) -> FloatArray:
        """Slip speed at states (B, P, s, n); the interval of the motor's curve follows from it."""
        return np.asarray(self.drive.synchronous_speed[..., None, None] - state[..., 0])


def turn_of(rates: RollRates, solution: PeriodicSolution) -> Turn:
    """The turns (B,) of a solution at its points."""
    members, states = len(solution.edges), solution.stages
    speed = states[..., 0]
    time, ends = running_integral(solution.edges, 1.0 / speed)
    if rates.momentum is None:
        angle, shell = states[..., 1], states[..., 2]
    else:
        place = rates.place(solution.nodes)
        shell = shell_speed(place, rates.momentum, speed.reshape(members, -1)).reshape(speed.shape)
        # the angle of a free shell is anybody's: it counts from where the turn begins
        angle, _ = running_integral(solution.edges, shell / speed)
    b, weight, t, w, s, theta = (
        part.reshape(members, -1)
        for part in (solution.nodes, solution.weights, time, speed, shell, angle)
    )
    driving = driving_torque(
        rates.machine, rates.drive, states.reshape(members, -1, states.shape[-1])
    )
    return Turn(b, weight, t, w, s, theta, ends[:, -1], driving)


def roll_problem(
    machine: RollMachine,
    drive: RollDrive,
    momentum: FloatArray | None,
    edges: FloatArray | None = None,
) -> tuple[PeriodicProblem, RollRates]:
    """Problem and right-hand side of the machines (B,); their gas tables stand at equal angles.

    `edges` are the smooth angles of these machines, if they are known.
    """
    rates = RollRates(machine, drive, momentum)
    edges = smooth_angles(machine, drive) if edges is None else edges
    has_kinks = len(drive.motor.threshold) > 0 and drive.circuit is None
    if momentum is None:
        scale = mounted_scale(machine, drive)
    else:
        scale = np.array([float(drive.synchronous_speed.max())])
    if drive.circuit is not None and drive.fluxes:
        scale = np.append(scale, np.full(drive.fluxes, drive.circuit.flux_size))
    return (
        PeriodicProblem(
            rates,
            edges,
            rates.slip if has_kinks else None,
            drive.motor.threshold if has_kinks else None,
            scale,
        ),
        rates,
    )


def mounted_scale(machine: RollMachine, drive: RollDrive) -> FloatArray:
    """Sizes of crank speed, shell angle and shell speed (3,), to weigh corrections with."""
    speed = float(np.max(drive.synchronous_speed))
    share = float(np.max(machine.rotor_inertia / (machine.shell_inertia + machine.rotor_inertia)))
    # a few per cent of the crank's speed go to and fro
    return np.array([speed, 0.05 * share, 0.05 * share * speed])


# ----------------------------------------------------------------------------
# What the machine asks of its motor on average, and the slip at which the motor gives it.
# ----------------------------------------------------------------------------

#: slips examined, over that of the peak
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
    """Slip (rad/s) and torque (N m) of the peak of a motor's steady curve, infinite if linear."""
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
        peak, least = rising_branch(drive.motor)
    else:
        peak, least = steady_breakdown(drive)[0], 0.0
    # far above synchronous speed the torque that brakes falls again
    braking = steady_curve(drive, np.min(slip, axis=-1)).value
    return np.asarray((np.max(slip, axis=-1) <= peak) & (braking >= -least))


def demand(machine: RollMachine, drive: RollDrive, terms: TermsOfTurn | None = None) -> Demand:
    """Mean demand of the machines (B,) and the slip that meets it.

    The mean over the crank angle of all torques between shell and crankshaft is zero in a periodic
    motion, so a demand above the breakdown torque rules one out. `terms` are those of these
    machines, if they are known.
    """
    if terms is None:
        terms = terms_of_turn(machine, drive, smooth_angles(machine, drive))
    asked = -(terms.place.load @ terms.weight) / (2.0 * np.pi)
    speed = np.broadcast_to(drive.synchronous_speed, asked.shape)
    peak, most = steady_breakdown(drive)
    if not np.isfinite(peak):
        gain = machine.motor_scale * drive.motor.coefficient[0, 1]
        slip = (asked + machine.friction_damping * speed) / (gain + machine.friction_damping)
        return Demand(asked, np.full(asked.shape, np.inf), np.where(slip < speed, slip, np.nan))
    slips = peak * _GRID
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
