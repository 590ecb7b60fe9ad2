"""Adapter: control of the motor's frequency by the reduced model, with the full one alongside."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import breakdown
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.level import DECIBEL, level_of
from vibecalc.numerics.rounding import EPSILON
from vibecalc.roll.adapters.readings import less, machine_turn, shell_levels
from vibecalc.roll.control.full_model import Law, closed_loop
from vibecalc.roll.control.gains import (
    BOUNDS,
    UNCONTROLLED,
    ControlledLoop,
    Demands,
    LoopLoad,
    certify,
    evaluate,
    evaluate_at_speed,
    motor_gain_study,
    tune,
)
from vibecalc.roll.control.loop import (
    Controller,
    Disturbance,
    ReducedModel,
    disturbance,
    loop_of,
    model_from_full,
    steady_speed,
    straight,
    tangent,
)
from vibecalc.roll.control.loop import source_model as rotor_alone
from vibecalc.roll.control.margins import STATUS
from vibecalc.roll.control.poles import poles, root_locus
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch, is_mounted
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.results import CONTROL
from vibecalc.roll.running import running_state
from vibecalc.roll.tables import Control, Tune
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Adapter, before the control: the reduced model of a machine, its load and its target.
# ----------------------------------------------------------------------------


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
    alone: Bounded
    target: float
    orders: np.ndarray

    def load(
        self, speed: float, reference: float | None = None, offset: float | None = None
    ) -> LoopLoad:
        """Load at a mean speed; the torque of the motor at no slip counts with it."""
        at = self.torque.at(speed)
        added = self.offset if offset is None else offset
        mean = self.torque.mean
        speed_of_field = self.reference if reference is None else reference
        return LoopLoad(
            speed_of_field, float(mean.value) + added, at.value, float(mean.error), at.error
        )

    def reported(self, levels: Bounded) -> Bounded:
        """The orders that the case asks for; a search may need more."""
        count = len(self.orders)
        return Bounded(levels.value[..., :count], levels.error[..., :count])

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
    assert case.response is not None and case.response.control is not None
    options, parts = case.response.control, build_roll(case)
    machine = as_batch(parts.machine)
    drive = roll_drive(parts)._replace(circuit=None)
    demand = disturbance(machine, drive, max(options.orders, *_tuned(options)))
    gain, offset = options.motor_gain, 0.0
    if gain is None:
        line = tangent(machine, drive)
        gain, offset = line.gain, line.offset
    drag = float(machine.friction_damping[0])
    if options.reduction == "rotor":
        shell = float(machine.shell_inertia[0])
        model = rotor_alone(float(machine.rotor_inertia[0]), shell, gain)._replace(viscous=drag)
    else:
        model = model_from_full(demand.whole, demand.coupling, demand.crank, gain, drag)
    synchronous = float(np.max(drive.synchronous_speed))
    most = float(machine.motor_scale[0]) * breakdown(drive.motor)[1]
    alone = steady_speed(model, UNCONTROLLED, synchronous, float(demand.mean.value) + offset)
    alone = Bounded(alone.value, alone.error + demand.mean.error / gain)
    if not alone.value > 0.0:
        raise NumericalFailure(
            f"control: a motor of {gain:.6g} N*m*s/rad does not carry the mean torque of "
            f"{-demand.mean.value:.6g} N*m below its synchronous speed of {synchronous:.6g} rad/s"
        )
    return Setup(
        options, machine, drive, model, demand, gain, offset, most, synchronous,
        synchronous if options.reference is None else options.reference, alone,
        float(alone.value) if options.target_speed is None else options.target_speed,
        np.arange(1, options.orders + 1),
    )  # fmt: skip


def _tuned(options: Control) -> tuple[int, ...]:
    return (0,) if options.tune is None else options.tune.orders


# ----------------------------------------------------------------------------
# Adapter, shared by the parts of the control: what every loop has, as results by name.
# ----------------------------------------------------------------------------


def put(
    scene: Scene, values: Mapping[str, Any], axes: Mapping[str, Any] | None = None, below: str = ""
) -> None:
    """Emit results by their names below the root of the stage."""
    scene.emit_all({f"{CONTROL}/{below}{name}": value for name, value in values.items()}, axes)


def of_loop(loop: ControlledLoop, given: Setup, without: Bounded) -> dict[str, Bounded]:
    """Levels, what they are below those `without` control, status, margins and demands of a loop.

    A loop that is not stable has no margins.
    """
    margins, level = loop.margins, given.reported(loop.level)
    rounding = 8.0 * EPSILON * np.abs(margins.feedthrough)
    return {
        "level": level,
        "attenuation": less(without, level),
        "status": Bounded(margins.status, np.zeros(())),
        "gain_margin": factor_in_decibels(margins.gain),
        "gain_reduction": factor_in_decibels(margins.gain_lower),
        "phase_margin": margins.phase,
        "delay_margin": margins.delay,
        "bandwidth": margins.bandwidth,
        "feedthrough": Bounded(margins.feedthrough, rounding),
        "command_rate": loop.command_rate,
        "torque_peak": torque_peak(loop, given),
    }


def torque_peak(loop: ControlledLoop, given: Setup) -> Bounded:
    """Largest torque of the motor over a turn of the reduced model; infinite if not stable.

    In the mean it carries the load and viscous friction.
    """
    drag = float(given.machine.friction_damping[0])
    mean = drag * loop.speed.value - float(given.torque.mean.value)
    stable = loop.margins.stable
    harmonics, error = loop.harmonics.motor_torque
    known = np.where(stable[..., None], harmonics, 0.0)
    orders = np.arange(harmonics.shape[-1] + 1)
    peak = cycle_peak(np.concatenate([mean[..., None] + 0j, known], axis=-1), orders)
    uncertainty = peak.error + np.sum(error, axis=-1) + drag * loop.speed.error
    uncertainty = uncertainty + float(given.torque.mean.error)
    return Bounded(np.where(stable, peak.value, np.inf), np.where(stable, uncertainty, 0.0))


def factor_in_decibels(factor: Bounded) -> Bounded:
    """How far a factor is from one, in dB; infinite for a factor that is zero or infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.abs(20.0 * np.log10(factor.value))
        error = DECIBEL * factor.error / factor.value
    fine = np.isfinite(level)
    rounding = 4.0 * EPSILON * (np.abs(np.where(fine, level, 0.0)) + DECIBEL)
    return Bounded(level, np.where(fine, error + rounding, 0.0))


# ----------------------------------------------------------------------------
# Adapter: control of the motor's frequency, its levels, its margins, and the full model alongside.
# ----------------------------------------------------------------------------

_BRANCHES = 6
#: gains of the locus: so many, up to this many times the gain of the case
_LOCUS, _BEYOND = 121, 10.0


def run_control(scene: Scene) -> None:
    """Emit the loop of the case, and the studies that it asks for next to it."""
    given = setup(scene.case)
    options = given.options
    _cite(scene)
    _say(scene, given)
    without = evaluate(
        given.model, UNCONTROLLED, given.load(float(given.alone.value), given.synchronous)
    )
    quiet = given.reported(without.level)
    loop, load = _closed(given)
    numbers = {
        "motor_gain": given.gain,
        "motor_offset": given.offset,
        "breakdown_torque": given.breakdown,
        "inertia": float(np.asarray(given.model.inertia)),
        "shell_share": float(np.asarray(given.model.ratio)),
        "target_speed": given.target,
        "speed_feedback_limit": given.reference / given.target,
    }
    found = {
        **{name: Bounded(np.asarray(v), np.asarray(1e-12 * abs(v))) for name, v in numbers.items()},
        "mean_torque": given.torque.mean,
        "speed_without": given.alone,
        "disturbance": given.reported(
            Bounded(np.asarray(load.harmonics), np.asarray(load.harmonics_error))
        ),
        "speed": loop.speed,
        "speed_feedback": loop.speed_feedback,
        "shell_acceleration": given.reported(loop.harmonics.shell_acceleration),
        "level_without": quiet,
        **of_loop(loop, given, quiet),
    }
    put(scene, found, {"order": given.orders})
    _judge(scene, given, loop)
    _emit_poles(scene, given, loop)
    if options.motor_gains:
        emit_motor_gains(scene, given)
    if options.gains or options.feedbacks:
        emit_grid(scene, given, quiet)
    if options.tune is not None and scene.wants(*below(f"{CONTROL}/tuned/")):
        emit_tuned(scene, given, options.tune, quiet)
    alone = None
    if scene.wants(*below(f"{CONTROL}/range/"), f"{CONTROL}/full/attenuation"):
        alone = emit_range(scene, given, quiet)
    if options.full_model and scene.wants(*below(f"{CONTROL}/full/")):
        _emit_full(scene, given, loop, alone)


def _emit_full(scene: Scene, given: Setup, loop: ControlledLoop, without: Bounded | None) -> None:
    """The full model; where the reduced loop is unstable it may have no motion at all."""
    try:
        feedback = float(loop.speed_feedback.value)
        emit_full(scene, given, feedback, given.reported(loop.level), without)
    except NumericalFailure as failure:
        status = int(loop.margins.status)
        if status < 2:
            raise
        scene.warn(
            f"the full model under control is left out: the loop is {STATUS[status]} in the "
            f"reduced model, and {failure}"
        )


def _closed(given: Setup) -> tuple[ControlledLoop, LoopLoad]:
    """The loop of the case and its load, with the speed feedback given or what keeps the target."""
    controller = given.controller()
    if given.options.speed_feedback is None:
        load = given.load(given.target)
        return evaluate_at_speed(given.model, controller, load, given.target), load
    load = given.load(given.target)
    speed = steady_speed(given.model, controller, load.reference, load.mean).value
    if not (np.isfinite(speed) and speed > 0.0):
        raise NumericalFailure(
            f"control: with a speed feedback of {given.options.speed_feedback:g} and a gain of "
            f"{given.options.gain:g} no mean speed balances torque and load"
        )
    load = given.load(float(speed))
    return evaluate(given.model, controller, load), load


def _emit_poles(scene: Scene, given: Setup, loop: ControlledLoop) -> None:
    """Poles of the loop and their way as the gain grows; with a delay a search that may fail."""
    controller = given.controller()._replace(speed_feedback=loop.speed_feedback.value)
    try:
        roots = poles(loop_of(given.model, controller), _BRANCHES)
        numbers = np.arange(1, roots.value.shape[-1] + 1)
        put(scene, {"pole": Bounded(roots.value, roots.error)}, {"pole": numbers})
        if not scene.wants(f"{CONTROL}/locus/pole"):
            return
        gain, traced = given.options.gain, given.options.speed_feedback is None
        gains = np.geomspace(min(1.0, 0.1 * gain), _BEYOND * max(1.0, gain), _LOCUS)
        moving = root_locus(
            given.model, controller, gains, given.load(given.target) if traced else None,
            given.target, _BRANCHES,
        )  # fmt: skip
        axes = {"locus_gain": gains, "branch": np.arange(1, moving.pole.shape[-1] + 1)}
        put(scene, {"pole": Bounded(moving.pole, moving.pole_error)}, axes, "locus/")
    except NumericalFailure as failure:
        scene.warn(f"the poles of the loop are left out: {failure}")


def _judge(scene: Scene, given: Setup, loop: ControlledLoop) -> None:
    status = int(loop.margins.status)
    if status == 1:
        scene.warn(
            f"the loop is {STATUS[1]}: its gain at high frequency is "
            f"{abs(float(loop.margins.feedthrough)):.4g}, so that any delay makes it "
            "diverge; its levels are valid for zero delay only"
        )
    elif status > 1:
        scene.warn(f"the loop is {STATUS[status]}: amplitudes unbounded")
    asked = float(torque_peak(loop, given).value)
    if status < 2 and asked > given.breakdown:
        scene.warn(
            f"the loop needs a motor torque of up to {asked:.5g} N*m, above the breakdown torque "
            f"of {given.breakdown:.5g} N*m: the levels of the reduced model, whose motor has "
            "no breakdown, cannot be reached"
            + ("" if given.options.full_model else "; see full_model = true")
        )


def _say(scene: Scene, given: Setup) -> None:
    """What the reduced model takes for granted in this machine."""
    machine, motor = given.machine, scene.case.machine.motor
    if np.any(machine.wrist_pin_offset) or np.any(machine.rod_inertia_difference):
        scene.warn(
            "the reduced model of the control neglects the effect of a wrist pin offset or of the "
            "rod inertia on the shell; its size: response/control/range"
        )
    if is_mounted(machine):
        frequency = np.sqrt(float(machine.shell_stiffness[0]) / given.torque.whole)
        scene.warn(
            "the reduced model of the control has no mounts: it is valid well above "
            f"{frequency:.4g} rad/s, the roll mode of the shell, and cannot show whether "
            "feedback excites that mode; full_model = true does"
        )
    if motor is not None and motor.kind == "dynamic":
        scene.warn("the control uses the motor's steady torque, without transients of its fluxes")


def _cite(scene: Scene) -> None:
    scene.cite(
        "reduced model of rotor and shell, and feedback to the speed of the motor's field",
        "levels under control",
        "Herold (1977), equations 97 to 116; docs/theory_roll_control.md",
    )
    scene.cite(
        "crossings of the imaginary axis, counted as the delay grows",
        "stability and margins of the loop",
        "Walton and Marshall (1987), IEE Proc. D 134, 101-107",
    )


# ----------------------------------------------------------------------------
# Adapter, continued: the full nonlinear machine next to the reduced model.
# ----------------------------------------------------------------------------


def emit_range(scene: Scene, given: Setup, reduced: Bounded) -> Bounded | None:
    """Levels of the full model without control, less those of the reduced one; and the first."""
    levels: list[Bounded] = []
    lines = given.drive._replace(motor=straight(given.gain, given.offset))
    for drive in (given.drive, lines):
        try:
            levels.append(_uncontrolled(scene, given, drive))
        except NumericalFailure as failure:
            scene.warn(
                "without control the full model has no running state to hold the reduced one "
                f"against: {failure}"
            )
            break
    off = [less(one, reduced) for one in levels]
    names = ("level", "difference", "linear_difference")
    put(
        scene,
        dict(zip(names, [*levels[:1], *off], strict=False)),
        {"order": given.orders},
        "range/",
    )
    return levels[0] if levels else None


def emit_full(
    scene: Scene, given: Setup, feedback: float, reduced: Bounded, without: Bounded | None
) -> None:
    """The closed loop in the full model: levels by the reduced ones, or that it is unstable."""
    options = given.options
    law = Law(
        options.gain, feedback, options.acceleration_feedback, given.reference, options.actuator_lag
    )
    closed = closed_loop(
        given.machine, given.drive, law,
        rtol=scene.case.accuracy.rtol, orders=len(given.orders),
    )  # fmt: skip
    axes = {
        "order": given.orders,
        "multiplier": np.arange(1, len(closed.multiplier) + 1),
    }
    level = level_of(closed.harmonics, reference=1.0)
    if not closed.stable:
        level = Bounded(np.full(len(given.orders), np.inf), np.zeros(len(given.orders)))
        size = float(np.max(np.abs(closed.multiplier)))
        scene.warn(
            "under control the full model is unstable: disturbances grow by a "
            f"factor of {size:.6g} per turn; no levels"
        )
    found = {
        "speed": closed.speed,
        "level": level,
        "difference": less(level, reduced),
        "multiplier": Bounded(closed.multiplier, closed.multiplier_error),
        "stable": int(closed.stable),
        "largest_slip": closed.largest_slip,
    }
    if without is not None:
        found["attenuation"] = less(without, level)
    put(scene, found, axes, "full/")
    scene.cite(
        "Gauss collocation of rotor, pistons, shell and controller over the crank angle",
        "the closed loop in the full nonlinear model, and its stability",
        "docs/theory_roll.md; own extension by the state of the actuator",
    )


def _uncontrolled(scene: Scene, given: Setup, drive: RollDrive) -> Bounded:
    running = running_state(
        given.machine, drive, rtol=scene.case.accuracy.rtol, orders=len(given.orders)
    )
    turns = [machine_turn(given.machine, drive, state) for state in (running.state, running.check)]
    return shell_levels(turns, len(given.orders))


# ----------------------------------------------------------------------------
# Adapter, continued: other motors, a grid of gains and feedbacks, and gains that are searched.
# ----------------------------------------------------------------------------


def emit_motor_gains(scene: Scene, given: Setup) -> None:
    """Speed and levels with motors whose curve is a line through the origin, uncontrolled."""
    gains = np.array(given.options.motor_gains)
    load = given.load(float(given.alone.value), given.synchronous, 0.0)
    found = motor_gain_study(given.model, gains, load)
    axes = {"motor_gain": gains, "order": given.orders}
    both = {"speed": found.speed, "level": given.reported(found.level)}
    put(scene, both, axes, "motor_gains/")


def emit_grid(scene: Scene, given: Setup, without: Bounded) -> None:
    """Every gain with every feedback, the speed kept at the target."""
    options = given.options
    gains = np.array(options.gains or (options.gain,))
    feedbacks = np.array(options.feedbacks or (options.acceleration_feedback,))
    controller = given.controller()._replace(gain=gains[:, None], acceleration_feedback=feedbacks)
    loop = evaluate_at_speed(given.model, controller, given.load(given.target), given.target)
    axes = {"gain": gains, "feedback": feedbacks, "order": given.orders}
    feedback = {"speed_feedback": loop.speed_feedback[:, 0]}
    put(scene, of_loop(loop, given, without) | feedback, axes, "grid/")
    lost, brittle = (int(np.sum(loop.margins.status >= 2)), int(np.sum(loop.margins.status == 1)))
    if lost or brittle:
        scene.warn(
            f"of {gains.size * feedbacks.size} pairs of gain and feedback {lost} are not stable "
            f"and {brittle} {STATUS[1]}: infinite levels, or valid for zero delay only"
        )


def emit_tuned(scene: Scene, given: Setup, asked: Tune, without: Bounded) -> None:
    """The gains that make the loudest of some orders quietest and keep their distance."""
    demands = Demands(
        (asked.gain.lower, asked.gain.upper),
        (asked.acceleration_feedback.lower, asked.acceleration_feedback.upper),
        asked.gain_margin,
        asked.phase_margin,
        asked.delay_margin,
    )
    load, controller = given.load(given.target), given.controller()
    of = (given.model, controller, load, given.target, demands)
    tuned = tune(*of, asked.orders)
    proof = certify(*of, tuned, asked.orders)
    # the differences are good to 1e-7, the place where they are taken to little more than 1e-6
    uncertainty = 1e-5 * (1.0 + np.abs(proof.multiplier))
    found = {
        "gain": tuned.gain,
        "acceleration_feedback": tuned.acceleration_feedback,
        "speed_feedback": tuned.controlled.speed_feedback,
        "objective": tuned.objective,
        **of_loop(tuned.controlled, given, without),
        "active": proof.active.astype(float),
        "multiplier": Bounded(proof.multiplier, uncertainty),
        "residual": Bounded(np.asarray(proof.residual), np.asarray(1e-5)),
    }
    axes = {"order": given.orders, "bound": np.array(BOUNDS, dtype=object)}
    put(scene, found, axes, "tuned/")
    scene.cite(
        "grids that close in over gain and feedback; conditions of Karush, Kuhn and Tucker",
        "gains of the controller under stability margins",
        "docs/theory_roll_control.md",
    )
