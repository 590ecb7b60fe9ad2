"""Claim: a mean square, tuning or limit that does not exist is refused in words that say why."""

import numpy as np
import pytest

from vibecalc.absorber.mean_square import mean_square, weights
from vibecalc.absorber.several import Several, several_amplitude
from vibecalc.absorber.several_peaks import several_peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.closed_forms import threshold
from vibecalc.absorber.tuning.mean_square import mean_square_tuning
from vibecalc.absorber.tuning.mistuning import mistuning, sensitivity
from vibecalc.absorber.tuning.restricted import stock_choice
from vibecalc.absorber.tuning.several import bounded_tuning, several_tuning
from vibecalc.errors import NumericalFailure

SOME = Absorber(0.05, 0.1, 0.08, 0.02)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (("force", "acceleration", ""), "highest frequencies"),
        (("base", "displacement", ""), "at zero frequency"),
        (("base", "velocity", ""), "at zero frequency"),
        (("base", "acceleration", "velocity"), "with damping in the primary system"),
        (("base", "transmitted_force", "velocity"), "with damping in the primary system"),
        (("base", "acceleration", "displacement"), "highest frequencies"),
        (("unbalance", "displacement", ""), "highest frequencies"),
        (("unbalance", "relative_displacement", ""), "highest frequencies"),
        (("force", "secondary_displacement", ""), "not among"),
        (("force", "displacement", "velocity"), "says nothing"),
        (("base", "displacement", "pink"), "says nothing"),
    ],
)
def test_mean_squares_that_do_not_exist(kind, words):
    with pytest.raises(NumericalFailure, match=words):
        mean_square(SOME, *kind)
    with pytest.raises(NumericalFailure):
        mean_square_tuning(0.05, 0.1, *kind)


def test_what_only_an_undamped_primary_has():
    undamped = SOME._replace(primary_damping=0.0)
    assert weights("base", "acceleration", "velocity").undamped_only
    same = mean_square(undamped, "force", "velocity").value
    assert mean_square(undamped, "base", "acceleration", "velocity").value == pytest.approx(same)


def test_secondary_that_nothing_holds_and_ground_that_drifts():
    with pytest.raises(NumericalFailure, match="nothing holds"):
        mean_square(Absorber(0.1, 0.1, 0.0, 0.0), "force", "relative_displacement")
    drifting = mean_square(Absorber(0.1, 0.1, 0.0, 0.1), "base", "relative_displacement")
    assert drifting.value == np.inf
    with pytest.raises(NumericalFailure, match="nothing to tune"):
        mean_square_tuning(0.1, 0.1, "force", "relative_displacement")


def test_thresholds_that_mean_nothing():
    with pytest.raises(NumericalFailure, match="no response of the primary"):
        threshold("force", "relative_displacement")


def test_bounds_that_leave_nothing():
    with pytest.raises(NumericalFailure, match=r"stiffness ratio, 0\.2 to 0\.1"):
        bounded_tuning(0.02, 0.1, stiffness=(0.2, 0.1))
    with pytest.raises(NumericalFailure, match="damping ratio, -1 to 1"):
        bounded_tuning(0.02, 0.1, damping=(-1.0, 1.0))
    with pytest.raises(NumericalFailure, match="leaves no motion"):
        bounded_tuning(0.02, 0.1, travel=0.0)
    with pytest.raises(NumericalFailure, match="exceeds it by the factor"):
        bounded_tuning(0.02, 0.1, stiffness=(0.0, 0.1), damping=(0.0, 0.02), travel=1.0)


def test_stock_without_a_usable_pair():
    with pytest.raises(NumericalFailure, match="least travel is"):
        stock_choice(0.02, 0.1, [0.07, 0.08], [0.01, 0.02], 3.9, travel=2.0)
    with pytest.raises(NumericalFailure, match="none of the 1 pairs"):
        stock_choice(0.0, 0.1, [0.08], [0.0], 3.9)


def test_losses_and_derivatives_of_what_is_no_optimum():
    with pytest.raises(NumericalFailure, match="not finite"):
        mistuning(Absorber(0.0, 0.1, 0.08, 0.0))
    with pytest.raises(NumericalFailure, match="sensitivity"):
        sensitivity(0.0, 0.1, 0.05, 0.005)
    with pytest.raises(NumericalFailure, match="sensitivity"):
        sensitivity(0.8, 0.1, 0.08, 0.02)


def test_trees_that_are_none():
    for parent in ((1, 0), (0, 2), (0,), (0, -1)):
        system = Several(0.1, [0.1, 0.1], [0.1, 0.1], [0.01, 0.01], parent)
        with pytest.raises(NumericalFailure, match="each must be 0"):
            several_amplitude(system, 1.0)
    system = Several(0.1, [0.1, 0.1], [0.1, 0.1], [0.01, 0.01], (0, 1))
    with pytest.raises(NumericalFailure, match="counted from 1"):
        several_amplitude(system, 1.0, "force", "relative_displacement", 3)


def test_several_without_a_finite_peak():
    bare = Several(0.0, [0.1, 0.1], [0.1, 0.08], [0.0, 0.0], (0, 0))
    with pytest.raises(NumericalFailure, match="undamped natural frequency"):
        several_peaks(bare)
    with pytest.raises(NumericalFailure, match="without bound"):
        several_tuning(0.1, [0.05, 0.05], (0, 0), "unbalance", "velocity")
