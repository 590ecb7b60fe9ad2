"""The shaft line as a first-order system whose state has the size of an energy.

The state is (sqrt(k) twist of each element and ground spring, sqrt(J) velocity of each freedom):
its squared length is twice the energy, so that free motion never lengthens it, whether the
eigenvalues are simple, multiple or defective. Angles are not in it, so a line without a ground
spring has no angle that could drift: its rigid mode has a velocity only.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.torsion.line import Line, damping_matrix


class TransientSystem(NamedTuple):
    """x' = state_matrix x + input_matrix torque, s states, n freedoms, e elements, SI units.

    `twist` (e, s) and `torque` (e, s) read an element's twist and its torque (stiffness and damping
    part) from the state. `balance` (n, n) turns mean torques into those that leave every piece
    without a ground spring on its prescribed motion. `idle` (s,) marks twists that act on nothing
    (elements of dashpots only). `twist_scale` (e,) is what a twist is multiplied with in the state,
    `fastest` in rad/s bounds the frequency of every mode.
    """

    state_matrix: FloatArray
    input_matrix: FloatArray
    twist: FloatArray
    torque: FloatArray
    balance: FloatArray
    idle: BoolArray
    twist_scale: FloatArray
    inertia: FloatArray
    fastest: float


def pieces(line: Line) -> FloatArray:
    """0/1 matrix (p, n): the freedoms of each connected piece that no ground spring holds."""
    from scipy.sparse.csgraph import connected_components

    n = line.inertia.shape[-1]
    joined = np.zeros((n, n), dtype=bool)
    linked = (line.stiffness > 0.0) | (line.damping > 0.0)
    joined[line.first[linked], line.second[linked]] = True
    count, label = connected_components(joined, directed=False)
    member = np.arange(count)[:, None] == label
    held = (member & (line.ground_stiffness > 0.0)).any(axis=1)
    free: FloatArray = member[~held].astype(float)
    return free


def balance_matrix(line: Line, reaction: FloatArray | None) -> FloatArray:
    """I - reaction (sum over the piece): mean torques (n,) to those without resultant.

    `reaction` (n,) are the shares by which the stations take what holds the prescribed motion (the
    driven machine, say); None: by their inertias, as if the whole line were slowed down evenly.
    """
    member = pieces(line)
    share = member * (line.inertia if reaction is None else np.asarray(reaction, dtype=float))
    total = share.sum(axis=1, keepdims=True)
    if (total <= 0.0).any():
        raise NumericalFailure(
            "a piece of the shaft line that no ground spring holds has no station which takes the "
            "mean torque"
        )
    matrix: FloatArray = np.eye(line.inertia.size) - (share / total).T @ member
    return matrix


def transient_system(line: Line, reaction: FloatArray | None = None) -> TransientSystem:
    """The system of one line (no leading axes); `reaction` as in `balance_matrix`.

    Raises NumericalFailure for loss factors (damping by hysteresis is defined at one frequency
    only) and for freedoms without inertia.
    """
    if np.any(line.loss_factor != 0.0):
        raise NumericalFailure(
            "a loss factor has no time domain: it is defined for steady vibration only; give the "
            "element a viscous damping for transients"
        )
    if not np.all(line.inertia > 0.0):
        raise NumericalFailure(
            "a transient needs an inertia at every freedom; condense the massless ones first"
        )
    n, e = line.inertia.size, line.stiffness.size
    ground = np.flatnonzero(line.ground_stiffness > 0.0)
    springs = e + ground.size
    root = np.sqrt(line.inertia)

    difference = np.zeros((springs, n))
    difference[np.arange(e), line.first] += 1.0
    difference[np.arange(e), line.second] -= 1.0
    difference[e + np.arange(ground.size), ground] = 1.0
    stiffness = np.concatenate([line.stiffness, line.ground_stiffness[ground]])
    # a dashpot alone still has a twist, counted in the middle of the other scales
    positive = stiffness[stiffness > 0.0]
    middle = float(np.sqrt(np.median(positive))) if positive.size else 1.0
    scale = np.where(stiffness > 0.0, np.sqrt(stiffness), middle)

    matrix = np.zeros((springs + n, springs + n))
    matrix[:springs, springs:] = scale[:, None] * difference / root
    matrix[springs:, :springs] = -(difference * (stiffness / scale)[:, None]).T / root[:, None]
    matrix[springs:, springs:] = -damping_matrix(line) / root / root[:, None]
    twist = np.zeros((e, springs + n))
    twist[np.arange(e), np.arange(e)] = 1.0 / scale[:e]
    rate = np.zeros_like(twist)
    rate[:, springs:] = difference[:e] / root
    inputs = np.zeros((springs + n, n))
    inputs[springs + np.arange(n), np.arange(n)] = 1.0 / root
    coupling = scale[:, None] * difference / root
    active = coupling[stiffness > 0.0]
    fastest = float(np.linalg.norm(active, 2)) if active.size else 0.0
    return TransientSystem(
        matrix, inputs, twist,
        line.stiffness[:, None] * twist + line.damping[:, None] * rate,
        balance_matrix(line, reaction),
        np.concatenate([stiffness == 0.0, np.zeros(n, dtype=bool)]),
        scale[:e], line.inertia, fastest,
    )  # fmt: skip
