"""Rates over the crank angle where the fluxes of the motor are states.

The motor's equations hold in time, df/dt = (A + w B) f + u with T = f' S f / 2
(`excitation/induction_motor_flux.py`); with the crank angle for time they are divided by w, as the
others are. They reach the machine through the torque alone, and the machine them through w.
"""

import numpy as np

from vibecalc.excitation.induction_motor_flux import (
    CircuitMotor,
    flux_rates,
    flux_torque,
    steady_flux,
)
from vibecalc.excitation.slip_torque import Torque
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.rates import Place, Rates, free_rates, mounted_rates


def driven_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: Place,
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
        found = mounted_rates(machine, drive, place, state[..., :rigid], None, driving)
        value[..., :rigid], jacobian[..., :rigid, :rigid] = found.value, found.jacobian
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
