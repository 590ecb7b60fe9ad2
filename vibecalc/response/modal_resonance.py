"""Where an order may meet a natural frequency of a rigid body, and how close it may come."""

import numpy as np

from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, WithError
from vibecalc.response.energy import damping_ratio, modal_force
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import Modes
from vibecalc.response.resonance import Resonances


def body_resonances(matrices: Matrices, shapes: Modes, force: WithError) -> Resonances:
    """Resonances of a rigid body under forces (orders, 6) in complex amplitude, any scale."""
    ratio = damping_ratio(matrices, shapes).value
    size = np.abs(shapes.shape)
    doubt_k = matrices.stiffness_error + 2.0 * UNIT_ROUNDOFF * np.abs(matrices.stiffness)
    doubt_m = matrices.mass_error + 4.0 * UNIT_ROUNDOFF * np.abs(matrices.mass)
    loss = np.sum(size * (doubt_k @ size), axis=0) / shapes.eigenvalue
    loss = loss + np.sum(size * (doubt_m @ size), axis=0)
    driven = modal_force(shapes, force.value, force.error)
    return Resonances(
        shapes.natural_frequency,
        np.abs(ratio),
        0.5 * loss / SINGULAR,
        np.abs(driven.value) <= 4.0 * driven.error,
    )
