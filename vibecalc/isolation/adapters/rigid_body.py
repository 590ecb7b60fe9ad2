"""Adapter: the body on its mounts with six degrees of freedom, or those in the crank plane."""

from functools import partial

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import as_loads
from vibecalc.isolation.adapters.common import OF_RUN_UP, emit_static, isolation_of
from vibecalc.isolation.adapters.loads import (
    AtMounts,
    BodyLoads,
    body_loads,
    mean_at_mounts,
    motion_of_six,
)
from vibecalc.isolation.adapters.steady import AtRest, Moved, emit_steady
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.isolation.results import NEAREST
from vibecalc.isolation.rigid_body import Static, displacement, held, static_deflection
from vibecalc.isolation.torque_reaction import nearest_driven
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.parts.body import COORDINATES, RigidBody, dofs_of_model
from vibecalc.parts.mount_needs import moves_with_machine
from vibecalc.parts.mounts import Mounts

#: an order that drives a mode is worth a word within this share of its natural frequency
CLOSE = 0.1

# ----------------------------------------------------------------------------
# Adapter: the body on its mounts with all six freedoms, or those in the plane of the crank.
# ----------------------------------------------------------------------------


def run_isolation_rigid_body(scene: Scene) -> None:
    """Emit modes, energies, sag, and the response of body and supports to all that acts on it."""
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    dofs = freedoms_of(scene)
    system = on_mounts(body, mounts, dofs)
    scene.cite(
        "rigid body on mounts, 6 x 6 complex dynamic stiffness",
        "response on the mounts",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3",
    )
    _emit_modes(scene, system)
    static = static_of(scene, held(system.whole, dofs), body, mounts)
    sag, share = emit_static(scene, mounts.names, static)

    loads, speed = body_loads(scene), scene.case.machine.speed
    mean = AtMounts(*[Bounded(np.zeros((1, 3)), np.zeros((1, 3)))] * 2)
    if np.any(loads.mean.value):
        mean = mean_at_mounts(system, body, loads.mean)
    at_rest = AtRest(sag, share, mean)
    scene.handed_on["loads"], scene.handed_on["on_mounts"] = loads, system
    scene.handed_on["at_rest"] = at_rest
    if mounts.rest is not None or mounts.spectrum is not None:
        from vibecalc.isolation.adapters.mounts import emit_mounts

        emit_mounts(scene, mounts, loads.order[: loads.retained], speed)
    if not moves_with_machine(scene.case):
        solve = partial(_moved, scene, system, loads)
        emit_steady(scene, mounts, loads, at_rest, solve(loads.load), solve)
        if loads.torque is not None and scene.wants(*NEAREST):
            _emit_nearest(scene, system, loads)
    if isinstance(scene, PointsScene) and scene.wants(*OF_RUN_UP):
        from vibecalc.isolation.arrays import hand_on_bodies

        forcing: Forcing = scene.handed_on["forcing"]
        per_square = system.felt(as_loads(forcing.per_speed_squared))
        hand_on_bodies(scene, forcing, system, per_square)


def _moved(scene: Scene, system: OnMounts, loads: BodyLoads, load: Bounded) -> Moved:
    """Of loads (..., m, 6) on a body whose mounts stand on rigid ground."""
    steady, _ = motion_of_six(scene, system, loads._replace(load=load))
    at_mounts = displacement(steady.motion, system.mounts.position)
    frequency = loads.order * np.asarray(scene.case.machine.speed)[..., None]
    force = system.force(at_mounts, frequency)
    return Moved(steady.motion, at_mounts, at_mounts, force)


def _emit_nearest(scene: Scene, system: OnMounts, loads: BodyLoads) -> None:
    """The nearest order of each mode, and a warning for those that nearly meet."""
    speed, used = scene.case.machine.speed, loads.retained
    felt = system.felt(loads.load[:used])
    nearest = nearest_driven(system.shapes, felt, loads.order[:used], speed)
    axes = {"mode": np.arange(1, len(nearest.order) + 1)}
    scene.emit(NEAREST[0], nearest.order, 0.0, axes)
    scene.emit(NEAREST[1], nearest.margin, nearest.margin_error, axes)
    resonances = system.resonances(felt)
    for mode in np.flatnonzero(np.abs(nearest.margin) < CLOSE):
        scene.warn(
            f"order {nearest.order[mode]:g} of the torque reaction and the shaking is within "
            f"{CLOSE:.0%} of mode {mode + 1} of the body on its mounts, "
            f"{resonances.frequency[mode]:.6g} rad/s (damping ratio "
            f"{resonances.damping_ratio[mode]:.2g})"
        )


def freedoms_of(scene: Scene) -> np.ndarray:
    """The motions (f,) that the model of `[isolation]` keeps, as indices into x y z rx ry rz."""
    return dofs_of_model(isolation_of(scene).model, scene.case.machine.crank_train.axis)


def _emit_modes(scene: Scene, system: OnMounts) -> None:
    dofs, shapes = system.freedoms, system.shapes
    axes = {"mode": np.arange(1, len(dofs) + 1), "coordinate": COORDINATES}
    ratio = system.damping_ratio()
    share = system.energy_fraction()
    scene.emit(
        "isolation/modes/natural_frequency",
        shapes.natural_frequency,
        shapes.natural_frequency_error,
        axes,
    )
    scene.emit("isolation/modes/damping_ratio", ratio.value, ratio.error, axes)
    scene.emit("isolation/modes/shape", shapes.shape.mT @ system.reach.T, shapes.shape_error, axes)
    scene.emit("isolation/modes/energy_fraction", share.value @ system.reach.T, share.error, axes)


def static_of(scene: Scene, matrices: Matrices, body: RigidBody, mounts: Mounts) -> Static:
    """The body at rest under its weight; `matrices` have all six motions."""
    options = isolation_of(scene)
    up = np.eye(3)["xyz".index(options.up)]
    if mounts.rest is not None:
        from vibecalc.isolation.adapters.mounts import static_at_rest

        return static_at_rest(mounts.rest, up)
    return static_deflection(
        matrices,
        mounts.position,
        mounts.stiffness,
        body.mass,
        body.centre,
        options.gravity,
        up,
        body.centre_error,
    )
