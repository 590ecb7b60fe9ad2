"""The body of `[isolation]` as plain arrays, read at one of its supports."""

import numpy as np

from vibecalc.accuracy.yardsticks.mounted import Mounted
from vibecalc.excitation.sums import about_point, as_loads
from vibecalc.isolation.rigid_body import assemble, displacement_at
from vibecalc.machine.pitch import pitch_parts
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing
from vibecalc.pipeline.stages.isolation_common import isolation_of


def support_of(scene: Scene, mount: int) -> Mounted:
    """What shakes the body, and the force of one support on the ground, for either model.

    Loads are those of all orders that the excitation has handed on, guard orders included.
    """
    forcing: Forcing = scene.handed_on["forcing"]
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    if isolation_of(scene).model == "pitch":
        train = scene.case.machine.crank_train
        parts = pitch_parts(body, mounts, train.axis, train.stroke)
        couple = about_point(forcing.per_speed_squared, parts.centre).couple @ parts.across
        square = np.square(parts.position)
        stiffness, damping, structural = (
            np.array([[square @ part]])
            for part in (parts.stiffness, parts.damping, parts.structural)
        )
        lever = -parts.position[mount]
        spring = parts.stiffness[mount] + 1j * parts.structural[mount]
        return Mounted(
            np.array([[parts.inertia]]),
            stiffness,
            damping,
            structural,
            couple[:, None],
            forcing.orders,
            np.array([[spring * lever]]),
            np.array([[parts.damping[mount] * lever]]),
        )
    matrices = assemble(
        body.mass_matrix, mounts.position, mounts.stiffness, mounts.damping, mounts.structural
    )
    there = displacement_at(mounts.position[mount])
    load = as_loads(forcing.per_speed_squared)
    # what is zero to rounding would drive what it does not
    value = np.where(np.abs(load.value) > load.error, load.value, 0.0)
    return Mounted(
        matrices.mass,
        matrices.stiffness,
        matrices.damping,
        matrices.structural,
        value,
        forcing.orders,
        (mounts.stiffness[mount] + 1j * mounts.structural[mount]) @ there,
        mounts.damping[mount] @ there,
    )
