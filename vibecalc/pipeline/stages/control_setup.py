"""Adapter, before the control: the reduced model of a machine, its load and its target."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.control_tables import Control
from vibecalc.case.schema import Case
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import breakdown
from vibecalc.machine.roll import build_roll, roll_drive
from vibecalc.numerics.rounding import WithError
from vibecalc.response.roll.machine import RollDrive, RollMachine, as_batch
from vibecalc.response.roll_control.disturbance import Disturbance, disturbance
from vibecalc.response.roll_control.evaluate import Load
from vibecalc.response.roll_control.model import Controller, ReducedModel, model_from_full
from vibecalc.response.roll_control.model import source_model as rotor_alone
from vibecalc.response.roll_control.motor_gains import UNCONTROLLED
from vibecalc.response.roll_control.steady import steady_speed
from vibecalc.response.roll_control.tangent import tangent


class Setup(NamedTuple):
    """Machine and drive for the full model; reduced model, load and speeds for the reduced one.

    `gain` is the motor's, `offset` its torque at no slip, `breakdown` its largest one; `alone` is
    the speed without control.
    """

    options: Control
    machine: RollMachine
    drive: RollDrive
    model: ReducedModel
    torque: Disturbance
    gain: float
    offset: float
    breakdown: float
    synchronous: float
    reference: float
    alone: WithError
    target: float
    orders: np.ndarray

    def load(
        self, speed: float, reference: float | None = None, offset: float | None = None
    ) -> Load:
        """Load at a mean speed; the torque of the motor at no slip counts with it."""
        at = self.torque.at(speed)
        own = self.offset if offset is None else offset
        mean = self.torque.mean
        speed_of_field = self.reference if reference is None else reference
        return Load(speed_of_field, float(mean.value) + own, at.value, float(mean.error), at.error)

    def kept(self, levels: WithError) -> WithError:
        """The orders that the case asks for; a search may need more."""
        count = len(self.orders)
        return WithError(levels.value[..., :count], levels.error[..., :count])

    def controller(self) -> Controller:
        """Gain, feedback, lag and delay of the case; the speed feedback is zero unless given."""
        options = self.options
        return Controller(
            options.gain, options.speed_feedback or 0.0, options.acceleration_feedback,
            options.actuator_lag, options.delay,
        )  # fmt: skip


def setup(case: Case) -> Setup:
    """Everything that the parts of the stage share.

    Raises NumericalFailure where the motor does not give what the machine takes.
    """
    if case.response is None or case.response.control is None:
        raise ValueError("the case has no [response.control]")
    options, parts = case.response.control, build_roll(case)
    machine = as_batch(parts.machine)
    drive = roll_drive(parts)._replace(circuit=None)
    found = disturbance(machine, drive, max(options.orders, *_tuned(options)))
    gain, offset = options.motor_gain, 0.0
    if gain is None:
        line = tangent(machine, drive)
        gain, offset = line.gain, line.offset
    drag = float(machine.friction_damping[0])
    if options.reduction == "rotor":
        shell = float(machine.shell_inertia[0])
        model = rotor_alone(float(machine.rotor_inertia[0]), shell, gain)._replace(viscous=drag)
    else:
        model = model_from_full(found.whole, found.coupling, found.crank, gain, drag)
    synchronous = float(np.max(drive.synchronous_speed))
    most = float(machine.motor_scale[0]) * breakdown(drive.motor)[1]
    alone = steady_speed(model, UNCONTROLLED, synchronous, float(found.mean.value) + offset)
    alone = WithError(alone.value, alone.error + found.mean.error / gain)
    if not alone.value > 0.0:
        raise NumericalFailure(
            f"control: a motor of {gain:.6g} N*m*s/rad does not carry the mean torque of "
            f"{-found.mean.value:.6g} N*m below its synchronous speed of {synchronous:.6g} rad/s"
        )
    return Setup(
        options, machine, drive, model, found, gain, offset, most, synchronous,
        synchronous if options.reference is None else options.reference, alone,
        float(alone.value) if options.target_speed is None else options.target_speed,
        np.arange(1, options.orders + 1),
    )  # fmt: skip


def _tuned(options: Control) -> tuple[int, ...]:
    return (0,) if options.tune is None else options.tune.orders
