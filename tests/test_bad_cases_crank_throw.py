"""Claim: what a formula for a throw or a shaft cannot say is refused in words."""

import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.from_dimensions import (
    Throw,
    reciprocating_inertia,
    shaft_stiffness,
    stiffness_spread,
    throw_stiffness,
)

#: short stroke, thick journal and pin: they overlap
OVERLAPPED = Throw(0.028, 0.090, 0.0, 0.030, 0.090, 0.0, 0.018, 0.11, 0.035)


def test_ker_wilson_without_a_web():
    with pytest.raises(NumericalFailure, match="no web left"):
        throw_stiffness(OVERLAPPED, 79e9, "ker_wilson")
    spread = stiffness_spread(OVERLAPPED, 79e9)
    assert spread.left_out == ("ker_wilson",) and len(spread.stiffness) == 3
    with pytest.raises(NumericalFailure, match="none of the formulas"):
        stiffness_spread(OVERLAPPED, 79e9, ("ker_wilson",))


def test_names_that_are_not_known_get_the_list():
    with pytest.raises(ValueError, match="known: source, timoshenko, carter, ker_wilson"):
        throw_stiffness(OVERLAPPED, 79e9, "bicera")
    with pytest.raises(ValueError, match="known: half, mean"):
        reciprocating_inertia(1.0, 0.1, 0.3, "third")


def test_shafts_that_have_no_stiffness():
    with pytest.raises(NumericalFailure, match="wall too thin"):
        shaft_stiffness(79e9, 0.3, 0.05, 0.0, 0.06, 0.0599999999)
