"""Claim: what has no steady response, or no trustworthy one, is refused in words."""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.forced import forced, modal_line
from vibecalc.torsion.line import chain
from vibecalc.torsion.modes import natural_modes

PAIR = chain(np.ones(2), np.array([2.0]))
#: the middle station has no inertia
LIGHT = chain(np.array([1.0, 0.0, 1.0]), np.array([4.0, 4.0]))
NEXT = 2.0 * (1.0 + 1e-13)


@pytest.mark.parametrize("estimate", [True, False])
@pytest.mark.parametrize(
    ("line", "frequency", "torque", "words"),
    [
        (PAIR, 2.0, [1.0, 0.0], "at 2 rad/s: it is a natural frequency"),
        (PAIR, 0.0, [1.0, 0.0], "free to turn do not balance"),
        # next to singular, however small the torque
        (PAIR, NEXT, [1e-25, 0.0], "natural frequency of the line"),
        (LIGHT, NEXT, [1.0, 0.0, 0.0], "natural frequency"),
        (LIGHT, NEXT, [0.1, 1.0, 0.2], "natural frequency"),
    ],
)
def test_no_steady_response(line, frequency, torque, words, estimate):
    with pytest.raises(NumericalFailure, match=words):
        forced(line, frequency, np.array(torque), estimate=estimate)


def test_unbalanced_loops_at_rest_are_refused_and_balanced_ones_twist():
    ring = chain(np.ones(3), np.ones(2))._replace(
        first=np.array([0, 1, 2]), second=np.array([1, 2, 0]),
        stiffness=np.ones(3), damping=np.zeros(3), loss_factor=np.zeros(3),
    )  # fmt: skip
    with pytest.raises(NumericalFailure, match="do not balance"):
        forced(ring, 0.0, np.array([1.0, 0.0, 0.0]))
    assert forced(ring, 0.0, [1.0, -1.0, 0.0]).angle == pytest.approx([1 / 3, -1 / 3, 0.0])


def test_a_station_without_inertia_that_nothing_holds_is_refused():
    line = chain(np.array([1.0, 0.0]), np.zeros(1))
    with pytest.raises(NumericalFailure):
        forced(line, 1.0, np.array([0.0, 1.0]))
    assert forced(line, 1.0, np.array([1.0, 0.0])).angle.tolist() == [-1.0, 0.0]


def test_modes_coupled_by_damping_are_no_modal_response():
    line = PAIR._replace(absolute_damping=np.array([1.0, 0.0]))
    with pytest.raises(NumericalFailure, match="couples the undamped modes"):
        modal_line(natural_modes(PAIR), line=line)
