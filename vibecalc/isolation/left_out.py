"""What the orders that are not kept may add to the rows of a run-up."""

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet


def with_left_out(rows: HarmonicsAt, left_out: HarmonicsAt, factor: float) -> HarmonicsAt:
    """Rows whose errors count the harmonics of `left_out` too, `factor` times.

    The magnitudes of the orders left out, and of their slopes by speed, are added to the errors of
    the last order kept. So they enter the error of every peak, and of the speed of a maximum,
    which moves with the slope of what was left out. A factor of 0 leaves nothing out.
    """

    if factor == 0.0:
        return rows

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        jet = rows(speed, slopes, errors)
        if not errors:
            return jet
        rest = left_out(speed, slopes)
        error = _added(jet.error, rest.value, factor)
        if not slopes:
            return jet._replace(error=error)
        slope_error = _added(jet.slope_error, rest.slope, factor)
        return jet._replace(error=error, slope_error=slope_error)

    return harmonics_at


def _added(error: np.ndarray, rest: np.ndarray, factor: float) -> np.ndarray:
    total = error.copy()
    total[..., -1] += factor * np.abs(rest).sum(axis=-1)
    return total
