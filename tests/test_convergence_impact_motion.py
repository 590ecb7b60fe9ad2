"""Claim: the fixed-step methods have their orders where the motion is smooth, and approach the
event-exact motion through contacts.
"""

import numpy as np
import pytest
from impact_machines import MASS, compressor_drive, gas_towards, source_joint
from long_but import long_but
from test_consistency_impact_motion import always_in_contact

from vibecalc.impact.fixed_step import METHODS, simulate_fixed_steps
from vibecalc.impact.simulate import simulate

FEW = {"euler": 1000, "heun": 1000, "rk4": 1600, "dormand_prince": 800}


@pytest.mark.parametrize("method", long_but(METHODS, "heun", "rk4"))
def test_orders_on_a_smooth_motion(method):
    # strong damping: nothing but the steady state is left after a turn
    drive, gas, joint, start, force = always_in_contact(6000.0)
    exact = np.zeros(9, dtype=complex)
    exact[drive.orders[drive.orders < 9]] = force[drive.orders < 9]
    errors = []
    for steps in (FEW[method], 2 * FEW[method]):
        run = simulate_fixed_steps(
            drive, gas, MASS, joint, start[:1], start[1:], method=method, steps=steps,
            revolutions=1, orders_retained=8,
        )  # fmt: skip
        errors.append(np.max(np.abs(run.wrist_pin.force_harmonics[0, 0] - exact)))
        assert np.all(run.wrist_pin.impact_count == 0)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(METHODS[method].order, abs=0.25)
    assert errors[1] < 1e-2 * abs(exact[1])


@pytest.mark.parametrize("method", METHODS)
def test_tableaus_satisfy_the_conditions_of_their_order(method):
    table = METHODS[method]
    fraction, weight = np.array(table.fraction), np.array(table.weight)
    for k in range(table.order):
        assert weight @ fraction**k == pytest.approx(1 / (k + 1), abs=1e-14)
    rows = [sum(row) for row in table.stage]
    np.testing.assert_allclose(rows, fraction, atol=1e-14)


@pytest.mark.long
def test_fixed_steps_of_three_gaps_approach_the_event_exact_motion():
    drive, gas = compressor_drive(with_rod_tangent=True), gas_towards("crank")
    gap, still = [[1e-6, 2e-6, 2e-5]], [[0.0, 0.0, 0.0]]
    parts = {"crank_joint": source_joint(), "rod_mass": 0.3 * MASS, "wall": source_joint()}
    exact = simulate(
        drive, gas, MASS, source_joint(), gap, still, revolutions=1, orders_retained=1,
        samples=1024, **parts,
    )  # fmt: skip
    run = simulate_fixed_steps(
        drive, gas, MASS, source_joint(), gap, still, method="dormand_prince", steps=8192,
        revolutions=1, orders_retained=1, **parts,
    )  # fmt: skip
    for ours, theirs in (
        (run.wrist_pin, exact.wrist_pin),
        (run.crank_pin, exact.crank_pin),
        (run.wall, exact.wall),
    ):
        error = np.abs(ours.gap[0, ::8] - theirs.gap[0])[:60]
        assert np.max(error) < 2e-3 * float(source_joint().clearance)
        assert np.max(np.abs(theirs.force[0, :60])) > 50.0
