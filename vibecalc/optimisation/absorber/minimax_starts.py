"""Where the search for a tuning begins: near the optimum of an undamped primary system."""

import numpy as np

from vibecalc.optimisation.absorber.closed_forms import nishihara_asami, warburton_acceleration
from vibecalc.response.absorber.fixed_points import fixed_points
from vibecalc.response.absorber.model import Transfer


def undamped_start(mass_ratio: np.ndarray, transfer: Transfer) -> tuple[np.ndarray, np.ndarray]:
    """Place (2, n) (ln k, ln 2 z2) and ln u of the two peaks (2, n) at z1 = 0.

    Exact for |N1 / D|; for x and x^2 times that, and for what passes from the ground to the
    ground, formulas close enough for Newton's method at mass ratios of 1e-4 to 10. The peaks are
    sought at the fixed points, which no power of x moves.
    """
    m = mass_ratio
    if transfer.motion == "primary" and transfer.power == 0:
        k, z2, _ = nishihara_asami(m)
    elif transfer.motion == "primary" and transfer.power == 2:
        k, z2, _ = warburton_acceleration(m)
    else:
        # between the two: fixed points of equal height in x H
        k = m * (1.0 + m / 2.0) / np.square(1.0 + m)
        z2 = m * np.sqrt(3.0 * m / 8.0) / (1.0 + m) ** 1.125
    marks = fixed_points(m, k)
    return (
        np.log(np.stack([k, 2.0 * z2])),
        2.0 * np.log(np.stack([marks.frequency_p, marks.frequency_q])),
    )
