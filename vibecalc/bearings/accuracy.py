"""A question of bearing loads: the highest load of the main bearing that is loaded most."""

import numpy as np

from vibecalc.bearings.adapter import highest_loads
from vibecalc.bearings.loads import Loads
from vibecalc.bearings.model import loads_of
from vibecalc.core.accuracy.kinds import Ask, ours, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import ComplexArray, FloatArray


def bearing_topics(scene: Scene) -> list[Topic]:
    """The peak over a cycle of the main bearing whose peak is the highest."""
    loads, speed = loads_of(scene), np.array([scene.case.machine.speed])
    asked = [0]

    def counted(of: Loads, angle: FloatArray, at: FloatArray) -> ComplexArray:
        asked[0] += np.broadcast(angle, at).size if of is loads else 0
        return of.main(angle, at)

    height, place = highest_loads(loads, counted, speed)
    most = int(np.argmax(height.value[0]))
    known, half = float(place.value[0, most]), 0.5 * loads.cycle

    def curve(angles: FloatArray) -> FloatArray:
        return np.abs(loads.main(angles, speed[0])[:, most])

    def own(_: float) -> Answer:
        asked[0] = 0
        height, place = highest_loads(loads, counted, speed)
        return Answer(height.value[0, [most]], float(asked[0]), float(place.value[0, most]))

    ask = Ask(
        "bearing_loads", "highest main bearing load", "over a cycle, of the bearing loaded most",
        "bearing_loads/main/peak", "N", 300.0,
        "all bearings are searched, between all kinks of the gas",
    )  # fmt: skip
    solver = ours("brackets between kinks", "polynomials about the tops of a grid", own)
    return [
        peak_over_range(ask, [solver], curve, known - half, known + half, "", known,
                        kind="peak over a cycle", ends=False)
    ]  # fmt: skip
