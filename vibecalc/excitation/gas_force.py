"""Force of the gas on a piston over one turn of its crank, from a table: piecewise polynomials.

Positive pushes the piston towards the crank. Herold (1977) gives such tables every 10 degrees and
runs the parabola of `parabola` through them (NLFGEN of his program).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.typing import ComplexArray, FloatArray

TURN = 2.0 * np.pi


class GasForce(NamedTuple):
    """A periodic curve: m pieces from each `node` (m,) of [0, 2 pi) on, or harmonics.

    On piece i the force is sum_k coefficient[i, k] (angle - node[i])^k in N; the last piece runs
    on to the first node of the next turn. With `harmonics` (n + 1,), one-sided and complex, it is
    Re sum_k harmonics[k] exp(i k angle) instead, and there are no nodes.
    """

    node: FloatArray
    coefficient: FloatArray
    harmonics: ComplexArray


def gas_force(angle: ArrayLike, force: ArrayLike, interpolation: str) -> GasForce:
    """A curve through a table over one turn, whose last row repeats the first.

    Parameters
    ----------
    angle, force : (m + 1,) in rad, ascending, and N.
    interpolation
        "linear": straight lines. "parabola": on each interval the parabola through its ends and
        the node before it. "cubic": the periodic cubic spline. "trigonometric": the trigonometric
        polynomial of least degree; its nodes have to be evenly spaced.

    Raises
    ------
    ValueError
        "trigonometric" with nodes that are not evenly spaced.
    """
    angle, force = np.asarray(angle, dtype=float), np.asarray(force, dtype=float)
    if interpolation == "trigonometric":
        return GasForce(np.empty(0), np.empty((0, 1)), _harmonics(angle, force))
    pieces = _PIECES[interpolation](np.diff(angle), force)
    start = np.mod(angle[:-1], TURN)
    order = np.argsort(start)
    return GasForce(start[order], pieces[order], np.empty(0, dtype=complex))


def force_at(gas: GasForce, angle: FloatArray) -> FloatArray:
    """Force in N at the cylinder's own crank angles, rad, of any turn."""
    if not len(gas.node):
        order = np.arange(len(gas.harmonics))
        return np.asarray(np.real(np.exp(1j * angle[..., None] * order) @ gas.harmonics))
    turned = np.mod(angle, TURN)
    place = np.searchsorted(gas.node, turned, side="right") - 1
    away = turned - gas.node[place]
    if gas.node[0] > 0.0:
        away += np.where(place < 0, TURN, 0.0)
    rows = gas.coefficient[place]
    value = rows[..., -1]
    for power in range(rows.shape[-1] - 2, -1, -1):
        value = value * away + rows[..., power]
    return np.asarray(value)


def _linear(step: FloatArray, force: FloatArray) -> FloatArray:
    return np.stack([force[:-1], np.diff(force) / step], axis=1)


def _parabola(step: FloatArray, force: FloatArray) -> FloatArray:
    slope = np.diff(force) / step
    bend = (slope - np.roll(slope, 1)) / (step + np.roll(step, 1))
    return np.stack([force[:-1], slope - bend * step, bend], axis=1)


def _cubic(step: FloatArray, force: FloatArray) -> FloatArray:
    from scipy.interpolate import CubicSpline

    nodes = np.concatenate([[0.0], np.cumsum(step)])
    closed = np.concatenate([force[:-1], force[:1]])
    return np.asarray(CubicSpline(nodes, closed, bc_type="periodic").c[::-1].T)


def _harmonics(angle: FloatArray, force: FloatArray) -> ComplexArray:
    count = len(angle) - 1
    step = TURN / count
    if np.max(np.abs(np.diff(angle) - step)) > 1e-9:
        raise ValueError("trigonometric interpolation needs evenly spaced angles")
    found = np.fft.rfft(force[:-1]) / count
    found[1:] *= 2.0
    if count % 2 == 0:
        found[-1] *= 0.5
    return np.asarray(found * np.exp(-1j * np.arange(len(found)) * angle[0]))


_PIECES = {"linear": _linear, "parabola": _parabola, "cubic": _cubic}
INTERPOLATIONS = (*_PIECES, "trigonometric")
