"""Question of isolation efficiency: the loads on the ground by order."""

import numpy as np

from vibecalc.core.accuracy.kinds import Ask, Matrices, forced, ours
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.loads import BodyLoads
from vibecalc.isolation.efficiency_results import OfForces
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.linear import dynamics, response


def efficiency_topics(scene: Scene) -> list[Topic]:
    """Loads on the ground; none of the pitch model, or of a foundation: these have their own."""
    if isolation_of(scene).model == "pitch" or "ground" in scene.handed_on:
        return []
    loads: BodyLoads = scene.handed_on["loads"]
    system: OnMounts = scene.handed_on["on_mounts"]
    if system.spectral is not None:
        return []  # the question is of matrices that no frequency changes
    matrices, load = system.matrices, system.felt(loads.load[: loads.retained])
    given = np.where(np.abs(load.value) > load.error, load.value, 0.0)
    acts = np.any(given != 0.0, axis=1)
    if not np.any(acts):
        return []
    given, w = given[acts], loads.order[: loads.retained][acts] * scene.case.machine.speed
    error = np.zeros(given.shape)

    def own(_: float) -> Answer:
        found = system.ground_load(response(dynamics(matrices, w), given, error), w)
        return Answer(found.value, 2.0 * len(w))

    def read(motion: np.ndarray) -> np.ndarray:
        return np.asarray((matrices.passing(w).value @ motion[..., None])[..., 0])

    ask = Ask(
        "isolation efficiency", "loads on the ground", "force and couple of each order",
        f"{OfForces.ROOT}/ground", "N", 2.0, "one step of refinement costs as much as the solution",
    )  # fmt: skip
    solver = ours(
        "inverse and one step", "inverse of the scaled matrix, refined once", own,
        citation="Higham, Accuracy and Stability of Numerical Algorithms, chapter 12",
    )  # fmt: skip
    return [forced(ask, [solver], Matrices(*matrices[:4]), w, given, read)]
