"""Claim: the truncated series approaches the exact motion at the rate of its own theory, and the
harmonics approach those of R/L = 1, where the piston follows cos t + |cos t|.
"""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.slider_crank import piston_motion
from vibecalc.kinematics.truncated_series import (
    truncated_dropped_acceleration,
    truncated_motion,
)


@pytest.mark.parametrize("rod_ratio", [0.2105, 0.3, 0.9])
def test_error_of_the_truncated_motion_falls_like_the_next_term(rod_ratio):
    # the first term left out in the acceleration at 90 degrees is about lam^(2 terms + 1)
    terms = np.arange(1, 7 if rod_ratio < 0.5 else 25)
    exact = piston_motion(np.pi / 2, rod_ratio, 1.0).acceleration
    cut = [truncated_motion(np.pi / 2, rod_ratio, 1.0, t).acceleration for t in terms.tolist()]
    error = np.abs(np.array(cut) - exact)
    rest = rod_ratio * np.array(
        [truncated_dropped_acceleration(rod_ratio, t) for t in terms.tolist()]
    )
    np.testing.assert_allclose(error, rest, rtol=1e-4, atol=2e-15)
    rate = rest[1:] / rest[:-1]
    limit = rod_ratio**2
    # one term to the next is lam^2 (2 j + 1)/(2 j + 2), so the rests fall between that and lam^2
    assert np.all(rate < limit)
    assert np.all(rate > limit * (2 * terms[:-1] + 1) / (2 * terms[:-1] + 2))


@pytest.mark.long
def test_limit_of_a_rod_as_short_as_the_crank():
    # |cos t| = 2/pi + 4/pi sum (-1)^(k+1) cos 2kt / (4 k^2 - 1); the way there is d log(1/d)
    distance = 10.0 ** -np.arange(3, 9)
    harmonics = motion_harmonics(1.0 - distance, 20).real
    k = np.arange(1, 11)
    limit = np.concatenate([[2.0], 4.0 * (-1.0) ** (k + 1) / (4.0 * k**2 - 1.0)]) / np.pi
    assert np.all(harmonics[:, 1] == 1.0)
    error = np.max(np.abs(harmonics[:, ::2] - limit), axis=1)
    rate = np.polyfit(np.log(distance), np.log(error / np.log(1.0 / distance)), 1)[0]
    assert rate == pytest.approx(1.0, abs=0.05)
    assert error[-1] < 3e-7


def test_a_ratio_within_rounding_of_one_is_refused_not_guessed():
    words = r"more than 1000000, because R/L .* lengthen the rod"
    with pytest.raises(NumericalFailure, match=words):
        motion_harmonics(np.nextafter(1.0, 0.0), 4)
