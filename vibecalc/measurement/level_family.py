"""All motions within the rounding of their levels at once: how loud and how quiet a place can be.

Levels within their half widths are linear bounds on the second moments G of a motion, and G is
positive semidefinite. Both together are a convex set that holds every motion that the readings
allow (and, between motions, mixtures of them). The largest and the least c' G c over it are found
by cutting planes: G is semidefinite if z' G z >= 0 for all z, and a few z are enough. Each linear
program on the way has too large a set, so that its extremes are bounds wherever the search stops.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level import DECIBEL
from vibecalc.measurement.quadratic import moment_rows, quadratic_rows, symmetric
from vibecalc.numerics.typing import FloatArray

_CUTS = 40
#: lowest eigenvalue over the largest, at which G counts as semidefinite
_SEMIDEFINITE = 1e-7
#: absolute error granted to a linear program whose numbers are of size one
_PROGRAM = 1e-7


class Extremes(NamedTuple):
    """Least and largest amplitudes (m,) at some rows; zero and infinity where nothing bounds."""

    low: FloatArray
    high: FloatArray


def extremes(
    rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray, targets: FloatArray
) -> Extremes | None:
    """Amplitudes that motions within `half_widths` (r,) dB of `amplitudes` (r,) have at `targets`.

    Rows (r, 3) and targets (m, 3) are scaled to one unit. None if no motion is within all half
    widths.
    """
    from scipy.optimize import linprog

    size = float(np.max(amplitudes))
    left = moment_rows(rows) * (size / amplitudes[:, None]) ** 2
    share = np.exp(2.0 * half_widths / DECIBEL)
    upper, lower = share * (1.0 + _PROGRAM), (1.0 - _PROGRAM) / share
    # what the levels do not tell is bounded by these two directions of it alone
    across = np.linalg.eigh(symmetric(np.linalg.svd(quadratic_rows(rows))[2][-1]))[1]
    cuts = [*moment_rows(across.T), *moment_rows(targets[np.any(targets != 0.0, axis=1)])]
    low, high = np.zeros(len(targets)), np.full(len(targets), np.inf)
    for place, target in enumerate(targets):
        length = float(np.linalg.norm(target))
        if length == 0.0:
            high[place] = 0.0
            continue
        aim = moment_rows(target / length)
        for side in (1.0, -1.0):
            value = np.nan
            for _ in range(_CUTS):
                end = linprog(
                    side * aim,
                    A_ub=np.vstack([left, -left, -np.array(cuts)]),
                    b_ub=np.concatenate([upper, -lower, np.zeros(len(cuts))]),
                    bounds=(None, None),
                )
                if end.status == 2:
                    return None
                if end.status != 0:
                    break
                value = float(aim @ end.x)
                values, vectors = np.linalg.eigh(symmetric(end.x))
                if values[0] >= -_SEMIDEFINITE * values[-1]:
                    break
                cuts.append(moment_rows(vectors[:, 0]))
            if np.isfinite(value):
                margin = value - side * 10.0 * _PROGRAM
                amplitude = size * length * max(margin, 0.0) ** 0.5
                (low if side > 0.0 else high)[place] = amplitude
    return Extremes(low, high)
