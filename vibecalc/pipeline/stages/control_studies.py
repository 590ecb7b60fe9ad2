"""Adapter, continued: other motors, a grid of gains and feedbacks, and gains that are searched."""

import numpy as np

from vibecalc.case.control_tables import Tune
from vibecalc.numerics.rounding import WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.control_setup import Setup
from vibecalc.pipeline.stages.control_values import emit_loop, less, put
from vibecalc.response.roll_control.certificate import BOUNDS, certify
from vibecalc.response.roll_control.count import STATUS
from vibecalc.response.roll_control.evaluate import evaluate_at_speed
from vibecalc.response.roll_control.motor_gains import motor_gain_study
from vibecalc.response.roll_control.tune import Demands, tune


def emit_motor_gains(scene: Scene, given: Setup) -> None:
    """Speed and levels with motors whose curve is a line through the origin, uncontrolled."""
    gains = np.array(given.options.motor_gains)
    load = given.load(float(given.alone.value), given.synchronous, 0.0)
    found = motor_gain_study(given.model, gains, load)
    axes = {"motor_gain": gains, "order": given.orders}
    put(scene, "motor_gains/speed", found.speed, axes)
    put(scene, "motor_gains/level", given.kept(found.level), axes)


def emit_grid(scene: Scene, given: Setup, without: WithError) -> None:
    """Every gain with every feedback, the speed kept at the target."""
    options = given.options
    gains = np.array(options.gains or (options.gain,))
    feedbacks = np.array(options.feedbacks or (options.acceleration_feedback,))
    controller = given.controller()._replace(gain=gains[:, None], acceleration_feedback=feedbacks)
    found = evaluate_at_speed(given.model, controller, given.load(given.target), given.target)
    axes = {"gain": gains, "feedback": feedbacks, "order": given.orders}
    feedback = WithError(found.speed_feedback.value[:, 0], found.speed_feedback.error[:, 0])
    put(scene, "grid/speed_feedback", feedback, axes)
    emit_loop(scene, "grid/", found, given, axes)
    level = given.kept(found.level)
    put(scene, "grid/level", level, axes)
    put(scene, "grid/attenuation", less(without, level), axes)
    lost, brittle = (int(np.sum(found.margins.status >= 2)), int(np.sum(found.margins.status == 1)))
    if lost or brittle:
        scene.warn(
            f"of {gains.size * feedbacks.size} pairs of gain and feedback {lost} are not stable "
            f"and {brittle} {STATUS[1]}: their levels are infinite, or hold on paper only"
        )


def emit_tuned(scene: Scene, given: Setup, asked: Tune, without: WithError) -> None:
    """The gains that make the loudest of some orders quietest and keep their distance."""
    demands = Demands(
        (asked.gain.lower, asked.gain.upper),
        (asked.acceleration_feedback.lower, asked.acceleration_feedback.upper),
        asked.gain_margin,
        asked.phase_margin,
        asked.delay_margin,
    )
    load, controller = given.load(given.target), given.controller()
    found = tune(given.model, controller, load, given.target, demands, asked.orders)
    proof = certify(given.model, controller, load, given.target, demands, found, asked.orders)
    put(scene, "tuned/gain", found.gain)
    put(scene, "tuned/acceleration_feedback", found.acceleration_feedback)
    put(scene, "tuned/speed_feedback", found.controlled.speed_feedback)
    put(scene, "tuned/objective", found.objective)
    axes = {"order": given.orders, "bound": np.array(BOUNDS, dtype=object)}
    level = given.kept(found.controlled.level)
    put(scene, "tuned/level", level, axes)
    put(scene, "tuned/attenuation", less(without, level), axes)
    emit_loop(scene, "tuned/", found.controlled, given)
    put(scene, "tuned/active", WithError(proof.active.astype(float), np.zeros(())), axes)
    # the differences are good to 1e-7, the place where they are taken to little more than 1e-6
    doubt = 1e-5 * (1.0 + np.abs(proof.multiplier))
    put(scene, "tuned/multiplier", WithError(proof.multiplier, doubt), axes)
    put(scene, "tuned/residual", WithError(np.asarray(proof.residual), np.asarray(1e-5)))
    scene.cite(
        "grids that close in over gain and feedback; conditions of Karush, Kuhn and Tucker",
        "gains of the controller under stability margins",
        "docs/theory_roll_control.md",
    )
