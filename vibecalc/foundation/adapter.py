"""Adapter: forces of the crank train onto machine and foundation, up and down."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, peak_with_tail
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.foundation.model import on_mass
from vibecalc.foundation.results import UpAndDown
from vibecalc.isolation.adapters.loads import steady_motion
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.bounded import Bounded


def run_foundation(scene: Scene) -> None:
    """Emit the steady motion at the operating speed, and what a rigid foundation would get."""
    forcing: Forcing = scene.handed_on["forcing"]
    speed, used = scene.case.machine.speed, forcing.retained
    system, alone = on_mass(scene)
    load = at_speed(forcing.per_speed_squared, speed)
    frequency = forcing.order * np.asarray(speed)[..., None]

    def moved(one: OnMounts) -> tuple[Bounded, Bounded]:
        motion = steady_motion(scene, one, load, forcing.order)
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
