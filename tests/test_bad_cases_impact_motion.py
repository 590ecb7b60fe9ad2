"""Claim: what cannot be followed is refused in words, and nothing sticks or returns nonsense."""

import numpy as np
import pytest
from impact_machines import (
    CLEARANCE,
    DAMPING,
    MASS,
    STIFFNESS,
    compressor_drive,
    gas_towards,
    near,
    source_joint,
)

from vibecalc.errors import NumericalFailure
from vibecalc.impact import simulate as sweep
from vibecalc.impact.fixed_step import simulate_fixed_steps
from vibecalc.impact.linkage import Drive, GasForce, Joint
from vibecalc.impact.simulate import simulate


def run(joint=None, drive=None, gas=None, gap=None, velocity=None, revolutions=1, **parts):
    start = near(2) if gap is None else gap
    return simulate(
        drive or compressor_drive(),
        gas or gas_towards("crank"),
        MASS,
        joint or source_joint(),
        start,
        np.zeros(np.shape(start)) if velocity is None else velocity,
        revolutions=revolutions,
        orders_retained=3,
        **parts,
    )


STILL = Drive(12.0, np.array([0]), np.array([0.0 + 0j]))


def constant(force):
    return GasForce(np.array([0.0, np.pi]), np.array([force, force]))


def test_a_contact_too_short_is_refused():
    with pytest.raises(NumericalFailure, match=r"less than 1e-9 of a revolution.*stiffness"):
        run(source_joint(stiffness=1e14 * STIFFNESS))


@pytest.mark.parametrize("where", ["contact_damping", "film_damping"])
def test_damping_too_strong_is_refused(where):
    with pytest.raises(NumericalFailure, match="too fast to be followed"):
        run(source_joint(**{where: 1e9 * DAMPING}))


@pytest.mark.long
def test_strong_damping_below_the_limit_is_followed():
    done = run(source_joint(contact_damping=1e3 * DAMPING, film_damping=1e2 * DAMPING))
    assert np.all(done.axial.relative_error < 1e-12)


def test_a_mass_at_rest_on_a_jump_sticks():
    # the force pushes it out of the gap, the spring's jump back into it: neither side can be
    joint = Joint(1e-3, 1e5, 6.0, 0.4, "full_deflection")
    with pytest.raises(NumericalFailure, match=r"sticks at the face.*continuous law"):
        run(joint, STILL, constant(-0.5), gap=[1e-3])
    # the continuous law has no such trouble
    done = run(joint._replace(law="continuous"), STILL, constant(-0.5), gap=[1e-3])
    assert done.wrist_pin.impact_count[0, 0] >= 1


@pytest.mark.long
def test_bounces_that_follow_each_other_ever_faster_are_stopped(monkeypatch):
    # damping in the gap takes the energy of every bounce on the jump
    joint = Joint(1e-3, 1e5, 6.0, 60.0, "full_deflection")
    monkeypatch.setattr(sweep, "MOST_STEPS", 300)
    with pytest.raises(NumericalFailure, match=r"run 0 (needs more than 300 steps|sticks)"):
        run(joint, STILL, constant(-0.5), gap=[0.9e-3], revolutions=160)


def test_starts_on_a_face_at_rest_and_outside_are_followed():
    joint = Joint(np.full(5, 1e-3), 1e5, 1.0, 0.1)
    gap = [0.0, 1e-3, -2e-5, 1.02e-3, 0.0]
    velocity = [0.0, 0.0, 0.0, 0.0, -0.01]
    done = run(joint, STILL, constant(0.5), gap=gap, velocity=velocity)
    assert np.all(done.axial.relative_error < 1e-12)
    # pulled by -0.5 N: the first and the last touch the lower face at once, the second falls
    assert np.all(done.wrist_pin.first_contacts[[0, 4], 0] == 0.0)
    assert done.wrist_pin.first_contacts[1, 0] > 0.01


def test_a_drive_with_orders_too_high_is_refused():
    shaken = Drive(3.0, np.array([40000]), np.array([1e-6 + 0j]))
    with pytest.raises(NumericalFailure, match="one revolution would need"):
        run(drive=shaken)


def test_fixed_steps_that_run_away_are_refused():
    with pytest.raises(NumericalFailure, match="euler with 64 steps per revolution is unstable"):
        simulate_fixed_steps(
            compressor_drive(), gas_towards("crank"), MASS, source_joint(clearance=CLEARANCE / 100),
            near(2), np.zeros(2), method="euler", steps=64, revolutions=30, orders_retained=3,
        )  # fmt: skip
