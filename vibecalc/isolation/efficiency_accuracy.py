"""Question of isolation efficiency: the loads on the ground by order."""

import numpy as np

from vibecalc.core.accuracy.kinds import Ask
from vibecalc.core.accuracy.topic import Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.accuracy import motion_topic
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.efficiency_results import OfForces
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.response.adapters.loads import BodyLoads


def efficiency_topics(scene: Scene) -> list[Topic]:
    """Loads on the ground; none of the pitch model, or of a foundation: these have their own."""
    if isolation_of(scene).model == "pitch" or "ground" in scene.handed_on:
        return []
    loads: BodyLoads = scene.handed_on["loads"]
    system: OnMounts = scene.handed_on["on_mounts"]
    if system.spectral is not None:
        return []  # the question is of matrices that no frequency changes
    load = system.felt(loads.load[: loads.retained])
    w = loads.order[: loads.retained] * scene.case.machine.speed

    def read(motion: np.ndarray) -> np.ndarray:
        return np.asarray((system.passing(w).value @ motion[..., None])[..., 0])

    ask = Ask(
        "isolation efficiency", "loads on the ground", "force and couple of each order",
        f"{OfForces.ROOT}/ground", "N", 2.0, "one step of refinement costs as much as the solution",
    )  # fmt: skip
    return motion_topic(ask, system, load, w, read)
