"""Adapter: a machine on its mounts under the torque of its cylinders, with what shakes it."""

import numpy as np

from vibecalc.excitation.sums import at_speed
from vibecalc.isolation.freedoms import all_six, held, restricted
from vibecalc.isolation.mount_motion import displacement, mount_force
from vibecalc.isolation.rigid_body import assemble
from vibecalc.isolation.static import static_deflection
from vibecalc.isolation.torque_reaction import (
    extreme_loads,
    left_out,
    nearest_driven,
    vector_peak,
    with_shaking,
)
from vibecalc.machine.frame import DIRECTIONS
from vibecalc.machine.mounts import Mounts
from vibecalc.machine.planar import kept_freedoms
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.pipeline.entries.torque_reaction import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing
from vibecalc.pipeline.stages.isolation_common import isolation_of
from vibecalc.pipeline.stages.torque_reaction_couple import Couples, couples_of
from vibecalc.response.damped_basis import damped_basis
from vibecalc.response.direct import Undriven, dynamics, response
from vibecalc.response.matrices import Matrices
from vibecalc.response.modal_resonance import body_resonances
from vibecalc.response.modes import Modes, modes
from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import check_operating_point
from vibecalc.response.singular import left_out as undriven_pairs
from vibecalc.response.trust import require_digits

#: an order that drives a mode is worth a word within this share of its natural frequency
CLOSE = 0.1


def run(scene: Scene) -> None:
    """Emit couple, motion, forces and loads of the supports, and how near orders come to modes."""
    forcing: Forcing = scene.handed_on["forcing"]
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    options, speed = isolation_of(scene), scene.case.machine.speed
    axis = scene.parts.crank_train.axis
    whole = assemble(
        body.mass_matrix, mounts.position, mounts.stiffness, mounts.damping, mounts.structural
    )
    freedoms = kept_freedoms(options.model, scene.case.machine.crank_train.axis)
    matrices, whole = restricted(whole, freedoms), held(whole, freedoms)
    shapes = damped_basis(matrices, modes(matrices))
    couples = couples_of(scene, forcing.kept)
    scene.cite(
        "torque reaction of the cylinders with the shaking of the crank train, order by order",
        f"{scene.case.machine.kind} on its mounts",
        "docs/theory_torsion_mounts.md",
    )
    kept, order = couples.kept, couples.order
    scene.emit(
        f"{ROOT}/couple",
        couples.total.value[:kept],
        couples.total.error[:kept],
        {"half_order": order[:kept]},
    )
    scene.emit(f"{ROOT}/mean_couple", couples.mean.value, couples.mean.error)

    driven = at_speed(forcing.per_speed_squared, speed)
    shaking = WithError(
        np.concatenate([driven.force, driven.couple], axis=-1),
        np.concatenate([driven.force_error, driven.couple_error], axis=-1),
    )
    loads = _of(with_shaking(couples.added, order, axis, shaking), freedoms)
    few, resonances = _motion(scene, matrices, shapes, loads, order)
    motion = _six(few, freedoms)
    _emit_nearest(scene, shapes, resonances, loads, couples)
    _emit_motion(scene, motion, axis, couples)
    at_mounts = displacement(motion, mounts.position)
    force = mount_force(
        at_mounts, order * speed, mounts.stiffness, mounts.damping, mounts.structural
    )
    alone = with_shaking(
        couples.total, order, axis, WithError(shaking.value[:0], shaking.error[:0])
    )
    torque_motion, _ = _motion(scene, matrices, shapes, _of(alone, freedoms), order)
    of_torque = mount_force(
        displacement(_six(torque_motion, freedoms), mounts.position),
        order * speed,
        mounts.stiffness,
        mounts.damping,
        mounts.structural,
    )
    by_mount = {"mount": mounts.names}
    scene.emit(
        f"{ROOT}/support_force",
        force.value[..., :kept],
        force.error[..., :kept],
        {**by_mount, "direction": DIRECTIONS, "half_order": order[:kept]},
    )
    for name, harmonics in (("peak", force), ("of_torque", of_torque)):
        peak = vector_peak(harmonics, order, kept)
        scene.emit(f"{ROOT}/support_force_{name}", peak.value, peak.error, by_mount)
    mean = _mean_force(whole, mounts, couples.mean, axis)
    scene.emit(
        f"{ROOT}/mean_support_force", mean.value, mean.error, {**by_mount, "direction": DIRECTIONS}
    )
    up = np.eye(3)["xyz".index(options.up)]
    static = static_deflection(
        whole, mounts.position, mounts.stiffness, body.mass, body.centre, options.gravity, up
    )
    share = static.share - mean.value @ up
    share_error = static.share_error + mean.error @ up + UNIT_ROUNDOFF * np.abs(share)
    downwards = WithError(
        -np.einsum("mdn,d->mn", force.value, up), np.einsum("mdn,d->mn", force.error, up)
    )
    load = extreme_loads(downwards, order, kept, WithError(share, share_error))
    scene.emit(f"{ROOT}/largest_load", load.highest, load.error, by_mount)
    scene.emit(f"{ROOT}/least_load", load.lowest, load.error, by_mount)


def _of(loads: WithError, freedoms: np.ndarray) -> WithError:
    return WithError(loads.value[:, freedoms], loads.error[:, freedoms])


def _six(motion: WithError, freedoms: np.ndarray) -> WithError:
    return WithError(all_six(motion.value, freedoms), all_six(motion.error, freedoms))


def _motion(
    scene: Scene, matrices: Matrices, shapes: Modes, loads: WithError, order: np.ndarray
) -> tuple[WithError, Resonances]:
    """Motion (m, f) of the reference point under loads (m, f) at the operating speed."""
    speed = scene.case.machine.speed
    resonances = body_resonances(matrices, shapes, loads)
    for warning in check_operating_point(resonances, order, speed):
        scene.warn(warning)
    undriven = Undriven(undriven_pairs(resonances), shapes.shape, shapes.eigenvalue)
    system = dynamics(matrices, order * speed, undriven)
    motion = response(system, loads.value, loads.error)
    require_digits(matrices, system, loads, motion, order, speed)
    return motion, resonances


def _mean_force(
    matrices: Matrices, mounts: Mounts, couple: WithError, axis: np.ndarray
) -> WithError:
    """Force (mounts, 3) of each support on the ground under a constant couple about `axis`."""
    none = np.zeros((6, 6))
    still = matrices._replace(structural=none, structural_error=none)
    load = np.concatenate([np.zeros(3), float(couple.value) * axis])[None]
    doubt = np.concatenate([np.zeros(3), float(couple.error) * np.abs(axis)])[None]
    motion = response(dynamics(still, np.zeros(1)), load.astype(complex), doubt)
    force = mount_force(
        displacement(motion, mounts.position),
        np.zeros(1),
        mounts.stiffness,
        np.zeros_like(mounts.damping),
        np.zeros_like(mounts.structural),
    )
    return WithError(force.value[..., 0].real, force.error[..., 0])


def _emit_motion(scene: Scene, motion: WithError, axis: np.ndarray, couples: Couples) -> None:
    kept = couples.kept
    axes = {"half_order": couples.order[:kept], "direction": DIRECTIONS}
    for name, part in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        scene.emit(f"{ROOT}/{name}", motion.value[:kept, part], motion.error[:kept, part], axes)
    roll = WithError(motion.value[:, 3:] @ axis, motion.error[:, 3:] @ np.abs(axis))
    peak = cycle_peak(roll.value[:kept], np.rint(2.0 * couples.order[:kept]).astype(np.int64))
    scene.emit(f"{ROOT}/roll_peak", peak.value, peak.error + left_out(roll, kept))


def _emit_nearest(
    scene: Scene, shapes: Modes, resonances: Resonances, loads: WithError, couples: Couples
) -> None:
    """The nearest order of each mode, and a warning for those that nearly meet."""
    speed, kept = scene.case.machine.speed, couples.kept
    listed = WithError(loads.value[:kept], loads.error[:kept])
    found = nearest_driven(shapes, listed, couples.order[:kept], speed)
    axes = {"mode": np.arange(1, len(found.order) + 1)}
    scene.emit(f"{ROOT}/nearest_order", found.order, 0.0, axes)
    scene.emit(f"{ROOT}/margin", found.margin, found.margin_error, axes)
    for mode in np.flatnonzero(np.abs(found.margin) < CLOSE):
        scene.warn(
            f"order {found.order[mode]:g} of the torque reaction and the shaking is within "
            f"{CLOSE:.0%} of mode {mode + 1} of the body on its mounts, "
            f"{resonances.frequency[mode]:.6g} rad/s (damping ratio "
            f"{resonances.damping_ratio[mode]:.2g})"
        )
