"""Claim: a damped line has one frequency and one damping ratio a mode, those of its poles.

The truth: zeros of the determinant in 40 digits, eigenvalues by scipy, where the forced response
peaks, a hub with half of the ring's inertia.
"""

import mpmath
import numpy as np
import pytest
from long_but import long_but
from torsion_lines import engine, network, star

from vibecalc.torsion.damped_modes import (
    MOVES,
    NO_PEAK,
    LineModes,
    _largest_first,
    damped_line_modes,
    moves_modes,
)
from vibecalc.torsion.line import Line, chain, damping_matrix, equivalent_line, stiffness_matrix
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.poles import MANY, _clusters, all_poles, close, guesses, modal_damping_matrix


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


def swinging(line: Line) -> LineModes:
    return damped_line_modes(line, 0)


@pytest.mark.parametrize("name", long_but(LINES, *list(LINES)[::2]))
def test_poles_against_forty_digits(name: str) -> None:
    line = LINES[name]
    found = swinging(line)
    assert np.all(np.diff(found.frequency) >= 0.0)
    assert np.all(found.frequency_error <= 1e-10 * found.frequency)
    errors = found.frequency_error.tolist()
    for pole, error in list(zip(found.pole.tolist(), errors, strict=True))[::2]:
        if pole != 0.0:
            assert abs(complex(exact_pole(line, pole) - pole)) <= error
    moving = found.frequency > 0.0
    pole = found.pole[moving, None, None]
    pencil = pole**2 * np.diag(line.inertia) + pole * damping_matrix(line) + stiffness_matrix(line)
    lacking = np.abs(np.einsum("mij,mj->mi", pencil, found.shape[moving])).max(axis=1)
    assert np.all(lacking <= 1e-12 * np.abs(pencil).max(axis=(1, 2)))


def test_every_inertia_has_a_mode_and_overdamped_ones_have_no_frequency() -> None:
    light, over = swinging(LINES["light damper"]), swinging(LINES["overdamped"])
    assert len(light.frequency) == len(over.frequency) == 8
    assert np.count_nonzero(light.frequency) == 7 and np.count_nonzero(over.frequency) == 6
    assert over.damping_ratio[:2].tolist() == [0.0, 1.0] and over.frequency[1] == 0.0
    assert len(swinging(LINES["massless with and without damper"]).frequency) == 3
    # a ring in oil stays where it is: it has no frequency either
    oil = damped_line_modes(OIL, 1)
    assert oil.frequency[:2].tolist() == [0.0, 0.0] == oil.damping_ratio[:2].tolist()
    assert np.abs(oil.shape[1]).tolist() == [0.0] * 8 + [1.0]


def test_without_damping_they_are_the_natural_modes() -> None:
    found, bare = swinging(engine()), natural_modes(engine())
    away = np.abs(found.pole - 1j * bare.frequency)
    assert np.all(away <= found.frequency_error + bare.frequency_error)
    assert np.abs(found.shape - bare.shape).max() < 1e-12
    assert found.inertia[1:] == pytest.approx(bare.modal_inertia[1:], rel=1e-12)


def test_rigid_motions_are_no_poles_however_rounding_moves_them_apart() -> None:
    """Of free lines, some with a ring in oil or a brake: a pole for each mode that swings."""
    rng = np.random.default_rng(36)
    for case in range(20):
        count = int(rng.integers(2, 12))
        line = chain(10.0 ** rng.uniform(-2, 2, count), 10.0 ** rng.uniform(3, 7, count - 1))
        dashpots = 1e-5 * line.stiffness / np.sqrt(line.stiffness / line.inertia[1:])
        if case % 2:
            line = line._replace(damping=dashpots)
        if case % 3 == 0:
            line = line._replace(stiffness=np.append(line.stiffness[:-1], 0.0))
        modes = natural_modes(line).frequency
        found = np.sort(np.abs(all_poles(line).pole))
        assert np.allclose(found, modes[modes > 0.0], rtol=1e-6)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_poles_of_a_line_with_a_station_without_inertia(damping: float) -> None:
    """They are those of the two shafts as one; with dashpots those of a tiny inertia instead."""
    line = chain(np.array([2.0, 0.0, 3.0]), np.array([1e5, 2e5]))
    line = line._replace(damping=np.array([damping, 0.0]))
    found = all_poles(line).pole
    light = all_poles(line._replace(inertia=np.array([2.0, 1e-9, 3.0]))).pole
    assert found[0] == pytest.approx(light[0], rel=1e-9)
    if not damping:
        one = np.sqrt(1.0 / (1.0 / 1e5 + 1.0 / 2e5) * (1.0 / 2.0 + 1.0 / 3.0))
        assert found == pytest.approx([1j * one], rel=1e-14)


#: an engine of six throws and a flywheel with a ring in oil at its free end, the ring last
OIL = Line(
    np.array([19.0, *[21.5] * 6, 420.0, 24.0]), np.zeros(9), np.zeros(9),
    np.array([0, 1, 2, 3, 4, 5, 6, 0]), np.array([1, 2, 3, 4, 5, 6, 7, 8]),
    np.array([52e6, *[39e6] * 5, 58e6, 0.0]), np.array([0.0] * 7 + [7500.0]), np.zeros(8),
)  # fmt: skip


def test_a_mode_damped_beyond_one_over_root_two_has_no_peak() -> None:
    for ratio, silent in ((0.6, False), (0.75, True)):
        one = chain(np.ones(1), np.zeros(0))._replace(
            ground_stiffness=np.array([4.0]), absolute_damping=np.array([4.0 * ratio])
        )
        found = swinging(one)
        assert found.damping_ratio == pytest.approx([ratio], rel=1e-12)
        assert found.silent.tolist() == [silent] and (ratio > NO_PEAK) == silent
        w = np.linspace(1e-3, 4.0, 2001)
        size = 1.0 / np.abs(4.0 - w**2 + 4j * ratio * w)
        assert (np.argmax(size) == 0) == silent


def test_loss_factors_count_as_dashpots_at_each_mode() -> None:
    two = chain(np.array([2.0, 3.0]), np.array([7.0]))._replace(loss_factor=np.array([0.3]))
    # two inertias on one spring: c = eta k / w, so that the ratio is eta / 2
    found = swinging(two)
    assert found.damping_ratio == pytest.approx([0.0, 0.15], rel=1e-14)
    assert found.frequency == pytest.approx(natural_modes(two).frequency, rel=1e-14)
    loss = np.array([1.2, 0.02, 0, 0, 0, 0, 0.3])
    line = damped_engine(700.0)._replace(loss_factor=loss)
    found = swinging(line)
    for pole, error, w in zip(found.pole, found.frequency_error, found.frequency, strict=True):
        if w:
            exact = exact_pole(equivalent_line(line, abs(pole)), pole)
            assert abs(complex(exact - pole)) <= 2.0 * error
    assert np.all(found.frequency_error <= 1e-10 * found.frequency)
    assert np.all(np.diff(found.frequency) > 0.0)


def equal_branches(count: int, apart: float = 0.0) -> Line:
    """A hub with an inertia and as many branches of three, the last a ring in oil; loss factors."""
    inertia, elements = [40.0, 100.0], [(0, 1, 500.0)]
    damping, loss = [0.0], [0.02]
    for branch in range(count):
        at = len(inertia)
        inertia += [2.0, 3.0, 0.8]
        soft = 900.0 * (1.0 + apart * branch)
        elements += [(0, at, soft), (at, at + 1, 2000.0), (at + 1, at + 2, 0.0)]
        damping, loss = [*damping, 0.0, 3.0, 9.0], [*loss, 0.1, 0.0, 0.0]
    return network(inertia, elements, damping=damping)._replace(loss_factor=np.array(loss))


@pytest.mark.parametrize("count", long_but([3, 4], 3))
def test_equal_branches_keep_their_pairs_as_subspaces(count: int) -> None:
    line = equal_branches(count)
    found = damped_line_modes(line, 0)
    moving = found.frequency > 0.0
    pole, shape = found.pole[moving], found.shape[moving]
    assert np.count_nonzero(found.together) == 2 * (count - 1)
    assert found.shape_error[found.together].tolist() == [2.0] * (2 * (count - 1))
    # each branch on a hub that stands still, its loss factor as the dashpot of this frequency
    branch = network([2.0, 3.0, 0.8], [(0, 1, 2000.0), (1, 2, 0.0)], damping=[3.0, 9.0])
    for one, error in zip(found.pole[found.together], found.frequency_error[found.together],
                          strict=True):  # fmt: skip
        held = branch._replace(
            ground_stiffness=np.array([900.0, 0.0, 0.0]),
            absolute_damping=np.array([0.1 * 900.0 / abs(one), 0.0, 0.0]),
        )
        assert abs(complex(exact_pole(held, one) - one)) <= error <= 1e-13 * abs(one)
    # shapes solve the equations and are orthogonal in their slope
    dashed = equivalent_line(line, np.abs(pole))
    damping = damping_matrix(dashed)
    pencil = pole[:, None, None] ** 2 * np.diag(line.inertia) + stiffness_matrix(line)
    pencil = pencil + pole[:, None, None] * damping
    lacking = np.abs(np.einsum("mij,mj->mi", pencil, shape)).max(axis=1)
    assert np.all(lacking <= 1e-12 * np.abs(pencil).max(axis=(1, 2)))
    first = shape[found.together[moving]][: count - 1]
    slope = 2.0 * pole[found.together[moving]][0] * np.diag(line.inertia)
    slope = slope + damping[found.together[moving]][0]
    between = first @ slope @ first.T
    assert np.abs(between - np.diag(np.diag(between))).max() <= 1e-12 * np.abs(between).max()


@pytest.mark.parametrize("damping", [2000.0, 100.0])
def test_one_rule_says_which_modes_a_line_has(damping: float) -> None:
    """Poles where damping moves a frequency by half a percent, which their own sizes confirm."""
    line = network(
        [4.0, 1.2, 2.2, 52.0, 27.0],
        [(1, 0, 1.9e6), (1, 2, 2.4e6), (2, 3, 3.0e6), (3, 4, 1.5e6)],
        damping=[damping, 0.0, 0.0, 0.0],
    )
    modes, poles = natural_modes(line), damped_line_modes(line, 1)
    moved = np.abs(poles.frequency[1:] / modes.frequency[1:] - 1.0).max()
    assert moves_modes(line, modes) == (moved > MOVES)


SOLITARY = chain(np.ones(1), np.zeros(0))
PAIR = chain(np.ones(2), np.ones(1))


@pytest.mark.parametrize(
    ("line", "ratios"),
    [
        (SOLITARY._replace(absolute_damping=np.array([3.0])), [0.0]),
        (PAIR._replace(damping=np.array([50.0])), [0.0, 1.0]),
        (PAIR._replace(damping=np.array([50.0]), loss_factor=np.array([0.3])), [0.0, 1.0]),
        # stations without inertia that a damper joins: its force is known all the same
        (network([1.0, 0, 0], [(0, 1, 5.0), (1, 2, 0.0), (2, 0, 5.0)], damping=[0, 3.0, 0]), [0.0]),
    ],
)
def test_lines_of_which_nothing_vibrates(line: Line, ratios: list[float]) -> None:
    found = damped_line_modes(line, 0)
    assert found.frequency.tolist() == [0.0] * len(ratios)
    assert found.damping_ratio.tolist() == ratios


def test_close_modes_of_a_long_line_that_dashpots_couple() -> None:
    """Beyond the length that one matrix for all poles serves; here against that matrix."""
    generator = np.random.default_rng(7)
    n = MANY + 60
    line = chain(1.0 + generator.random(n), 1e6 * (1.0 + generator.random(n - 1)))
    line = line._replace(
        damping=25.0 * generator.random(n - 1), absolute_damping=0.5 + generator.random(n)
    )
    modes = natural_modes(line)
    # modes are told apart one by one, but for some few that go together
    pole, _ = guesses(line, modes)
    own = np.diag(modal_damping_matrix(line, modes))
    alone = (1j * modes.frequency - 0.5 * own)[1:]
    assert 2 <= np.count_nonzero(np.abs(pole - alone) > 1e-9) < n // 4
    found = damped_line_modes(line, 0)
    inverse = 1.0 / line.inertia[:, None]
    state = np.block([
        [np.zeros((n, n)), np.eye(n)],
        [-inverse * stiffness_matrix(line), -inverse * damping_matrix(line)],
    ])  # fmt: skip
    value = np.linalg.eigvals(state)
    value = value[value.imag > 1.0]
    value = value[np.argsort(np.abs(value))]
    assert np.allclose(found.pole[found.pole.imag > 0.0], value, rtol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_poles_are_joined_and_given_to_modes_as_by_all_pairs(seed: int) -> None:
    draw = np.random.default_rng(seed)
    weight = np.round(6.0 * draw.random((25, 25))) / 6.0
    left, expected = weight.copy(), np.full(25, -1)
    for _ in expected:
        row, column = np.unravel_index(np.argmax(left), left.shape)
        expected[row] = column
        left[row], left[:, column] = -1.0, -1.0
    assert (_largest_first(weight) == expected).all()
    about = draw.choice(draw.normal(size=(5, 2)), 25) @ [1.0, 1.0j]
    pole = about + 1e-3 * (draw.normal(size=(25, 2)) @ [1.0, 1.0j])
    error = 10.0 ** draw.uniform(-6.0, -2.0, 25)
    first = np.argmax(close(pole, error), axis=1)
    while np.any(first != first[first]):
        first = first[first]
    same = first[:, None] == first
    cluster = _clusters(pole, error)
    assert ((cluster[:, None] == cluster) == same).all()
    assert 1 < len(np.unique(cluster)) < 25
