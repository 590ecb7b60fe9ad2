"""Matrices of a damped shaft line without its rigid motion, for first guesses of its poles."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.graph import walk
from vibecalc.response.torsion.line import Line, damping_matrix, stiffness_matrix


class Matrices(NamedTuple):
    """A line of which undamped stations without inertia are condensed; r freedoms are kept.

    `inertia` (r,), `damping`, `stiffness` (r, r); elements of what is kept as `differences`
    (e + r, r) with `element_stiffness` and `element_damping` (e + r,), ground last; `free` lists
    the kept freedoms of each piece without springs to ground and whether nothing brakes it;
    `full` (n, r) gives all angles.
    """

    inertia: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    differences: FloatArray
    element_stiffness: FloatArray
    element_damping: FloatArray
    free: list[tuple[IntArray, bool]]
    full: FloatArray


def line_matrices(line: Line) -> tuple[Matrices, list[FloatArray]]:
    """The matrices, and the rigid motion (n,) of each ungrounded piece.

    Raises `NumericalFailure` for a piece without inertia.
    """
    count = len(line.inertia)
    damping, stiffness = damping_matrix(line), stiffness_matrix(line)
    still = (line.inertia == 0.0) & (np.diag(damping) == 0.0)
    kept = np.flatnonzero(~still)
    taken = np.flatnonzero(still)
    differences = np.zeros((len(line.stiffness) + count, count))
    rows = np.arange(len(line.stiffness))
    differences[rows, line.first] += 1.0
    differences[rows, line.second] -= 1.0
    differences[len(rows) :] = np.eye(count)
    free, rigid = _free_pieces(line, damping, kept)
    full = np.zeros((count, len(kept)))
    full[kept, np.arange(len(kept))] = 1.0
    if taken.size:
        inner = stiffness[np.ix_(taken, taken)]
        full[taken] = -np.linalg.solve(inner, stiffness[np.ix_(taken, kept)])
    matrices = Matrices(
        line.inertia[kept],
        damping[np.ix_(kept, kept)],
        full.T @ stiffness @ full if taken.size else stiffness,
        differences @ full,
        np.concatenate([line.stiffness, line.ground_stiffness]),
        np.concatenate([line.damping, line.absolute_damping]),
        free,
        full,
    )
    return matrices, rigid


def resting(line: Line) -> list[FloatArray]:
    """Displacements (n,) that nothing brings back, beside the rigid ones.

    Parts joined to the rest by dashpots alone can rest anywhere; one part of each ungrounded piece
    is the one that the others are counted from.
    """
    count = len(line.inertia)
    by_springs = _labels(line, line.stiffness != 0.0)
    by_both = _labels(line, (line.stiffness != 0.0) | (line.damping != 0.0))
    found = []
    for piece in sorted(set(by_both)):
        inside = [s for s in range(count) if by_both[s] == piece]
        parts = sorted({by_springs[s] for s in inside})
        free = [
            part
            for part in parts
            if not any(line.ground_stiffness[s] for s in inside if by_springs[s] == part)
        ]
        taken = 1 if len(free) == len(parts) else 0
        found += [np.array([float(one == part) for one in by_springs]) for part in free[taken:]]
    return found


def _labels(line: Line, joins: BoolArray) -> list[int]:
    """Of each freedom the first one that some elements join it to."""
    joined: dict[int, dict[int, float]] = {s: {} for s in range(len(line.inertia))}
    for a, b in zip(line.first[joins].tolist(), line.second[joins].tolist(), strict=True):
        joined[a][b] = joined[b][a] = 1.0
    label = [-1] * len(joined)
    for start in joined:
        if label[start] < 0:
            for station in walk(joined, start):
                label[station] = start
    return label


def _free_pieces(
    line: Line, damping: FloatArray, kept: IntArray
) -> tuple[list[tuple[IntArray, bool]], list[FloatArray]]:
    """Ungrounded pieces (springs and dampers both join): kept freedoms, unbraked; rigid motions."""
    joined: dict[int, dict[int, float]] = {s: {} for s in range(len(line.inertia))}
    for a, b, k, c in zip(line.first, line.second, line.stiffness, line.damping, strict=True):
        if k or c:
            joined[int(a)][int(b)] = joined[int(b)][int(a)] = 1.0
    free, rigid, left = [], [], set(joined)
    place = {int(station): index for index, station in enumerate(kept)}
    while left:
        piece = sorted(walk(joined, min(left)))
        left -= set(piece)
        if not np.any(line.inertia[piece]):
            raise NumericalFailure(
                f"the shaft line has a piece without any inertia, with station {piece[0] + 1}"
            )
        if not np.any(line.ground_stiffness[piece]):
            held = np.array([place[s] for s in piece if s in place])
            free.append((held, not np.any(line.absolute_damping[piece])))
            rigid.append(np.isin(np.arange(len(joined)), piece).astype(float))
    return free, rigid


def state_matrix(matrices: Matrices) -> FloatArray:
    """A with x' = A x: positions but those of a root per free piece, speeds of all inertias but
    the root's where momentum is zero. Raises `NumericalFailure` if massless dampers leave a
    station without a law of motion."""
    inertia, damping, stiffness = matrices.inertia, matrices.damping, matrices.stiffness
    count = len(inertia)
    heavy, light = np.flatnonzero(inertia > 0.0), np.flatnonzero(inertia == 0.0)
    positions, speeds = np.eye(count), np.eye(count)[:, heavy]
    rate = np.eye(count)
    drop_position, drop_speed = [], []
    for held, unbraked in matrices.free:
        root = held[np.argmax(inertia[held])]
        drop_position.append(root)
        rate[held, root] -= 1.0
        if unbraked:
            drop_speed.append(int(np.flatnonzero(heavy == root)[0]))
            speeds[root] = np.where(np.isin(heavy, held), -inertia[heavy] / inertia[root], 0.0)
    positions = np.delete(positions, drop_position, axis=1)
    rate = np.delete(rate, drop_position, axis=0)
    kept = np.delete(np.arange(len(heavy)), drop_speed)
    speeds = speeds[:, kept]
    pull = np.zeros((count, positions.shape[1]), dtype=stiffness.dtype)
    if light.size:
        inner = damping[np.ix_(light, light)]
        if np.linalg.cond(inner) > 0.01 / EPSILON:
            raise NumericalFailure(
                "stations without inertia are joined to each other by dampers alone: give one "
                "of them an inertia or leave it out"
            )
        pull[light] = -np.linalg.solve(inner, stiffness[light] @ positions)
        speeds[light] = -np.linalg.solve(inner, damping[np.ix_(light, heavy)] @ speeds[heavy])
    moving = heavy[kept]
    force = -(stiffness @ positions + damping @ pull)[moving] / inertia[moving, None]
    brake = -(damping @ speeds)[moving] / inertia[moving, None]
    matrix: FloatArray = np.block([[rate @ pull, rate @ speeds], [force, brake]])
    return matrix


def work_terms(
    matrices: Matrices, pole: complex, shape: ComplexArray
) -> tuple[complex, complex, float]:
    """v'P(s)v, its derivative by s, and its rounding, from twists and not from sums of forces."""
    twist = matrices.differences @ shape
    square, kinetic = twist**2, shape**2 * matrices.inertia
    elastic = matrices.element_stiffness + pole * matrices.element_damping
    work = pole**2 * kinetic.sum() + elastic @ square
    slope = 2.0 * pole * kinetic.sum() + matrices.element_damping @ square
    size = abs(pole) ** 2 * np.abs(kinetic).sum()
    # two damping ratios may ask for a negative damping of the inertias
    whole = np.abs(matrices.element_stiffness) + abs(pole) * np.abs(matrices.element_damping)
    size += whole @ np.abs(square)
    # a twist is the difference of two angles, each right to a rounding
    coarse = np.abs(matrices.differences) @ np.abs(shape)
    size += 0.5 * whole @ (np.abs(twist) * coarse)
    return complex(work), complex(slope), float(8.0 * EPSILON * size)
