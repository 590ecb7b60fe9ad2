"""Claim: what has no optimum, no meaning or no digits is refused in words."""

import numpy as np
import pytest

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.closed_forms import closed_form
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import given_damping, given_stiffness, undamped_spring
from vibecalc.errors import NumericalFailure


@pytest.mark.parametrize(
    ("z1", "m"), [(0.1, 0.0), (0.1, -1.0), (0.1, np.inf), (-0.1, 0.1), (np.inf, 0.1), (np.nan, 0.1)]
)
def test_ratios_out_of_range(z1, m):
    with pytest.raises(NumericalFailure, match="mass ratio"):
        minimax(z1, m)
    with pytest.raises(NumericalFailure, match="mass ratio"):
        given_stiffness(z1, m, 0.1)


def test_a_response_of_the_secondary_is_not_made_least():
    for response in ("secondary_displacement", "relative_displacement"):
        with pytest.raises(NumericalFailure, match="vanishes with the absorber"):
            minimax(0.1, 0.1, "force", response)
        with pytest.raises(NumericalFailure, match="vanishes with the absorber"):
            given_damping(0.1, 0.1, 0.1, "force", response)


def test_given_parts_out_of_range():
    for bad in (-0.1, np.inf, np.nan):
        with pytest.raises(NumericalFailure, match="zero or above"):
            given_damping(0.1, 0.1, bad)


def test_an_undamped_system_has_no_best_spring():
    with pytest.raises(NumericalFailure, match="infinite whatever the spring"):
        undamped_spring([0.0, 0.1], 0.1)


def test_closed_forms_by_an_unknown_name_or_without_a_mass():
    with pytest.raises(NumericalFailure, match="nishihara_asami"):
        closed_form("newton", 0.1)
    with pytest.raises(NumericalFailure, match="mass ratios above 0"):
        closed_form("lanchester", [0.1, 0.0])


def test_a_resonance_too_sharp_for_double_precision():
    with pytest.raises(NumericalFailure, match="beyond double precision"):
        peaks(Absorber(1e-20, 0.1, 0.1, 0.0))


def test_unknown_excitation():
    with pytest.raises(NumericalFailure, match="unbalance"):
        minimax(0.1, 0.1, "wind")
