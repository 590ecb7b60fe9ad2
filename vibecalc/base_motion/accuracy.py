"""Question of a base that moves: the motion against it under its harmonics."""

import numpy as np

from vibecalc.base_motion.model import amplitude_of, at_reference, frequency_of
from vibecalc.base_motion.results import HARMONIC
from vibecalc.core.accuracy.kinds import Ask, Matrices, forced, ours
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded


def base_topics(scene: Scene) -> list[Topic]:
    """Motion against the base by each harmonic; none without harmonics."""
    given, system = scene.case.base_motion, scene.handed_on["on_base"]
    if given is None or not given.harmonics or system.spectral is not None:
        return []
    w = np.array([frequency_of(one, scene.case) for one in given.harmonics])
    said = np.array([amplitude_of(one, rate) for one, rate in zip(given.harmonics, w, strict=True)])
    base = said @ at_reference(given.point).T
    load = (base @ system.carried.T) @ system.matrices.mass * np.square(w)[:, None]

    def own(_: float) -> Answer:
        exact = Bounded(base, np.zeros(base.shape))
        return Answer(system.moved_by_base(exact, w)[0].value, 2.0 * len(w))

    ask = Ask(
        "base motion", "motion against the base", "motion of the body against the base",
        f"{HARMONIC}/relative_translation", "m", 2.0,
        "one step of refinement costs as much as the solution",
    )  # fmt: skip
    solver = ours(
        "inverse and one step", "inverse of the scaled matrix, refined once", own,
        citation="Higham, Accuracy and Stability of Numerical Algorithms, chapter 12",
    )  # fmt: skip
    return [forced(ask, [solver], Matrices(*system.matrices[:4]), w, load)]
