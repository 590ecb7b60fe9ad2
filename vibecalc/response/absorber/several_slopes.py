"""Derivatives of a peak of several absorbers by every ratio, up to the second, from the matrices.

Z(x) theta = f with Z = K - x^2 M + 2 i x C; H = l' Z^-1 r, so that by two ratios a and b
H_a = v' (r_a - Z_a y) and H_ab = -v' (Z_a y_b + Z_b y_a + Z_ab y), Z y = r, Z' v = l.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.model import Transfer
from vibecalc.response.absorber.several import Several


class Slopes(NamedTuple):
    """log |H|^2 at the peaks (p,): level, its gradient (p, q) and second derivatives (p, q, q).

    The frequency follows each peak unless told to stay. Ratios in the order k (n), z (n), z1,
    m (n): q = 3 n + 1.
    `width` (p,): second derivative by x, negative.
    """

    level: np.ndarray
    first: np.ndarray
    second: np.ndarray
    width: np.ndarray


def several_slopes(
    system: Several, frequency: np.ndarray, transfer: Transfer, absorber: int = 1,
    follow: bool = True,
) -> Slopes:  # fmt: skip
    """Derivatives at peaks `frequency` (p,) of one system (no leading axes).

    With `follow` false the frequencies stay, and need not be peaks. By an infinite k or z, which
    locks an absorber, and by its partner the derivatives are zero.
    """
    z1 = float(np.asarray(system.primary_damping))
    m, k, z = (np.asarray(part, dtype=float) for part in system[1:4])
    count = len(m)
    locked = np.isinf(k) | np.isinf(z)
    unit = _coordinates(system.parent, locked)
    k, z = np.where(locked, 0.0, k), np.where(locked, 0.0, z)
    link = unit[1:] - unit[list(system.parent)]
    bonds = link[:, :, None] * link[:, None, :]
    own = unit[:, :, None] * unit[:, None, :]
    x = np.asarray(frequency, dtype=float)
    inertia = np.concatenate([[1.0], m])
    mass = np.tensordot(inertia, own, 1)
    drag = np.tensordot(z, bonds, 1) + z1 * own[0]
    stiff = np.tensordot(k, bonds, 1) + own[0]
    wide = x[:, None, None]
    matrix = stiff - wide**2 * mass + 2j * wide * drag

    # by k, z, z1, m and last x
    size = 3 * count + 2
    width = unit.shape[1]
    by = np.zeros((len(x), size, width, width), dtype=complex)
    turn = 2j * x[:, None, None, None]
    by[:, :count] = bonds
    by[:, count : 2 * count] = turn * bonds
    by[:, 2 * count] = turn[:, 0] * own[0]
    by[:, 2 * count + 1 : -1] = -(x[:, None, None, None] ** 2) * own[1:]
    by[:, -1] = -2.0 * wide * mass + 2j * drag
    twice = np.zeros_like(by)  # by x and the other
    twice[:, count : 2 * count] = 2j * bonds
    twice[:, 2 * count] = 2j * own[0]
    twice[:, 2 * count + 1 : -1] = -2.0 * x[:, None, None, None] * own[1:]
    twice[:, -1] = -2.0 * mass

    left, right, right_by = _ends(transfer, absorber, inertia, unit, link, size)
    y = np.linalg.solve(matrix, np.broadcast_to(right, (len(x), width))[..., None])[..., 0]
    v = np.linalg.solve(
        np.swapaxes(matrix, -1, -2), np.broadcast_to(left, (len(x), width))[..., None]
    )[..., 0]
    load = right_by - np.einsum("pqij,pj->pqi", by, y)
    moved = np.linalg.solve(matrix[:, None], load[..., None])[..., 0]
    value = y @ left
    first = np.einsum("pi,pqi->pq", v, load) / value[:, None]
    pulled = np.einsum("pi,pqij->pqj", v, by)
    second = -np.einsum("paj,pbj->pab", pulled, moved)
    second = second + np.swapaxes(second, -1, -2)
    mixed = np.einsum("pi,pqij,pj->pq", v, twice, y)
    second[:, :, -1] -= mixed
    second[:, -1, :-1] -= mixed[:, :-1]
    second = second / value[:, None, None] - first[:, :, None] * first[:, None, :]
    first, second = 2.0 * first.real, 2.0 * second.real

    level = 2.0 * np.log(np.abs(value)) + 2.0 * transfer.power * np.log(x)
    first[:, -1] += 2.0 * transfer.power / x
    second[:, -1, -1] -= 2.0 * transfer.power / x**2
    if transfer.ground:
        square = 1.0 + 4.0 * z1 * z1 * x * x
        g, d = float(transfer.ground), 2 * count
        level = level + g * np.log(square)
        first[:, d] += g * 8.0 * z1 * x * x / square
        first[:, -1] += g * 8.0 * z1 * z1 * x / square
        second[:, d, d] += g * 8.0 * x * x * (2.0 - square) / square**2
        second[:, -1, -1] += g * 8.0 * z1 * z1 * (2.0 - square) / square**2
        second[:, d, -1] += g * 16.0 * z1 * x / square**2
        second[:, -1, d] += g * 16.0 * z1 * x / square**2
    if not follow:
        return Slopes(level, first[:, :-1], second[:, :-1, :-1], second[:, -1, -1])
    return _following(level, first, second)


def _coordinates(parent: tuple[int, ...], locked: np.ndarray) -> np.ndarray:
    """Displacements (n + 1, free) of all masses by those that are free of their support."""
    free = np.flatnonzero(np.concatenate([[True], ~locked]))
    unit = np.zeros((len(locked) + 1, len(free)))
    unit[free, np.arange(len(free))] = 1.0
    for i in np.flatnonzero(locked):
        unit[i + 1] = unit[parent[i]]
    return unit


def _ends(
    transfer: Transfer, absorber: int, inertia: np.ndarray, unit: np.ndarray, link: np.ndarray,
    size: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """What is read (l), what drives (r), and the derivatives of r."""
    by = np.zeros((size, unit.shape[1]))
    left, right = unit[0], unit[0]
    if transfer.motion == "ground":
        right = inertia @ unit
        by[-len(unit) : -1] = unit[1:]
    elif transfer.motion == "relative":
        left = link[absorber - 1]
    elif transfer.motion == "secondary":
        left = unit[absorber]
    return left, right, by


def _following(level: np.ndarray, first: np.ndarray, second: np.ndarray) -> Slopes:
    """Let the frequency go to the top of the parabola."""
    width, tilt, across = second[:, -1, -1], first[:, -1], second[:, :-1, -1]
    return Slopes(
        level - 0.5 * tilt**2 / width,
        first[:, :-1] - across * (tilt / width)[:, None],
        second[:, :-1, :-1] - across[:, :, None] * across[:, None, :] / width[:, None, None],
        width,
    )
