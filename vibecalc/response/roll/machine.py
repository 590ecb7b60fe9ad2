"""The roll machine as plain arrays: what turns, what slides, and what holds the shell."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import GasForce
from vibecalc.excitation.induction_motor_flux import CircuitMotor
from vibecalc.excitation.slip_torque import SlipCurve
from vibecalc.numerics.typing import FloatArray


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
