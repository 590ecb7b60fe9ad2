"""A question of bearing loads: the highest load of the main bearing that is loaded most."""

import numpy as np

from vibecalc.bearings.adapter import highest_loads
from vibecalc.bearings.loads import Loads
from vibecalc.bearings.model import loads_of
from vibecalc.core.accuracy.kinds import Ask, ours, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.parts.firing import cycle_angle


def bearing_topics(scene: Scene) -> list[Topic]:
    """The peak over a cycle of the main bearing whose peak is the highest."""
    loads, speed = loads_of(scene), np.asarray(scene.case.machine.speed)
    half = 0.5 * cycle_angle(scene.case.machine)
    asked = [0]

    def counted(of: Loads, angle: FloatArray, at: FloatArray) -> ComplexArray:
        asked[0] += np.broadcast(angle, at).size if of is loads else 0
        return of.main(angle, at)

    def search() -> tuple[float, float, int]:
        asked[0] = 0
        found = highest_loads(scene, loads, counted, speed)
        which = int(np.argmax(found.height.value))
        return float(found.height.value[which]), float(found.angle.value[which]), which

    _, known, most = search()

    def curve(angles: FloatArray) -> FloatArray:
        return np.abs(loads.main(angles, speed)[:, most])

    def own(_: float) -> Answer:
        height, place, _ = search()
        return Answer(np.array([height]), float(asked[0]), place)

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
