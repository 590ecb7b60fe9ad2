"""Rotor, pistons, shell and motor of a validated case as the arrays of the roll."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import FORCE_INTERPOLATIONS, gas_force
from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_fit import MotorFit, fit_induction_motor
from vibecalc.excitation.induction_motor_flux import CircuitMotor, circuit_motor
from vibecalc.excitation.induction_motor_identify import transient_inductance, with_stator_leakage
from vibecalc.excitation.slip_torque import SlipCurve, linear_motor, slip_curve
from vibecalc.kinds import working
from vibecalc.numerics.leading import side_by_side
from vibecalc.parts.crank_train import build_crank_train, moving, rod_share, working_names
from vibecalc.parts.drive_checks import suits
from vibecalc.parts.motor_tables import Motor
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch, roll_machine
from vibecalc.roll.rates import demand
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The motor of a validated case as a circuit with transients, fitted to its table of torques.
# ----------------------------------------------------------------------------

#: number of cages by their name in a case
CAGES = {"single": 1, "double": 2, "triple": 3}
DEFAULT = "double"


class FittedMotor(NamedTuple):
    """A fit with its motor, and another one that is as far off as the search leaves open.

    What differs between the two is the error that the fit brings into a result.
    """

    fit: MotorFit
    circuit: CircuitMotor
    other: CircuitMotor


def fitted_motor(motor: Motor) -> FittedMotor | None:
    """The dynamic motor of a case; None for the other kinds.

    Raises
    ------
    NumericalFailure
        No search ends in a minimum, or the table leaves parameters of the cages open.
    """
    if motor.kind != "dynamic":
        return None
    table, pairs, cages = motor.slip_table, motor.poles // 2, motor.cages or DEFAULT
    fit = fit_induction_motor(
        np.array(table.slip),
        np.array(table.torque),
        line_frequency=pairs * motor.synchronous_speed,
        pole_pairs=pairs,
        phase_voltage=motor.voltage * math.sqrt(2.0 / 3.0),
        stator_resistance=motor.stator_resistance,
        cages=CAGES[cages],
    )
    if not math.isfinite(fit.log_error):
        raise NumericalFailure(
            f"motor: the slip table does not settle the parameters of a {cages} cage, so that its "
            "transients are anybody's; ask for fewer cages with machine.motor.cages"
        )
    return FittedMotor(fit, circuit_motor(fit.motor), circuit_motor(_moved(fit)))


def _moved(fit: MotorFit) -> InductionMotor:
    """Every fitted parameter moved by the error of its logarithm, to and fro in turn."""
    share = np.asarray(fit.motor.stator_leakage) / transient_inductance(fit.motor)
    gathered = with_stator_leakage(fit.motor, 0.0)
    resistance, leakage = (
        np.asarray(part) for part in (gathered.rotor_resistance, gathered.rotor_leakage)
    )
    signs = np.where(np.arange(2 * resistance.size) % 2, -1.0, 1.0)
    factors = np.exp(fit.log_error * signs).reshape(2, -1)
    moved = gathered._replace(
        rotor_resistance=resistance * factors[0], rotor_leakage=leakage * factors[1]
    )
    return with_stator_leakage(moved, share * transient_inductance(moved))


# ----------------------------------------------------------------------------
# Rotor, pistons and shell of a validated case as the arrays that the roll is computed from.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]


class GasTable(NamedTuple):
    """Force (m + 1,) in N at a cylinder's own angles in rad; the last row repeats the first."""

    angle: Array
    force: Array


@dataclass(frozen=True, kw_only=True)
class RollParts:
    """What the roll of a machine is computed from; one entry of `gas` for each cylinder.

    A cylinder that works and has no gas, and one that does not work, has None there.
    `interpolations` are the ways in which all these tables can be read; `motor` is the motor of
    the case, whose kind says which of its fields there are.
    """

    names: tuple[str, ...]
    machine: RollMachine
    gas: tuple[GasTable | None, ...]
    gas_interpolation: str
    interpolations: tuple[str, ...]
    motor: Motor


def build_roll(case: Case) -> RollParts:
    """Arrays of a case whose motor finds the speed.

    A cylinder that [excitation] leaves out has neither gas nor, where it is stopped, mass. What
    turns at a throw counts with the rotor, at the crank radius.

    Raises ValueError for a case without rotor, shell or such a motor, which the checks refuse.
    """
    machine, options = case.machine, case.excitation
    rotor, shell, motor, written = machine.rotor, machine.shell, machine.motor, machine.crank_train
    assert rotor is not None and shell is not None and motor is not None
    train = build_crank_train(written)
    if options is not None:
        train = moving(train, options.working, options.idle)
    friction = machine.friction
    gas = gas_tables(case)
    return RollParts(
        names=train.names,
        machine=roll_machine(
            crank_radius=train.crank_radius,
            rod_length=train.rod_length,
            wrist_pin_offset=train.wrist_pin_offset,
            crank_angle_offset=train.crank_phase - train.bank_angle,
            reciprocating_mass=train.reciprocating_mass,
            rod_inertia_difference=_rod_difference(case),
            rotor_inertia=rotor.inertia + train.rotating_mass.sum(-1) * train.crank_radius**2,
            shell_inertia=shell.inertia,
            shell_stiffness=shell.stiffness,
            shell_damping=shell.damping,
            friction_torque=0.0 if friction is None else friction.torque,
            friction_damping=0.0 if friction is None else friction.viscous,
            piston_friction=0.0 if friction is None else friction.piston_force,
        ),
        gas=gas,
        gas_interpolation=written.gas_interpolation or "linear",
        interpolations=interpolations(gas),
        motor=motor,
    )


def roll_drive(parts: RollParts, gas_interpolation: str | None = None) -> RollDrive:
    """Gas forces and motor of the parts, the gas tables read as the case says or by another
    interpolation.

    Of a dynamic motor this is the table of its steady torque.
    """
    interpolation = gas_interpolation or parts.gas_interpolation
    return RollDrive(
        tuple(None if table is None else gas_force(*table, interpolation) for table in parts.gas),
        motor_curve(parts.motor),
        np.asarray(parts.motor.synchronous_speed),
        parts.motor.beyond == "hold",
    )


def motor_curve(motor: Motor) -> SlipCurve:
    """Steady torque of a motor that finds the speed, over the slip."""
    if motor.kind == "linear":
        return linear_motor(motor.gain)
    table = motor.slip_table
    return slip_curve(table.slip, table.torque, motor.interpolation or "monotone")


def gas_tables(case: Case) -> tuple[GasTable | None, ...]:
    """Gas force of every cylinder: its own table, or pressure times the area of the bore."""
    train = case.machine.crank_train
    works = working_names(train, working(case))
    tables: list[GasTable | None] = []
    for cylinder in train.cylinders:
        given, pressure = cylinder.gas_force, train.gas_pressure
        if cylinder.name not in works:
            tables.append(None)
        elif given is not None:
            tables.append(GasTable(np.array(given.crank_angle), np.array(given.force)))
        elif pressure is not None and train.bore is not None:
            area = 0.25 * math.pi * train.bore**2
            force = area * np.array(pressure.pressure)
            tables.append(GasTable(np.array(pressure.crank_angle), force))
        else:
            tables.append(None)
    return tuple(tables)


def interpolations(gas: tuple[GasTable | None, ...]) -> tuple[str, ...]:
    """The ways in which all these tables can be read; none without tables."""
    angles = [table.angle.tolist() for table in gas if table is not None]
    if not angles:
        return ()
    return tuple(
        interpolation
        for interpolation in FORCE_INTERPOLATIONS
        if all(suits(interpolation, angle) for angle in angles)
    )


def mean_demand(case: Case) -> float:
    """Mean torque in N m that gas and friction take from the motor over one turn.

    Viscous friction counts at synchronous speed.
    """
    parts = build_roll(case)
    machine, drive = as_batch(parts.machine), roll_drive(parts)
    viscous = machine.friction_damping * drive.synchronous_speed
    return float((demand(machine, drive).torque + viscous)[0])


def _rod_difference(case: Case) -> Array:
    """Moment of each rod beyond that of its two point masses, kg m^2; zero where it stands."""
    train, options = case.machine.crank_train, case.excitation
    rod, count = train.rod, len(train.cylinders)
    if rod is None or rod.inertia is None:
        return np.zeros(count)
    share = rod_share(train)
    difference = rod.inertia - rod.mass * train.rod_length**2 * share * (1.0 - share)
    if options is None or options.idle == "unloaded":
        return side_by_side([difference] * count)
    works = working_names(case.machine.crank_train, working(case))
    return side_by_side([difference if c.name in works else 0.0 for c in train.cylinders])
