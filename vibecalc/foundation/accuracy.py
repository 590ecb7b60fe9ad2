"""Questions of a machine on a foundation that moves: the force on the ground."""

import numpy as np

from vibecalc.core.accuracy.kinds import Ask, Matrices, forced, ours
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.foundation.adapter import two_masses
from vibecalc.foundation.two_masses import motion
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.linear import dynamics, response
from vibecalc.numerics.rounding import FloatArray


def coupled_topics(scene: Scene) -> list[Topic]:
    """Motion of machine and foundation by order; none of a foundation of tables."""
    system: OnMounts | None = scene.handed_on.get("on_foundation")
    if system is None or system.spectral is not None:
        return []
    loads = scene.handed_on["loads"]
    known = loads.load[: loads.retained]
    load = np.where(np.abs(known.value) > known.error, known.value, 0.0)
    acts = np.any(load != 0.0, axis=1)
    if not np.any(acts):
        return []
    both = np.concatenate([load[acts], np.zeros((int(acts.sum()), 6))], axis=1)
    w = loads.order[: loads.retained][acts] * scene.case.machine.speed

    def own(_: float) -> Answer:
        found = response(dynamics(system.matrices, w), both, np.zeros(both.shape))
        return Answer(found.value, 2.0 * len(w))

    ask = Ask(
        "flexible foundation", "motion of both bodies", "motion by order",
        "isolation/body/translation_harmonics", "m", 2.0,
        "one step of refinement costs as much as the solution",
    )  # fmt: skip
    solver = ours(
        "inverse and one step", "inverse of the scaled matrix, refined once", own,
        citation="Higham, Accuracy and Stability of Numerical Algorithms, chapter 12",
    )  # fmt: skip
    return [forced(ask, [solver], Matrices(*system.matrices[:4]), w, both)]


def foundation_topics(scene: Scene) -> list[Topic]:
    """The force on the ground by order; none where no order of the forces acts up or down."""
    forcing: Forcing = scene.handed_on["forcing"]
    one, up = two_masses(scene)
    speed, kept = scene.case.machine.speed, forcing.retained
    force = forcing.per_speed_squared.value[:kept, up] * speed**2
    w = forcing.order[:kept] * speed
    if not np.any(np.abs(force) > 0.0):
        return []

    def closed(_: float) -> Answer:
        return Answer(motion(one, force, np.zeros(kept), w).ground_force.value, 0.25 * kept)

    def chain(above: FloatArray, below: FloatArray) -> np.ndarray:
        return np.array([[above, -above], [-above, above + below]], dtype=float)

    ask = Ask(
        "foundation", "force on the ground", "force of each order on what carries the foundation",
        "foundation/ground_force", "N",
    )  # fmt: skip
    solvers = [ours(
        "closed form", "determinant of two masses", closed,
        citation="Den Hartog, Mechanical Vibrations, section 3.2",
    )]  # fmt: skip
    parts = Matrices(
        np.diag([one.machine_mass, one.foundation_mass]),
        chain(one.mount_stiffness, one.stiffness),
        chain(one.mount_damping, one.damping),
        chain(one.mount_structural, one.structural),
    )
    below = one.stiffness + 1j * (one.structural + w * one.damping)
    load = np.stack([force, np.zeros_like(force)], axis=-1)
    return [forced(ask, solvers, parts, w, load, lambda found: below * found[:, 1])]
