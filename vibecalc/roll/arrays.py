"""Running states of a roll machine at many points as one batch."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.run.columns import Columns, Sheet, together
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.arrays import TRAIN, Train, build_train
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.level import level_of
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.roll.adapters.readings import lags_of
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    dead_centres,
    is_mounted,
    roll_machine,
    widest_panel,
)
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.rates import surely_fastest
from vibecalc.roll.results import FORCES, ROLL, VARIABLES
from vibecalc.roll.running import point_levels
from vibecalc.roll.steady import SteadyTurn, multipliers, steady_state
from vibecalc.roll.turn import Readings, Turn, by_cylinder, harmonics, mean, readings

#: of the numbers of Gauss points to try; a point that these do not settle is run alone
_LEVELS = 4


def emit_roll(columns: Columns, sheet: Sheet) -> BoolArray:
    """Put the results of all points into `sheet`; returns which points (points,) need a run alone.

    What stands in the sheet for such a point means nothing.
    """
    case = columns.case
    if case.response is None or case.response.roll is None:
        raise ValueError("the case has no [response.roll]")
    options, drive = case.response.roll, roll_drive(build_roll(case))
    machine = _machines(columns)
    started = columns.optional("response", "roll", "started_at")
    given = options.points
    points = point_levels(case.accuracy.rtol)[:_LEVELS] if given is None else (given, given + 2)
    widest = widest_panel(options.orders)
    state = steady_state(machine, drive, points[0], started_at=started, widest=widest)
    orders = np.arange(1.0, options.orders + 1)
    settled = np.zeros(columns.count, dtype=bool)
    pistons = any(sheet.wants(*spectrum_paths(name)) for name in FORCES)
    read = readings(machine, drive, state.turn, pistons=pistons)
    check, checked = state, read
    for count in points[1:]:
        if not state.solved.all():
            raise NumericalFailure("roll: some points have no running state")
        check, checked = state, read
        state = steady_state(machine, drive, count, started_at=started, start=state)
        read = readings(machine, drive, state.turn, pistons=pistons)
        settled = _settled((check.turn, checked), (state.turn, read), orders, case.accuracy.rtol)
        if settled.all():
            break
    if options.points is not None:
        (state, read), (check, checked) = (check, checked), (state, read)
        settled = np.ones(columns.count, dtype=bool)
    uncertain = ~settled | ~state.solved | _beyond(state, drive)
    uncertain |= ~surely_fastest(machine, drive, state.turn)
    value, error = multipliers(state)
    size = np.abs(value)
    uncertain |= np.any(size > 1.0 + error, axis=-1)
    largest = Bounded(size.max(axis=-1), error.max(axis=-1))
    sheet.emit(f"{ROLL}/largest_multiplier", largest)
    names = [cylinder.name for cylinder in case.machine.crank_train.cylinders]
    both = ((state.turn, read), (check.turn, checked))
    _emit(sheet, machine, both, {"order": orders.astype(int), "cylinder": names})
    return uncertain


_Read = tuple[Turn, Readings]


def _emit(
    sheet: Sheet, machine: RollMachine, both: tuple[_Read, _Read], axes: Mapping[str, Any]
) -> None:
    orders = np.asarray(axes["order"], dtype=float)
    speed = 2.0 * np.pi / both[0][0].period
    for name, values in (
        ("speed", [2.0 * np.pi / turn.period for turn, _ in both]),
        ("mean_slip", [mean(turn, read.slip) for turn, read in both]),
        ("shell_drift", [mean(turn, turn.shell_speed) for turn, _ in both]),
    ):
        error = np.abs(values[0] - values[1]) + 64.0 * EPSILON * speed
        sheet.emit(f"{ROLL}/{name}", Bounded(values[0], error))
    torque = np.max(np.abs(both[0][1].motor_torque) + np.abs(both[0][1].gas_torque), axis=-1)
    for name in (*VARIABLES, *FORCES):
        if not sheet.wants(*spectrum_paths(name)):
            continue
        spectrum, other = (_spectrum(turn, read, name, orders) for turn, read in both)
        size = np.abs(np.asarray(getattr(both[0][1], name)))
        floor = np.max(size, axis=tuple(range(1, size.ndim)), initial=0.0)
        if name.endswith("_acceleration"):
            floor = floor + torque / machine.shell_inertia
        rounding = 32.0 * EPSILON * floor.reshape(-1, *(1,) * (spectrum.ndim - 1))
        _emit_spectrum(sheet, name, spectrum, np.abs(spectrum - other) + rounding, axes)


def _spectrum(turn: Turn, read: Readings, name: str, orders: FloatArray) -> np.ndarray:
    values = np.asarray(getattr(read, name))
    return (
        harmonics(turn, values, orders) if name in VARIABLES else by_cylinder(turn, values, orders)
    )


def spectrum_paths(name: str) -> tuple[str, ...]:
    """Where the spectrum of a variable stands in a result."""
    return tuple(f"{ROLL}/{kind}{name}" for kind in ("", "level/", "phase_lag/"))


def _emit_spectrum(
    sheet: Sheet,
    name: str,
    values: np.ndarray,
    error: np.ndarray,
    axes: Mapping[str, Any],
) -> None:
    sheet.emit(f"{ROLL}/{name}", Bounded(values, error), axes)
    sheet.emit(f"{ROLL}/level/{name}", level_of(Bounded(values, error), reference=1.0), axes)
    sheet.emit(f"{ROLL}/phase_lag/{name}", Bounded(*lags_of(values, error)), axes)


def _settled(one: _Read, other: _Read, orders: FloatArray, rtol: float) -> BoolArray:
    """Where two settings give the same spectrum of the shell's acceleration within `rtol`."""
    each = [harmonics(turn, read.shell_acceleration, orders) for turn, read in (one, other)]
    largest = np.max(np.abs(each[1]), axis=-1)
    return np.asarray(np.max(np.abs(each[1] - each[0]), axis=-1) <= rtol * largest)


def _beyond(state: SteadyTurn, drive: RollDrive) -> BoolArray:
    if drive.holds:
        return np.zeros(len(state.solved), dtype=bool)
    slip = drive.synchronous_speed[..., None] - state.turn.crank_speed
    return np.asarray(np.max(np.abs(slip), axis=-1) > drive.motor.largest)


def _machines(columns: Columns) -> RollMachine:
    """The machines of all points, as `machine.roll.build_roll` would make them one by one."""
    train = build_train(columns)
    alone = build_roll(columns.case).machine
    mounts = (columns.varies("machine", "shell", name) for name in ("stiffness", "damping"))
    if not is_mounted(alone) and any(mounts):
        raise NumericalFailure("roll: mounts that come and go are run one by one")
    pins = train.rotating_mass.sum(axis=-1) * train.crank_radius**2
    fields: dict[str, object] = {
        "crank_radius": train.crank_radius,
        "rod_length": train.rod_length,
        "wrist_pin_offset": train.wrist_pin_offset,
        "crank_angle_offset": alone.crank_angle_offset[None],
        "reciprocating_mass": train.reciprocating_mass,
        "rod_inertia_difference": _rods(columns, train),
        "rotor_inertia": columns.number("machine", "rotor", "inertia") + pins,
        "shell_inertia": columns.number("machine", "shell", "inertia"),
        "shell_stiffness": columns.number("machine", "shell", "stiffness"),
        "shell_damping": columns.number("machine", "shell", "damping"),
        "friction_torque": columns.number("machine", "friction", "torque"),
        "friction_damping": columns.number("machine", "friction", "viscous"),
        "piston_friction": columns.number("machine", "friction", "piston_force"),
    }
    filled = roll_machine(**fields)
    count = columns.count
    if filled.piston_friction.any() and np.ptp(dead_centres(filled), axis=0).any():
        # panels end where the friction turns, and all points share their ends
        raise NumericalFailure("roll: dead centres that move are run one by one")
    return RollMachine(*(np.broadcast_to(field, (count, *field.shape[1:])) for field in filled))


def _rods(columns: Columns, train: Train) -> FloatArray:
    """Moment of each rod beyond its two point masses (points or 1, cylinders)."""
    rod = (*TRAIN, "rod")
    inertia = None if columns.written(*rod) is None else columns.optional(*rod, "inertia")
    if inertia is None:
        return np.zeros((1, len(train.runs)))
    share = train.rod_share
    points = columns.number(*rod, "mass") * train.rod_length**2 * share * (1.0 - share)
    return together([inertia - points]) * train.runs
