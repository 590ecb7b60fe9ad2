"""Rotor, pistons and shell as plain arrays: their inertia and the torques between them."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import TURN, GasForce, force_at
from vibecalc.excitation.induction_motor_flux import CircuitMotor, circuit_torque
from vibecalc.excitation.slip_torque import SlipCurve, Torque, slip_torque
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.rounding import FloatArray, IntArray

# ----------------------------------------------------------------------------
# The roll machine as plain arrays: what turns, what slides, and what holds the shell.
# ----------------------------------------------------------------------------


class RollMachine(NamedTuple):
    """Rotor, c pistons and shell in plane motion about the crank axis; SI and radians.

    Every field broadcasts over leading axes (...), for many machines at once; those with (..., c)
    have one entry for each cylinder.

    `crank_angle_offset` is what is added to the crank angle to get a cylinder's own, phase less
    bank angle. `reciprocating_mass` moves with the piston. `rod_inertia_difference` is what the
    rod's moment has beyond that of its two point masses. `rotor_inertia` is all that turns with
    the crankshaft, `shell_inertia` that of the shell without the pistons. `shell_stiffness` and
    `shell_damping` hold the shell to the ground; both zero is a free shell. `friction_torque` and
    `friction_damping` act between shell and crankshaft, `piston_friction` between each piston and
    its wall; each opposes the motion. `gas_scale` multiplies the forces of the gas, and
    `motor_scale` the torque of the motor.
    """

    crank_radius: FloatArray
    rod_length: FloatArray
    wrist_pin_offset: FloatArray
    crank_angle_offset: FloatArray
    reciprocating_mass: FloatArray
    rod_inertia_difference: FloatArray
    rotor_inertia: FloatArray
    shell_inertia: FloatArray
    shell_stiffness: FloatArray
    shell_damping: FloatArray
    friction_torque: FloatArray
    friction_damping: FloatArray
    piston_friction: FloatArray
    gas_scale: FloatArray
    motor_scale: FloatArray


class RollDrive(NamedTuple):
    """What drives it: gas forces over each cylinder's own turn, and a motor curve over its slip.

    `synchronous_speed` (...,) is that of the stator field against the shell, rad/s. A slip beyond
    the curve is an error unless `holds`, when the last torque is kept. A `circuit` takes the place
    of the curve in everything that is found by collocation over the crank angle, and there alone.
    """

    gas: tuple[GasForce | None, ...]
    motor: SlipCurve
    synchronous_speed: FloatArray
    holds: bool = False
    circuit: CircuitMotor | None = None

    @property
    def fluxes(self) -> int:
        """Number of states that the motor brings along."""
        return 0 if self.circuit is None else self.circuit.states


#: fields with one entry for each cylinder
PER_CYLINDER = frozenset(
    {
        "crank_angle_offset",
        "reciprocating_mass",
        "rod_inertia_difference",
        "gas_scale",
    }
)


def roll_machine(**fields: object) -> RollMachine:
    """A machine from numbers and lists; what is left out is zero, scales are one.

    All fields get the same leading axes; those of cylinders keep theirs behind them.
    """
    given = {name: np.asarray(value, dtype=float) for name, value in fields.items()}
    count = given["reciprocating_mass"].shape[-1]
    empty: dict[str, object] = dict.fromkeys(RollMachine._fields, 0.0)
    empty |= {"gas_scale": np.ones(count), "motor_scale": 1.0}
    filled = {name: np.asarray(given.get(name, empty[name])) for name in RollMachine._fields}
    lead = np.broadcast_shapes(
        *(v.shape[:-1] if n in PER_CYLINDER and v.ndim else v.shape for n, v in filled.items())
    )
    return RollMachine(
        **{
            name: np.broadcast_to(value, (*lead, count) if name in PER_CYLINDER else lead)
            for name, value in filled.items()
        }
    )


def is_mounted(machine: RollMachine) -> bool:
    """Whether anything holds the shell to the ground, in any of the machines."""
    return bool(np.any(machine.shell_stiffness) or np.any(machine.shell_damping))


def as_batch(machine: RollMachine) -> RollMachine:
    """The machine with one leading axis of length one, if it has none."""
    if machine.crank_radius.ndim:
        return machine
    return RollMachine(*(field[None] for field in machine))


def member(machine: RollMachine, place: int) -> RollMachine:
    """One machine of a batch, still with a leading axis."""
    return RollMachine(*(field[place : place + 1] for field in machine))


# ----------------------------------------------------------------------------
# Inertia of rotor, pistons and shell as the crank turns, and the accelerations that follow.
#
# With theta the angle of the shell, s its rate, and w the speed of the crank against the shell, the
# kinetic energy is (J s^2 + 2 N s w + Q w^2) / 2. All three depend on the crank angle b. Lagrange's
# equations (docs/theory_roll.md) are, with primes for d/db,
#
#     J ds/dt + N dw/dt + J' w s + N' w^2   = torque of the mounts on the shell,
#     N ds/dt + Q dw/dt - J' s^2/2 + Q' w^2/2 = torque between shell and crankshaft.
#
# They are what equations 81 and 88 of Herold (1977) become with their misprints corrected and the
# motion of the pistons exact.
# ----------------------------------------------------------------------------


class Inertia(NamedTuple):
    """Inertia at crank angles (..., k), kg m^2, and its derivatives by the angle.

    `shell`, `coupling` and `crank` are J, N and Q, `determinant` is J Q - N^2 without its
    cancellation. `stroke` (..., k, c) is d r/d b of each piston in m, `position` (..., k, c) is r.
    """

    shell: FloatArray
    coupling: FloatArray
    crank: FloatArray
    shell_slope: FloatArray
    coupling_slope: FloatArray
    crank_slope: FloatArray
    determinant: FloatArray
    position: FloatArray
    stroke: FloatArray
    curvature: FloatArray


def inertia(machine: RollMachine, crank_angle: FloatArray) -> Inertia:
    """Inertia of the machines (...,) at the angles (..., k) or (k,), rad."""
    angle = np.asarray(crank_angle)[..., None] + machine.crank_angle_offset[..., None, :]
    offset = machine.wrist_pin_offset[..., None, None]
    radius = machine.crank_radius[..., None, None]
    position, stroke, curvature, rod = piston_path(
        angle, radius, machine.rod_length[..., None, None], offset
    )
    mass = machine.reciprocating_mass[..., None, :]
    rotor = machine.rotor_inertia[..., None]
    moving = mass * stroke
    shell = machine.shell_inertia[..., None] + np.vecdot(mass * position, position)
    crank = np.vecdot(moving, stroke)
    shell_slope = 2.0 * np.vecdot(moving, position)
    crank_slope = 2.0 * np.vecdot(moving, curvature)
    coupling = np.zeros_like(shell)
    coupling_slope = coupling
    if machine.wrist_pin_offset.any():
        shell = shell + np.sum(mass * offset * offset, axis=-1)
        coupling = -np.sum(offset * moving, axis=-1)
        coupling_slope = -np.sum(offset * mass * curvature, axis=-1)
    if machine.rod_inertia_difference.any():
        difference = machine.rod_inertia_difference[..., None, :]
        turn, bend = _rod_turn(machine, angle, rod)
        shell = shell + np.sum(difference, axis=-1)
        coupling = coupling + np.sum(difference * turn, axis=-1)
        coupling_slope = coupling_slope + np.sum(difference * bend, axis=-1)
        crank = crank + np.sum(difference * turn * turn, axis=-1)
        crank_slope = crank_slope + 2.0 * np.sum(difference * turn * bend, axis=-1)
    # the rotor is in J, N and Q alike: formed with it, J Q - N^2 would lose what a light shell has
    determinant = rotor * (shell + crank - 2.0 * coupling) + shell * crank - coupling * coupling
    return Inertia(
        shell + rotor,
        coupling + rotor,
        crank + rotor,
        shell_slope,
        coupling_slope,
        crank_slope,
        determinant,
        position,
        stroke,
        curvature,
    )


def _rod_turn(
    machine: RollMachine, angle: FloatArray, rod: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of the rod's angle, in the crank's sense, by the crank angle."""
    radius = machine.crank_radius[..., None, None]
    lever = radius * np.cos(angle)
    height = radius * np.sin(angle)
    sine = height - machine.wrist_pin_offset[..., None, None]
    # sin(phi) = sine / L and the rod turns by -phi
    turn = -lever / rod
    return turn, height / rod - sine * lever * lever / rod**3


class Accelerations(NamedTuple):
    """Accelerations of the shell and of the crank against it, rad/s^2."""

    shell: FloatArray
    crank: FloatArray


def accelerations(
    moved: Inertia,
    crank_speed: FloatArray,
    shell_speed: FloatArray,
    shell_torque: FloatArray,
    crank_torque: FloatArray,
) -> Accelerations:
    """Accelerations under a torque on the shell from outside and one between shell and crank, N m.

    All arrays broadcast to the shape of `moved`. The determinant is positive for every machine.
    """
    square = crank_speed * crank_speed
    outer = (
        shell_torque - moved.shell_slope * crank_speed * shell_speed - moved.coupling_slope * square
    )
    inner = crank_torque + 0.5 * (
        moved.shell_slope * shell_speed * shell_speed - moved.crank_slope * square
    )
    return Accelerations(
        (moved.crank * outer - moved.coupling * inner) / moved.determinant,
        (moved.shell * inner - moved.coupling * outer) / moved.determinant,
    )


# ----------------------------------------------------------------------------
# Torques between shell and crankshaft: motor, gas, friction; and of the mounts on the shell.
# ----------------------------------------------------------------------------


def gas_forces(machine: RollMachine, drive: RollDrive, crank_angle: FloatArray) -> FloatArray:
    """Force of the gas on each piston (..., k, c), N towards the crank, at angles (..., k)."""
    lead = np.broadcast_shapes(np.shape(crank_angle), (*machine.crank_radius.shape, 1))
    forces = np.zeros((*lead, len(drive.gas)))
    for place, gas in enumerate(drive.gas):
        if gas is not None:
            angle = crank_angle + machine.crank_angle_offset[..., None, place]
            forces[..., place] = machine.gas_scale[..., None, place] * force_at(gas, angle)
    return forces


def gas_torque(moved: Inertia, forces: FloatArray) -> FloatArray:
    """Torque of the gas on the crankshaft (..., k), N m; over a turn it does the gas's work."""
    return np.asarray(-np.vecdot(forces, moved.stroke))


def motor_torque(
    machine: RollMachine,
    drive: RollDrive,
    crank_speed: FloatArray,
    interval: IntArray | None = None,
) -> Torque:
    """Steady motor torque (..., k), N m, and its slope by slip; `interval`: `slip_torque`."""
    slip = drive.synchronous_speed[..., None] - crank_speed
    value, slope = steady_curve(drive, slip, interval)
    scale = machine.motor_scale[..., None]
    return Torque(scale * value, scale * slope)


def steady_curve(drive: RollDrive, slip: FloatArray, interval: IntArray | None = None) -> Torque:
    """Torque in N m at steady slips (...,), rad/s, of one motor, by its circuit or its table."""
    if drive.circuit is not None:
        return circuit_torque(drive.circuit, slip)
    return slip_torque(drive.motor, slip, interval)


def friction_torque(machine: RollMachine, moved: Inertia, crank_speed: FloatArray) -> FloatArray:
    """Torque of friction on the crankshaft (..., k), N m, against its motion."""
    dry = machine.friction_torque[..., None] + machine.piston_friction[..., None] * np.sum(
        np.abs(moved.stroke), axis=-1
    )
    return np.asarray(
        -dry * np.sign(crank_speed) - machine.friction_damping[..., None] * crank_speed
    )


def mount_torque(
    machine: RollMachine, shell_angle: FloatArray, shell_speed: FloatArray
) -> FloatArray:
    """Torque of the mounts on the shell (..., k), N m."""
    return np.asarray(
        -machine.shell_stiffness[..., None] * shell_angle
        - machine.shell_damping[..., None] * shell_speed
    )


class AngleTerms(NamedTuple):
    """What depends on the crank angle alone, at angles (..., k).

    `gas_force` (..., k, c) as of `gas_forces`; `load` is the torque of gas and dry friction on the
    crankshaft, N m, and `drag` its viscous friction over the speed.
    """

    moved: Inertia
    gas_force: FloatArray
    load: FloatArray
    drag: FloatArray


def place_at(machine: RollMachine, drive: RollDrive, crank_angle: FloatArray) -> AngleTerms:
    """Inertia, and torque of gas and dry friction, N m, at crank angles (..., k)."""
    moved = inertia(machine, crank_angle)
    forces = gas_forces(machine, drive, crank_angle)
    load = gas_torque(moved, forces)
    if machine.friction_torque.any() or machine.piston_friction.any():
        dry = machine._replace(friction_damping=np.zeros_like(machine.friction_damping))
        load = load + friction_torque(dry, moved, np.ones(1))
    return AngleTerms(moved, forces, load, machine.friction_damping[..., None])


#: rad, the widest panel; where the crank stands across a cylinder, narrower ones if R/L is near 1
WIDEST = np.pi / 18.0
_LONG_RODS = 0.8
#: rad of the highest order on one panel
_OF_A_WAVE = 4.0


def smooth_angles(machine: RollMachine, drive: RollDrive, widest: float = WIDEST) -> FloatArray:
    """Crank angles from 0 to 2 pi (m,) between which all that hangs on the angle alone is smooth.

    Nodes of the gas tables, and with friction of the pistons their dead centres (of many machines,
    those of the first). No two are further apart than `widest`, rad; towards the angles at which a
    short rod lies across its cylinder they crowd together.
    """
    offsets = machine.crank_angle_offset.reshape(-1, len(drive.gas))[0]
    kinks, steep = [np.array([0.0, TURN])], _steep(machine)
    for gas, offset in zip(drive.gas, offsets, strict=True):
        if gas is not None:
            kinks.append(np.mod(gas.node - offset, TURN))
        if np.any(machine.piston_friction):
            kinks.append(np.mod(dead_centres(machine).reshape(-1, 2)[0] - offset, TURN))
        if len(steep):
            kinks.append(np.mod(steep - offset, TURN))
    every = np.sort(np.concatenate(kinks))
    edges = every[np.concatenate([[True], np.diff(every) > 1e-9])]
    edges[-1] = TURN
    parts = np.ceil(np.diff(edges) / (widest * (1.0 + 1e-9))).astype(int)
    start = np.repeat(edges[:-1], parts)
    place = np.arange(len(start)) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(start + place * np.repeat(np.diff(edges) / parts, parts), TURN)


def widest_panel(orders: int) -> float:
    """Width of panels, rad, on which the highest of the `orders` has less than one wave."""
    return min(WIDEST, _OF_A_WAVE / orders)


def dead_centres(machine: RollMachine) -> FloatArray:
    """Own angles (..., 2) at which crank and rod lie along one line."""
    radius, length = machine.crank_radius[..., None], machine.rod_length[..., None]
    reach = length + radius * np.array([1.0, -1.0])
    tilt = np.arcsin(machine.wrist_pin_offset[..., None] / reach)
    return np.asarray(tilt + np.array([0.0, np.pi]))


def _steep(machine: RollMachine) -> FloatArray:
    """Own angles around which the motion of a piston with a short rod changes quickly."""
    reach = np.max((machine.crank_radius + np.abs(machine.wrist_pin_offset)) / machine.rod_length)
    if reach < _LONG_RODS:
        return np.empty(0)
    width = float(np.sqrt(2.0 * (1.0 - reach)))
    steps = width * 2.0 ** np.arange(0, max(1, int(np.ceil(np.log2(WIDEST / width) + 1))))
    away = np.concatenate([-steps, [0.0], steps])
    return np.concatenate([0.5 * np.pi + away, 1.5 * np.pi + away])
