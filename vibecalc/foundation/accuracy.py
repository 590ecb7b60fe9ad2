"""Questions of a machine on a foundation that moves: motion of both, the force on the ground."""

from vibecalc.core.accuracy.topic import Ask, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.foundation.model import on_mass
from vibecalc.isolation.accuracy import REFINED, driven, motion_topic
from vibecalc.isolation.on_mounts import OnMounts


def coupled_topics(scene: Scene) -> list[Topic]:
    """Motion of machine and foundation by order; none of a foundation of tables."""
    system: OnMounts | None = scene.handed_on.get("on_foundation")
    if system is None:
        return []
    ask = Ask("motion of both bodies", "motion by order",
              "isolation/body/translation_harmonics", *REFINED)  # fmt: skip
    return motion_topic(ask, system, *driven(scene, system)[1:])


def foundation_topics(scene: Scene) -> list[Topic]:
    """The force on the ground by order; none where no order of the forces acts up or down."""
    forcing: Forcing = scene.handed_on["forcing"]
    (system, _), speed = on_mass(scene), scene.case.machine.speed
    load = at_speed(forcing.per_speed_squared, speed)[: forcing.retained]
    w = forcing.order[: forcing.retained] * speed
    ask = Ask("force on the ground", "force of each order on what carries the foundation",
              "foundation/ground_force", *REFINED)  # fmt: skip
    below = system.passing(w).value[:, 0, 1]
    return motion_topic(ask, system, system.felt(load), w, lambda found: below * found[:, 1])
