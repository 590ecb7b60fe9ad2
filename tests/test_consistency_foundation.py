"""Claim: machine and foundation move as their matrices say, and as a rigid ground in the limit."""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.foundation.two_masses import TwoMasses, motion, natural_frequencies

ORDERS = np.arange(1.0, 9.0)


def system(seed: int) -> TwoMasses:
    random = np.random.default_rng([seed, 41])
    m1, m2 = 10.0 ** random.uniform(1.0, 4.0, 2)
    k1, k2 = 10.0 ** random.uniform(4.0, 8.0, 2)
    return TwoMasses(
        *(np.asarray(value) for value in (
            m1, k1, 10.0 ** random.uniform(0.0, 3.0), random.uniform(0.0, 0.2) * k1,
            m2, k2, 10.0 ** random.uniform(0.0, 3.0), random.uniform(0.0, 0.2) * k2,
        ))
    )  # fmt: skip


def matrices(one: TwoMasses, w: float) -> tuple[np.ndarray, np.ndarray]:
    k1 = one.mount_stiffness + 1j * (one.mount_structural + w * one.mount_damping)
    k2 = one.stiffness + 1j * (one.structural + w * one.damping)
    return np.array([[k1, -k1], [-k1, k1 + k2]]), np.diag([one.machine_mass, one.foundation_mass])


@pytest.mark.parametrize("seed", range(40))
def test_motion_is_that_of_the_matrices_and_within_its_error(seed: int) -> None:
    one = system(seed)
    w = 7.0 * ORDERS
    force = np.exp(1j * ORDERS) * 100.0 / ORDERS
    found = motion(one, force, np.zeros(8), w)
    for i, frequency in enumerate(w):
        stiffness, mass = matrices(one, frequency)
        u, v = np.linalg.solve(stiffness - frequency**2 * mass, [force[i], 0.0])
        scale = np.linalg.cond(stiffness - frequency**2 * mass) * 1e-14
        assert found.machine.value[i] == pytest.approx(u, rel=max(scale, 1e-12))
        assert found.foundation.value[i] == pytest.approx(v, rel=max(scale, 1e-12))
        below = stiffness[0, 0] + stiffness[0, 1] + stiffness[1, 0] + stiffness[1, 1]
        assert found.ground_force.value[i] == pytest.approx(below * v, rel=max(scale, 1e-12))
    # what the force does not give to the masses, the ground gets
    inertia = w**2 * (
        one.machine_mass * found.machine.value + one.foundation_mass * found.foundation.value
    )
    terms = np.abs(force) + np.abs(found.ground_force.value)
    assert np.all(np.abs(force + inertia - found.ground_force.value) < 1e-9 * terms)


@pytest.mark.parametrize("seed", range(20))
def test_natural_frequencies_are_the_eigenvalues(seed: int) -> None:
    one = system(seed)
    stiffness, mass = matrices(one, 0.0)
    values = np.linalg.eigvals(np.linalg.solve(mass, stiffness.real - 0.0))
    found = natural_frequencies(one)
    assert np.sort(found**2) == pytest.approx(np.sort(values.real), rel=1e-8)


def test_a_stiff_or_heavy_foundation_is_a_rigid_one() -> None:
    for change in ({"stiffness": np.asarray(1e16)}, {"foundation_mass": np.asarray(1e16)}):
        one = system(3)._replace(**change)
        found = motion(one, np.full(8, 10.0 + 0j), np.zeros(8), 7.0 * ORDERS)
        passed = found.machine.value * (
            one.mount_stiffness + 1j * (one.mount_structural + 7.0 * ORDERS * one.mount_damping)
        )
        assert passed == pytest.approx(found.rigid_force.value, rel=1e-9)


def test_the_case_agrees_with_its_isolation_on_a_rigid_ground() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    record = run_case(loaded.case)
    force = record["foundation/rigid_force"].values
    # the couples of this machine lift nothing: all mounts together pass the same force
    mounts = record["isolation/support_force/steady_harmonics"].values
    assert mounts[:, 2].sum(axis=0) == pytest.approx(force, rel=1e-9, abs=1e-9)
    assert record["foundation/rigid_force_peak"].values <= np.abs(force).sum() * (1.0 + 1e-9)
    hertz = record["foundation/natural_frequency"].values / (2.0 * np.pi)
    assert 9.0 < hertz[0] < 15.0 < hertz[1]


def test_what_it_needs_is_said() -> None:
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    table = dict(loaded.resolved)
    del table["isolation"]
    with pytest.raises(CaseError, match=r"\[foundation\] needs \[isolation\]"):
        validate({key: table[key] for key in table if key != "limit"})
    plate = {"schema": 1, "title": "without a speed", "machine": {"kind": "plate"}}
    with pytest.raises(CaseError, match=r"\[foundation\] needs \[isolation\]"):
        load_checked([{**plate, "foundation": {"mass": 1.0, "stiffness": 1e7}}])
    table = {**loaded.resolved, "foundation": {"mass": -1.0, "stiffness": 1e7}}
    with pytest.raises(CaseError, match="mass"):
        validate(table)


def test_an_undamped_resonance_is_refused_and_an_undriven_one_is_nothing() -> None:
    zero = np.asarray(0.0)
    free = system(5)._replace(
        mount_damping=zero, mount_structural=zero, damping=zero, structural=zero
    )
    lower = natural_frequencies(free)[:1]
    with pytest.raises(NumericalFailure, match=f"natural frequency, {lower[0]:.6g} rad/s"):
        motion(free, np.ones(1, dtype=complex), np.zeros(1), lower)
    still = motion(free, np.zeros(1, dtype=complex), np.zeros(1), lower)
    assert still.ground_force.value == still.ground_force.error == 0.0
    alone = np.sqrt(free.mount_stiffness / free.machine_mass)[None]
    with pytest.raises(NumericalFailure, match="rigid foundation"):
        motion(free, np.ones(1, dtype=complex), np.zeros(1), alone)
