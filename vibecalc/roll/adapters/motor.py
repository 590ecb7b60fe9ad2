"""Adapter: a motor fitted to its table, with and without its transients."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import steady_torque, torque_curve
from vibecalc.excitation.induction_motor_flux import (
    CircuitMotor,
    eigenvalues,
    power_flow,
    time_constants,
    torque_answer,
)
from vibecalc.excitation.induction_motor_identify import Identifiability, identifiability
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.roll.adapters.readings import (
    MachineTurn,
    less,
    machine_turn,
    shell_levels,
    time_history,
)
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.model import FittedMotor
from vibecalc.roll.results import COMPARED, ENERGIES, MOTOR
from vibecalc.roll.running import Running, running_state, steady_drive
from vibecalc.roll.steady import SteadyTurn, steady_state
from vibecalc.roll.tables import Roll
from vibecalc.roll.turn import mean

# ----------------------------------------------------------------------------
# Adapter, continued: the circuit that was fitted to a motor's table, and its transients.
# ----------------------------------------------------------------------------

#: slips of the curve, from none to standstill
_SHOWN = 361
_FIT_ROUNDING = 64.0 * EPSILON

_MACHINE = ("stator_leakage", "magnetising_inductance", "rotor_resistance", "rotor_leakage")
_CURVE = ("breakdown_slip", "breakdown_torque", "locked_rotor_torque", "gain")


def of_circuit(
    circuit: CircuitMotor, turn: MachineTurn, state: SteadyTurn, orders: int
) -> dict[str, Bounded]:
    """Parameters of a circuit, its curve, transients at the mean slip of a turn, and its energies.

    The answer of its torque is that to harmonics of the mean speed of the crank.
    """
    motor, curve = circuit.motor, torque_curve(circuit.motor)
    times = time_constants(motor)
    slip = float(mean(turn.turn, turn.drive.synchronous_speed - turn.turn.crank_speed)[0])
    pace = 2.0 * np.pi / float(turn.turn.period[0])
    value, error = eigenvalues(motor, slip)
    answer, still = torque_answer(motor, slip, pace * np.arange(1, orders + 1))
    # the static answer is real, and the same at every frequency
    real, off = (np.broadcast_to(part, (np.size(part),))[0] for part in still)
    return {
        **{name: rounded(getattr(motor, name), 0.0) for name in _MACHINE},
        **{name: getattr(curve, name) for name in _CURVE},
        "curve": steady_torque(motor, _slips(circuit)),
        "stator_time": times.stator,
        "rotor_open_time": times.rotor_open,
        "rotor_short_time": times.rotor_short,
        "transient_decay_time": Bounded(-1.0 / value.real, error / value.real**2),
        "transient_frequency": Bounded(np.abs(value.imag), error),
        "torque_answer": answer,
        "static_answer": Bounded(np.asarray(real.real), np.asarray(off)),
        **{f"energy/{name}": one for name, one in _energies(circuit, state).items()},
    }


def _slips(circuit: CircuitMotor) -> FloatArray:
    """Slips of the curve, closer together where the machine runs."""
    return float(circuit.motor.synchronous_speed) * np.linspace(0.0, 1.0, _SHOWN) ** 2


def _emit_table(scene: Scene, fitted: FittedMotor) -> None:
    """The fitted torque at each row of the table."""
    fit = fitted.fit
    error = _apart(fit.torque, steady_torque(fitted.other.motor, fit.slip))
    for name, value, off in (
        ("torque", fit.table, 0.0),
        ("fitted", fit.torque.value, error),
        ("difference", fit.residual, error),
        ("relative_difference", fit.residual / fit.table, error / fit.table),
        ("used", fit.used.astype(int), 0.0),
    ):
        scene.emit(f"{MOTOR}/table/{name}", value, off, {"slip": fit.slip})
    worst = float(np.max(error / fit.table))
    scene.emit(f"{MOTOR}/worst_difference", fit.worst_relative, worst)
    scene.emit(f"{MOTOR}/rms_difference", fit.rms_relative, worst)


def _emit_identifiability(scene: Scene, fitted: FittedMotor) -> None:
    fit = fitted.fit
    chosen = fit.identifiability
    twin = identifiability(fitted.other.motor, fit.slip[fit.used])
    names, count = {"motor_parameter": chosen.names}, len(chosen.names)
    numbers = {"combination": np.arange(1, count + 1)}
    for name, field in (
        ("parameter_spread", "held_spread"),
        ("parameter_free_spread", "free_spread"),
        ("combination_spread", "spread"),
        ("singular_value", "singular_values"),
    ):
        value, moved = getattr(chosen, field), getattr(twin, field)
        known = np.isfinite(value) & np.isfinite(moved)
        change = np.abs(np.subtract(value, moved, out=np.zeros_like(value), where=known))
        size = float(np.max(value, initial=0.0, where=known))
        # the least of the singular values that are not zero sets what rounding costs a spread
        loss = 1.0 if field == "singular_values" else _loss(chosen)
        scene.emit(f"{MOTOR}/{name}", value, change + _FIT_ROUNDING * loss * size, names | numbers)
    turned = (
        np.abs(chosen.combinations - twin.combinations) + (_FIT_ROUNDING / _gaps(chosen))[:, None]
    )
    scene.emit(f"{MOTOR}/combination", chosen.combinations, turned, names | numbers)


def _loss(identifiability: Identifiability) -> float:
    there = identifiability.singular_values[np.isfinite(identifiability.spread)]
    return float(there.max() / there.min())


def _gaps(identifiability: Identifiability) -> FloatArray:
    """Distance (n,) of each singular value from the others, over the largest; zeros are one."""
    values = np.where(np.isfinite(identifiability.spread), identifiability.singular_values, 0.0)
    apart = np.abs(values[:, None] - values)
    alike = np.eye(values.size, dtype=bool) | ((values == 0.0)[:, None] & (values == 0.0))
    return np.asarray(np.min(np.where(alike, np.inf, apart), axis=1) / values.max())


def _apart(value: Bounded, other: Bounded) -> FloatArray:
    rounding = _FIT_ROUNDING * np.abs(value.value)
    return np.asarray(np.abs(value.value - other.value) + value.error + rounding)


# ----------------------------------------------------------------------------
# Adapter, continued: a motor fitted to its table, with and without its transients.
# ----------------------------------------------------------------------------

_ROUNDING = 1e-14
_CYCLE = (f"{MOTOR}/cycle/static_slip", f"{MOTOR}/cycle/static_torque")


def uncertain(
    machine: RollMachine, other: RollDrive, running: Running, started_at: float | None
) -> Running:
    """The running state whose check has, next to other points, the motor that the fit leaves open.

    `other` is the drive with that motor.
    """
    check = steady_state(
        machine, other, running.check.points, started_at=started_at, start=running.check
    )
    if not check.solved[0]:
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
    turns: tuple[MachineTurn, MachineTurn],
) -> None:
    """Fit and transients of the motor, its energies, and the same machine without transients."""
    for text in (*fitted.fit.assumptions, *fitted.fit.warnings):
        scene.warn(f"motor: {text}")
    _emit_table(scene, fitted)
    _emit_identifiability(scene, fitted)
    each = zip((fitted.circuit, fitted.other), turns, (running.state, running.check), strict=True)
    found, twin = (of_circuit(*one, options.orders) for one in each)
    axes = {
        "cage": np.arange(1, found["rotor_open_time"].value.size + 1),
        "transient": np.arange(1, found["transient_frequency"].value.size + 1),
        "order": np.arange(1, options.orders + 1),
        "slip": _slips(fitted.circuit),
    }
    for name, value in found.items():
        scene.emit(f"{MOTOR}/{name}", value.value, _apart(value, twin[name]), axes)
    if scene.wants(*COMPARED):
        _emit_compared(scene, options, machine, turns)
    scene.cite(
        "induction machine with stator and rotor flux transients, fitted to the slip table",
        "motor",
        "docs/theory_roll.md; cf. Krause, Wasynczuk and Sudhoff (2002), chapter 4",
    )


def _energies(circuit: CircuitMotor, state: SteadyTurn) -> dict[str, Bounded]:
    """Work of a turn, with the rounding in it."""
    turn, stages = state.turn, state.solution.stages[0]
    flat = stages.reshape(-1, stages.shape[-1])
    flow = power_flow(circuit.motor, flat[:, -circuit.states :], flat[:, 0])
    rate = turn.weight[0] / turn.crank_speed[0]
    rounding = np.sum(rate * flow.error) + _ROUNDING * np.sum(rate * np.abs(flow.electrical))
    work = {name: np.sum(rate * getattr(flow, name)) for name in list(ENERGIES)[:-1]}
    used = work["stator_copper"] + work["rotor_copper"] + work["mechanical"]
    work["residual"] = work["electrical"] - used
    return {name: Bounded(np.asarray(value), rounding) for name, value in work.items()}


def _emit_compared(
    scene: Scene, options: Roll, machine: RollMachine, turns: tuple[MachineTurn, MachineTurn]
) -> None:
    """Levels with the steady curve and with the table, and what changes from one to the next."""
    drive, other = (steady_drive(one.drive) for one in turns)
    static = _solved(scene, options, machine, drive, other)
    table = turns[0].drive._replace(circuit=None)
    plain = _solved(scene, options, machine, table, table)
    axes = {"order": np.arange(1, options.orders + 1)}
    levels = [one and shell_levels(one, options.orders) for one in (plain, static)]
    for name, one, level in zip(("table", "static"), (plain, static), levels, strict=True):
        if one is not None and level is not None:
            _emit_speed(scene, f"{name}_speed", one)
            scene.emit(f"{MOTOR}/{name}_level", level, axes=axes)
    dynamic = shell_levels(turns, options.orders)
    steps = (("fit", levels[0], levels[1]), ("dynamics", levels[1], dynamic))
    for name, before, after in steps:
        if before is not None and after is not None:
            scene.emit(f"{MOTOR}/{name}_change", less(after, before), axes=axes)
    if static is not None and scene.wants(*_CYCLE):
        (angles, first), (_, second) = (time_history(one) for one in static)
        for path, variable in zip(_CYCLE, ("slip", "motor_torque"), strict=True):
            size = float(np.max(np.abs(first[variable])))
            error = np.abs(first[variable] - second[variable]) + _ROUNDING * size
            scene.emit(path, first[variable], error, {"crank_angle": angles})


def _solved(
    scene: Scene, options: Roll, machine: RollMachine, drive: RollDrive, other: RollDrive
) -> tuple[MachineTurn, MachineTurn] | None:
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
            between_points=scene.wants(*_CYCLE),
        )
    except NumericalFailure as failure:
        which = "the slip table" if drive.circuit is None else "the steady torque of its motor"
        scene.warn(f"the machine with {which} is left out: {failure}")
        return None
    if other is not drive:
        running = uncertain(machine, other, running, options.started_at)
    one, twin = (
        machine_turn(machine, fitted, state)
        for state, fitted in ((running.state, drive), (running.check, other))
    )
    return one, twin


def _emit_speed(scene: Scene, name: str, turns: tuple[MachineTurn, MachineTurn]) -> None:
    one, twin = (2.0 * np.pi / float(turn.turn.period[0]) for turn in turns)
    scene.emit(f"{MOTOR}/{name}", one, abs(one - twin) + _ROUNDING * one)
