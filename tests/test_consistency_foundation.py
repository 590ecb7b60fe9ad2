"""Claim: machine and foundation move as their matrices say, and as a rigid ground in the limit."""

import copy
from typing import NamedTuple

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.foundation.systems import on_second_mass
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.linear import response
from vibecalc.parts.body import RigidBody
from vibecalc.parts.mounts import Mounts

ORDERS = np.arange(1.0, 9.0)


class Two(NamedTuple):
    """Mass, stiffness, damping and structural stiffness of machine and mounts, of foundation."""

    machine: tuple[float, float, float, float]
    below: tuple[float, float, float, float]

    def systems(self) -> tuple[OnMounts, OnMounts]:
        mass, *mounts = self.machine
        matrix = mass * np.eye(6)
        body = RigidBody(mass=mass, centre=np.zeros(3), mass_matrix=matrix, inertia=matrix[3:, 3:])
        each = (np.array([0.5 * one * np.eye(3)] * 2) for one in mounts)
        names = dict(zip(("stiffness", "damping", "structural"), each, strict=True))
        pair = Mounts(names=("1", "2"), position=np.zeros((2, 3)), **names)
        return on_second_mass(body, pair, 2, self.below[0], self.below[1:])

    def matrices(self, w: float) -> tuple[np.ndarray, np.ndarray]:
        k1, k2 = (k + 1j * (h + w * c) for _, k, c, h in self)
        return np.array([[k1, -k1], [-k1, k1 + k2]]), np.diag([self.machine[0], self.below[0]])


def system(seed: int) -> Two:
    random = np.random.default_rng([seed, 41])
    m1, m2 = 10.0 ** random.uniform(1.0, 4.0, 2)
    k1, k2 = 10.0 ** random.uniform(4.0, 8.0, 2)
    return Two(
        (m1, k1, 10.0 ** random.uniform(0.0, 3.0), random.uniform(0.0, 0.2) * k1),
        (m2, k2, 10.0 ** random.uniform(0.0, 3.0), random.uniform(0.0, 0.2) * k2),
    )


def moved(one: OnMounts, force: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Motion (m, f) and force on the ground (m,) under forces (m,) on the machine."""
    load = force[:, None] * np.eye(len(one.freedoms))[0]
    motion = response(one.dynamics(w), load, 0.0 * np.abs(load))
    return motion.value, one.ground_load(motion, w).value[:, 0]


@pytest.mark.parametrize("seed", range(40))
def test_motion_is_that_of_the_matrices_and_the_ground_gets_the_rest(seed: int) -> None:
    one = system(seed)
    w = 7.0 * ORDERS
    force = np.exp(1j * ORDERS) * 100.0 / ORDERS
    motion, ground = moved(one.systems()[0], force, w)
    for i, frequency in enumerate(w):
        stiffness, mass = one.matrices(frequency)
        dynamic = stiffness - frequency**2 * mass
        u, v = np.linalg.solve(dynamic, [force[i], 0.0])
        scale = max(np.linalg.cond(dynamic) * 1e-14, 1e-12)
        assert motion[i] == pytest.approx([u, v], rel=scale)
        assert ground[i] == pytest.approx(stiffness.sum() * v, rel=scale)
    # what the force does not give to the masses, the ground gets
    inertia = w**2 * (motion @ [one.machine[0], one.below[0]])
    assert np.all(np.abs(force + inertia - ground) < 1e-9 * (np.abs(force) + np.abs(ground)))


@pytest.mark.parametrize("seed", range(20))
def test_natural_frequencies_are_the_eigenvalues(seed: int) -> None:
    one = system(seed)
    stiffness, mass = one.matrices(0.0)
    values = np.linalg.eigvals(np.linalg.solve(mass, stiffness.real))
    found = one.systems()[0].shapes.natural_frequency
    assert found**2 == pytest.approx(np.sort(values.real), rel=1e-8)


@pytest.mark.parametrize("place", [0, 1])
def test_a_stiff_or_heavy_foundation_is_a_rigid_one(place: int) -> None:
    one = system(3)
    below = [*one.below]
    below[place] = 1e16
    both, alone = one._replace(below=tuple(below)).systems()
    force, w = np.full(8, 10.0 + 0j), 7.0 * ORDERS
    k1 = np.array([one.matrices(rate)[0][0, 0] for rate in w])
    passed = moved(both, force, w)[0][:, 0] * k1
    assert passed == pytest.approx(moved(alone, force, w)[1], rel=1e-9)


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
    (loaded,) = load_checked([CASES["generator_on_floor"]])
    table = copy.deepcopy(dict(loaded.resolved))
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    table["foundation"]["loss_factor"] = 0.0
    lower = float(run_case(validate(table))["foundation/natural_frequency"].values[0])
    # pistons have no force of order 3
    for order, driven in ((2, True), (3, False)):
        table["machine"]["speed"] = lower / order
        if driven:
            with pytest.raises(NumericalFailure, match=f"order 2 .*of mode 1, {lower:.9g}"):
                run_case(validate(table))
        else:
            assert run_case(validate(table))["foundation/ground_force"].values[2] == 0.0
