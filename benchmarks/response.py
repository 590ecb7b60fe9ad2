"""All energies of a two-cylinder compressor in one batched call, against two yardsticks.

Modes, response to 41 orders of 3 operations and to 3 balances of each, energies by order, totals
with their peaks over the cycle, combinations as phasors, and the range of the mean over the phase
of the balance weight. Yardsticks, measured in the same run: the plain loop over operations,
balances and orders (without any error estimate or peak), and what `import numpy` costs in a fresh
process. CPU time, one thread; ratios are what counts.
"""

import os
import statistics
import subprocess
import sys
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from rows import Report, Row, reported, seconds
from timing import in_turns

from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear, dynamics
from vibecalc.response.energies import (
    energy_by_order,
    mass_of,
    mean_over_cycle,
    peak_over_cycle,
    stiffness_of,
    velocity,
)
from vibecalc.response.modes import modes
from vibecalc.response.operations import (
    Parts,
    at_phase,
    mean_energy_range,
    peak_energy_range,
    superpose,
)

SPEED, RADIUS, ROD = 361.0, 0.0127, 0.060325
ORDERS = np.array([1, *range(2, 81, 2)])
LEVERS = (0.097409, 0.145034)
IMPORT = "import time; a = time.process_time(); import numpy; print(time.process_time() - a)"
AIM = 0.1


class Machine(NamedTuple):
    """Matrices; loads (operations, orders, 6) by pistons, (operations, balances, 6) by weights."""

    matrices: Linear
    shaking: Bounded
    residual: Bounded


def machine() -> Machine:
    """A compressor of 36 kg on soft springs, in SI; data of Ong (2000), rounded."""
    mass = np.diag([36.08, 36.08, 36.08, 0.3808, 0.3356, 0.1638])
    mass[4, 5] = mass[5, 4] = -0.0554
    upper = [
        [232570.0, 3309.9, 2469.3, 449.3, -9443.6, 1712.6],
        [237298.0, 6374.6, 9990.7, -627.2, 430.1],
        [188963.0, -511.5, -707.3, 146.3],
        [2603.8, -102.0, 43.2],
        [3487.8, -226.6],
        [1636.7],
    ]
    stiffness = np.zeros((6, 6))
    for number, row in enumerate(upper):
        stiffness[number, number:] = stiffness[number:, number] = row
    nothing = np.zeros((6, 6))
    rounding = [2.0**-50 * np.abs(part) for part in (mass, stiffness, nothing, nothing)]

    a, b = (np.array([0.0, 1.0, 0.0, lever, 0.0, 0.0]) for lever in LEVERS)
    acceleration = motion_harmonics(RADIUS / ROD, 80, derivative=2)[ORDERS]
    strength = -0.348 * RADIUS * SPEED**2 * acceleration[:, None]
    shaking = strength * np.array([a - b, a, b])[:, None, :]
    turn_a, turn_b = (
        0.0438 * RADIUS * SPEED**2 * np.array([-1.0, 1j, 0.0, 1j * lever, lever, 0.0])
        for lever in LEVERS
    )
    nil = 0.0 * turn_a
    residual = np.array(
        [[nil, -turn_b, turn_a], [turn_a, nil, turn_a + turn_b], [-turn_b, -turn_a - turn_b, nil]]
    )
    return Machine(
        Linear(mass, stiffness, nothing, nothing, *rounding),
        Bounded(shaking, 2.0**-50 * np.abs(shaking)),
        Bounded(residual, 2.0**-50 * np.abs(residual)),
    )


def batched(one: Machine) -> np.ndarray:
    """Everything, with errors; mean kinetic energies (operations, balances) are returned."""
    matrices = one.matrices
    modes(matrices)
    parts = superpose(dynamics(matrices, ORDERS * SPEED), Parts(one.shaking, one.residual))
    for motion, rate in (
        (parts.shaking, SPEED * ORDERS),
        (parts.residual, np.full(3, SPEED)),
    ):
        energy_by_order(mass_of(matrices), velocity(motion, rate))
        energy_by_order(stiffness_of(matrices), motion)
    motion = at_phase(parts)
    moving = velocity(motion, SPEED * ORDERS)
    kinetic = mean_over_cycle(mass_of(matrices), moving)
    mean_over_cycle(stiffness_of(matrices), motion)
    peak_over_cycle(mass_of(matrices), moving, ORDERS)
    peak_over_cycle(stiffness_of(matrices), motion, ORDERS)
    mean_energy_range(mass_of(matrices), parts.times(1j * SPEED * ORDERS))
    mean_energy_range(stiffness_of(matrices), parts)
    return np.asarray(kinetic.value)


def means(one: Machine) -> np.ndarray:
    """What the loop does, with error estimates: means of all combinations by order."""
    matrices = one.matrices
    modes(matrices)
    motion = at_phase(
        superpose(dynamics(matrices, ORDERS * SPEED), Parts(one.shaking, one.residual))
    )
    kinetic = energy_by_order(mass_of(matrices), velocity(motion, SPEED * ORDERS))
    energy_by_order(stiffness_of(matrices), motion)
    return np.asarray(kinetic.mean.value.sum(axis=-1))


def looped(one: Machine) -> np.ndarray:
    """One solution and one energy after the other, as the source's script files do."""
    mass, stiffness = one.matrices.mass, one.matrices.stiffness
    np.linalg.eig(np.linalg.solve(mass, stiffness))
    total = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k, order in enumerate(ORDERS):
                rate = order * SPEED
                load = one.shaking.value[i, k]
                if order == 1:
                    load = load + one.residual.value[i, j]
                x = np.linalg.solve(stiffness - rate**2 * mass, load)
                total[i, j] += 0.25 * rate**2 * (x.conj() @ mass @ x).real
                _ = 0.25 * (x.conj() @ stiffness @ x).real
    return total


def peak_ranges(one: Machine) -> None:
    """The search over all phases, which no table of the source has."""
    parts = superpose(dynamics(one.matrices, ORDERS * SPEED), Parts(one.shaking, one.residual))
    state = parts.times(1j * SPEED * ORDERS)
    peak_energy_range(mass_of(one.matrices), state, ORDERS)


def import_seconds(repeats: int) -> float:
    """Median CPU seconds of `import numpy` in fresh processes; a first one fills the caches."""
    reported = [
        float(
            subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, check=True).stdout
        )
        for _ in range(repeats + 1)
    ]
    return statistics.median(reported[1:])


def measure() -> Report:
    """What each costs and the ratios."""
    one = machine()
    apart = float(np.max(np.abs(batched(one) / looped(one) - 1.0)))
    took = in_turns(
        {
            "all": lambda: batched(one),
            "means": lambda: means(one),
            "loop": lambda: looped(one),
            "peaks": lambda: peak_ranges(one),
        },
        {"all": 20, "means": 20, "loop": 5, "peaks": 5},
    )
    numpy_seconds = import_seconds(9)
    error = f"{apart:.0e} from the loop"
    rows = [
        Row("mean energies of 3 operations, 3 balances, 41 orders, with error estimates",
            "batched", "numpy loop over them, no estimate", took["loop"] / took["means"],
            error=error, note=f"{seconds(took['means'])} against {seconds(took['loop'])}"),
        Row("the same with modes, peaks, ranges", "batched", "import numpy in a fresh process",
            took["all"] / numpy_seconds, AIM, error,
            f"{seconds(took['all'])} against {seconds(numpy_seconds)}", cost=True),
    ]  # fmt: skip
    said = f"Peak ranges over all phases of the weights, 9 searches: {seconds(took['peaks'])}."
    return Report(
        "Energies of a compressor",
        "All energies of a two-cylinder compressor (Ong, 2000) in one call.",
        rows,
        remarks=[said],
    )


if __name__ == "__main__":
    reported(measure)
