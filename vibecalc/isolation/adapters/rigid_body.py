"""Adapter: the body on its mounts with six degrees of freedom, or those in the crank plane."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, few_orders, peak_with_tail
from vibecalc.excitation.inertia_forces import Excitation, as_loads, at_speed, size_of_terms
from vibecalc.isolation.adapters.common import (
    HEIGHTS,
    LARGEST,
    OF_RUN_UP,
    KeptRows,
    OfBody,
    RunUpSetup,
    emit_heights,
    emit_static,
    emit_support_motion,
    isolation_of,
    length_over_cycle,
)
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.isolation.rigid_body import (
    Static,
    all_six,
    displacement,
    held,
    mount_readout,
    static_deflection,
)
from vibecalc.isolation.rows import Readout, with_left_out
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.parts.body import COORDINATES, DIRECTIONS, RigidBody, dofs_of_model
from vibecalc.parts.firing import torque_reaches_mounts
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mounts import Mounts
from vibecalc.response.forced import MotionByOrder, require_digits, response
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import check_operating_point, idle_warnings

# ----------------------------------------------------------------------------
# Adapter: the body on its mounts with all six freedoms, or those in the plane of the crank.
# ----------------------------------------------------------------------------


class MountedBody(NamedTuple):
    """A body on its mounts for those who load it otherwise: what the run-up is made of.

    Matrices and modes of the motions `freedoms`, the `readout` of the supports, and which of the
    modes each of them `shows` (modes, supports); all of it is of `system`.
    """

    freedoms: np.ndarray
    matrices: Matrices
    shapes: Modes
    readout: Readout
    shows: np.ndarray
    system: OnMounts


def run_isolation_rigid_body(scene: Scene) -> None:
    """Emit modes, energies, sag, and the response of body and supports."""
    forcing: Forcing = scene.handed_on["forcing"]
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    dofs = freedoms_of(scene)
    system = on_mounts(body, mounts, dofs)
    matrices = system.matrices
    scene.cite(
        "rigid body on mounts, 6 x 6 complex dynamic stiffness",
        "response on the mounts",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3",
    )
    _emit_modes(scene, system)
    sag = _emit_static(scene, held(system.whole, dofs), body, mounts)

    load = _loads(forcing.per_speed_squared, dofs)
    resonances = system.resonances(load)
    speed = scene.case.machine.speed
    for warning in check_operating_point(resonances, forcing.orders, speed):
        scene.warn(warning)
    frequency = forcing.orders * np.asarray(speed)[..., None]
    driven = _loads(at_speed(forcing.per_speed_squared, speed), dofs)
    dynamic = system.dynamics(frequency, resonances)
    motion = response(dynamic, driven.value, driven.error)
    require_digits(matrices, dynamic, driven, motion, forcing.orders, speed)
    motion = Bounded(*(all_six(part, dofs) for part in motion))
    scene.handed_on["motion_by_order"] = MotionByOrder(
        forcing.orders, forcing.retained, forcing.tail, motion
    )
    _emit_motion(scene, forcing, motion)
    at_mounts = displacement(motion, mounts.position)
    force = system.force(at_mounts, frequency)
    up = np.eye(3)["xyz".index(isolation_of(scene).up)]
    emit_support_motion(scene, forcing, mounts.names, DIRECTIONS, at_mounts, force)
    if scene.wants(LARGEST):
        largest = length_over_cycle(force, forcing)
        axes = {"mount": mounts.names}
        scene.emit(LARGEST, largest.value, largest.error, axes, terms=largest.terms)
    if scene.wants(*HEIGHTS):
        vertical = Bounded(
            np.einsum("...dn,d->...n", at_mounts.value, up),
            np.einsum("...dn,d->...n", at_mounts.error, np.abs(up)),
        )
        emit_heights(scene, mounts.names, peak_with_tail(vertical, forcing), sag)
    if mounts.rest is not None or mounts.spectrum is not None:
        from vibecalc.isolation.adapters.mounts import emit_mounts, emit_travel

        emit_mounts(scene, mounts, forcing.orders[: forcing.retained], speed)
        if not torque_reaches_mounts(scene.case):
            emit_travel(scene, mounts, at_mounts, forcing.orders, forcing.retained, forcing)
    if scene.wants(*OF_RUN_UP):
        if isinstance(scene, PointsScene):
            from vibecalc.isolation.arrays import hand_on_bodies

            hand_on_bodies(scene, forcing, system, load)
        else:
            _hand_on_run_up(scene, forcing, system, load)


def freedoms_of(scene: Scene) -> np.ndarray:
    """The motions (f,) that the model of `[isolation]` keeps, as indices into x y z rx ry rz."""
    return dofs_of_model(isolation_of(scene).model, scene.case.machine.crank_train.axis)


def _loads(excitation: Excitation, dofs: np.ndarray) -> Bounded:
    return Bounded(*(part[..., dofs] for part in as_loads(excitation)))


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
    scene.emit("isolation/modes/shape", all_six(shapes.shape.mT, dofs), shapes.shape_error, axes)
    scene.emit("isolation/modes/energy_fraction", all_six(share.value, dofs), share.error, axes)


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


def _emit_static(scene: Scene, matrices: Matrices, body: RigidBody, mounts: Mounts) -> Bounded:
    static = static_of(scene, matrices, body, mounts)
    emit_static(scene, mounts.names, static.sag, static.sag_error, static.share, static.share_error)
    return Bounded(static.sag, static.sag_error)


def _emit_motion(scene: Scene, forcing: Forcing, motion: Bounded) -> None:
    used = forcing.retained
    axes = {"order": forcing.orders[:used], "direction": DIRECTIONS}
    for name, part in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        scene.emit(
            f"isolation/body/{name}_harmonics",
            motion[..., :used, part],
            axes=axes,
            terms=size_of_terms(motion.error[..., :used, part]),
        )


def _hand_on_run_up(scene: Scene, forcing: Forcing, system: OnMounts, load: Bounded) -> None:
    freedoms, mounts = system.freedoms, system.mounts
    loss = mounts.structural if mounts.spectrum is None else np.zeros_like(mounts.stiffness)
    whole = mount_readout(mounts.position, mounts.stiffness, mounts.damping, loss)
    readout = whole._replace(spring=whole.spring[..., freedoms], damper=whole.damper[..., freedoms])
    used, orders = forcing.retained, forcing.orders
    first = Bounded(load.value[:used], load.error[:used])
    few, few_tail = few_orders(forcing)
    higher = Bounded(load.value[few], load.error[few])
    met = system.resonances(first)
    resonances = system.with_poles(met, first)
    beyond = system.resonances(higher)
    shapes = system.shapes
    stretch = mounts.stiffness @ displacement_at(mounts.position)[..., freedoms] @ shapes.shape
    size = np.sqrt(np.square(stretch).sum(axis=1)).T
    shows = size > 1e-12 * size.max()
    scene.handed_on["mounted"] = MountedBody(
        freedoms, system.matrices, shapes, readout, shows, system
    )

    def rows(read: Readout, passed_on: bool = False) -> KeptRows:
        return KeptRows(
            system.rows(read, orders[:used], first, met, passed_on=passed_on),
            system.rows(read, orders[few], higher, beyond, passed_on=passed_on),
            few_tail,
            orders[few],
        )

    travel = system.travel()
    scene.handed_on["run_up"] = RunUpSetup(
        rows=with_left_out(*rows(readout, True)[:3]),
        harmonics=orders[:used],
        step=1,
        resonances=resonances,
        shows=shows,
        row_of=np.arange(len(mounts.names)),
        lever_rows=0,
        idle=lambda low, high: idle_warnings(resonances, orders[:used], low, high),
        of_body=of_body(rows, freedoms, shapes),
        travel=None if travel is None else with_left_out(*rows(travel)[:3]),
    )


def of_body(rows: Callable[[Readout], KeptRows], freedoms: np.ndarray, shapes: Modes) -> OfBody:
    """What is read of a body that has some of its six motions, as a run-up hands it on."""
    motion = np.eye(6)[:, freedoms]
    return OfBody(rows, motion, motion @ shapes.shape)
