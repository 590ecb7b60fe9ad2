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
from vibecalc.absorber.results import Jump, OverOrders, Pendulum, SmallSwings, SteadySwings
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.pendulums import SMALL_SWING

#: orders of the response curve, over the wanted one
_RATIOS = (0.8, 1.2, 401)


def run_absorber_pendulum(scene: Scene) -> None:
    """Emit order, detuning, response to the torque of the case and the torque of a jump."""
    parts = build_pendulum(scene.case)
    pendulum = parts.pendulum
    nearby = as_secondary(pendulum, parts.rotor_inertia, parts.speed, parts.damping)
    ratio, off = nearby.inertia / nearby.primary_inertia, nearby.error
    found = Pendulum(
        order=tuning_order(pendulum),
        path_radius=rounded(pendulum.path_radius, 16.0),
        path_exponent=Bounded(np.asarray(pendulum.path_exponent), np.asarray(EPSILON)),
        detuning=detuning_coefficient(pendulum),
        largest_swing=rounded(largest_swing(pendulum), 8.0),
        mass_ratio=Bounded(ratio, 4.0 * off * ratio),
        inertia=Bounded(nearby.inertia, 2.0 * off * nearby.inertia),
        stiffness=Bounded(nearby.stiffness, 2.0 * off * nearby.stiffness),
        order_of_swing=order_of_swing(pendulum, parts.swings) if parts.swings.size else None,
    )
    scene.emit_all(found, {"swing": parts.swings})
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
    inertia = float(nearby.primary_inertia + nearby.inertia)
    locked = torque / (hold - inertia * frequency**2)
    lost = (hold + inertia * frequency**2) * abs(locked) / torque
    slack = (2.0 * float(nearby.error) + 8.0 * EPSILON) * abs(locked)
    scene.emit_all(SmallSwings(
        rotor=Bounded(motion.rotor, motion.rotor_error),
        swing=Bounded(motion.swing, motion.swing_error),
        rotor_without=Bounded(np.asarray(complex(locked)), np.asarray(slack * lost)),
    ))  # fmt: skip
    ratios = np.linspace(*_RATIOS)
    sweep = small_motion(nearby, ratios * frequency, torque, hold)
    with np.errstate(divide="ignore"):
        alone = torque / (hold - inertia * (ratios * frequency) ** 2)
    curves = OverOrders(
        rotor=Bounded(sweep.rotor, sweep.rotor_error),
        without=Bounded(alone.astype(complex), 1e-12 * np.abs(alone)),
    )
    scene.emit_all(curves, {"order_ratio": ratios})
    reach = float(np.abs(motion.swing))
    if reach > SMALL_SWING:
        scene.warn(
            f"swings of {np.degrees(reach):.4g} degrees under this torque, by equations for small "
            "ones"
        )


def _emit_steady(scene: Scene, parts: PendulumParts) -> None:
    """Torque that holds each swing of an undamped pendulum, by its exact equations."""
    swings, found = [], []
    for swing in parts.swings[parts.swings > 0.0]:
        try:
            motion = steady_motion(parts.pendulum, parts.rotor_inertia, parts.order, swing)
        except NumericalFailure as failure:
            scene.warn(f"beyond a swing of {np.degrees(swing):.4g} degrees: {failure}")
            break
        swings.append(float(swing))
        found.append([*motion.torque * parts.speed**2, *motion.largest])
    torque, error, reach, off = np.array(found, dtype=float).reshape(-1, 4).T
    rows = SteadySwings(Bounded(torque, error), Bounded(reach, off))
    scene.emit_all(rows, {"steady_swing": np.array(swings)})


def _emit_jump(scene: Scene, parts: PendulumParts) -> None:
    """The torque beyond which the motion out of rest is gone; infinite where there is none."""
    try:
        found = jump(parts.pendulum, parts.rotor_inertia, parts.order)
    except NumericalFailure as failure:
        scene.warn(str(failure))
        scene.emit_all(Jump(np.inf, np.inf))
        return
    torque = found.torque * parts.speed**2
    scene.emit_all(Jump(torque, found.swing))
    limit = float(torque.value)
    if parts.torque is not None and parts.torque > limit:
        scene.warn(
            f"the torque of {parts.torque:.4g} N*m is above the jump at {limit:.4g} N*m: the "
            "steady motion of small swings does not exist"
        )
