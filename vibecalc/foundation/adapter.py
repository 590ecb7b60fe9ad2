"""Adapter: a machine on a foundation of one mass: both up and down, and all its motions there."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, peak_with_tail
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.foundation.model import on_floor, on_mass
from vibecalc.foundation.results import UpAndDown
from vibecalc.isolation.adapters.efficiency import Ground
from vibecalc.isolation.adapters.steady import emit_steady, moved_by
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.adapters.loads import BodyLoads, steady_motion


def run_foundation(scene: Scene) -> None:
    """Emit the steady motion at the operating speed, and what a rigid foundation would get."""
    forcing: Forcing = scene.handed_on["forcing"]
    speed, used = scene.case.machine.speed, forcing.retained
    system, alone = on_mass(scene)
    load = at_speed(forcing.per_speed_squared, speed)
    frequency = forcing.order * np.asarray(speed)[..., None]

    def moved(one: OnMounts) -> tuple[Bounded, Bounded]:
        motion = steady_motion(scene, one, one.felt(load), forcing.order)
        return motion, one.ground_load(motion, frequency)[..., 0]

    (motion, ground_force), (_, rigid_force) = moved(system), moved(alone)
    shapes = system.shapes
    found = UpAndDown(
        natural_frequency=shapes.bounded_frequency,
        machine=motion[..., :used, 0],
        motion=motion[..., :used, 1],
        ground_force=ground_force[..., :used],
        rigid_force=rigid_force[..., :used],
        motion_peak=lambda: peak_with_tail(motion[..., 1], forcing),
        ground_force_peak=lambda: peak_with_tail(ground_force, forcing),
        rigid_force_peak=lambda: peak_with_tail(rigid_force, forcing),
    )
    scene.emit_all(found, {"foundation_mode": np.arange(1, 3), "order": forcing.order[:used]})
    scene.cite(
        "two masses with complex stiffness",
        "motion of machine and foundation",
        "Den Hartog, Mechanical Vibrations, 4th ed., section 3.2",
    )


def run_machine(scene: Scene) -> None:
    """Emit the machine in all its motions on the foundation, under all that acts on it."""
    mounts, still = scene.parts.mounts, scene.handed_on["on_mounts"]
    assert mounts is not None
    loads: BodyLoads = scene.handed_on["loads"]
    frequency = loads.order * scene.case.machine.speed
    system = scene.handed_on["on_foundation"] = on_floor(scene, still.freedoms)

    def motion(load: Bounded) -> Bounded:
        return steady_motion(scene, system, system.felt(load), loads.order)

    moving = motion(loads.load)
    emit_steady(
        scene,
        mounts,
        moved_by(system, moving, frequency),
        lambda load: moved_by(system, motion(load), frequency),
    )
    natural = np.concatenate([still.shapes.natural_frequency, system.shapes.natural_frequency])
    ground = system.ground_load(moving, frequency)
    scene.handed_on["ground"] = Ground(ground, system.transmissibility, natural)
    scene.cite(
        "rigid body on mounts on a mass that moves up and down, complex dynamic stiffness",
        "motion of the machine on its foundation",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3",
    )
