"""Claim: every mode of hard rows and trees is right to 1e-13, by two ways and in 40 digits."""

import numpy as np
import pytest
from long_but import long_but
from torsion_lines import HARD, assert_every_mode, hard_chain, network, star

from vibecalc.torsion.line import Line, lines_of, stiffness_matrix
from vibecalc.torsion.modes import Modes, natural_modes
from vibecalc.torsion.modes_of_tree import holzer_table, riccati_frequencies


def assert_sound(line: Line, found: Modes, orthogonality: float) -> None:
    """Scale, energies and orthogonality of the shapes, and rigid modes exactly zero."""
    assert np.all(np.abs(found.shape).max(axis=1) == 1.0)
    assert np.all(found.shape.max(axis=1) > 1.0 - 2e-3)
    rigid = found.frequency == 0.0
    assert np.all(found.frequency_error <= 1e-13 * found.frequency)
    assert np.all(np.diff(found.frequency) >= 0.0)
    weighted = found.shape * np.sqrt(line.inertia / found.modal_inertia[:, None])
    assert np.abs(weighted @ weighted.T - np.eye(len(rigid))).max() < orthogonality
    twist = found.shape[:, line.first] - found.shape[:, line.second]
    strain = twist**2 @ line.stiffness + found.shape**2 @ line.ground_stiffness
    kinetic = found.frequency**2 * found.modal_inertia
    # the energy is second order in what shapes are off
    assert np.all(np.abs(strain - kinetic) <= 1e-11 * kinetic)


@pytest.mark.parametrize("count", long_but([50, 100, 200], 100))
@pytest.mark.parametrize("name", HARD)
def test_hard_rows_agree_with_the_transfer_matrix(name: str, count: int) -> None:
    if count == 100 and name not in ("weak_link", "graded"):
        count = 24  # short rows take LAPACK's QR for the shapes
    line = hard_chain(name, count)
    found = natural_modes(line)
    assert_sound(line, found, 1e-8)
    rigid = {"held": 0, "two_pieces": 2}.get(name, 1)
    assert np.count_nonzero(found.frequency == 0.0) == rigid
    if count < 200 or name == "alternating":
        other = riccati_frequencies(line)
        assert np.all(np.abs(other - found.frequency) <= found.frequency_error)


@pytest.mark.parametrize(
    "name", long_but([name for name in HARD if name != "two_pieces"], "graded", "held")
)
def test_every_mode_of_a_hard_row_against_forty_digits(name: str) -> None:
    line = hard_chain(name, 50)
    found = natural_modes(line)
    assert_every_mode(line, found.frequency, found.frequency_error)


TREES = {
    "equal branches": star(3, 4, 0.0),
    "nearly equal branches": star(4, 3, 1e-13),
    "massless junction": network(
        [1, 2, 0, 3, 1e6, 4, 5, 1],
        [(0, 1, 1e6), (1, 2, 1.0), (2, 3, 5.0), (2, 4, 2.0), (4, 5, 1e-6), (5, 6, 1e6), (3, 7, 3)],
    ),
    "held massless leaf": network(
        [2.0, 1.0, 1.0, 0.0], [(0, 1, 3.0), (0, 2, 1e5), (0, 3, 7.0)], [0.0, 0.0, 1e-4, 2.0]
    ),
}


@pytest.mark.parametrize("name", TREES)
def test_trees(name: str) -> None:
    line = TREES[name]
    found = natural_modes(line)
    assert len(found.frequency) == np.count_nonzero(line.inertia)
    assert_sound(line, found, 1e-11)
    assert_every_mode(line, found.frequency, found.frequency_error)
    assert np.allclose(riccati_frequencies(line), found.frequency, rtol=1e-14, atol=0.0)
    lacking = found.shape @ stiffness_matrix(line)
    lacking -= found.frequency[:, None] ** 2 * found.shape * line.inertia
    assert np.abs(lacking).max() < 1e-14 * np.abs(stiffness_matrix(line)).max()


def test_the_shape_error_bounds_what_a_last_digit_of_the_data_does() -> None:
    line = hard_chain("weak_link", 60)
    found = natural_modes(line)
    away = np.random.default_rng(5).choice([-1.0, 1.0], 60) * 2.0**-52
    other = natural_modes(line._replace(inertia=line.inertia * (1.0 + away)))
    moved = np.abs(other.shape - found.shape).max(axis=1)
    assert np.all(moved <= 2.0 * found.shape_error)
    assert np.max(moved[1:] / found.shape_error[1:]) > 1e-3


def test_a_holzer_table_goes_by_branches() -> None:
    """Two branches on a row, one with a branch of its own: rows in order, torques in balance."""
    ends = [(0, 1), (1, 2), (2, 3), (3, 4), (2, 5), (5, 6), (5, 7), (7, 8), (3, 9)]
    inertia = [1.0, 0.0, 3.0, 2.0, 9.0, 0.7, 0.3, 1.1, 0.4, 2.2]
    ground = [0.0] * 7 + [40.0] + [0.0] * 2
    line = network(inertia, [(a, b, 90.0 + 7 * i) for i, (a, b) in enumerate(ends)], ground)
    found = natural_modes(line)
    table = holzer_table(line, found.frequency)
    rows = table.rows
    assert rows.freedom[0] == 0 and sorted(rows.freedom) == list(range(10))
    joined = {frozenset((rows.freedom[i], rows.freedom[b])) for i, b in enumerate(rows.below[:-1])}
    assert joined == {frozenset(pair) for pair in ends}
    assert np.all(rows.below[:-1] > np.arange(9)) and rows.below[-1] == -1
    shape = found.shape[:, rows.freedom]
    assert table.angle == pytest.approx(shape / shape[:, :1], rel=1e-9, abs=1e-9)
    torque = found.frequency[:, None] ** 2 * line.inertia[rows.freedom] * table.angle
    assert np.all(np.abs(table.sum_torque[:, -1]) <= 1e-9 * np.abs(torque).max(axis=1))
    # a line that is another one at each frequency, as with couplings
    softer = line.stiffness * np.linspace(1.0, 0.8, len(found.frequency))[:, None]
    own = line._replace(stiffness=softer, loss_factor=np.zeros_like(softer))
    every = holzer_table(own, found.frequency).sum_torque
    for one, at, torques in zip(lines_of(own), found.frequency, every, strict=True):
        assert holzer_table(one, at).sum_torque.tolist() == torques.tolist()
    between = holzer_table(line, np.array(7.7))
    angle = np.empty(10)
    angle[rows.freedom] = between.angle
    drive = stiffness_matrix(line) @ angle - 7.7**2 * line.inertia * angle
    last = rows.freedom[-1]
    assert drive[last] == pytest.approx(-between.sum_torque[-1], rel=1e-10)
    assert np.allclose(np.delete(drive, last), 0.0, atol=1e-11 * np.abs(between.sum_torque).max())
