"""Adapter, continued: a motor fitted to its table, with and without its transients."""

import numpy as np

from vibecalc.case.roll_tables import Roll
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor_flux import CircuitMotor, power_flow
from vibecalc.machine.roll_motor import FittedMotor
from vibecalc.numerics.level import level_of
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.roll_motor import COMPARED, ENERGIES, ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.roll_motor_fit import emit_fit, emit_transients
from vibecalc.pipeline.stages.roll_observed import Seen, course_of, seen_in, spectra_of
from vibecalc.response.roll.dynamic_start import steady_drive
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.running import Running, running_state
from vibecalc.response.roll.steady import Steady, steady_state
from vibecalc.response.roll.turn import mean

_ROUNDING = 1e-14
_CYCLE = (f"{ROOT}/cycle/static_slip", f"{ROOT}/cycle/static_torque")


def doubted(
    machine: RollMachine, other: RollDrive, running: Running, started_at: float | None
) -> Running:
    """The running state whose check has, beside other points, the motor that the fit leaves open.

    `other` is the drive with that motor.
    """
    check = steady_state(
        machine, other, running.check.points, started_at=started_at, start=running.check
    )
    if not check.found[0]:
        raise NumericalFailure(
            "roll: within what the fit of the motor leaves open the running state is lost"
        )
    return running._replace(check=check, coarse=None)


def emit_motor(
    scene: Scene,
    options: Roll,
    machine: RollMachine,
    fitted: FittedMotor,
    running: Running,
    looks: tuple[Seen, Seen],
) -> None:
    """Fit and transients of the motor, its energies, and the same machine without transients."""
    for text in (*fitted.fit.assumptions, *fitted.fit.warnings):
        scene.warn(f"motor: {text}")
    emit_fit(scene, fitted)
    slips = [float(mean(look.turn, _slip(look))[0]) for look in looks]
    speeds = [2.0 * np.pi / float(look.turn.period[0]) for look in looks]
    emit_transients(scene, fitted, slips, speeds, options.orders)
    _emit_energies(scene, fitted, running)
    if scene.wants(*COMPARED):
        _emit_compared(scene, options, machine, looks)
    scene.cite(
        "induction machine with stator and rotor flux transients, fitted to the slip table",
        "motor",
        "docs/theory_roll_motor.md; cf. Krause, Wasynczuk and Sudhoff (2002), chapter 4",
    )


def _slip(look: Seen) -> FloatArray:
    return np.asarray(look.drive.synchronous_speed - look.turn.crank_speed)


def _emit_energies(scene: Scene, fitted: FittedMotor, running: Running) -> None:
    own = _energies(fitted.circuit, running.state)
    twin = _energies(fitted.other, running.check)
    for name in ENERGIES:
        error = abs(float(own[name].value - twin[name].value)) + float(own[name].error)
        scene.emit(f"{ROOT}/energy/{name}", float(own[name].value), error)


def _energies(circuit: CircuitMotor, state: Steady) -> dict[str, WithError]:
    """Work of a turn, with the rounding in it."""
    turn, stages = state.turn, state.solution.stages[0]
    flat = stages.reshape(-1, stages.shape[-1])
    flow = power_flow(circuit.motor, flat[:, -circuit.states :], flat[:, 0])
    rate = turn.weight[0] / turn.crank_speed[0]
    rounding = np.sum(rate * flow.error) + _ROUNDING * np.sum(rate * np.abs(flow.electrical))
    work = {name: np.sum(rate * getattr(flow, name)) for name in list(ENERGIES)[:-1]}
    used = work["stator_copper"] + work["rotor_copper"] + work["mechanical"]
    work["residual"] = work["electrical"] - used
    return {name: WithError(np.asarray(value), rounding) for name, value in work.items()}


def _emit_compared(
    scene: Scene, options: Roll, machine: RollMachine, looks: tuple[Seen, Seen]
) -> None:
    """Levels with the steady curve and with the table, and what changes from one to the next."""
    own, other = (steady_drive(look.drive) for look in looks)
    static = _solved(scene, options, machine, own, other)
    table = looks[0].drive._replace(circuit=None)
    plain = _solved(scene, options, machine, table, table)
    axes = {"order": np.arange(1, options.orders + 1)}
    found = [None if look is None else _levels(look, options.orders) for look in (plain, static)]
    for name, look, level in zip(("table", "static"), (plain, static), found, strict=True):
        if look is not None and level is not None:
            _emit_speed(scene, f"{name}_speed", look)
            scene.emit(f"{ROOT}/{name}_level", *level, axes)
    steps = (("fit", found[0], found[1]), ("dynamics", found[1], _levels(looks, options.orders)))
    for name, before, after in steps:
        if before is not None and after is not None:
            change = _less(after[0], before[0])
            scene.emit(f"{ROOT}/{name}_change", change, before[1] + after[1], axes)
    if static is not None and scene.wants(*_CYCLE):
        (angles, first), (_, second) = (course_of(look) for look in static)
        for path, variable in zip(_CYCLE, ("slip", "motor_torque"), strict=True):
            size = float(np.max(np.abs(first[variable])))
            error = np.abs(first[variable] - second[variable]) + _ROUNDING * size
            scene.emit(path, first[variable], error, {"crank_angle": angles})


def _solved(
    scene: Scene, options: Roll, machine: RollMachine, drive: RollDrive, other: RollDrive
) -> tuple[Seen, Seen] | None:
    """The running state with a motor without transients, and its check with `other`.

    None, and a warning, if there is no such state.
    """
    try:
        running = running_state(
            machine,
            drive,
            rtol=scene.case.accuracy.rtol,
            orders=options.orders,
            started_at=options.started_at,
            points=options.points,
            course=scene.wants(*_CYCLE),
        )
    except NumericalFailure as failure:
        which = "the slip table" if drive.circuit is None else "the steady torque of its motor"
        scene.warn(f"what the machine does with {which} is left out: {failure}")
        return None
    if other is not drive:
        running = doubted(machine, other, running, options.started_at)
    one, twin = (
        seen_in(machine, own, state)
        for state, own in ((running.state, drive), (running.check, other))
    )
    return one, twin


def _levels(looks: tuple[Seen, Seen], orders: int) -> tuple[FloatArray, FloatArray]:
    """Levels of the shell's acceleration (orders,) and their errors."""
    (values, rounding), (others, _) = (
        spectra_of(look, orders)["shell_acceleration"] for look in looks
    )
    return level_of(values, np.abs(values - others) + rounding, reference=1.0)


def _less(level: FloatArray, other: FloatArray) -> FloatArray:
    """Difference of levels; two harmonics that are zero do not differ."""
    both = np.isfinite(level) | np.isfinite(other)
    return np.subtract(level, other, out=np.zeros_like(level), where=both)


def _emit_speed(scene: Scene, name: str, looks: tuple[Seen, Seen]) -> None:
    one, twin = (2.0 * np.pi / float(look.turn.period[0]) for look in looks)
    scene.emit(f"{ROOT}/{name}", one, abs(one - twin) + _ROUNDING * one)
