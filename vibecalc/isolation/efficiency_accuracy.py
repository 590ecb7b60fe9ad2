"""Question of isolation efficiency: the loads on the ground by order."""

import numpy as np

from vibecalc.core.accuracy.kinds import Ask, Matrices, forced, ours
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.loads import body_loads
from vibecalc.isolation.efficiency_results import FORCES
from vibecalc.isolation.on_base import alone, ground_load
from vibecalc.isolation.rigid_body import restricted
from vibecalc.parts.body import dofs_of_model
from vibecalc.parts.matrices import assemble
from vibecalc.response.forced import dynamics, response


def efficiency_topics(scene: Scene) -> list[Topic]:
    """Loads on the ground; none of the pitch model, whose couple is a topic of its own stage."""
    body, mounts, options = scene.parts.body, scene.parts.mounts, isolation_of(scene)
    if body is None or mounts is None or options.model == "pitch":
        return []
    loads = body_loads(scene)
    freedoms = dofs_of_model(options.model, scene.case.machine.crank_train.axis)
    held = (mounts.stiffness, mounts.damping, mounts.structural)
    matrices = restricted(assemble(body.mass_matrix, mounts.position, *held), freedoms)
    load = loads.load[: loads.retained, freedoms]
    given = np.where(np.abs(load.value) > load.error, load.value, 0.0)
    acts = np.any(given != 0.0, axis=1)
    if not np.any(acts):
        return []
    given, w = given[acts], loads.order[: loads.retained][acts] * scene.case.machine.speed
    error = np.zeros(given.shape)

    def own(_: float) -> Answer:
        found = ground_load(alone(matrices), response(dynamics(matrices, w), given, error), w)
        return Answer(found.value, 2.0 * len(w))

    def read(motion: np.ndarray) -> np.ndarray:
        rate = w[:, None, None]
        passing = matrices.stiffness + 1j * (matrices.structural + rate * matrices.damping)
        return np.asarray((passing @ motion[..., None])[..., 0])

    ask = Ask(
        "isolation efficiency", "loads on the ground", "force and couple of each order",
        f"{FORCES}/ground", "N", 2.0, "one step of refinement costs as much as the solution",
    )  # fmt: skip
    solver = ours(
        "inverse and one step", "inverse of the scaled matrix, refined once", own,
        citation="Higham, Accuracy and Stability of Numerical Algorithms, chapter 12",
    )  # fmt: skip
    return [forced(ask, [solver], Matrices(*matrices[:4]), w, given, read)]
