"""Slopes: by how much each parameter changes each harmonic of the shell, for small changes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.machine import PER_CYLINDER, RollDrive, RollMachine
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.steady import steady_state
from vibecalc.response.roll.turn import harmonics, level

#: relative step of a parameter; the others are its double and both the other way
_STEP = 1e-3
_FACTORS = (1.0 + _STEP, 1.0 - _STEP, 1.0 + 2.0 * _STEP, 1.0 - 2.0 * _STEP)
_SHARED = (
    "rod_length",
    "crank_radius",
    "shell_inertia",
    "rotor_inertia",
    "motor_scale",
    "shell_stiffness",
    "shell_damping",
    "friction_torque",
    "friction_damping",
    "piston_friction",
)
_OF_CYLINDERS = ("reciprocating_mass", "gas_scale")


class Sensitivity(NamedTuple):
    """dB for one percent more of each parameter (parameters, orders), and the error of each."""

    parameters: tuple[str, ...]
    value: FloatArray
    error: FloatArray


def sensitivity(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    cylinders: Sequence[str],
    *,
    points: int,
    started_at: float | None = None,
) -> Sensitivity:
    """Slopes of the levels of the shell's acceleration for one machine (B = 1), as one batch.

    Central differences in the logarithm of each parameter with two steps, extrapolated; the error
    is what the extrapolation changed. Parameters that are zero are left out.
    """
    rows = parameters(machine, cylinders)
    batch = altered(machine, [(row, factor) for row in rows for factor in _FACTORS])
    found = steady_state(batch, drive, points, started_at=started_at)
    if not found.found.all():
        lost = rows[int(np.flatnonzero(~found.found)[0]) // len(_FACTORS)][0]
        raise NumericalFailure(
            f"roll: with {lost} changed by two thousandths the running state is lost, so that its "
            "levels have no slope; leave sensitivity away"
        )
    spectrum = harmonics(
        found.turn,
        readings(batch, drive, found.turn, pistons=False).shell_acceleration,
        np.asarray(orders, dtype=float),
    )
    high = level(spectrum).reshape(len(rows), len(_FACTORS), len(orders))
    near = (high[:, 0] - high[:, 1]) / (np.log1p(_STEP) - np.log1p(-_STEP))
    far = (high[:, 2] - high[:, 3]) / (np.log1p(2.0 * _STEP) - np.log1p(-2.0 * _STEP))
    slope = (4.0 * near - far) / 3.0
    noise = 1e4 * EPSILON / _STEP
    error = np.abs(slope - near) + noise
    percent = np.log1p(0.01)
    return Sensitivity(tuple(name for name, _, _ in rows), percent * slope, percent * error)


class Parameter(NamedTuple):
    """What may be altered: its name, its field of the machine, and which cylinder's it is."""

    name: str
    field: str
    cylinder: int | None


def parameters(machine: RollMachine, cylinders: Sequence[str]) -> list[Parameter]:
    """Every parameter of the machine that is there, that is not zero."""
    names: dict[str, str] = {"motor_scale": "motor_torque"}
    rows = [
        Parameter(names.get(field, field), field, None)
        for field in _SHARED
        if np.any(getattr(machine, field))
    ]
    words = {"reciprocating_mass": "reciprocating_mass", "gas_scale": "gas_force"}
    for field in _OF_CYLINDERS:
        rows += [
            Parameter(f"{words[field]} {name}", field, place)
            for place, name in enumerate(cylinders)
            if np.any(getattr(machine, field)[..., place])
        ]
    return rows


def altered(machine: RollMachine, changes: Sequence[tuple[Parameter | None, float]]) -> RollMachine:
    """One machine (B = 1) for each change: a parameter times a factor, or None for no change."""
    fields = {
        name: np.repeat(getattr(machine, name), len(changes), axis=0) for name in machine._fields
    }
    for row, (parameter, factor) in enumerate(changes):
        if parameter is None:
            continue
        if parameter.field in PER_CYLINDER:
            fields[parameter.field][row, parameter.cylinder] *= factor
        else:
            fields[parameter.field][row] *= factor
    return RollMachine(**fields)
