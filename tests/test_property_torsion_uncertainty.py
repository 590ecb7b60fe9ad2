"""Claims: errors of shapes hold, and are small, where a mode fades; a gear without load counts the
lower one of its torques.
"""

import mpmath
import numpy as np
from random_engines import random_engine

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.numerics.errors import with_errors
from vibecalc.torsion.line import chain, stiffness_matrix
from vibecalc.torsion.modes import natural_modes


def test_errors_of_a_shape_that_fades() -> None:
    inertia = np.array([1.0, 1.1, 0.9, 1.0, 1.2, 40.0, 3.0, 0.01])
    line = chain(inertia, np.array([1e6, 1.1e6, 0.9e6, 1e6, 1e6, 3e5, 2e6]))
    modes = natural_modes(line)
    shape = with_errors(lambda one: natural_modes(one).shape, line)
    with mpmath.workdps(40):
        root = [mpmath.sqrt(mpmath.mpf(j)) for j in inertia.tolist()]
        matrix = mpmath.matrix(stiffness_matrix(line).tolist())
        for a in range(8):
            for b in range(8):
                matrix[a, b] /= root[a] * root[b]
        _, vectors = mpmath.eigsy(matrix)
        true = [[vectors[a, m] / root[a] for a in range(8)] for m in range(8)]
        rows = []
        for own, angle in zip(true, modes.shape.tolist(), strict=True):
            top = int(np.argmax(np.abs(angle)))
            rows.append(
                [float(x / own[top] * angle[top] - y) for x, y in zip(own, angle, strict=True)]
            )
    error, reported = np.abs(rows)[1:], shape.error[1:]
    assert np.all(error <= 10.0 * reported)
    # the first station all but stands still in the highest mode
    assert abs(modes.shape[-1, 0]) < 1e-9
    assert reported[-1, 0] < 0.01 * modes.shape_error[-1]
    twist = with_errors(lambda one: natural_modes(one).shape @ [1.0, -1.0, *6 * [0.0]], line)
    off = float(twist.error[-1])
    assert abs(rows[-1][0] - rows[-1][1]) <= 10.0 * off < 0.1 * modes.shape_error[-1]


def test_a_gear_without_load_counts_the_lower_torque() -> None:
    table = random_engine(179)
    table["response"]["torsion"].pop("speeds", None)
    record = run_case(validate(table))
    place = "response/torsion/gear/"
    mean, half, least = (
        record[place + name] for name in ("mean_torque", "alternating_torque", "minimum_torque")
    )
    assert abs(mean.values[0]) <= mean.error_estimate
    assert mean.values[1] > 1e3 * mean.error_estimate
    # the lower one of both ends is at least half a range below zero
    assert least.values[0] <= -half.values[0] + least.error_estimate
