"""Claim: cards and cycles that make no sense are refused in words."""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import (
    card_weights,
    pressure_at,
)
from vibecalc.excitation.pressure_cycle import (
    card_of_mean_pressure,
    card_of_peak,
    motored_cycle,
    usual_cycle,
)
from vibecalc.parts.geometry import CrankGeometry

CAR = CrankGeometry(0.035, 0.123, 0.076)


@pytest.mark.parametrize("speed", [99.0, 501.0, np.nan])
def test_no_card_is_continued_beyond_its_range(speed: float) -> None:
    with pytest.raises(NumericalFailure, match="outside the cards' range, 100 to 500"):
        card_weights([100.0, 500.0], [300.0, speed])


def test_cycles_without_a_pressure_to_be_found_are_refused() -> None:
    with pytest.raises(NumericalFailure, match="not above what the compression alone reaches"):
        card_of_peak(usual_cycle("spark"), CAR, 8e5)
    # the charge is still being compressed while it begins to burn
    cycle = usual_cycle("spark")
    reached = pressure_at(motored_cycle(cycle, CAR), cycle.combustion_starts)
    with pytest.raises(NumericalFailure, match="not above what the compression alone reaches"):
        card_of_peak(cycle, CAR, 1.001 * float(reached) + cycle.crankcase_pressure)
    with pytest.raises(NumericalFailure, match="mean indicated pressure of -1e\\+06 Pa is below"):
        card_of_mean_pressure(usual_cycle("spark"), CAR, -1e6)
