"""Spectra of the joint force over an ensemble, and from which order on they lead."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.impact.ensemble import Statistic, mean_over_runs, quantiles

#: share of revolutions below the low and the high curve
LOW, HIGH = 0.05, 0.95
#: who leads an order
SHAKING, IMPACT, MOTOR = 0, 1, 2


class Spectra(NamedTuple):
    """Amplitudes (C, N), N 0-to-peak, of orders 1 to N, and their mean over the orders (C,)."""

    mean: Statistic
    low: Statistic
    high: Statistic
    average: Statistic


def spectra(harmonics: ComplexArray) -> Spectra:
    """Statistics of |F_n| of single revolutions, from harmonics (C, M, R, N + 1) in N.

    Order 0, the mean force, is left out: it balances the gas and shakes nothing. The amplitude
    of an order is the mean of magnitudes; that of magnitudes of means would be smaller by what
    revolutions differ in phase.
    """
    size = np.abs(harmonics[..., 1:])
    low, high = quantiles(size, (LOW, HIGH))
    return Spectra(mean_over_runs(size), low, high, mean_over_runs(np.mean(size, axis=-1)))


class Dominance(NamedTuple):
    """Who has the largest amplitude.

    `leads_from` (C,): the lowest order from which on the impact exceeds both others at every
    higher order of the spectrum, 0 if it does not at the last one. `leader` (C, N): 0 the piston's
    inertia force, 1 the impact, 2 the motor. The `spread` of each is half of what it changes
    between spectra two standard errors lower and as much higher.
    """

    leads_from: IntArray
    leads_from_spread: FloatArray
    leader: IntArray
    leader_spread: FloatArray


def dominance(impact: Statistic, shaking: FloatArray, motor: FloatArray) -> Dominance:
    """Compare amplitudes, N, of orders 1 to N: `impact` (C, N), `shaking` and `motor` (N,)."""
    leading = leader(impact.value, shaking, motor)
    start = leads_from(leading)
    doubt = 2.0 * impact.standard_error
    changed = [leader(impact.value + side * doubt, shaking, motor) for side in (-1.0, 1.0)]
    # nowhere, as a place beyond the last order
    last = impact.value.shape[-1] + 1
    ends = [np.where(leads_from(each) > 0, leads_from(each), last) for each in changed]
    return Dominance(
        start,
        0.5 * np.abs(ends[1] - ends[0]),
        leading,
        0.5 * np.abs(changed[1] - changed[0]),
    )


def leader(impact: FloatArray, shaking: FloatArray, motor: FloatArray) -> IntArray:
    """Index (C, N) of the largest; of equals the first in the order of the indices."""
    rows = np.broadcast_arrays(shaking, impact, motor)
    return np.asarray(np.argmax(np.stack(rows), axis=0).astype(np.int64))


def leads_from(leading: IntArray) -> IntArray:
    """Lowest order (C,) from which on IMPACT leads in (C, N), 0 if it does not at the last."""
    others = leading != IMPACT
    count = leading.shape[-1]
    trailing = np.argmax(others[..., ::-1], axis=-1)
    start = np.where(np.any(others, axis=-1), count - trailing + 1, 1)
    return np.asarray(np.where(start > count, 0, start).astype(np.int64))
