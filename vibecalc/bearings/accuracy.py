"""A question of bearing loads: the highest load of the main bearing that is loaded most."""

import numpy as np

from vibecalc.bearings.crank_loads import cycle_peaks
from vibecalc.bearings.model import loads_of
from vibecalc.core.accuracy.kinds import Counted, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import ComplexArray, FloatArray


def bearing_topics(scene: Scene) -> list[Topic]:
    """The peak over a cycle of the main bearing whose peak is the highest."""
    loads, speed = loads_of(scene), np.asarray(scene.case.machine.speed)

    def forces(angles: FloatArray) -> ComplexArray:
        return loads.main(angles, speed)

    height, place = cycle_peaks(forces, loads.gas.kinks, loads.cycle)
    most = int(np.argmax(height.value))
    known, half = float(place.value[most]), 0.5 * loads.cycle

    def own(_: float) -> Answer:
        counted = Counted(forces)
        height, place = cycle_peaks(counted, loads.gas.kinks, loads.cycle)
        return Answer(height.value[[most]], float(counted.asked), float(place.value[most]))

    ask = Ask("highest main bearing load", "over a cycle, of the bearing loaded most",
              "bearing_loads/main/peak", 300.0,
              "all bearings are searched, between all kinks of the gas")  # fmt: skip
    solver = Solver("brackets between kinks", own)
    return [peak_over_range(ask, solver, lambda angles: np.abs(forces(angles)[:, most]),
                            (known - half, known + half), known, around=True)]  # fmt: skip
