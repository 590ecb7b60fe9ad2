"""Question of a base that moves: the motion against it under its harmonics."""

import numpy as np

from vibecalc.base_motion.model import harmonics_of
from vibecalc.base_motion.results import HARMONIC
from vibecalc.core.accuracy.topic import Ask, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.accuracy import REFINED, motion_topic
from vibecalc.numerics.bounded import bounded


def base_topics(scene: Scene) -> list[Topic]:
    """Motion against the base by each harmonic; none without harmonics."""
    given, system = scene.case.base_motion, scene.handed_on["on_base"]
    if given is None or not given.harmonics:
        return []
    w, base = harmonics_of(scene.case)
    load = (base.value @ system.carried.T) @ system.matrices.mass * np.square(w)[:, None]
    ask = Ask("motion against the base", "motion of the body against the base",
              f"{HARMONIC}/relative_translation", *REFINED)  # fmt: skip
    return motion_topic(ask, system, bounded(load), w)
