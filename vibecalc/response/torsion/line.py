"""A shaft line as freedoms and the elastic elements between them.

Everything is referred to the crankshaft: a station that turns r times as fast as the crankshaft
has the angle r phi, the inertia J r^2 and shafts of stiffness k r^2 here. What two rigid gears hold
together is one freedom. So a line with gears is a plain network of inertias and springs.
"""

from typing import NamedTuple, TypeVar

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray

Values = TypeVar("Values", FloatArray, ComplexArray)


class Line(NamedTuple):
    """n freedoms and e elements; the values may have leading axes, the network is one.

    `inertia` (..., n) in kg m^2, `absolute_damping` (..., n) in N m s/rad and `ground_stiffness`
    (..., n) in N m/rad act between a freedom and the steadily turning frame; `stiffness`, `damping`
    and `loss_factor` (..., e) act on the twist phi[first] - phi[second] of each element, whose
    torque is (k (1 + i loss_factor) + i w c) (phi[first] - phi[second]).
    """

    inertia: FloatArray
    absolute_damping: FloatArray
    ground_stiffness: FloatArray
    first: IntArray
    second: IntArray
    stiffness: FloatArray
    damping: FloatArray
    loss_factor: FloatArray


def chain(inertia: FloatArray, stiffness: FloatArray) -> Line:
    """An undamped line of n inertias in a row with n - 1 shafts between them."""
    inertia, stiffness = np.asarray(inertia, dtype=float), np.asarray(stiffness, dtype=float)
    start = np.arange(stiffness.shape[-1])
    none, free = np.zeros_like(inertia), np.zeros_like(stiffness)
    return Line(inertia, none, none, start, start + 1, stiffness, free, free)


def network_matrix(line: Line, element: Values, ground: Values) -> Values:
    """Symmetric matrix (..., n, n) of element values (..., e) and values to ground (..., n)."""
    n = line.inertia.shape[-1]
    leading: tuple[int, ...] = np.broadcast_shapes(element.shape[:-1], ground.shape[:-1])
    matrix: Values = np.zeros((*leading, n, n), dtype=element.dtype)
    index = np.arange(n)
    matrix[..., index, index] += ground
    for e, (a, b) in enumerate(zip(line.first, line.second, strict=True)):
        matrix[..., a, a] += element[..., e]
        matrix[..., b, b] += element[..., e]
        matrix[..., a, b] -= element[..., e]
        matrix[..., b, a] -= element[..., e]
    return matrix


def stiffness_matrix(line: Line) -> FloatArray:
    """K (..., n, n) in N m/rad, without loss factors."""
    return network_matrix(line, line.stiffness, line.ground_stiffness)


def damping_matrix(line: Line) -> FloatArray:
    """C (..., n, n) in N m s/rad."""
    return network_matrix(line, line.damping, line.absolute_damping)


def dynamic_stiffness(line: Line, frequency: FloatArray) -> ComplexArray:
    """K (1 + i loss factor) + i w C - w^2 J, (..., n, n) complex, w (...) in rad/s."""
    w = np.asarray(frequency, dtype=float)[..., None]
    element = line.stiffness * (1.0 + 1j * line.loss_factor) + 1j * w * line.damping
    ground = line.ground_stiffness + 1j * w * line.absolute_damping - w**2 * line.inertia
    return network_matrix(line, element, ground)
