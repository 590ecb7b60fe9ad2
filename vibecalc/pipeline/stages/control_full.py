"""Adapter, continued: the full nonlinear machine beside the reduced model."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.level import level_of
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.control_setup import Setup
from vibecalc.pipeline.stages.control_values import less, put
from vibecalc.response.roll.controlled import Law
from vibecalc.response.roll.controlled_state import closed_loop
from vibecalc.response.roll.machine import RollDrive
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.running import running_state
from vibecalc.response.roll.turn import harmonics
from vibecalc.response.roll_control.tangent import straight


def emit_range(scene: Scene, given: Setup, reduced: WithError) -> WithError | None:
    """Levels of the full model without control, less those of the reduced one; and the first."""
    found: list[WithError] = []
    lines = given.drive._replace(motor=straight(given.gain, given.offset))
    for drive in (given.drive, lines):
        try:
            found.append(_uncontrolled(scene, given, drive))
        except NumericalFailure as failure:
            scene.warn(
                "without control the full model has no running state to hold the reduced one "
                f"against: {failure}"
            )
            break
    axes = {"order": given.orders}
    if found:
        put(scene, "range/level", found[0], axes)
        put(scene, "range/difference", less(found[0], reduced), axes)
    if len(found) > 1:
        put(scene, "range/linear_difference", less(found[1], reduced), axes)
    return found[0] if found else None


def emit_full(
    scene: Scene, given: Setup, feedback: float, reduced: WithError, without: WithError | None
) -> None:
    """The closed loop in the full model: levels beside the reduced ones, or that it is unstable."""
    options = given.options
    law = Law(
        options.gain, feedback, options.acceleration_feedback, given.reference, options.actuator_lag
    )
    found = closed_loop(
        given.machine, given.drive, law,
        rtol=scene.case.accuracy.rtol, orders=len(given.orders),
    )  # fmt: skip
    axes = {
        "order": given.orders,
        "multiplier": np.arange(1, len(found.multiplier) + 1),
    }
    level = level_of(found.harmonics.value, found.harmonics.error, reference=1.0)
    if not found.stable:
        level = WithError(np.full(len(given.orders), np.inf), np.zeros(len(given.orders)))
        size = float(np.max(np.abs(found.multiplier)))
        scene.warn(
            "under control the motion of the full model is unstable: a disturbance grows by the "
            f"factor {size:.6g} in each turn. It has no levels"
        )
    put(scene, "full/speed", found.speed)
    put(scene, "full/level", level, axes)
    put(scene, "full/difference", less(level, reduced), axes)
    if without is not None:
        put(scene, "full/attenuation", less(without, level), axes)
    put(scene, "full/multiplier", WithError(found.multiplier, found.multiplier_error), axes)
    put(scene, "full/stable", WithError(np.asarray(int(found.stable)), np.zeros(())))
    put(scene, "full/largest_slip", found.largest_slip)
    scene.cite(
        "Gauss collocation of rotor, pistons, shell and controller over the crank angle",
        "the closed loop in the full nonlinear model, and its stability",
        "docs/theory_roll.md; own extension by the state of the actuator",
    )


def _uncontrolled(scene: Scene, given: Setup, drive: RollDrive) -> WithError:
    running = running_state(
        given.machine, drive, rtol=scene.case.accuracy.rtol, orders=len(given.orders)
    )
    each = [
        harmonics(
            state.turn,
            readings(given.machine, drive, state.turn, pistons=False).shell_acceleration,
            given.orders.astype(float),
        )[0]
        for state in (running.state, running.check)
    ]
    rounding = 64.0 * EPSILON * float(np.max(np.abs(each[0])))
    return level_of(each[0], np.abs(each[0] - each[1]) + rounding, reference=1.0)
