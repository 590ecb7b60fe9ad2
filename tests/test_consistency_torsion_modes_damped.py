"""Claim: damped poles solve their pencil in 40 digits, and none is lost."""

import mpmath
import numpy as np
import pytest
from torsion_lines import engine, network, star

from vibecalc.errors import NumericalFailure
from vibecalc.response.torsion.damped_equivalent import equivalent_line, equivalent_modes
from vibecalc.response.torsion.damped_modes import DampedModes, damped_modes
from vibecalc.response.torsion.line import Line, chain, damping_matrix, stiffness_matrix
from vibecalc.response.torsion.modes import natural_modes


def damped_engine(coefficient: float) -> Line:
    line = engine(damper=True)
    damping = np.zeros(7)
    damping[0] = coefficient
    return line._replace(damping=damping)


LINES = {
    "light damper": damped_engine(700.0),
    "overdamped": damped_engine(1e5),
    "locked": damped_engine(1e9),
    "braked, no spring to ground": engine()._replace(absolute_damping=np.array([0.0] * 6 + [5e4])),
    "held": engine()._replace(
        ground_stiffness=np.array([0.0, 1e5, 0, 0, 0, 0, 0]),
        absolute_damping=np.array([300.0, 0, 0, 0, 0, 0, 0]),
    ),
    "massless with and without damper": network(
        [1.0, 0.0, 2.0, 0.0, 1.0],
        [(0, 1, 50.0), (1, 2, 80.0), (2, 3, 9.0), (3, 4, 30.0)],
        damping=[0.0, 0.0, 4.0, 0.0],
    ),
    "branches": star(3, 2, 0.01)._replace(damping=np.array([0.5, 0, 0, 0.2, 0, 0.1])),
}


def exact_pole(line: Line, near: complex) -> mpmath.mpc:
    """The zero of det(s^2 J + s C + K) by the secant method, in 40 digits."""
    with mpmath.workdps(40):
        stiffness, damping = (mpmath.matrix(m.tolist()) for m in _matrices(line))
        inertia = mpmath.diag(line.inertia.tolist())

        def determinant(s: mpmath.mpc) -> mpmath.mpc:
            return mpmath.det(s**2 * inertia + s * damping + stiffness)

        start = mpmath.mpc(near)
        return mpmath.findroot(
            determinant, (start * (1 + mpmath.mpf("1e-9")), start), solver="secant",
            tol=1e-200, maxsteps=12, verify=False,
        )  # fmt: skip


def _matrices(line: Line) -> tuple[np.ndarray, np.ndarray]:
    # sums of two powers apart by less than 2^53 are exact here but for the locked damper
    return stiffness_matrix(line), damping_matrix(line)


def all_poles(found: DampedModes) -> int:
    """Poles counted with their mirror images."""
    return int(np.sum(np.where(found.pole.imag > 0.0, 2, 1)))


@pytest.mark.parametrize("name", LINES)
def test_poles_against_forty_digits(name: str) -> None:
    line = LINES[name]
    found = damped_modes(line)
    assert np.all(np.diff(found.frequency) >= 0.0)
    assert np.all(found.pole_error <= 1e-10 * found.frequency)
    for pole, error in zip(found.pole[::2].tolist(), found.pole_error[::2].tolist(), strict=True):
        if pole != 0.0:
            assert abs(complex(exact_pole(line, pole) - pole)) <= error
    pencil = np.einsum("m,i,ij->mij", found.pole**2, line.inertia, np.eye(len(line.inertia)))
    pencil = pencil + found.pole[:, None, None] * damping_matrix(line) + stiffness_matrix(line)
    lacking = np.abs(np.einsum("mij,mj->mi", pencil, found.shape)).max(axis=1)
    assert np.all(lacking <= 1e-13 * np.abs(pencil).max(axis=(1, 2)))


def test_none_is_lost() -> None:
    assert all_poles(damped_modes(LINES["overdamped"])) == 15
    assert all_poles(damped_modes(LINES["braked, no spring to ground"])) == 14
    assert all_poles(damped_modes(LINES["held"])) == 14
    # three inertias, a damped massless station, one momentum taken as rigid
    assert all_poles(damped_modes(LINES["massless with and without damper"])) == 6
    assert np.count_nonzero(damped_modes(LINES["overdamped"]).pole.imag == 0.0) == 3
    real = damped_modes(LINES["overdamped"]).pole.imag == 0.0
    assert np.array_equal(damped_modes(LINES["overdamped"]).damping_ratio[real], [0.0, 1.0, 1.0])


def test_without_damping_they_are_the_natural_modes() -> None:
    found, bare = damped_modes(engine()), natural_modes(engine())
    away = np.abs(found.pole - 1j * bare.frequency)
    assert np.all(away <= found.pole_error + bare.frequency_error)


def test_a_locked_damper_turns_with_the_crank() -> None:
    line = chain(
        np.array([27.5126 + 18.64] + [18.64] * 5 + [2655.0]),
        np.array([22.82e6] * 5 + [19.21e6]),
    )
    swinging = damped_modes(LINES["locked"])
    swinging_frequency = swinging.frequency[swinging.pole.imag > 0.0]
    assert np.allclose(swinging_frequency, natural_modes(line).frequency[1:], rtol=1e-8)


def test_a_critically_damped_pole_is_known_to_half_its_digits_only() -> None:
    line = chain(np.ones(1), np.zeros(0))
    line = line._replace(ground_stiffness=np.array([4.0]), absolute_damping=np.array([4.0]))
    found = damped_modes(line)
    assert np.all(np.abs(found.pole + 2.0) <= found.pole_error)
    assert np.all(found.pole_error < 1e-6)


def test_loss_factors_count_as_dashpots_at_each_mode() -> None:
    two = chain(np.array([2.0, 3.0]), np.array([7.0]))._replace(loss_factor=np.array([0.3]))
    # two inertias on one spring: c = eta k / w, so that the ratio is eta / 2
    found = equivalent_modes(two, natural_modes(two))
    assert found.damping_ratio == pytest.approx([0.0, 0.15], rel=1e-14)
    assert found.frequency == pytest.approx(natural_modes(two).frequency, rel=1e-14)
    loss = np.array([1.2, 0.02, 0, 0, 0, 0, 0.3])
    line = damped_engine(700.0)._replace(loss_factor=loss)
    bare = natural_modes(line)
    found = equivalent_modes(line, bare)
    for pole, error, w in zip(found.pole, found.pole_error, bare.frequency, strict=True):
        if w:
            assert abs(complex(exact_pole(equivalent_line(line, w), pole) - pole)) <= error
    assert np.all(found.pole_error <= 1e-10 * found.frequency)
    assert np.all(np.diff(found.frequency) > 0.0)
    # far beyond what a spring can lose, the ring does not swing any more
    with pytest.raises(NumericalFailure, match="so strongly"):
        equivalent_modes(line._replace(loss_factor=20.0 * loss), bare)
