"""How much less reaches the ground than the body would send there, held still."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import numbered, vector_cycle_peak
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Isolation efficiency: 1 - transmissibility. The transmissibility is what reaches the ground over
# what the body held still would send there, which is what acts on it. Below zero the mounts send
# more than acts, as next to a resonance.
# ----------------------------------------------------------------------------

#: share of the largest below which an amplitude is what rounding left of zero
_NOTHING = 1.0e-12
#: share of what arrives below which a load is no measure of it
_OWN = 1.0e-2


class OverCycle(NamedTuple):
    """A magnitude over the cycle, and the part of its error that is rounding: what orders that are
    left out may add makes no zero of it."""

    value: Bounded
    rounding: FloatArray

    def norm(self) -> "OverCycle":
        """Of all components (n,)."""
        return OverCycle(self.value.norm(), Bounded(self.value.value, self.rounding).norm().error)


def is_more(size: Bounded, rounding: FloatArray, largest: Bounded) -> BoolArray:
    """Whether magnitudes are more than what rounding leaves of zero."""
    return np.asarray(size.value > np.maximum(_NOTHING * largest.value, 4.0 * rounding))


def is_swamped(held: Bounded, ground: Bounded, own: FloatArray) -> BoolArray:
    """Whether more arrives than is `held`, nearly all of it from other loads, such as couples.

    `own` is what would arrive of this load alone: where that is next to nothing, as of one that
    nearly cancels, the ratio of what arrives to what acts tells nothing.
    """
    return np.asarray((ground.value > held.value) & (own < _OWN * ground.value))


def own_part(held: Bounded, through: Bounded, part: Any) -> ComplexArray:
    """What would arrive (orders, n) of the loads `held` (orders, n) alone.

    `through` (orders, k, k) are loads that arrive over loads that act, of which `part` are these.
    """
    alone: ComplexArray = through.value[:, part][:, :, part] @ held.value[..., None]
    return alone[..., 0]


def efficiency(held: Bounded, ground: Bounded, acts: BoolArray, arrives: BoolArray) -> Bounded:
    """1 - |ground| / |held| (...), of magnitudes.

    Where nothing acts and nothing arrives it is 1, where nothing acts (or what arrives comes from
    other loads) and something arrives it is minus infinity.
    """
    ratio = bounded.where(arrives, ground, 0.0) / bounded.where(acts, held, 1.0)
    ratio = bounded.where(acts, ratio, 0.0)
    unbounded = Bounded(np.asarray(-np.inf), np.zeros(()))
    return bounded.where(arrives & ~acts, unbounded, 1.0 - ratio)


def by_order(held: Bounded, ground: Bounded, own: ComplexArray) -> Bounded:
    """Efficiency (orders, components + 1) of vectors (orders, components), the resultant last.

    `own` is what would arrive of these loads alone.
    """

    def sizes(vector: Bounded) -> Bounded:
        size = abs(vector)
        return bounded.concatenate([size, size.norm()[..., None]])

    both = sizes(held), sizes(ground)
    acts, arrives = (is_more(one, one.error, one.max(0)[..., -1:]) for one in both)
    acts &= ~is_swamped(*both, sizes(bounded.bounded(own)).value)
    return efficiency(*both, acts, arrives)


def rms(harmonics: Bounded, retained: int, tail: FloatArray | float) -> OverCycle:
    """Root of the mean square (...) over the cycle of amplitudes (orders, ...), 0 to peak.

    What is beyond the `retained` orders may add `tail` times the magnitudes that follow them.
    """
    total = (bounded.square(abs(harmonics[:retained])).sum(0)) * 0.5
    dropped = tail * np.sqrt(0.5 * np.square(np.abs(harmonics.value[retained:])).sum(0))
    value, error = bounded.sqrt(total)
    # orders add in squares
    more = np.hypot(value, dropped) - value
    return OverCycle(Bounded(value, error + more), error)


def peak(vector: Bounded, order: FloatArray, retained: int, tail: FloatArray | float) -> OverCycle:
    """Largest length over the cycle of a vector (orders, components); orders are whole, or all are
    halves."""
    found = vector_cycle_peak(vector.value[:retained].T, numbered(order[:retained]))
    dropped = tail * np.abs(vector.value[retained:]).sum(0)
    error = vector.errors[:retained].sum(0)
    whole = found.error + np.linalg.norm(error + dropped)
    return OverCycle(Bounded(found.value, whole), found.error + np.linalg.norm(error))
