"""Claim: lines without an answer are refused in words, none with a number."""

import numpy as np
import pytest
from torsion_lines import network

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.damped_modes import damped_line_modes
from vibecalc.torsion.holzer import holzer_table
from vibecalc.torsion.line import chain
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.modes_of_tree import riccati_frequencies

LOOP = network([1, 1, 1], [(0, 1, 1.0), (1, 2, 1.0), (2, 0, 1.0)])
TWINS = network([1, 1, 1, 1], [(0, 1, 1.0), (1, 2, 1.0), (1, 3, 1.0)])
EMPTY = chain(np.array([1.0, 0.0, 0.0]), np.array([0.0, 2.0]))
STEEP = chain(np.ones(400), np.full(399, 1e-3))


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: natural_modes(EMPTY), "without any inertia"),
        (lambda: damped_line_modes(EMPTY, 0), "without any inertia"),
        (lambda: riccati_frequencies(LOOP), "closed loop"),
        (lambda: holzer_table(LOOP, np.array(1.0)), "closed loops"),
        (lambda: holzer_table(EMPTY, np.array(1.0)), "without any inertia"),
        # each branch on its own spring, the middle still: two branches of one frequency
        (lambda: holzer_table(TWINS, np.array(1.0)), "stands still"),
        (lambda: holzer_table(STEEP, np.array(1e3)), "range of numbers"),
    ],
)
def test_refused(ask, words: str) -> None:
    with pytest.raises(NumericalFailure, match=words):
        ask()
