"""Claim: Ong (2000, chapter 5) prints average impact forces of 21.11 lb for a clearance of 1.5e-3
in and 3.16 lb for 1e-4 in, and both are members of the ensemble that his options give; the third,
546.26 lb for 1e-2 in, is not.

His options: a spring that acts with the whole deflection, the damper always on, gas pressure with
the printed sense (towards the head), 1024 fixed steps per revolution, one revolution of samples
from .15 s on. His solver is shown in a lost figure; a Runge-Kutta method of order 4 and that of
Dormand and Prince are tried. Runs that start 1e-8 m apart have nothing to do with each other by
then, so one published run can only be compared with the distribution of many.
"""

import numpy as np
import pytest
from impact_machines import INCH, POUND_FORCE, near, source_joint, source_linkage, states

from vibecalc.impact.fixed_step import one_sided, simulate_fixed_steps
from vibecalc.impact.simulate import simulate

MEMBERS = 30


def average(force_harmonics: np.ndarray) -> np.ndarray:
    """His average, lb: the mean over 512 bins of 2 |FFT| / 1024, which doubles the mean force."""
    size = np.abs(force_harmonics[..., :512])
    return (size.sum(axis=-1) + size[..., 0]) / 512 / POUND_FORCE


def ensemble(clearance, law="full_deflection", sense="head", method="rk4"):
    """Averages of the revolutions that end after .08 s, of 30 runs."""
    linkage = source_linkage(sense, source_joint(law, clearance=clearance * INCH))
    start = states(near(MEMBERS) * clearance / 1.5e-3)
    run, _ = simulate_fixed_steps(linkage, start, method, 1024, 8, 511)
    return average(run.harmonics[0, :, 4:])


@pytest.mark.long
@pytest.mark.parametrize("method", ["rk4", "dormand_prince"])
@pytest.mark.parametrize(("clearance", "printed"), [(1.5e-3, 21.11), (1e-4, 3.16)])
def test_published_averages_are_members_of_the_ensemble(clearance, printed, method):
    values = ensemble(clearance, method=method)
    low, high = np.quantile(values, [0.01, 0.99])
    # the claim can fail: nearly all runs lie within a factor of two of each other
    assert high < 2.0 * low
    assert low < printed < high


@pytest.mark.long
@pytest.mark.parametrize("sense", ["head", "crank"])
def test_the_continuous_spring_does_not_give_the_published_averages(sense):
    assert np.max(ensemble(1.5e-3, "continuous", sense)) < 0.5 * 21.11


@pytest.mark.long
@pytest.mark.parametrize("law", ["full_deflection", "continuous"])
@pytest.mark.parametrize("sense", ["head", "crank"])
def test_third_published_average_is_out_of_reach(law, sense):
    values = ensemble(1e-2, law, sense)
    assert np.max(values) < 0.5 * 546.26
    assert np.median(values) < 0.3 * 546.26


@pytest.mark.long
def test_event_exact_runs_are_near_the_published_average():
    linkage = source_linkage("head", source_joint("full_deflection"))
    run = simulate(linkage, states(near(12)), 4, 8, 1024)
    values = average(one_sided(run.force[0]))
    # another integrator, without its errors in the contacts, has its median within two fifths
    assert 0.6 * 21.11 < np.median(values) < 1.4 * 21.11
