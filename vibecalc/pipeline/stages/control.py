"""Adapter: control of the motor's frequency, its levels, its margins, and the full model beside."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.pipeline.entries.roll_control import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_plan import below
from vibecalc.pipeline.stages.control_full import emit_full, emit_range
from vibecalc.pipeline.stages.control_setup import Setup, setup
from vibecalc.pipeline.stages.control_studies import emit_grid, emit_motor_gains, emit_tuned
from vibecalc.pipeline.stages.control_values import emit_loop, less, put, torque_peak
from vibecalc.response.roll.machine import is_mounted
from vibecalc.response.roll_control.count import STATUS
from vibecalc.response.roll_control.evaluate import (
    Controlled,
    Load,
    evaluate,
    evaluate_at_speed,
)
from vibecalc.response.roll_control.locus import root_locus
from vibecalc.response.roll_control.model import loop_of
from vibecalc.response.roll_control.motor_gains import UNCONTROLLED
from vibecalc.response.roll_control.poles import poles
from vibecalc.response.roll_control.steady import steady_speed

_BRANCHES = 6
#: gains of the locus: so many, up to this many times the gain of the case
_LOCUS, _BEYOND = 121, 10.0


def run(scene: Scene) -> None:
    """Emit the loop of the case, and the studies that it asks for beside it."""
    given = setup(scene.case)
    options = given.options
    _cite(scene)
    _say(scene, given)
    without = evaluate(
        given.model, UNCONTROLLED, given.load(float(given.alone.value), given.synchronous)
    )
    found, load = _closed(given)
    _emit_model(scene, given, load)
    _emit_found(scene, given, found, without)
    emit_loop(scene, "", found, given)
    _judge(scene, given, found)
    _emit_poles(scene, given, found)
    quiet = given.kept(without.level)
    if options.motor_gains:
        emit_motor_gains(scene, given)
    if options.gains or options.feedbacks:
        emit_grid(scene, given, quiet)
    if options.tune is not None and scene.wants(*below(f"{ROOT}/tuned/")):
        emit_tuned(scene, given, options.tune, quiet)
    alone = None
    if scene.wants(*below(f"{ROOT}/range/"), f"{ROOT}/full/attenuation"):
        alone = emit_range(scene, given, quiet)
    if options.full_model and scene.wants(*below(f"{ROOT}/full/")):
        _emit_full(scene, given, found, alone)


def _emit_full(scene: Scene, given: Setup, found: Controlled, without: WithError | None) -> None:
    """The full model; where the reduced loop is unstable it may have no motion to look at."""
    try:
        feedback = float(found.speed_feedback.value)
        emit_full(scene, given, feedback, given.kept(found.level), without)
    except NumericalFailure as failure:
        status = int(found.margins.status)
        if status < 2:
            raise
        scene.warn(
            f"the full model under control is left out: the loop is {STATUS[status]} in the "
            f"reduced model, and {failure}"
        )


def _closed(given: Setup) -> tuple[Controlled, Load]:
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


def _emit_model(scene: Scene, given: Setup, load: Load) -> None:
    for name, value in {
        "motor_gain": given.gain,
        "motor_offset": given.offset,
        "breakdown_torque": given.breakdown,
        "inertia": float(np.asarray(given.model.inertia)),
        "shell_share": float(np.asarray(given.model.ratio)),
        "target_speed": given.target,
        "speed_feedback_limit": given.reference / given.target,
    }.items():
        scene.emit(f"{ROOT}/{name}", value, 1e-12 * abs(value) if np.isfinite(value) else 0.0)
    put(scene, "mean_torque", given.torque.mean)
    put(scene, "speed_without", given.alone)
    both = WithError(np.asarray(load.harmonics), np.asarray(load.harmonics_error))
    put(scene, "disturbance", given.kept(both), {"order": given.orders})


def _emit_found(scene: Scene, given: Setup, found: Controlled, without: Controlled) -> None:
    axes = {"order": given.orders}
    put(scene, "speed", found.speed)
    put(scene, "speed_feedback", found.speed_feedback)
    put(scene, "shell_acceleration", given.kept(found.harmonics.shell_acceleration), axes)
    level, quiet = given.kept(found.level), given.kept(without.level)
    put(scene, "level", level, axes)
    put(scene, "level_without", quiet, axes)
    put(scene, "attenuation", less(quiet, level), axes)


def _emit_poles(scene: Scene, given: Setup, found: Controlled) -> None:
    """Poles of the loop and their way as the gain grows; with a delay a search that may fail."""
    controller = given.controller()._replace(speed_feedback=found.speed_feedback.value)
    try:
        own = poles(loop_of(given.model, controller), _BRANCHES)
        put(
            scene, "pole", WithError(own.value, own.error),
            {"pole": np.arange(1, own.value.shape[-1] + 1)},
        )  # fmt: skip
        if not scene.wants(f"{ROOT}/locus/pole"):
            return
        gain, kept = given.options.gain, given.options.speed_feedback is None
        gains = np.geomspace(min(1.0, 0.1 * gain), _BEYOND * max(1.0, gain), _LOCUS)
        moving = root_locus(
            given.model, controller, gains, given.load(given.target) if kept else None,
            given.target, _BRANCHES,
        )  # fmt: skip
        axes = {"locus_gain": gains, "branch": np.arange(1, moving.pole.shape[-1] + 1)}
        put(scene, "locus/pole", WithError(moving.pole, moving.pole_error), axes)
    except NumericalFailure as failure:
        scene.warn(f"the poles of the loop are left out: {failure}")


def _judge(scene: Scene, given: Setup, found: Controlled) -> None:
    status = int(found.margins.status)
    if status == 1:
        scene.warn(
            f"the loop is {STATUS[1]}: its gain at high frequency is "
            f"{abs(float(found.margins.feedthrough)):.4g}, so that the least delay lets it "
            "diverge; its levels hold on paper only"
        )
    elif status > 1:
        scene.warn(f"the loop is {STATUS[status]}: its amplitudes have no bound")
    asked = float(torque_peak(found, given).value)
    if status < 2 and asked > given.breakdown:
        scene.warn(
            f"the loop asks the motor for up to {asked:.5g} N*m, and it gives "
            f"{given.breakdown:.5g} N*m at most: the levels of the reduced model, whose motor has "
            "no breakdown, cannot be reached"
            + ("" if given.options.full_model else "; full_model = true says what can")
        )


def _say(scene: Scene, given: Setup) -> None:
    """What the reduced model takes for granted in this machine."""
    machine, motor = given.machine, scene.case.machine.motor
    if np.any(machine.wrist_pin_offset) or np.any(machine.rod_inertia_difference):
        scene.warn(
            "the reduced model of the control leaves out what a wrist pin offset or the own moment "
            "of a rod does to the shell; response/control/range says what that comes to"
        )
    if is_mounted(machine):
        frequency = np.sqrt(float(machine.shell_stiffness[0]) / given.torque.whole)
        scene.warn(
            "the reduced model of the control has no mounts: it holds for frequencies well above "
            f"{frequency:.4g} rad/s, at which the shell rolls on them, and does not see whether "
            "feedback excites that motion; full_model = true does"
        )
    if motor is not None and motor.kind == "dynamic":
        scene.warn("the control takes the motor's steady torque, without transients of its fluxes")


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
