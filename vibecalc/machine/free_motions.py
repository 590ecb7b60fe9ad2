"""Motions of a body that no mount resists, in words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vibecalc.machine.body import cross_matrix
from vibecalc.machine.frame import DIRECTIONS
from vibecalc.machine.mounts import Mounts

Array = NDArray[np.float64]
#: A stiffness below this share of the largest of its mount is the round-off of a turned zero.
STIFFNESS_TOLERANCE = 1e-13
#: Singular values of the mounts' deformations, which go with the root of a stiffness.
RANK_TOLERANCE = 1e-11


def free_motions(mounts: Mounts, kept: Sequence[int] | NDArray[np.intp] = range(6)) -> list[str]:
    """Motions in which no spring is deformed, as `moving along z` or `turning about x through ...`.

    Of `kept`, indices into x y z rx ry rz; all six if not said.

    The rows root(k_i) (e_i . displacement) of all principal directions e_i of all mounts are
    stacked; their null space is what is free. Rotations are measured at the mounts' distance.
    """
    distance = float(np.linalg.norm(mounts.position, axis=1).max()) or 1.0
    rows = []
    for place, stiffness in zip(mounts.position, mounts.stiffness, strict=True):
        values, directions = np.linalg.eigh(stiffness)
        values = np.where(values > STIFFNESS_TOLERANCE * max(values[-1], 0.0), values, 0.0)
        motion = np.hstack([np.eye(3), -cross_matrix(place) / distance])[:, kept]
        rows.append((np.sqrt(values) * directions).T @ motion)
    _, sizes, vectors = np.linalg.svd(np.vstack([*rows, np.zeros((len(kept), len(kept)))]))
    found = vectors[sizes <= RANK_TOLERANCE * max(sizes[0], np.finfo(float).tiny)]
    free = np.zeros((len(found), 6))
    free[:, kept] = found
    # Rotations first, so that elimination leaves the pure translations in the last rows.
    reduced = _row_echelon(np.hstack([free[:, 3:], free[:, :3]]))
    return [_words(row[:3] / distance, row[3:], distance) for row in reduced]


def _row_echelon(matrix: Array) -> Array:
    """Reduced row echelon form, the largest pivot of each column first."""
    rows = matrix.copy()
    done = 0
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) < 1e-9:
            continue
        rows[[done, pivot]] = rows[[pivot, done]]
        rows[done] /= rows[done, column]
        others = np.arange(len(rows)) != done
        rows[others] -= np.outer(rows[others, column], rows[done])
        done += 1
    rows[np.abs(rows) < 1e-9] = 0.0
    return rows


def _direction(vector: Array) -> str:
    unit: Array = vector / np.linalg.norm(vector)
    for name, share in zip(DIRECTIONS, np.abs(unit), strict=True):
        if share > 1.0 - 1e-9:
            return name
    return _triple(unit)


def _triple(vector: Array) -> str:
    """Three numbers in brackets, what is zero but for round-off as 0."""
    small = 1e-9 * float(np.abs(vector).max())
    return "(" + ", ".join(f"{0.0 if abs(x) <= small else x:.3g}" for x in vector) + ")"


def _words(turn: Array, shift: Array, distance: float) -> str:
    if not turn.any():
        return f"moving along {_direction(shift)}"
    # The points of the axis of a turn w with a shift v satisfy w x p = v - (its part along w).
    point = np.cross(turn, shift) / (turn @ turn)
    words = f"turning about {_direction(turn)}"
    if np.linalg.norm(point) > 1e-9 * distance:
        words += f" through {_triple(point)} m"
    return words
