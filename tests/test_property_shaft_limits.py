"""Claim: limit curves of the rules are continuous, scale as written and are refused outside their
scope; separations agree with their definitions on the edges.
"""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.stress_limits import (
    M68,
    SEPARATIONS,
    barred_range,
    covered,
    propulsion_shaft_limits,
    separation,
)


def test_m68_by_hand_at_rest_and_at_rated_speed():
    # 600 N/mm2, 200 mm, flange: 760 / 18 * (.35 + .93 * 200^-.2) * 3 at rest
    size = 0.35 + 0.93 * 200.0**-0.2
    found = propulsion_shaft_limits([0.0, 1.0], 600e6, 0.2)
    assert found.continuous == pytest.approx(760 / 18 * size * 1e6 * np.array([3.0, 1.38]))
    assert found.continuous[0] == pytest.approx(85.16e6, rel=1e-3)
    assert found.transient == pytest.approx(1.7 * found.continuous)
    keyed = propulsion_shaft_limits(0.5, 600e6, 0.2, 0.6)
    plain = propulsion_shaft_limits(0.5, 600e6, 0.2)
    assert keyed.continuous == pytest.approx(0.6 * plain.continuous)
    assert keyed.transient == pytest.approx(np.sqrt(0.6) * plain.transient)


def test_m68_curve_is_continuous_and_never_rises():
    ratio = np.linspace(0.0, 1.05, 2101)
    limit = propulsion_shaft_limits(ratio, 500e6, 0.3).continuous
    assert np.all(np.diff(limit) <= 1e-9 * limit[0])
    near = propulsion_shaft_limits([np.nextafter(0.9, 0.0), 0.9], 500e6, 0.3)
    assert np.ptp(near.continuous) <= 1e-14 * near.continuous[0]
    # steel above the cap counts no more
    capped = propulsion_shaft_limits(0.5, 900e6, 0.3).continuous
    assert capped == propulsion_shaft_limits(0.5, 600e6, 0.3).continuous


def test_m68_says_what_it_is_not_for():
    assert "crankshafts" in M68.not_for and M68.status == "informative"
    assert covered([0.0, 1.05, 1.0501, -0.1]).tolist() == [True, True, False, False]
    with pytest.raises(NumericalFailure, match=r"no limit at 1.2 of the rated speed"):
        propulsion_shaft_limits([0.3, 1.2], 600e6, 0.2)


def test_barred_range():
    found = barred_range([50.0, 80.0], 100.0)
    assert found.lower == pytest.approx([16 * 50 / 17.5, 16 * 80 / 17.2])
    assert found.upper == pytest.approx([17.5 * 50 / 16, 17.2 * 80 / 16])
    # geometric about the critical speed
    assert found.lower * found.upper == pytest.approx([2500.0, 6400.0])
    assert found.permitted.tolist() == [True, False]
    with pytest.raises(NumericalFailure, match=r"above 1\.05"):
        barred_range(106.0, 100.0)


def test_separation_margins():
    # orders 1, 2 and 2.5 of 90 to 100 rad/s
    found = separation([80.0, 95.0, 112.0, 165.0, 209.0], [1.0, 2.0, 2.5], 90.0, 100.0)
    assert found.margin[:, 0] == pytest.approx([1 / 9, -0.05, 0.12, 0.65, 1.09])
    assert found.kept[:, 0].tolist() == [True, False, True, True, True]
    assert found.margin[3:, 1] == pytest.approx([15 / 180, 9 / 200])
    assert found.kept[3:, 1].tolist() == [True, False]
    assert found.kept[:, 2].all()
    # a range from rest has no side below
    from_rest = separation([50.0], [1.0], 0.0, 100.0, "api_684")
    assert from_rest.margin[0, 0] == pytest.approx(-0.5) and not from_rest.kept[0, 0]
    assert SEPARATIONS["api_618"].margin[10.0] == 0.05 and 11.0 not in SEPARATIONS["api_618"].margin
