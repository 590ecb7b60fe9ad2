"""The free optimum of one absorber in the form of several: sharp down to a threshold."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.certificate import certify
from vibecalc.optimisation.absorber.minimax import BALANCED, minimax
from vibecalc.optimisation.absorber.several import SeveralTuning
from vibecalc.optimisation.absorber.several_problem import Problem
from vibecalc.response.absorber.model import Absorber, transfer_of
from vibecalc.response.absorber.several_slopes import several_slopes


def free_optimum(problem: Problem) -> SeveralTuning | None:
    """The minimax of one absorber without limits; None where two equal peaks do not hold it.

    Beside a threshold the peaks stand above the floor by less than the levels of several absorbers
    can tell; `minimax` works with that excess itself.
    """
    pair = problem.excitation, problem.response
    z1, m = problem.primary_damping, problem.mass_ratio
    try:
        best = minimax(z1, float(m[0]), *pair)
    except NumericalFailure:
        return None
    if int(best.outcome) != BALANCED:
        return None
    k, z2 = best.stiffness_ratio.reshape(1), best.secondary_damping.reshape(1)
    ratios = np.append(k, z2)
    found = several_slopes(problem.system(ratios), best.frequency, transfer_of(*pair))
    # along the line of equal levels, per relative change of both ratios
    slope = found.first[:, :2] * ratios
    apart = slope[0] - slope[1]
    along = np.array([-apart[1], apart[0]]) / max(float(np.linalg.norm(apart)), 1e-300)
    bend = np.tensordot(best.weight, found.second[:, :2, :2], 1) * ratios[:, None] * ratios
    none = np.zeros(2, dtype=bool)
    return SeveralTuning(
        m, k, z2, float(best.largest), float(best.largest_error),
        np.array([float(best.stiffness_error), float(best.damping_error)]), best.frequency,
        best.weight, float(certify(Absorber(z1, m[0], k[0], z2[0]), *pair).residual),
        float(along @ bend @ along), none, none, np.zeros(0), np.zeros(0, dtype=bool), False, False,
        1, 1, int(best.evaluations),
    )  # fmt: skip
