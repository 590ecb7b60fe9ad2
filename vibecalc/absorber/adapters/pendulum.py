"""Adapter: pendulums on a rotor: their order, how it changes with the swing, what they absorb."""

import numpy as np

from vibecalc.absorber.pendulum_order import (
    PendulumParts,
    build_pendulum,
    detuning_coefficient,
    largest_swing,
    order_of_swing,
    tuning_order,
)
from vibecalc.absorber.pendulum_steady import (
    Secondary,
    as_secondary,
    jump,
    small_motion,
    steady_motion,
)
from vibecalc.absorber.results import PENDULUM_ROOT
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.pendulums import SMALL_SWING

#: orders of the response curve, over the wanted one
_RATIOS = (0.8, 1.2, 401)


def run_absorber_pendulum(scene: Scene) -> None:
    """Emit order, detuning, response to the torque of the case and the torque of a jump."""
    parts = build_pendulum(scene.case)
    tuned = tuning_order(parts.pendulum)
    scene.emit(f"{PENDULUM_ROOT}/order", tuned.value, tuned.error)
    radius = float(np.asarray(parts.pendulum.path_radius))
    scene.emit(f"{PENDULUM_ROOT}/path_radius", radius, 8.0 * EPSILON * radius)
    scene.emit(
        f"{PENDULUM_ROOT}/path_exponent", float(np.asarray(parts.pendulum.path_exponent)), EPSILON
    )
    detuning = detuning_coefficient(parts.pendulum)
    scene.emit(f"{PENDULUM_ROOT}/detuning", detuning.value, detuning.error)
    end = float(largest_swing(parts.pendulum))
    scene.emit(f"{PENDULUM_ROOT}/largest_swing", end, 4.0 * EPSILON * end)
    nearby = as_secondary(parts.pendulum, parts.rotor_inertia, parts.speed, parts.damping)
    error = float(nearby.error)
    ratio = float(nearby.inertia / nearby.primary_inertia)
    scene.emit(f"{PENDULUM_ROOT}/mass_ratio", ratio, 4.0 * error * ratio)
    scene.emit(
        f"{PENDULUM_ROOT}/inertia", float(nearby.inertia), 2.0 * error * float(nearby.inertia)
    )
    scene.emit(
        f"{PENDULUM_ROOT}/stiffness", float(nearby.stiffness), 2.0 * error * float(nearby.stiffness)
    )
    if parts.swings.size:
        orders = order_of_swing(parts.pendulum, parts.swings)
        scene.emit(
            f"{PENDULUM_ROOT}/order_of_swing", orders.value, orders.error, {"swing": parts.swings}
        )
    if parts.torque is not None:
        _emit_small(scene, parts, nearby, parts.torque)
    if parts.rotor_stiffness == 0.0:
        if parts.swings.size:
            _emit_steady(scene, parts)
        if parts.path == "circular":
            _emit_jump(scene, parts)
    scene.cite(
        "Lagrange's equations of rotor and pendulums in the rotating frame",
        "order, detuning, response",
        "Den Hartog, Mechanical Vibrations; Denman (1992) for the paths; "
        "docs/theory_absorber_parts.md",
    )


def _emit_small(scene: Scene, parts: PendulumParts, nearby: Secondary, torque: float) -> None:
    """Rotor and swing under the torque, as far as swings are small; rotor with locked pendulums."""
    frequency, hold = parts.order * parts.speed, parts.rotor_stiffness
    motion = small_motion(nearby, frequency, torque, hold)
    if np.isinf(np.abs(motion.rotor)):
        raise NumericalFailure(
            f"order {parts.order:.6g} meets an undamped resonance of rotor and pendulum"
        )
    scene.emit(f"{PENDULUM_ROOT}/small/rotor", motion.rotor, motion.rotor_error)
    scene.emit(f"{PENDULUM_ROOT}/small/swing", motion.swing, motion.swing_error)
    inertia = float(nearby.primary_inertia + nearby.inertia)
    locked = torque / (hold - inertia * frequency**2)
    lost = (hold + inertia * frequency**2) * abs(locked) / torque
    slack = (2.0 * float(nearby.error) + 8.0 * EPSILON) * abs(locked)
    scene.emit(f"{PENDULUM_ROOT}/small/rotor_without", complex(locked), slack * lost)
    ratios = np.linspace(*_RATIOS)
    sweep = small_motion(nearby, ratios * frequency, torque, hold)
    axes = {"order_ratio": ratios}
    finite = np.isfinite(np.abs(sweep.rotor))
    scene.emit(
        f"{PENDULUM_ROOT}/response/rotor",
        sweep.rotor,
        np.where(finite, sweep.rotor_error, 0.0),
        axes,
    )
    with np.errstate(divide="ignore"):
        alone = torque / (hold - inertia * (ratios * frequency) ** 2)
    scene.emit(
        f"{PENDULUM_ROOT}/response/without", alone.astype(complex),
        1e-12 * np.where(np.isfinite(alone), np.abs(alone), 0.0), axes,
    )  # fmt: skip
    reach = float(np.abs(motion.swing))
    if reach > SMALL_SWING:
        scene.warn(
            f"swings of {np.degrees(reach):.4g} degrees under this torque, by equations for small "
            "ones"
        )


def _emit_steady(scene: Scene, parts: PendulumParts) -> None:
    """Torque that holds each swing of an undamped pendulum, by its exact equations."""
    swings, torques, errors, reach = [], [], [], []
    square = parts.speed**2
    for swing in parts.swings[parts.swings > 0.0]:
        try:
            motion = steady_motion(parts.pendulum, parts.rotor_inertia, parts.order, swing)
        except NumericalFailure as failure:
            scene.warn(f"beyond a swing of {np.degrees(swing):.4g} degrees: {failure}")
            break
        swings.append(float(swing))
        torques.append(float(motion.torque.value) * square)
        errors.append(float(motion.torque.error) * square)
        reach.append((float(motion.largest.value), float(motion.largest.error)))
    axes = {"steady_swing": np.array(swings)}
    scene.emit(f"{PENDULUM_ROOT}/steady/torque", np.array(torques), np.array(errors), axes)
    largest, uncertainties = np.array(reach).reshape(-1, 2).T
    scene.emit(f"{PENDULUM_ROOT}/steady/largest_swing", largest, uncertainties, axes)


def _emit_jump(scene: Scene, parts: PendulumParts) -> None:
    """The torque beyond which the motion out of rest is gone; infinite where there is none."""
    try:
        found = jump(parts.pendulum, parts.rotor_inertia, parts.order)
    except NumericalFailure as failure:
        scene.warn(str(failure))
        scene.emit(f"{PENDULUM_ROOT}/jump/torque", np.inf)
        scene.emit(f"{PENDULUM_ROOT}/jump/swing", np.inf)
        return
    square = parts.speed**2
    scene.emit(
        f"{PENDULUM_ROOT}/jump/torque", found.torque.value * square, found.torque.error * square
    )
    scene.emit(f"{PENDULUM_ROOT}/jump/swing", found.swing.value, found.swing.error)
    limit = float(found.torque.value) * square
    if parts.torque is not None and parts.torque > limit:
        scene.warn(
            f"the torque of {parts.torque:.4g} N*m is above the jump at {limit:.4g} N*m: the "
            "steady motion of small swings does not exist"
        )
