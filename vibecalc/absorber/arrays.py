"""Tunings of one absorber at many points at once: over its mass ratio and the primary's damping."""

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON


def tunings(scene: PointsScene) -> None:
    """Emit the tunings of all points; those that no absorber helps, or with a set of optima, which
    a run of their own tells in words, are left alone.
    """
    from vibecalc.absorber.model import build_absorber
    from vibecalc.absorber.peaks import peaks
    from vibecalc.absorber.transfer import Absorber, own_damping_ratio
    from vibecalc.absorber.tuning.minimax import BALANCED, minimax

    parts, options = build_absorber(scene.case), scene.case.tuning
    assert parts.absorber is not None and options is not None
    pair = options.excitation, options.response
    z1, m = (
        np.array(np.broadcast_to(given, scene.count), dtype=float)
        for given in (parts.primary_damping, parts.absorber.mass_ratio)
    )
    tuning = minimax(z1, m, *pair)
    scene.alone |= tuning.outcome != BALANCED
    done = np.flatnonzero(~scene.alone)
    k, z2 = tuning.stiffness_ratio[done], tuning.secondary_damping[done]
    tuned = Absorber(z1[done], m[done], k, z2)
    ratio, top = own_damping_ratio(tuned), peaks(tuned, *pair)
    k_error, z2_error = tuning.stiffness_error[done], tuning.damping_error[done]
    relative = z2_error / z2 + k_error / k + 4.0 * EPSILON
    for name, value, error in (
        ("primary_damping", z1[done], np.zeros(len(done))),
        ("mass_ratio", m[done], 2.0 * EPSILON * m[done]),
        ("stiffness_ratio", k, k_error),
        ("damping_over_primary_critical", z2, z2_error),
        ("absorber_damping_ratio", ratio, ratio * relative),
        ("peak", top.largest, top.largest_error + tuning.largest_error[done]),
    ):
        found = np.zeros((2, scene.count))
        found[:, done] = value, error
        scene.emit(f"tuning/{name}", Bounded(*found))
