"""How much less reaches the ground than the body would send there, held still."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# Isolation efficiency: 1 - transmissibility. The transmissibility is what reaches the ground over
# what the body held still would send there, which is what acts on it. Below zero the mounts send
# more than acts, as next to a resonance.
# ----------------------------------------------------------------------------

#: share of the largest below which an amplitude is what rounding left of zero
_NOTHING = 1.0e-12


class Overall(NamedTuple):
    """Of a vector over the cycle: root of its mean square, and its largest length."""

    rms: Bounded
    peak: Bounded


def efficiency(held: Bounded, ground: Bounded, size: Bounded, size_ground: Bounded) -> Bounded:
    """1 - |ground| / |held| (...), of magnitudes.

    What is below 1e-12 of the sizes, or within its error, counts as zero: where nothing acts
    and nothing arrives it is 1, where nothing acts and something arrives it is minus infinity.
    """
    acts = held.value > np.maximum(_NOTHING * size.value, 4.0 * held.error)
    arrives = ground.value > np.maximum(_NOTHING * size_ground.value, 4.0 * ground.error)
    ratio = bounded.where(arrives, ground, 0.0) / bounded.where(acts, held, 1.0)
    ratio = bounded.where(acts, ratio, 0.0)
    unbounded = Bounded(np.asarray(-np.inf), np.zeros(()))
    return bounded.where(arrives & ~acts, unbounded, 1.0 - ratio)


def with_resultant(vector: Bounded) -> Bounded:
    """Magnitudes (..., components) and, behind them, the length of the vector."""
    size = abs(vector)
    length = size.norm()
    return bounded.concatenate([size, Bounded(length.value[..., None], length.error[..., None])])


def by_order(held: Bounded, ground: Bounded) -> Bounded:
    """Efficiency (orders, components + 1) of vectors (orders, components), the resultant last."""
    first, second = with_resultant(held), with_resultant(ground)
    return efficiency(first, second, first.max(0)[..., -1:], second.max(0)[..., -1:])


def rms(harmonics: Bounded, retained: int, tail: float) -> Bounded:
    """Root of the mean square (...) over the cycle of amplitudes (orders, ...), 0 to peak.

    What is beyond the `retained` orders may add `tail` times the magnitudes that follow them.
    """
    total = (bounded.square(abs(harmonics[:retained])).sum(0)) * 0.5
    dropped = tail * np.sqrt(0.5 * np.square(np.abs(harmonics.value[retained:])).sum(0))
    value, error = bounded.sqrt(total)
    # orders add in squares
    more = np.hypot(value, dropped) - value
    return Bounded(value, error + more)


def overall(vector: Bounded, order: FloatArray, retained: int, tail: float) -> Overall:
    """Of a vector (orders, components) over the cycle; orders are whole, or all are halves."""
    step = 1.0 if np.all(order % 1.0 == 0.0) else 0.5
    numbers = np.rint(order[:retained] / step).astype(np.int64)
    found = vector_cycle_peak(vector.value[:retained].T, numbers)
    dropped = tail * np.abs(vector.value[retained:]).sum(0)
    error = np.broadcast_to(vector.error, vector.shape)[:retained].sum(0) + dropped
    each = rms(vector, retained, tail)
    return Overall(each.norm(), Bounded(found.value, found.error + np.linalg.norm(error)))
