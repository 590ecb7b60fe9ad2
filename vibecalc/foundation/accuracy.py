"""Questions of a machine on a foundation that moves: motion of both, the force on the ground."""

from vibecalc.core.accuracy.kinds import Ask
from vibecalc.core.accuracy.topic import Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.foundation.model import on_mass
from vibecalc.isolation.accuracy import motion_topic
from vibecalc.isolation.on_mounts import OnMounts

_WHY = "one step of refinement costs as much as the solution"


def coupled_topics(scene: Scene) -> list[Topic]:
    """Motion of machine and foundation by order; none of a foundation of tables."""
    system: OnMounts | None = scene.handed_on.get("on_foundation")
    if system is None or system.spectral is not None:
        return []
    loads, path = scene.handed_on["loads"], "isolation/body/translation_harmonics"
    ask = Ask(
        "flexible foundation", "motion of both bodies", "motion by order", path, "m", 2.0, _WHY
    )
    kept = loads.retained
    w = loads.order[:kept] * scene.case.machine.speed
    return motion_topic(ask, system, system.felt(loads.load[:kept]), w)


def foundation_topics(scene: Scene) -> list[Topic]:
    """The force on the ground by order; none where no order of the forces acts up or down."""
    forcing: Forcing = scene.handed_on["forcing"]
    system, _ = on_mass(scene)
    speed, kept = scene.case.machine.speed, forcing.retained
    load, w = at_speed(forcing.per_speed_squared, speed), forcing.order[:kept] * speed
    ask = Ask(
        "foundation", "force on the ground", "force of each order on what carries the foundation",
        "foundation/ground_force", "N", 2.0, _WHY,
    )  # fmt: skip
    below = system.passing(w).value[:, 0, 1]
    return motion_topic(ask, system, system.felt(load[:kept]), w, lambda found: below * found[:, 1])
