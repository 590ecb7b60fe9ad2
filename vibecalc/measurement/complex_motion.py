"""The motion from complex amplitudes: weighted linear least squares, for any number of readings."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.quadratic import NO_RANK
from vibecalc.measurement.rigid_plate import scaled, span_of
from vibecalc.measurement.spread import Spread
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray


class ComplexMotion(NamedTuple):
    """Motion (3,) in SI, residual (r,) computed less read, and its standard uncertainty's source.

    `condition` is the ratio of the largest to the smallest weighed singular value, with angular
    accelerations counted at the span of the plate; `excess` the root mean square of the residuals
    over the uncertainty of the readings, per degree of freedom (0 where there is none to spare):
    much above 1 says that readings contradict each other by more than they are said to be off.
    """

    motion: ComplexArray
    residual: ComplexArray
    condition: float
    excess: float
    spread: Spread


def complex_motion(
    rows: FloatArray, readings: ComplexArray, half_widths: FloatArray, deviations: FloatArray
) -> ComplexMotion:
    """Least squares of rows (r, 3) on readings (r,), each weighed by its deviation > 0.

    `half_widths` and `deviations` (r,) hold for the real and for the imaginary part alike, in the
    unit of the reading.

    Raises
    ------
    NumericalFailure : the readings leave a motion free, such as the roll about a line of points.
    """
    span = span_of(rows)
    weighed = scaled(rows, span) / deviations[:, None]
    left, size, right = np.linalg.svd(weighed, full_matrices=False)
    if len(size) < 3 or size[-1] <= NO_RANK * size[0]:
        raise NumericalFailure("the readings leave a motion of the plate free")
    inverse = (right.T / size) @ left.T / deviations
    inverse = inverse / np.array([1.0, span, span])[:, None]
    motion = inverse @ readings
    residual = rows @ motion - readings
    spare = 2 * (len(rows) - 3)
    squares = float(np.sum(np.abs(residual / deviations) ** 2))
    none = np.zeros_like(inverse)
    slopes = np.block([[inverse, none], [none, inverse]])
    return ComplexMotion(
        motion,
        residual,
        float(size[0] / size[-1]),
        (squares / spare) ** 0.5 if spare else 0.0,
        Spread(
            slopes,
            np.tile(half_widths, 2),
            np.tile(deviations, 2),
            16.0 * EPSILON * float(size[0] / size[-1]),
        ),
    )
