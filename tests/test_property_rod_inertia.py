"""Claim: no rod along its line exceeds the bound on its couple, and the bound can be met."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.excitation.rod_inertia import rod_couple_peak, split_inertia
from vibecalc.numerics.bounded import Bounded

shares = st.lists(
    st.tuples(st.floats(1e-3, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=6, unique=True
)


def rod_of(parts, length):
    """Mass, distance of the centre from the crank pin, moment about it."""
    mass, place = np.array(parts).T
    place = length * place
    first = float(mass @ place / mass.sum())
    return float(mass.sum()), first, float(mass @ (place - first) ** 2)


@settings(max_examples=150, deadline=None)
@given(shares, st.floats(0.01, 0.95), st.floats(-0.9, 0.9), st.floats(0.01, 10.0))
def test_bound_holds_for_rods_of_point_masses(parts, ratio, offset, length):
    mass, first, inertia = rod_of(parts, length)
    lengths = (length * ratio * (1.0 - abs(offset)), length, length * offset)
    points = split_inertia(mass, first, length)
    bound = rod_couple_peak(points.value, *lengths)
    rounding = 1e-14 * mass * length**2
    couple = rod_couple_peak(Bounded(inertia - points.value, np.asarray(rounding)), *lengths)
    assert couple.value <= bound.value + couple.error + bound.error
    assert points.value >= inertia - rounding
