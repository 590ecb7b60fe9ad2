"""Adapter, continued: the circuit that was fitted to a motor's table, and its transients."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibecalc.excitation.induction_motor import steady_torque, torque_curve
from vibecalc.excitation.induction_motor_flux import (
    CircuitMotor,
    eigenvalues,
    time_constants,
    torque_answer,
)
from vibecalc.excitation.induction_motor_identify import Identifiability, identifiability
from vibecalc.machine.roll_motor import FittedMotor
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.roll_motor import ROOT
from vibecalc.pipeline.scene import Scene

#: slips of the curve, from none to standstill
_SHOWN = 361
_ROUNDING = 64.0 * EPSILON

_Pair = tuple[WithError, WithError]


def emit_fit(scene: Scene, fitted: FittedMotor) -> None:
    """Parameters, what the table tells of them, differences from it, points of the curve."""
    fit, own, other = fitted.fit, fitted.circuit.motor, fitted.other.motor
    cages = {"cage": np.arange(1, np.asarray(own.rotor_resistance).size + 1)}
    for name in ("stator_leakage", "magnetising_inductance", "rotor_resistance", "rotor_leakage"):
        value, moved = np.asarray(getattr(own, name)), np.asarray(getattr(other, name))
        scene.emit(f"{ROOT}/{name}", value, _apart(_exact(value), _exact(moved)), cages)
    _emit_told(scene, fitted)
    rows = {"slip": fit.slip}
    error = _apart(fit.torque, steady_torque(other, fit.slip))
    scene.emit(f"{ROOT}/table/torque", fit.table, 0.0, rows)
    scene.emit(f"{ROOT}/table/fitted", fit.torque.value, error, rows)
    scene.emit(f"{ROOT}/table/difference", fit.residual, error, rows)
    relative = fit.residual / fit.table
    scene.emit(f"{ROOT}/table/relative_difference", relative, error / fit.table, rows)
    scene.emit(f"{ROOT}/table/used", fit.used.astype(int), 0.0, rows)
    worst = float(np.max(error / fit.table))
    scene.emit(f"{ROOT}/worst_difference", fit.worst_relative, worst)
    scene.emit(f"{ROOT}/rms_difference", fit.rms_relative, worst)
    _emit_curve(scene, fitted)


def emit_transients(
    scene: Scene,
    fitted: FittedMotor,
    slips: Sequence[float],
    speeds: Sequence[float],
    orders: int,
) -> None:
    """Time constants, transients at the mean slips (rad/s) of the motion and of its check.

    `speeds` are the mean speeds of the crank, whose multiples are the frequencies of the answer.
    """
    circuits = (fitted.circuit, fitted.other)
    one, twin = (time_constants(circuit.motor) for circuit in circuits)
    cages = {"cage": np.arange(1, one.rotor_open.value.size + 1)}
    _emit(scene, "stator_time", (one.stator, twin.stator), {})
    _emit(scene, "rotor_open_time", (one.rotor_open, twin.rotor_open), cages)
    _emit(scene, "rotor_short_time", (one.rotor_short, twin.rotor_short), cages)
    found = tuple(_fading(circuit, slip) for circuit, slip in zip(circuits, slips, strict=True))
    axes = {"transient": np.arange(1, found[0][0].value.size + 1)}
    for place, name in enumerate(("transient_decay_time", "transient_frequency")):
        _emit(scene, name, (found[0][place], found[1][place]), axes)
    numbers = np.arange(1, orders + 1)
    answers = [
        torque_answer(circuit.motor, slip, speed * numbers)
        for circuit, slip, speed in zip(circuits, slips, speeds, strict=True)
    ]
    _emit(scene, "torque_answer", (answers[0][0], answers[1][0]), {"order": numbers})
    still = tuple(_first(answer[1]) for answer in answers)
    _emit(scene, "static_answer", (still[0], still[1]), {})


def _emit_told(scene: Scene, fitted: FittedMotor) -> None:
    fit = fitted.fit
    told = fit.identifiability
    twin = identifiability(fitted.other.motor, fit.slip[fit.used], np.ones(int(fit.used.sum())))
    names, count = {"motor_parameter": told.names}, len(told.names)
    numbers = {"combination": np.arange(1, count + 1)}
    for name, field in (
        ("parameter_spread", "held_spread"),
        ("parameter_free_spread", "free_spread"),
        ("combination_spread", "spread"),
        ("singular_value", "singular_values"),
    ):
        value, moved = getattr(told, field), getattr(twin, field)
        known = np.isfinite(value) & np.isfinite(moved)
        change = np.abs(np.subtract(value, moved, out=np.zeros_like(value), where=known))
        size = float(np.max(value, initial=0.0, where=known))
        # the least of the singular values that are not zero sets what rounding costs a spread
        loss = 1.0 if field == "singular_values" else _loss(told)
        scene.emit(f"{ROOT}/{name}", value, change + _ROUNDING * loss * size, names | numbers)
    turned = np.abs(told.combinations - twin.combinations) + (_ROUNDING / _gaps(told))[:, None]
    scene.emit(f"{ROOT}/combination", told.combinations, turned, names | numbers)


def _loss(told: Identifiability) -> float:
    there = told.singular_values[np.isfinite(told.spread)]
    return float(there.max() / there.min())


def _gaps(told: Identifiability) -> FloatArray:
    """Distance (n,) of each singular value from the others, over the largest; zeros are one."""
    values = np.where(np.isfinite(told.spread), told.singular_values, 0.0)
    apart = np.abs(values[:, None] - values)
    alike = np.eye(values.size, dtype=bool) | ((values == 0.0)[:, None] & (values == 0.0))
    return np.asarray(np.min(np.where(alike, np.inf, apart), axis=1) / values.max())


def _emit_curve(scene: Scene, fitted: FittedMotor) -> None:
    own, other = fitted.circuit.motor, fitted.other.motor
    # closer together where the machine runs
    slips = float(own.synchronous_speed) * np.linspace(0.0, 1.0, _SHOWN) ** 2
    _emit(scene, "curve", (steady_torque(own, slips), steady_torque(other, slips)), {"slip": slips})
    one, twin = torque_curve(own), torque_curve(other)
    for name in ("breakdown_slip", "breakdown_torque", "locked_rotor_torque", "gain"):
        _emit(scene, name, (getattr(one, name), getattr(twin, name)), {})


def _fading(circuit: CircuitMotor, slip: float) -> tuple[WithError, WithError]:
    """Time (s) in which each transient falls to 1/e, and its frequency (rad/s) in the torque."""
    value, error = eigenvalues(circuit.motor, slip)
    rate = -value.real
    return WithError(1.0 / rate, error / rate**2), WithError(np.abs(value.imag), error)


def _first(found: WithError) -> WithError:
    """The static answer is real, and the same at every frequency."""
    value, error = (np.broadcast_to(part, (np.size(part),))[0] for part in found)
    return WithError(np.asarray(value.real), np.asarray(error))


def _exact(value: FloatArray) -> WithError:
    return WithError(value, np.zeros_like(value))


def _apart(own: WithError, other: WithError) -> FloatArray:
    rounding = _ROUNDING * np.abs(own.value)
    return np.asarray(np.abs(own.value - other.value) + own.error + rounding)


def _emit(scene: Scene, name: str, pair: _Pair, axes: Mapping[str, Any]) -> None:
    scene.emit(f"{ROOT}/{name}", pair[0].value, _apart(*pair), axes)
