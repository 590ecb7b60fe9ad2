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
from vibecalc.numerics.periodic.panels import PeriodicProblem
from vibecalc.numerics.rounding import BoolArray, FloatArray, IntArray
from vibecalc.roll.mechanism import (
    AngleTerms,
    RollDrive,
    RollMachine,
    accelerations,
    is_mounted,
    motor_torque,
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


def terms_of_turn(machine: RollMachine, drive: RollDrive, edges: FloatArray) -> TermsOfTurn:
    """What depends on the crank angle alone, over a turn whose smooth angles are `edges`."""
    rule = gauss_rule(POINTS_OF_TERMS)
    widths = np.diff(edges)[:, None]
    angle = (edges[:-1, None] + widths * rule.nodes).ravel()
    every = np.broadcast_to(angle, (*machine.crank_radius.shape, len(angle)))
    weight = (widths * rule.weights).ravel()
    return TermsOfTurn(edges, angle, weight, place_at(machine, drive, every))


class Rates(NamedTuple):
    """dy/db (..., k, n) and its Jacobian (..., k, n, n)."""

    value: FloatArray
    jacobian: FloatArray


def free_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: AngleTerms,
    momentum: FloatArray,
    speed: FloatArray,
    interval: IntArray | None = None,
    driving: Torque | None = None,
) -> tuple[FloatArray, FloatArray]:
    """dw/db and its derivative by w (..., k) for a free shell with angular momentum (...,).

    `driving` replaces the steady torque of the motor at the slip.
    """
    moved = place.moved
    motor, slope = driving or motor_torque(machine, drive, speed, interval)
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


def mounted_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: AngleTerms,
    state: FloatArray,
    interval: IntArray | None = None,
    driving: Torque | None = None,
) -> Rates:
    """dy/db for y = (w, shell angle, s) (..., k, 3), the shell held by mounts; see `free_rates`."""
    speed, angle, shell = state[..., 0], state[..., 1], state[..., 2]
    moved = place.moved
    motor, slope = driving or motor_torque(machine, drive, speed, interval)
    stiffness, damping = machine.shell_stiffness[..., None], machine.shell_damping[..., None]
    outer = -stiffness * angle - damping * shell
    inner = motor + place.load - place.drag * speed
    accelerated = accelerations(moved, speed, shell, outer, inner)
    value = np.stack([accelerated.crank, shell, accelerated.shell], axis=-1) / speed[..., None]

    # derivatives of the two torques by w, angle, s
    outer_by = np.stack(
        [
            -moved.shell_slope * shell - 2.0 * moved.coupling_slope * speed,
            np.broadcast_to(-stiffness, speed.shape),
            -damping - moved.shell_slope * speed,
        ],
        axis=-1,
    )
    inner_by = np.stack(
        [
            -slope - place.drag - moved.crank_slope * speed,
            np.zeros_like(speed),
            moved.shell_slope * shell,
        ],
        axis=-1,
    )
    j, n, q, over = (
        np.asarray(part)[..., None]
        for part in (moved.shell, moved.coupling, moved.crank, moved.determinant * speed)
    )
    jacobian = np.zeros((*speed.shape, 3, 3))
    jacobian[..., 0, :] = (j * inner_by - n * outer_by) / over
    jacobian[..., 1, 2] = 1.0 / speed
    jacobian[..., 2, :] = (q * outer_by - n * inner_by) / over
    jacobian[..., :, 0] -= value / speed[..., None]
    return Rates(value, jacobian)


def shell_speed(place: AngleTerms, momentum: FloatArray, speed: FloatArray) -> FloatArray:
    """Angular speed s of a free shell with angular momentum (...,), at crank speeds (..., k)."""
    return np.asarray((momentum[..., None] - place.moved.coupling * speed) / place.moved.shell)


# ----------------------------------------------------------------------------
# Rates over the crank angle where the fluxes of the motor are states.
#
# The motor's equations hold in time, df/dt = (A + w B) f + u with T = f' S f / 2
# (`excitation/induction_motor_flux.py`); with the crank angle for time they are divided by w, as
# the others are. They reach the machine through the torque alone, and the machine them through w.
# ----------------------------------------------------------------------------


def driven_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: AngleTerms,
    momentum: FloatArray | None,
    state: FloatArray,
) -> Rates:
    """dy/db (..., k, n) and Jacobian for y = (w, fluxes) or (w, shell angle, s, fluxes).

    `momentum` (...,) is that of a free shell, None with mounts; `drive.circuit` is the motor.
    """
    circuit = motor_of(drive)
    speed = state[..., 0]
    rigid = state.shape[-1] - circuit.states
    flux = state[..., rigid:]
    scale = machine.motor_scale[..., None]
    pull = flux_torque(circuit.system, flux)
    driving = Torque(scale * pull.value, np.zeros_like(speed))
    moved = place.moved
    value, jacobian = np.empty_like(state), np.zeros((*state.shape, state.shape[-1]))
    if momentum is not None:
        rate, slope = free_rates(machine, drive, place, momentum, speed, None, driving)
        value[..., 0], jacobian[..., 0, 0] = rate, slope
        answer = (moved.shell / moved.determinant)[..., None]
    else:
        mounted = mounted_rates(machine, drive, place, state[..., :rigid], None, driving)
        value[..., :rigid], jacobian[..., :rigid, :rigid] = mounted.value, mounted.jacobian
        parts = (moved.shell, np.zeros_like(moved.shell), -moved.coupling)
        answer = np.stack(parts, axis=-1) / moved.determinant[..., None]
    # what a newton metre more of the motor does to w, shell angle and s, over w
    answer = answer / speed[..., None]
    jacobian[..., :rigid, rigid:] = (
        answer[..., None] * (scale[..., None] * pull.by_flux)[..., None, :]
    )
    moving = flux_rates(circuit.system, flux, speed)
    over = (speed * circuit.pace)[..., None]
    value[..., rigid:] = moving.rates / over
    jacobian[..., rigid:, rigid:] = moving.by_flux / over[..., None]
    jacobian[..., rigid:, 0] = moving.by_speed / over - value[..., rigid:] / speed[..., None]
    return Rates(value, jacobian)


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
    if drive.circuit is None:
        raise ValueError("the motor of this drive has no fluxes")
    return drive.circuit


# ----------------------------------------------------------------------------
# The periodic problem of a roll machine, as `numerics.periodic_panels` takes it.
# ----------------------------------------------------------------------------


class RollRates:
    """dy/db at (B, P, s) crank angles; what depends on the angle alone is kept with it.

    For a free shell y = (w,) and `momentum` (B,) is its angular momentum; else y = (w, shell angle,
    shell speed) and `momentum` is None. The fluxes of a motor with transients follow behind.
    """

    def __init__(self, machine: RollMachine, drive: RollDrive, momentum: FloatArray | None):
        self.machine, self.drive, self.momentum = machine, drive, momentum
        self.evaluations = 0
        self._angles: FloatArray | None = None
        self._place: AngleTerms | None = None

    def keep(self, terms: TermsOfTurn) -> None:
        """Take terms that are known for what the first panels ask for."""
        members, panels = len(terms.place.load), len(terms.edges) - 1
        self._angles = np.broadcast_to(
            terms.angle.reshape(panels, -1), (members, panels, POINTS_OF_TERMS)
        )
        self._place = terms.place

    def place(self, crank_angle: FloatArray) -> AngleTerms:
        """Inertia and torques at the angles (B, P, s), as (B, P s)."""
        if self._place is None or not self._known(crank_angle):
            flat = crank_angle.reshape(len(crank_angle), -1)
            self._place = place_at(self.machine, self.drive, flat)
            self._angles = crank_angle
        return self._place

    def _known(self, crank_angle: FloatArray) -> bool:
        known = self._angles
        return known is crank_angle or (known is not None and np.array_equal(known, crank_angle))

    def __call__(
        self, crank_angle: FloatArray, state: FloatArray, interval: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        members, panels, points = crank_angle.shape
        self.evaluations += crank_angle.size
        place = self.place(crank_angle)
        flat = state.reshape(members, panels * points, -1)
        if self.drive.fluxes:
            safe = np.where(flat[..., :1] > 0.0, flat, np.nan)
            evaluated = driven_rates(self.machine, self.drive, place, self.momentum, safe)
            return evaluated.value.reshape(state.shape), evaluated.jacobian.reshape(
                *state.shape, state.shape[-1]
            )
        chosen = None if interval is None else np.repeat(interval, points, axis=1)
        if self.momentum is not None:
            speed = np.where(flat[..., 0] > 0.0, flat[..., 0], np.nan)
            rate, slope = free_rates(self.machine, self.drive, place, self.momentum, speed, chosen)
            return rate.reshape(state.shape), slope.reshape(*state.shape, 1)
        safe = np.where(flat[..., :1] > 0.0, flat, np.nan)
        evaluated = mounted_rates(self.machine, self.drive, place, safe, chosen)
        return evaluated.value.reshape(state.shape), evaluated.jacobian.reshape(*state.shape, 3)

    def slip(self, state: FloatArray) -> FloatArray:
        """Slip speed at states (B, P, s, n); the interval of the motor's curve follows from it."""
        return np.asarray(self.drive.synchronous_speed[..., None, None] - state[..., 0])


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
