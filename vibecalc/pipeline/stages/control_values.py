"""Adapter, shared by the parts of the control: values with errors put into the record."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.entries.roll_control import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.control_setup import Setup
from vibecalc.response.roll_control.evaluate import Controlled


def put(scene: Scene, name: str, found: WithError, axes: Mapping[str, Any] | None = None) -> None:
    """Emit one value with its error below the root of the stage."""
    scene.emit(f"{ROOT}/{name}", found.value, found.error, axes)


def emit_loop(
    scene: Scene, below: str, found: Controlled, given: Setup,
    axes: Mapping[str, Any] | None = None,
) -> None:  # fmt: skip
    """Status, margins and demands on the actuator; a loop that is not stable has no margins."""
    margins = found.margins
    rounding = 8.0 * EPSILON * np.abs(margins.feedthrough)
    for name, value in {
        "status": WithError(margins.status, np.zeros(())),
        "gain_margin": factor_in_decibels(margins.gain),
        "gain_reduction": factor_in_decibels(margins.gain_lower),
        "phase_margin": margins.phase,
        "delay_margin": margins.delay,
        "bandwidth": margins.bandwidth,
        "feedthrough": WithError(margins.feedthrough, rounding),
        "command_rate": found.command_rate,
        "torque_peak": torque_peak(found, given),
    }.items():
        put(scene, below + name, value, axes)


def torque_peak(found: Controlled, given: Setup) -> WithError:
    """Largest torque of the motor over a turn of the reduced model; infinite if not stable.

    In the mean it carries the load and viscous friction.
    """
    drag = float(given.machine.friction_damping[0])
    mean = drag * found.speed.value - float(given.torque.mean.value)
    stable = found.margins.stable
    harmonics, error = found.harmonics.motor_torque
    known = np.where(stable[..., None], harmonics, 0.0)
    orders = np.arange(harmonics.shape[-1] + 1)
    peak = cycle_peak(np.concatenate([mean[..., None] + 0j, known], axis=-1), orders)
    doubt = peak.error + np.sum(error, axis=-1) + drag * found.speed.error
    doubt = doubt + float(given.torque.mean.error)
    return WithError(np.where(stable, peak.value, np.inf), np.where(stable, doubt, 0.0))


def factor_in_decibels(factor: WithError) -> WithError:
    """How far a factor is from one, in dB; infinite for a factor that is zero or infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.abs(20.0 * np.log10(factor.value))
        error = DECIBEL * factor.error / factor.value
    fine = np.isfinite(level)
    rounding = 4.0 * EPSILON * (np.abs(np.where(fine, level, 0.0)) + DECIBEL)
    return WithError(level, np.where(fine, error + rounding, 0.0))


def less(one: WithError, other: WithError) -> WithError:
    """Difference of two levels; zero where both are infinite alike."""
    with np.errstate(invalid="ignore"):
        value = one.value - other.value
    value = np.where(np.isnan(value), 0.0, value)
    return WithError(value, np.where(np.isfinite(value), one.error + other.error, 0.0))
