"""Claim: where a tuning makes maxima equal, the last bits do not choose which one is named."""

import numpy as np

from vibecalc.torsion.damper_design.design import first_of_the_highest

ROW = np.array([3, 1, 1, 0])
SPEED = np.array([80.0, 120.0, 90.0, 60.0])


def test_of_equal_heights_the_first_section_at_its_lowest_speed_is_named() -> None:
    for bits in ((0, 0, 0), (1, 0, -1), (-1, 1, 0), (0, -1, 1)):
        height = 565.0 * (1.0 + 1e-14 * np.array([*bits, 0]))
        height[3] = 300.0
        assert first_of_the_highest(ROW, SPEED, height) == 2


def test_a_height_that_is_larger_by_more_wins() -> None:
    height = np.array([565.0, 565.0 * (1.0 + 1e-8), 565.0, 300.0])
    assert first_of_the_highest(ROW, SPEED, height) == 1
    assert first_of_the_highest(ROW, SPEED, np.array([-np.inf, -np.inf, -np.inf, 3.0])) == 3
