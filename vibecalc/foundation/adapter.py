"""Adapter: forces of the crank train onto machine and foundation, up and down."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.foundation.results import ROOT
from vibecalc.foundation.two_masses import TwoMasses, motion, natural_frequencies
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.parts.body import DIRECTIONS


def run_foundation(scene: Scene) -> None:
    """Emit the steady motion at the operating speed, and what a rigid foundation would get."""
    case, forcing = scene.case, scene.handed_on["forcing"]
    system, up = two_masses(scene)
    used, speed = forcing.retained, case.machine.speed
    natural = natural_frequencies(system)
    scene.emit(
        f"{ROOT}/natural_frequency", natural, 16.0 * EPSILON * natural.max(),
        {"foundation_mode": np.arange(1, 3)},
    )  # fmt: skip
    force = forcing.per_speed_squared.force[:, up] * speed**2
    error = forcing.per_speed_squared.force_error[:, up] * speed**2
    motions = motion(system, force, error, forcing.orders * speed)
    axes = {"order": forcing.orders[:used]}
    for name, result in (
        ("machine", motions.machine),
        ("motion", motions.foundation),
        ("ground_force", motions.ground_force),
        ("rigid_force", motions.rigid_force),
    ):
        scene.emit(f"{ROOT}/{name}", result.value[:used], result.error[:used], axes)
        if name != "machine":
            _emit_peak(scene, f"{ROOT}/{name}_peak", result, forcing)
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
    up = DIRECTIONS.index(case.isolation.up)

    def together(each: FloatArray) -> FloatArray:
        return np.asarray(each[:, up, up].sum())

    return TwoMasses(
        machine_mass=np.asarray(body.mass_matrix[0, 0]),
        mount_stiffness=together(mounts.stiffness),
        mount_damping=together(mounts.damping),
        mount_structural=together(mounts.structural),
        foundation_mass=np.asarray(given.mass),
        stiffness=np.asarray(given.stiffness),
        damping=np.asarray(given.damping),
        structural=np.asarray(given.loss_factor * given.stiffness),
    ), up


def _emit_peak(scene: Scene, path: str, harmonics: Bounded, forcing: Forcing) -> None:
    """Largest value over a cycle; the guard orders tell what the rest leaves out."""
    used = forcing.retained
    peak = cycle_peak(harmonics.value[:used], forcing.orders[:used])
    left_out = np.sum(np.abs(harmonics.value[used:])) * forcing.tail
    scene.emit(path, peak.value, peak.error + np.sum(harmonics.error[:used]) + left_out)
