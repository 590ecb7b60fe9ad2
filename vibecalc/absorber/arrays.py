"""Tunings of one absorber at many points at once: over its mass ratio and the primary's damping."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.run.columns import Column, Sheet
from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, IntArray

if TYPE_CHECKING:
    from vibecalc.schema import Case

MASS: KeyPath = ("machine", "secondary", "mass_ratio")
DAMPING: KeyPath = ("machine", "primary", "damping_ratio")
#: results that arrays give
TUNING_PATHS = tuple(
    f"tuning/{name}"
    for name in (
        *("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping"),
        *("own_damping", "peak"),
    )
)


def tunings(
    case: "Case", varied: Mapping[KeyPath, np.ndarray], count: int, keep: frozenset[str]
) -> tuple[IntArray, dict[str, Column], IntArray]:
    """Places that are done, their results, and the places that need a single run.

    These are points that a check refuses, that no absorber helps, or with a set of optima, which a
    single run tells in words.
    """
    from vibecalc.absorber.model import build_absorber
    from vibecalc.absorber.peaks import peaks
    from vibecalc.absorber.transfer import Absorber, own_damping_ratio
    from vibecalc.absorber.tuning.minimax import BALANCED, minimax

    parts, options = build_absorber(case), case.tuning
    if parts.absorber is None or options is None:
        raise ValueError("the case has no absorber to tune")
    pair = options.excitation, options.response
    given = {DAMPING: parts.primary_damping, MASS: parts.absorber.mass_ratio}
    z1, m = (
        np.array(np.broadcast_to(varied.get(key, given[key]), (count,)), dtype=float)
        for key in (DAMPING, MASS)
    )
    usable = np.isfinite(z1) & (z1 >= 0.0) & np.isfinite(m) & (m > 0.0)
    every = np.arange(count)
    try:
        tuning = minimax(np.where(usable, z1, 0.0), np.where(usable, m, 1.0), *pair)
    except NumericalFailure:
        return every[:0], {}, every
    done = np.flatnonzero(usable & (tuning.outcome == BALANCED))
    sheet = Sheet(len(done), keep)
    k, z2 = tuning.stiffness_ratio[done], tuning.secondary_damping[done]
    tuned = Absorber(z1[done], m[done], k, z2)
    ratio, top = own_damping_ratio(tuned), peaks(tuned, *pair)
    k_error, z2_error = tuning.stiffness_error[done], tuning.damping_error[done]
    relative = z2_error / z2 + k_error / k + 4.0 * EPSILON
    for name, value, error in (
        ("primary_damping", z1[done], np.zeros(len(done))),
        ("mass_ratio", m[done], 2.0 * EPSILON * m[done]),
        ("stiffness_ratio", k, k_error),
        ("secondary_damping", z2, z2_error),
        ("own_damping", ratio, ratio * relative),
        ("peak", top.largest, top.largest_error + tuning.largest_error[done]),
    ):
        sheet.emit(f"tuning/{name}", Bounded(value, error))
    return done, sheet.columns, np.setdiff1d(every, done)
