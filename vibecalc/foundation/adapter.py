"""Adapter: forces of the crank train onto machine and foundation, up and down."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import peak_with_tail
from vibecalc.foundation.results import UpAndDown
from vibecalc.foundation.two_masses import TwoMasses, motion, natural_frequencies
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.parts.body import DIRECTIONS


def run_foundation(scene: Scene) -> None:
    """Emit the steady motion at the operating speed, and what a rigid foundation would get."""
    case, forcing = scene.case, scene.handed_on["forcing"]
    system, up = two_masses(scene)
    used, speed = forcing.retained, case.machine.speed
    natural = natural_frequencies(system)
    rounding = 16.0 * EPSILON * natural.max(axis=-1, keepdims=True)
    axes = {"foundation_mode": np.arange(1, 3), "order": forcing.order[:used]}
    per_square = forcing.per_speed_squared[..., up]
    square = np.asarray(speed**2)[..., None]
    frequency = forcing.order * np.asarray(speed)[..., None]
    motions = motion(system, per_square.value * square, per_square.error * square, frequency)
    found = UpAndDown(
        natural_frequency=Bounded(natural, rounding),
        machine=motions.machine[..., :used],
        motion=motions.foundation[..., :used],
        ground_force=motions.ground_force[..., :used],
        rigid_force=motions.rigid_force[..., :used],
        motion_peak=lambda: peak_with_tail(motions.foundation, forcing),
        ground_force_peak=lambda: peak_with_tail(motions.ground_force, forcing),
        rigid_force_peak=lambda: peak_with_tail(motions.rigid_force, forcing),
    )
    scene.emit_all(found, axes)
    scene.cite(
        "two masses with complex stiffness",
        "motion of machine and foundation",
        "Den Hartog, Mechanical Vibrations, 4th ed., section 3.2",
    )


def two_masses(scene: Scene) -> tuple[TwoMasses, int]:
    """Machine and foundation of a case, and the axis along which they move."""
    case, body, mounts = scene.case, scene.parts.body, scene.parts.mounts
    given = case.foundation
    if given is None or body is None or mounts is None or case.isolation is None:
        raise ValueError("[foundation] needs [isolation], a body and mounts")
    if given.mass is None or given.stiffness is None:
        raise ValueError("a foundation of kind 'mass' has a mass and a stiffness")
    up = DIRECTIONS.index(case.isolation.up)

    def together(each: FloatArray) -> FloatArray:
        return np.asarray(each[..., up, up].sum(axis=-1))

    return TwoMasses(
        machine_mass=np.asarray(body.mass_matrix[..., 0, 0]),
        mount_stiffness=together(mounts.stiffness),
        mount_damping=together(mounts.damping),
        mount_structural=together(mounts.structural),
        foundation_mass=np.asarray(given.mass),
        stiffness=np.asarray(given.stiffness),
        damping=np.asarray(given.damping),
        structural=np.asarray(given.loss_factor * given.stiffness),
    ), up
