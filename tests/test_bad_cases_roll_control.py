"""Claim: gains out of all reason give an answer or a refusal in words, never NaN, and never a
finite level for a loop that is not stable.
"""

import itertools

import numpy as np
import pytest
from long_but import long_but
from roll_control_loops import SOURCE, TARGET, source_load

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.roll.control.gains import ControlledLoop, Demands, evaluate, evaluate_at_speed, tune
from vibecalc.roll.control.loop import Controller, loop_of
from vibecalc.roll.control.margins import STATUS
from vibecalc.roll.control.poles import poles

EXTREMES = list(
    itertools.product(
        (1e-6, 1.0, 1e6),  # gain
        (-2.0, -1e-9, 0.0, 0.9, 1e4),  # speed feedback
        (-1e4, -0.0746, 0.0, 1e-9, 0.0746, 1e4),  # acceleration feedback
        (0.0, 1e-12, 1e-3, 1e3),  # lag
        (0.0, 1e-12, 1e-3, 10.0),  # delay
    )
)


def leaves(found: object) -> list[np.ndarray]:
    if isinstance(found, tuple | Bounded):
        return [leaf for part in found for leaf in leaves(part)]
    return [np.asarray(found)]


def test_no_extreme_gives_nan_or_praise():
    columns = np.array(EXTREMES).T
    found: ControlledLoop = evaluate(SOURCE, Controller(*columns), source_load())
    assert not any(np.any(np.isnan(leaf)) for leaf in leaves(found))
    stable = found.margins.stable
    assert 100 < np.sum(stable) < len(stable)
    np.testing.assert_array_equal(np.isfinite(found.level.value).all(axis=-1), stable)
    assert np.all(found.margins.gain.value >= 1.0) and np.all(found.margins.phase.value >= 0.0)
    assert np.all(found.margins.gain_lower.value <= 1.0)
    assert np.all(found.margins.delay.value >= 0.0)
    assert np.all((found.margins.status >= 0) & (found.margins.status < len(STATUS)))


def test_positive_feedback_of_the_shell_is_flagged_where_it_outruns_the_rotor():
    feedback = np.array([0.01, 0.07, 0.08, 1.0, 10.0])
    controller = Controller(10.0, 0.0, feedback)
    found = evaluate_at_speed(SOURCE, controller, source_load(), TARGET)
    np.testing.assert_array_equal(found.margins.stable, [True, True, False, False, False])
    assert STATUS[int(found.margins.status[-1])] == "unstable"


@pytest.mark.parametrize("delay", long_but([1e-9, 1e-5, 1e-2, 1.0], 1e-5, 1.0))
@pytest.mark.parametrize("lag", [0.0, 1e-9, 1e-3, 1.0])
def test_poles_are_found_or_refused_in_words(lag, delay):
    loop = loop_of(SOURCE, Controller(10.0, 0.9, np.array([-10.0, -0.05, 0.0]), lag, delay))
    refused = ""
    try:
        found = poles(loop, 4)
    except NumericalFailure as failure:
        refused = str(failure)
    if refused:
        assert "do not agree" in refused
        return
    assert np.all(np.isfinite(found.value)) and np.all(found.error < 1e-6 * np.abs(found.value))


def test_a_lag_with_most_delays_has_its_poles():
    """The refusal above is for corners: in the range of real actuators the poles are found."""
    lag, delay = (a.ravel() for a in np.meshgrid(np.geomspace(1e-4, 3e-2, 3), [1e-5, 1e-4, 3e-3]))
    for one, late in zip(lag, delay, strict=True):
        loop = loop_of(SOURCE, Controller(10.0, 0.9, np.array([-1.0, -0.05, 0.0, 0.05]), one, late))
        assert poles(loop, 4).complete.all()


def test_bounds_that_allow_only_unstable_loops_are_refused():
    demands = Demands((5.0, 10.0), (1.0, 2.0))
    with pytest.raises(NumericalFailure, match=r"no gain from 5 to 10 .* from 1 to 2 s"):
        tune(SOURCE, Controller(1.0, 0.0, 0.0), source_load(), TARGET, demands)
