"""One step of the linear system under a polynomial torque, exactly.

Over a step of length h the torque is the polynomial through its values at p Gauss points, written
in Legendre polynomials P_l. With I_l = int_0^h exp(A (h - t)) B P_l dt the state at the end is
exp(A h) x + sum_l I_l u_l: the phi functions of an exponential integrator in an orthogonal basis,
where they neither cancel nor need an inverse of A. They are found on a step so short that
|A h| <= 1, where the series of the exponential neither cancels nor lasts, and doubled.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.transient_system import TransientSystem

#: Gauss points of a step; the torque is represented to this order
POINTS = 10

#: terms of the series of the exponential of a matrix whose norm is at most 1
TERMS = 20


class Propagator(NamedTuple):
    """What leads from the start of a step to its j-th part, j = 1 ... parts; the last is its end.

    `transition` (parts, s, s) and `weight` (parts, s, p, n): x_j = transition x + weight torques at
    the p Gauss points; `place` (p,) of these as shares of the step.
    """

    transition: FloatArray
    weight: FloatArray
    place: FloatArray


def legendre_values(x: FloatArray) -> FloatArray:
    """P_l(x), (..., p) for l = 0 ... p - 1."""
    return np.polynomial.legendre.legvander(np.asarray(x, dtype=float), POINTS - 1)


@lru_cache(maxsize=4)
def rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points in -1 ... 1 and their weights, read-only."""
    x, weight = np.polynomial.legendre.leggauss(points)
    x.flags.writeable = weight.flags.writeable = False
    return x, weight


@lru_cache(maxsize=512)
def restriction(start: float, end: float) -> FloatArray:
    """(p, p): [l, k] the share of P_k of the part in P_l of the whole step, part as shares.

    Shared by all callers, hence read-only.
    """
    x, weight = rule(POINTS)
    inside = 2.0 * (start + (end - start) * (x + 1.0) / 2.0) - 1.0
    share = weight[:, None] * legendre_values(x) * (np.arange(POINTS) + 0.5)
    matrix: FloatArray = legendre_values(inside).T @ share
    matrix.flags.writeable = False
    return matrix


def short_step(system: TransientSystem, step: float) -> tuple[FloatArray, FloatArray]:
    """exp(A h) (s, s) and I_l (p, s, n) of one step: a series on h / 2^d, then d doublings."""
    a = system.state_matrix * step
    size = float(np.linalg.norm(a, 1))
    doublings = max(0, int(np.ceil(np.log2(max(size, 1e-300)))))
    small = a * 0.5**doublings
    x, weight = rule(POINTS + TERMS)
    basis = weight[:, None] * legendre_values(x) / 2.0
    transition = np.eye(a.shape[0])
    power, column = transition, 0.5**doublings * step * system.input_matrix
    moment = np.zeros((POINTS, *column.shape))
    for k in range(TERMS):
        share = ((1.0 - x) / 2.0) ** k @ basis
        moment += share[:, None, None] * column
        power, column = small @ power / (k + 1.0), small @ column / (k + 1.0)
        transition = transition + power
    first, second = restriction(0.0, 0.5), restriction(0.5, 1.0)
    for _ in range(doublings):
        early = np.tensordot(first, moment, 1)
        moment = np.matmul(transition, early) + np.tensordot(second, moment, 1)
        transition = transition @ transition
    return transition, moment


def propagator(
    system: TransientSystem, step: float, parts: int = 1, view: FloatArray | None = None
) -> Propagator:
    """Propagator of a step in s to `parts` equal parts of it.

    With a `view` (e, s) it leads from the state to what that reads, e instead of s values.
    """
    transition, moment = short_step(system, step / parts)
    x, weight = rule(POINTS)
    to_legendre = weight[:, None] * legendre_values(x) * (np.arange(POINTS) + 0.5)
    transitions, weights = [], []
    power, total = np.eye(transition.shape[0]), np.zeros_like(moment)
    for part in range(parts):
        power = transition @ power
        border = restriction(part / parts, (part + 1) / parts)
        total = np.matmul(transition, total) + np.tensordot(border, moment, 1)
        transitions.append(power if view is None else view @ power)
        seen = total if view is None else np.matmul(view, total)
        weights.append(np.einsum("gl,lsn->sgn", to_legendre, seen))
    return Propagator(np.array(transitions), np.array(weights), (x + 1.0) / 2.0)


def scan(transition: FloatArray, start: FloatArray, gain: FloatArray) -> FloatArray:
    """x_0 = start, x_{k+1} = transition x_k + gain_k: states (N + 1, s) for gains (N, s).

    The steps lie in about sqrt(N) blocks that are marched side by side from zero; what each block
    hands to the next is then carried along, and the blocks are marched again from there.
    """
    count, size = gain.shape
    length = max(1, int(np.sqrt(count)))
    blocks = -(-count // length)
    padded = np.zeros((blocks * length, size))
    padded[:count] = gain
    inner = padded.reshape(blocks, length, size)
    own = np.zeros((blocks, size))
    for place in range(length):
        own = own @ transition.T + inner[:, place]
    across = np.linalg.matrix_power(transition, length)
    begin = np.empty((blocks, size))
    carried = np.asarray(start, dtype=float)
    for block in range(blocks):
        begin[block] = carried
        carried = across @ carried + own[block]
    states = np.empty((blocks, length, size))
    for place in range(length):
        begin = begin @ transition.T + inner[:, place]
        states[:, place] = begin
    return np.concatenate([[start], states.reshape(-1, size)[:count]])
