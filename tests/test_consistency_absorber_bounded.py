"""Claim: an optimum within limits is the best point of a brute grid within them, held by the
limits it names; the best stock pair is the best of all pairs.
"""

import numpy as np
import pytest

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import stock_choice
from vibecalc.absorber.tuning.several import bounded_tuning

CASES = [
    ({"travel": 8.0}, ("spring travel",)),
    ({"travel": 1.0}, ("spring travel",)),
    ({"stiffness": (0.1, 0.2)}, ("least stiffness",)),
    ({"damping": (0.0, 0.01)}, ("largest damping",)),
    ({"damping": (0.03, 1.0)}, ("least damping",)),
    ({"stiffness": (0.02, 0.05), "travel": 10.0}, ("largest stiffness", "spring travel")),
    ({"damping": (0.0, 0.02), "travel": 3.0}, ("largest damping", "spring travel")),
    ({"stiffness": (0.0, 0.0)}, ("least stiffness", "largest stiffness")),
]


@pytest.mark.parametrize(
    ("limits", "active"),
    [
        *CASES[::5],
        *(pytest.param(*row, marks=pytest.mark.long) for k, row in enumerate(CASES) if k % 5),
    ],
)
def test_no_point_of_a_grid_within_the_limits_is_better(limits, active):
    found = bounded_tuning(0.02, 0.1, **limits)
    assert found.active == active
    low, high = limits.get("stiffness", (1e-3, 3.0))
    k = np.linspace(low, high, 40) if "stiffness" in limits else np.geomspace(low, high, 90)
    low, high = limits.get("damping", (1e-3, 3.0))
    z = np.linspace(low, high, 40) if "damping" in limits else np.geomspace(low, high, 90)
    grid = Absorber(0.02, 0.1, k[:, None], z)
    height = peaks(grid).largest
    allowed = peaks(grid, "force", "relative_displacement").largest <= limits.get("travel", np.inf)
    best = float(np.min(np.where(allowed, height, np.inf)))
    assert found.tuning.peak <= best * (1.0 + 1e-12)
    assert found.tuning.peak >= best * 0.9
    assert found.travel <= limits.get("travel", np.inf) * (1.0 + 1e-9)
    chosen = Absorber(0.02, 0.1, found.tuning.stiffness_ratio[0], found.tuning.secondary_damping[0])
    assert peaks(chosen).largest == pytest.approx(found.tuning.peak, rel=1e-12)
    assert found.penalty == pytest.approx(found.tuning.peak / found.free_peak - 1.0, rel=1e-12)


def test_limits_that_do_not_bind_cost_nothing():
    found = bounded_tuning(0.02, 0.1, stiffness=(0.0, 1.0), damping=(0.0, 1.0), travel=30.0)
    assert found.active == () and abs(found.penalty) <= found.penalty_error
    assert found.free_peak == pytest.approx(float(minimax(0.02, 0.1).largest), rel=1e-12)


def test_other_excitations_count_travel_in_their_own_unit():
    free = bounded_tuning(0.05, 0.2, "base", "displacement")
    held = bounded_tuning(0.05, 0.2, "base", "displacement", travel=0.5 * free.travel)
    assert held.travel == pytest.approx(0.5 * free.travel, rel=1e-9)
    assert held.penalty > 0.0


def test_the_best_stock_pair():
    springs, oils = [0.07, 0.08, 0.09], [0.01, 0.015, 0.02, 0.03]
    free = float(minimax(0.02, 0.1).largest)
    found = stock_choice(0.02, 0.1, springs, oils, free)
    one_by_one = np.array([[float(peaks(Absorber(0.02, 0.1, k, z)).largest) for z in oils]
                           for k in springs])  # fmt: skip
    assert found.peak == pytest.approx(one_by_one, rel=1e-13)
    assert (found.spring, found.oil) == np.unravel_index(np.argmin(one_by_one), (3, 4))
    assert np.all(np.diff(one_by_one[tuple(found.order.T)]) >= 0.0)
    assert np.all(found.penalty > 0.0)
    limited = stock_choice(0.02, 0.1, springs, oils, free, travel=9.0)
    assert not np.any(limited.travel[tuple(limited.order.T)] > 9.0)
    assert len(limited.order) == 3 and limited.oil == 3
