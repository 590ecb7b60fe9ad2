"""What becomes of a tuned absorber while its oil warms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray


class Warming(NamedTuple):
    """Over temperature (n,) in K: damping in N m s/rad, the same referred to the primary, peak.

    `secondary_damping` is c2 / (2 sqrt(K1 J1)); `penalty` the peak over the least one, less 1.
    """

    temperature: FloatArray
    damping: WithError
    secondary_damping: WithError
    peak: WithError
    penalty: FloatArray


def warming(
    temperature: ArrayLike,
    damping_at: Callable[[FloatArray], WithError],
    primary_stiffness: float,
    primary_inertia: float,
    peak_of: Callable[[FloatArray], WithError],
    least_peak: float,
) -> Warming:
    """Damping, its ratio and the peak of the primary at each temperature (n,) in K.

    `damping_at` gives the damping of the gap (N m s/rad), `peak_of` the largest amplification for
    secondary dampings (n,) with everything else as built, both with errors; the error of the
    damping is carried into the peak by a difference. Stiffnesses are taken as constant: those of
    steel fall by some 3 per cent over 100 K.
    """
    (warm,) = floats(temperature)
    damping = damping_at(warm)
    scale = 2.0 * np.sqrt(primary_stiffness * primary_inertia)
    value = damping.value / scale
    share = WithError(value, damping.error / scale + 2.0 * UNIT_ROUNDOFF * value)
    peak = peak_of(value)
    step = 1e-6 * value
    slope = np.abs(peak_of(value + step).value - peak.value) / step
    doubt = peak.error + share.error * (slope + 2.0 * peak.error / step)
    return Warming(
        warm, damping, share, WithError(peak.value, doubt), peak.value / least_peak - 1.0
    )
