"""Claim: a ring whose inertia is searched at a price grows until it gains what it costs."""

import pytest
from line_damper_samples import branched

from vibecalc.torsion.damper_design.design import design
from vibecalc.torsion.damper_design.problem import Limits

FREE = Limits((0.5, 0.5), (4e3, 1.6e4), (20.0, 150.0))


@pytest.mark.long
def test_a_priced_ring_gains_as_much_as_it_costs() -> None:
    limits = FREE._replace(inertia=(0.6, 1.2), inertia_price=50.0)
    found = design(branched(), limits, map_points=5, speeds=21, starts=1)
    assert found.residual < 1e-11 and found.curvature > 0.0
    inertia = found.damper.inertia
    assert 0.6 < inertia < 1.2
    _, stiffness, damping = found.damper
    near = FREE._replace(
        inertia=(0.998 * inertia, 0.998 * inertia),
        stiffness=(0.95 * stiffness, 1.1 * stiffness),
        damping=(0.95 * damping, 1.1 * damping),
    )
    light = design(branched(), near, map_points=2, speeds=21)
    assert abs((light.worst - found.worst) / (0.002 * inertia) / 50.0 - 1.0) < 0.01
