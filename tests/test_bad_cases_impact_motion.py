"""Claim: what cannot be followed is refused in words, and nothing sticks or returns nonsense."""

import numpy as np
import pytest
from impact_machines import CLEARANCE, DAMPING, near, source_joint, source_linkage, states

from vibecalc.errors import NumericalFailure
from vibecalc.impact import simulate as sweep
from vibecalc.impact.fixed_step import simulate_fixed_steps
from vibecalc.impact.linkage import Drive, GasForce, Joint
from vibecalc.impact.simulate import simulate


def run(joint=None, gap=None, velocity=0.0, revolutions=1, **parts):
    start = near(2) if gap is None else gap
    return simulate(source_linkage(joint=joint, **parts), states(start, velocity), revolutions, 3)


STILL = Drive(12.0, np.array([0]), np.array([0.0 + 0j]))


def constant(force):
    return GasForce(np.array([0.0, np.pi]), np.array([force, force]))


@pytest.mark.long
def test_strong_damping_below_the_limit_is_followed():
    done = run(source_joint(contact_damping=1e3 * DAMPING, film_damping=1e2 * DAMPING))
    assert np.all(done.imbalance < 1e-12)


def test_a_mass_at_rest_on_a_jump_sticks():
    # the force pushes it out of the gap, the spring's jump back into it: neither side can be
    joint = Joint(1e-3, 1e5, 6.0, 0.4, "full_deflection")
    with pytest.raises(NumericalFailure, match=r"sticks at the face.*continuous law"):
        run(joint, drive=STILL, gas=constant(-0.5), gap=[1e-3])
    # the continuous law has no such trouble
    done = run(joint._replace(law="continuous"), drive=STILL, gas=constant(-0.5), gap=[1e-3])
    assert done.forces.contacts[0, 0, 0] >= 1


@pytest.mark.long
def test_bounces_that_follow_each_other_ever_faster_are_stopped(monkeypatch):
    # damping in the gap takes the energy of every bounce on the jump
    joint = Joint(1e-3, 1e5, 6.0, 60.0, "full_deflection")
    monkeypatch.setattr(sweep, "MOST_STEPS", 300)
    with pytest.raises(NumericalFailure, match=r"run 0 (needs more than 300 steps|sticks)"):
        run(joint, drive=STILL, gas=constant(-0.5), gap=[0.9e-3], revolutions=160)


def test_starts_on_a_face_at_rest_and_outside_are_followed():
    joint = Joint(np.full(5, 1e-3), 1e5, 1.0, 0.1)
    gap = [0.0, 1e-3, -2e-5, 1.02e-3, 0.0]
    velocity = [0.0, 0.0, 0.0, 0.0, -0.01]
    done = run(joint, drive=STILL, gas=constant(0.5), gap=gap, velocity=velocity)
    assert np.all(done.imbalance < 1e-12)
    # pulled by -0.5 N: the first and the last touch the lower face at once, the second falls
    assert np.all(done.first_contacts[0, [0, 4], 0] == 0.0)
    assert done.first_contacts[0, 1, 0] > 0.01


def test_a_drive_with_orders_too_high_is_refused():
    shaken = Drive(3.0, np.array([40000]), np.array([1e-6 + 0j]))
    with pytest.raises(NumericalFailure, match="one revolution would need"):
        run(drive=shaken)


def test_fixed_steps_that_run_away_are_refused():
    linkage = source_linkage(joint=source_joint(clearance=CLEARANCE / 100))
    with pytest.raises(NumericalFailure, match="euler with 64 steps per revolution is unstable"):
        simulate_fixed_steps(linkage, states(near(2)), "euler", 64, 30, 3)
