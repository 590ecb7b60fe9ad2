"""Whirling frequencies of an overhung rod by beam elements with cubic shapes.

Deflections in the two planes across the axis make one complex number; a body that spins with W
about the rod then has the real equation (K + w W G - w^2 M) v = 0, with G the polar inertia at the
slope of the end. With M = L L^T, C = W L^-1 G L^-T and L^-1 K L^-T = R R^T it is the symmetric
eigenvalue problem of [[C, R], [R^T, 0]]: all w are real, as many above zero (whirl in the sense of
the spin) as below (against it). Errors of the frequencies fall with the fourth power of the length
of an element.
"""

import numpy as np

from vibecalc.hardware.overhung_parts import EndBody, OverhungRod
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.typing import FloatArray

#: stiffness and mass of an element of length 1, E I = 1 and mass per length 1
_STIFFNESS = np.array(
    [
        [12.0, 6.0, -12.0, 6.0],
        [6.0, 4.0, -6.0, 2.0],
        [-12.0, -6.0, 12.0, -6.0],
        [6.0, 2.0, -6.0, 4.0],
    ]
)
_MASS = np.array(
    [[156.0, 22.0, 54.0, -13.0], [22.0, 4.0, 13.0, -3.0], [54.0, 13.0, 156.0, -22.0],
     [-13.0, -3.0, -22.0, 4.0]]
) / 420.0  # fmt: skip


def element_frequencies(
    rod: OverhungRod,
    body: EndBody,
    spin: FloatArray | float = 0.0,
    span_elements: int = 16,
    end_elements: int = 4,
) -> tuple[FloatArray, FloatArray]:
    """Angular frequencies (..., modes) of whirl with and against the spin, each ascending and > 0.

    Everything broadcasts; spin in rad/s. The overhang must be longer than zero.
    """
    stiff, line, span, overhang = floats(*rod)
    mass, diametral, polar, offset = floats(*body)
    turning = np.asarray(spin, dtype=float)
    shape = np.broadcast_shapes(
        *(a.shape for a in (stiff, line, span, overhang, mass, diametral, polar, offset, turning))
    )
    lengths = np.concatenate(
        [
            np.repeat(np.broadcast_to(span, shape)[..., None] / span_elements, span_elements, -1),
            np.repeat(np.broadcast_to(overhang, shape)[..., None] / end_elements, end_elements, -1),
        ],
        axis=-1,
    )
    size = 2 * (lengths.shape[-1] + 1)
    bend, move = np.zeros((*shape, size, size)), np.zeros((*shape, size, size))
    for place in range(lengths.shape[-1]):
        long = lengths[..., place]
        scale = np.stack([np.ones_like(long), long, np.ones_like(long), long], axis=-1)
        both = scale[..., :, None] * scale[..., None, :]
        part = slice(2 * place, 2 * place + 4)
        bend[..., part, part] += (stiff / long**3)[..., None, None] * both * _STIFFNESS
        move[..., part, part] += (line * long)[..., None, None] * both * _MASS
    move[..., -2, -2] += mass
    move[..., -2, -1] += mass * offset
    move[..., -1, -2] += mass * offset
    move[..., -1, -1] += diametral + mass * offset**2
    free = np.delete(np.arange(size), [0, 2 * span_elements])
    bend, move = bend[..., free[:, None], free], move[..., free[:, None], free]
    gyroscopic = np.zeros_like(move)
    gyroscopic[..., -1, -1] = polar * turning
    # slopes times the span: entries of one size
    level = np.ones((*shape, len(free)))
    level[..., _slopes(free)] = 1.0 / np.broadcast_to(span, shape)[..., None]
    both = level[..., :, None] * level[..., None, :]
    whirl = _whirl(bend * both, move * both, gyroscopic * both)
    count = len(free)
    return whirl[..., count:], -whirl[..., count - 1 :: -1]


def _slopes(free: np.ndarray) -> np.ndarray:
    return np.flatnonzero(free % 2 == 1)


def _whirl(bend: FloatArray, move: FloatArray, gyroscopic: FloatArray) -> FloatArray:
    factor = np.linalg.cholesky(move)
    inner = np.linalg.solve(factor, gyroscopic)
    inner = np.linalg.solve(factor, np.swapaxes(inner, -1, -2))
    root = np.linalg.solve(factor, np.linalg.cholesky(bend))
    count = bend.shape[-1]
    both = np.zeros((*bend.shape[:-2], 2 * count, 2 * count))
    both[..., :count, :count] = 0.5 * (inner + np.swapaxes(inner, -1, -2))
    both[..., :count, count:] = root
    both[..., count:, :count] = np.swapaxes(root, -1, -2)
    return np.asarray(np.linalg.eigvalsh(both))
