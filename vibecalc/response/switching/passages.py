"""Which resonances a course runs through, when, and how fast."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.run import runs_of
from vibecalc.response.switching.system import Loads, ModalSystem, Piece, modal_loads


class Passage(NamedTuple):
    """Order `order` meets mode `mode` (from 1) at the crank `speed` (rad/s) and `time` (s).

    `slow_energy` in J is the peak energy of the mode if the crank stayed there. `haste` is
    n |w'| / (zeta w_j)^2: well below 1 the motion follows as if it stayed, above 1 the resonance
    has no time to build up.
    """

    mode: int
    order: int
    speed: float
    time: float
    piece: int
    slow_energy: float
    haste: float


def passages(system: ModalSystem, loads: Loads, pieces: Sequence[Piece]) -> list[Passage]:
    """All passages of driven modes in order of time; a constant speed passes none.

    An order n passes a mode where n |w| is its undamped natural frequency; there
    Q = p_n W^2 / (2 i zeta w_j n W) at W = w_j / n, which is a peak energy of
    w_j^2 |p_n|^2 / (8 zeta^2 n^4).
    Modes damped critically or more have no resonance. Orders whose modal load is zero to rounding
    are not listed. Raises NumericalFailure as `modal_loads` does.
    """
    modal = modal_loads(system, loads)
    found = []
    for run in runs_of(pieces, 0.0):
        if run.acceleration == 0.0:
            continue
        for number, order in enumerate(modal.orders.tolist()):
            speed = system.frequency / order * np.sign(run.speed + run.end_speed)
            time = (speed - run.speed) / run.acceleration
            force = np.abs(modal.amplitude[run.operation, number])
            met = (time >= 0.0) & (time < run.duration) & (force > 0.0)
            for mode in np.flatnonzero(met & (system.damping_ratio < 1.0)).tolist():
                ratio, frequency = system.damping_ratio[mode], system.frequency[mode]
                size = frequency * float(force[mode]) / (2.0 * ratio * order**2)
                haste = order * abs(run.acceleration) / (ratio * frequency) ** 2
                found.append(
                    Passage(
                        mode + 1,
                        order,
                        float(speed[mode]),
                        run.start + float(time[mode]),
                        run.piece,
                        float(0.5 * size**2),
                        float(haste),
                    )
                )
    return sorted(found, key=lambda passage: (passage.time, passage.mode))
