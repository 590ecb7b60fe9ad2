"""Adapter: the body on its mounts, in six motions, in those of the crank plane, or in pitch."""

from functools import partial

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import in_hertz
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.steady import AtRest, Moved, emit_steady, moved_by
from vibecalc.isolation.at_mounts import AtMounts, deflected, require_weight, weight_load
from vibecalc.isolation.on_mounts import OnMounts, on_mounts, pitching
from vibecalc.isolation.results import (
    NEAREST,
    BodyModes,
    SupportDisplacement,
    SupportForce,
    TorqueReaction,
)
from vibecalc.isolation.torque_reaction import nearest_driven
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.leading import leave_alone
from vibecalc.parts.body import COORDINATES, RigidBody, dofs_of_model
from vibecalc.parts.mount_needs import foundation_kind, moves_with_machine
from vibecalc.parts.mounts import Mounts
from vibecalc.response.adapters.loads import BodyLoads, body_loads, steady_motion

#: an order that drives a mode is worth a word within this share of its natural frequency
CLOSE = 0.1


def run_isolation(scene: Scene) -> None:
    """Emit modes, sag, and the response of body and supports to all that acts on it."""
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    train, model = scene.case.machine.crank_train, isolation_of(scene).model
    if model == "pitch":
        system = pitching(body, mounts, train.axis, train.stroke_axis)
    else:
        system = on_mounts(body, mounts, dofs_of_model(model, train.axis))
        _emit_modes(scene, system)
    loads, speed = body_loads(scene), scene.case.machine.speed
    mean = AtMounts(*[Bounded(np.zeros((1, 3)), np.zeros((1, 3)))] * 2)
    if np.any(loads.mean.value):
        mean = deflected(system.resting, loads.mean)
    sag, share = _weight(scene, system, body)
    scene.emit_all(SupportDisplacement(static=sag), {"mount": mounts.names})
    scene.emit_all(SupportForce(static=share), {"mount": mounts.names})
    _warn_of_pull(scene, mounts, share)
    scene.handed_on["loads"], scene.handed_on["on_mounts"] = loads, system
    scene.handed_on["at_rest"] = AtRest(sag, share, mean)
    if mounts.rest is not None or mounts.spectrum is not None:
        from vibecalc.isolation.adapters.mounts import emit_mounts

        emit_mounts(scene, mounts, loads.order[: loads.retained], speed)
    if not moves_with_machine(scene.case):
        solve = partial(_moved, scene, system, loads)
        moved = solve(loads.load)
        emit_steady(scene, mounts, moved, solve)
        if model == "pitch":
            from vibecalc.isolation.adapters.pitch import emit_pitch

            emit_pitch(scene, system, loads, moved)
    on_ground = foundation_kind(scene.case) in ("", "mass")  # whose modes are those of the machine
    if model != "pitch" and on_ground and loads.torque is not None and scene.wants(*NEAREST):
        _emit_nearest(scene, system, loads)


def _warn_of_pull(scene: Scene, mounts: Mounts, load: Bounded) -> None:
    """Say which mount the weight pulls at most; of many machines (..., mounts) each alone does."""
    pulls = load.value < -load.error
    if pulls.ndim > 1:
        leave_alone(np.any(pulls, axis=-1))
    elif np.any(pulls):
        worst = int(np.argmin(load.value))
        scene.warn(
            f"at rest the weight pulls at mount {mounts.names[worst]!r} with "
            f"{-load.value[worst]:.4g} N: the mass centre is not between the mounts"
        )


def _moved(scene: Scene, system: OnMounts, loads: BodyLoads, load: Bounded) -> Moved:
    """Of loads (..., m, 6) on a body whose mounts stand on rigid ground."""
    motion = steady_motion(scene, system, system.felt(load), loads.order)
    return moved_by(system, motion, loads.order * np.asarray(scene.case.machine.speed)[..., None])


def _emit_nearest(scene: Scene, system: OnMounts, loads: BodyLoads) -> None:
    """The nearest order of each mode, and a warning for those that nearly meet."""
    speed, used = scene.case.machine.speed, loads.retained
    felt = system.felt(loads.load[:used])
    nearest, margin = nearest_driven(system.shapes, felt, loads.order[:used], speed)
    axes = {"mode": np.arange(1, len(nearest) + 1)}
    scene.emit_all(TorqueReaction(nearest_order=nearest, margin=margin), axes)
    resonances = system.resonances(felt)
    for mode in np.flatnonzero(np.abs(margin.value) < CLOSE):
        scene.warn(
            f"order {nearest[mode]:g} of the torque reaction and the shaking is within "
            f"{CLOSE:.0%} of mode {mode + 1} of the body on its mounts, "
            f"{in_hertz(resonances.frequency[mode])} (damping ratio "
            f"{resonances.damping_ratio[mode]:.2g})"
        )


def _emit_modes(scene: Scene, system: OnMounts) -> None:
    scene.cite(
        "rigid body on mounts, 6 x 6 complex dynamic stiffness",
        "response on the mounts",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3",
    )
    shapes, reach, share = system.shapes, system.reach.mT, system.energy_fraction()
    found = BodyModes(
        natural_frequency=shapes.bounded_frequency,
        damping_ratio=system.damping_ratio(),
        shape=reshaped(shapes.bounded_shape, np.matrix_transpose) @ reach,
        energy_fraction=share @ reach,
    )
    axes = {"mode": np.arange(1, len(system.freedoms) + 1), "coordinate": COORDINATES}
    scene.emit_all(found, axes)


def _weight(scene: Scene, system: OnMounts, body: RigidBody) -> tuple[Bounded, Bounded]:
    """Sag and share of the weight of each mount (..., mounts), positive downwards."""
    options, rest = isolation_of(scene), system.mounts.rest
    up = np.eye(3)["xyz".index(options.up)]
    if rest is not None:
        return -(rest.motion @ up), -(rest.force @ up)
    load = weight_load(body.mass, body.centre, options.gravity, up, body.centre_error)
    down, few = deflected(system.resting, load), -up[list(system.directions)]
    sag, share = (one @ few for one in down)
    require_weight(share, load)
    return sag, share
