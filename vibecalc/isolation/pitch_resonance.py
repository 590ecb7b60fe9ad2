"""Where an order may meet the natural frequency of a pitching body."""

import numpy as np

from vibecalc.isolation.pitch import Pitch
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, WithError
from vibecalc.response.resonance import Resonances


def pitch_resonances(pitch: Pitch, couple: WithError) -> Resonances:
    """The one resonance of a pitch model without leading axes, couples (orders,) at any scale."""
    loss = 2.0 * (pitch.rounding + 2.0 * UNIT_ROUNDOFF)
    return Resonances(
        np.reshape(pitch.natural_frequency, 1),
        np.reshape(pitch.damping_ratio, 1),
        np.array([0.5 * loss / SINGULAR]),
        (np.abs(couple.value) <= 4.0 * couple.error)[:, None],
    )
