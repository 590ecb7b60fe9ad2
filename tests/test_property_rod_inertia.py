"""Claim: no rod along its line exceeds the bound on its couple, and the bound can be met."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.excitation.rod_inertia import rod_couple_peak, split_inertia
from vibecalc.kinematics.rod_angle import largest_rod_acceleration

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
    couple = rod_couple_peak(inertia - points.value, *lengths, inertia_error=rounding)
    assert couple.value <= bound.value + couple.error + bound.error
    assert points.value >= inertia - rounding


@settings(max_examples=50, deadline=None)
@given(st.floats(0.05, 0.95), st.floats(0.01, 0.99))
def test_bound_is_met_by_a_point_and_missed_by_two(share, ratio):
    # all mass at the centre: J = 0. All mass at the bearings: J = m l1 l2
    points = split_inertia(2.0, share, 1.0)
    bound = rod_couple_peak(points.value, ratio, 1.0)
    _, _, at_centre = rod_of([(2.0, share)], 1.0)
    assert rod_couple_peak(at_centre - points.value, ratio, 1.0).value == bound.value
    _, _, at_ends = rod_of([(2.0 * share, 1.0), (2.0 * (1.0 - share), 0.0)], 1.0)
    left = rod_couple_peak(at_ends - points.value, ratio, 1.0).value
    assert left <= 4e-16 * largest_rod_acceleration(ratio, 1.0).value
