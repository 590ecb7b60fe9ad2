"""Running states of a roll machine at many points as one batch."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import agreed, leave_alone
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.roll.adapters.readings import emit_spectra, spectrum_paths
from vibecalc.roll.mechanism import RollMachine, as_batch, dead_centres, widest_panel
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.rates import surely_fastest
from vibecalc.roll.results import FORCES, ROLL, VARIABLES
from vibecalc.roll.running import point_levels
from vibecalc.roll.steady import is_stable, multipliers, steady_state, within_table
from vibecalc.roll.turn import Readings, Turn, harmonics, mean, readings, spectrum

#: of the numbers of Gauss points to try; a point that these do not settle is run alone
_LEVELS = 4


def run_roll_at_points(scene: PointsScene) -> None:
    """Emit the running states of all points; those that one batch does not settle are alone."""
    case = scene.case
    assert case.response is not None and case.response.roll is not None
    parts = build_roll(case)
    options, drive = case.response.roll, roll_drive(parts)
    machine, started = _machines(parts.machine, scene.count), options.started_at
    given = options.points
    points = point_levels(case.accuracy.rtol)[:_LEVELS] if given is None else (given, given + 2)
    widest = widest_panel(options.orders)
    state = steady_state(machine, drive, points[0], started_at=started, widest=widest)
    orders = np.arange(1.0, options.orders + 1)
    settled = np.zeros(scene.count, dtype=bool)
    pistons = any(scene.wants(*spectrum_paths(name)) for name in FORCES)
    read = readings(machine, drive, state.turn, pistons=pistons, place=state.place)
    check, checked = state, read
    for count in points[1:]:
        if not state.solved.all():
            raise NumericalFailure("roll: some points have no running state")
        check, checked = state, read
        state = steady_state(machine, drive, count, started_at=started, start=state)
        read = readings(machine, drive, state.turn, pistons=pistons, place=state.place)
        settled = _settled((check.turn, checked), (state.turn, read), orders, case.accuracy.rtol)
        if settled.all():
            break
    if options.points is not None:
        (state, read), (check, checked) = (check, checked), (state, read)
        settled = np.ones(scene.count, dtype=bool)
    uncertain = ~settled | ~state.solved | ~within_table(state, drive)
    uncertain |= ~surely_fastest(machine, drive, state.turn)
    value, error = multipliers(state)
    uncertain |= ~is_stable(value, error)
    largest = Bounded(np.abs(value).max(axis=-1), error.max(axis=-1))
    scene.emit(f"{ROLL}/largest_multiplier", largest)
    names = [cylinder.name for cylinder in case.machine.crank_train.cylinders]
    both = ((state.turn, read), (check.turn, checked))
    _emit(scene, machine, both, {"order": orders.astype(int), "cylinder": names})
    scene.alone |= uncertain


_Read = tuple[Turn, Readings]


def _emit(
    scene: PointsScene, machine: RollMachine, both: tuple[_Read, _Read], axes: Mapping[str, Any]
) -> None:
    orders = np.asarray(axes["order"], dtype=float)
    speed = 2.0 * np.pi / both[0][0].period
    for name, values in (
        ("speed", [2.0 * np.pi / turn.period for turn, _ in both]),
        ("mean_slip", [mean(turn, read.slip) for turn, read in both]),
        ("shell_drift", [mean(turn, turn.shell_speed) for turn, _ in both]),
    ):
        error = np.abs(values[0] - values[1]) + 64.0 * EPSILON * speed
        scene.emit(f"{ROLL}/{name}", Bounded(values[0], error))
    torque = np.max(np.abs(both[0][1].motor_torque) + np.abs(both[0][1].gas_torque), axis=-1)
    spectra = {}
    for name in (*VARIABLES, *FORCES):
        if not scene.wants(*spectrum_paths(name)):
            continue
        value, other = (spectrum(turn, read, name, orders) for turn, read in both)
        size = np.abs(np.asarray(getattr(both[0][1], name)))
        floor = np.max(size, axis=tuple(range(1, size.ndim)), initial=0.0)
        if name.endswith("_acceleration"):
            floor = floor + torque / machine.shell_inertia
        rounding = 32.0 * EPSILON * floor.reshape(-1, *(1,) * (value.ndim - 1))
        spectra[name] = Bounded(value, np.abs(value - other) + rounding)
    emit_spectra(scene, spectra, axes)


def _settled(one: _Read, other: _Read, orders: FloatArray, rtol: float) -> BoolArray:
    """Where two settings give the same spectrum of the shell's acceleration within `rtol`."""
    each = [harmonics(turn, read.shell_acceleration, orders) for turn, read in (one, other)]
    largest = np.max(np.abs(each[1]), axis=-1)
    return np.asarray(np.max(np.abs(each[1] - each[0]), axis=-1) <= rtol * largest)


def _machines(built: RollMachine, count: int) -> RollMachine:
    """The machines of all points: all of them on mounts or none, and with common dead centres."""
    agreed((built.shell_stiffness != 0.0) | (built.shell_damping != 0.0))
    machine = as_batch(built)
    if machine.piston_friction.any() and np.ptp(dead_centres(machine), axis=0).any():
        # panels end where the friction turns, and all points share their ends
        leave_alone(np.ones(count, dtype=bool))
    return RollMachine(*(np.broadcast_to(field, (count, *field.shape[1:])) for field in machine))
