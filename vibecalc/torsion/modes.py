"""Natural frequencies and shapes of an undamped shaft line; those of a row of inertias in full."""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.line import (
    Line,
    LinePart,
    angles_of_condensed,
    condense,
    connected_parts,
    path_order,
)
from vibecalc.torsion.modes_of_tree import (
    clusters,
    factor_modes,
    orthogonal,
    orthogonal_pairs,
    relative_error,
    tree_modes,
)
from vibecalc.torsion.network import inverse_iteration

# ----------------------------------------------------------------------------
# Frequencies of a row of inertias as singular values of a bidiagonal factor.
#
# K = L P L' with pivots p_i = k_i + S_i, where S_i is the stiffness to ground of all that lies
# before shaft i: S_1 = g_1, S_(i+1) = g_(i+1) + S_i k_i / (S_i + k_i). Nothing is subtracted, so
# every entry of the upper bidiagonal factor P^(1/2) L' J^(-1/2), with sqrt(p_i / J_i) on and
# -k_i / sqrt(p_i J_(i+1)) above the diagonal, is right to a few roundings, and so are all its
# singular values, the smallest like the largest (Demmel and Kahan 1990). LAPACK finds them by the
# differential qd algorithm (Fernando and Parlett 1994), which keeps that accuracy; its reduction
# to bidiagonal form leaves a matrix that has this form as it is. A free row ends with the pivot 0.
# ----------------------------------------------------------------------------


class StationRow(NamedTuple):
    """Inertias (n,), springs to ground (n,), and shafts (n - 1,) between neighbours."""

    inertia: FloatArray
    ground: FloatArray
    stiffness: FloatArray


def bidiagonal_factor(row: StationRow) -> FloatArray:
    """The upper bidiagonal factor (n, n) in rad/s; its singular values are the frequencies."""
    count = len(row.inertia)
    root = np.sqrt(row.inertia)
    pivot, above = np.empty(count), row.stiffness
    if row.ground.any():
        before = 0.0
        for index, (k, g) in enumerate(zip(row.stiffness.tolist(), row.ground.tolist()[:-1])):  # noqa: B905
            before += g
            pivot[index] = k + before
            before *= k / pivot[index]
        pivot[-1] = before + row.ground[-1]
        above = row.stiffness / np.sqrt(pivot[:-1]) if count > 1 else above
    else:
        pivot[:-1], pivot[-1] = row.stiffness, 0.0
        above = np.sqrt(row.stiffness)
    factor = np.zeros((count, count))
    factor.reshape(-1)[:: count + 1] = np.sqrt(pivot) / root
    factor.reshape(-1)[1 :: count + 1] = -above / root[1:]
    return factor


def row_frequencies(factor: FloatArray, free: bool) -> FloatArray:
    """Frequencies (n,) in rad/s, ascending, of a bidiagonal factor; the rigid one exactly 0."""
    frequency: FloatArray = bidiagonal_singular_values(factor)[::-1].copy()
    if free:
        frequency[0] = 0.0
    return frequency


# ----------------------------------------------------------------------------
# Natural frequencies and shapes of an undamped shaft line, by the method that its shape allows.
# ----------------------------------------------------------------------------


class Modes(NamedTuple):
    """m modes of n freedoms, one mode for each freedom with inertia.

    `frequency` (m,) in rad/s, ascending, exactly 0 for the rigid mode of each ungrounded piece;
    `shape` (m, n) angles of largest magnitude 1, the largest positive, of several within a
    thousandth the first; `modal_inertia` (m,) = sum of J shape^2 in kg m^2; `frequency_error` (m,)
    in rad/s and `shape_error` (m,) of its worst component, absolute.
    """

    frequency: FloatArray
    shape: FloatArray
    modal_inertia: FloatArray
    frequency_error: FloatArray
    shape_error: FloatArray


def natural_modes(line: Line) -> Modes:
    """Undamped modes of any shaft line without leading axes; damping and loss are not examined.

    Rows: qd algorithm on a bidiagonal factor and twisted factorisation; trees: mode counts; loops:
    dense singular values. Rows and trees are right to some roundings in every mode. A freedom
    without inertia moves as statics bids; its infinite frequency is left out. Stiffness zero
    parts a line. Shapes of frequencies that agree to their error are any orthogonal ones of
    their space, and their `shape_error` says so by being 2. Raises `NumericalFailure` for a
    part without inertia.
    """
    count = len(line.inertia)
    if _is_row(line):
        row = StationRow(line.inertia, line.ground_stiffness, line.stiffness)
        frequency, shape = _row_modes(row)
        relative = relative_error(count)
        return _finished(line.inertia, frequency, shape, relative * frequency)
    frequencies, errors, shapes, parts = [], [], [], connected_parts(line)
    for connected in parts:
        frequency, shape, error = _part_modes(connected, count)
        frequencies.append(frequency)
        errors.append(error)
        shapes.append(shape)
    frequency, error = np.concatenate(frequencies), np.concatenate(errors)
    order = np.argsort(frequency, kind="stable")
    shape = np.concatenate(shapes)[order]
    if not all(part.is_tree for part in parts):
        _sharpen(line, frequency[order], shape)
    owner = np.repeat(np.arange(len(shapes)), [len(part) for part in shapes])[order]
    return _finished(line.inertia, frequency[order], shape, error[order], owner)


def _is_row(line: Line) -> bool:
    """Stations in a row in their own order, each with inertia, each shaft with stiffness."""
    elements = len(line.stiffness)
    if elements != len(line.inertia) - 1 or not line.inertia.all() or not line.stiffness.all():
        return False
    first, second = line.first.tolist(), line.second.tolist()
    return bool(first == list(range(elements)) and second == list(range(1, elements + 1)))


def _row_modes(row: StationRow) -> tuple[FloatArray, FloatArray]:
    """Frequencies (n,) and shapes (n, n) of a row in which every station has inertia."""
    free = not row.ground.any()
    factor = bidiagonal_factor(row)
    frequency = row_frequencies(factor, free)
    shape = row_shapes(row, frequency)
    runs = clusters(frequency)
    pairs = np.array([a for a, b in runs if b == a + 2], dtype=np.int64)
    done = set[int]()
    if len(pairs):
        turned_pairs, sound = orthogonal_pairs(shape, pairs, row.inertia)
        pairs, turned_pairs = pairs[sound], turned_pairs[sound]
        shape[pairs], shape[pairs + 1] = turned_pairs[:, 0], turned_pairs[:, 1]
        done = set(pairs.tolist())
    for first, last in runs:
        if first in done:
            continue
        turned = orthogonal(shape[first:last], row.inertia)
        if turned is None:
            turned = np.linalg.svd(factor)[2][::-1][first:last] / np.sqrt(row.inertia)
        shape[first:last] = turned
    if free:
        shape[0] = 1.0
    return frequency, shape


def _part_modes(connected: LinePart, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies (m,), shapes (m, count) and absolute frequency errors (m,) of one piece."""
    small, taken = condense(connected, 2)
    order = path_order(small)
    if order is not None:
        stiffness = [small.spring[a][b] for a, b in pairwise(order)]
        row = StationRow(
            np.array([small.inertia[name] for name in order]),
            np.array([small.ground[name] for name in order]),
            np.array(stiffness),
        )
        frequency, part = _row_modes(row)
        error = relative_error(len(connected.spring)) * frequency
    elif small.is_tree:
        order = list(small.spring)
        frequency, part, error = tree_modes(small)
    else:
        small, taken = condense(connected, len(connected.spring))
        order = list(small.spring)
        frequency, part, bound = factor_modes(small)
        error = np.where(frequency > 0.0, bound + relative_error(len(order)) * frequency, 0.0)
    shape = np.zeros((len(frequency), count))
    shape[:, order] = part
    angles_of_condensed(shape, taken)
    return frequency, shape, error


def _sharpen(line: Line, frequency: FloatArray, shape: FloatArray) -> None:
    """Shapes (m, n) by a step of inverse iteration, which keeps small angles, in place.

    Of dense singular vectors all angles have the error of the largest. Those that share their
    frequency stay as they are: a step would turn them into each other.
    """
    alone = frequency > 0.0
    for first, last in clusters(frequency):
        alone[first:last] = False
    plain = line._replace(damping=0.0 * line.damping, loss_factor=0.0 * line.loss_factor,
                          absolute_damping=0.0 * line.inertia)  # fmt: skip
    pole = np.asarray(1j * frequency[alone], dtype=np.complex128)
    found = inverse_iteration(plain, pole, shape[alone].T.astype(np.complex128))
    shape[alone] = found.imag.T


def _finished(
    inertia: FloatArray,
    frequency: FloatArray,
    shape: FloatArray,
    error: FloatArray,
    owner: IntArray | None = None,
) -> Modes:
    """Scale shapes and bound what their error may be; modes of other parts do not mix."""
    modes = np.arange(len(frequency))
    size = np.abs(shape)
    # within a thousandth stations count as equal: no rounding may choose the sign
    largest = np.argmax(size, axis=1)
    top = size[modes, largest]
    first = np.argmax(size >= (1.0 - 1e-3) * top[:, None], axis=1)
    shape = shape / np.copysign(top, shape[modes, first])[:, None]
    np.multiply(shape, shape, out=size)
    modal = size @ inertia
    # Relative changes h of J and k turn mode i by at most h w_i / |w_i - w_j| towards each j (both
    # at modal inertia 1), squares summed; the error of w_i is such an h w_i.
    away = np.subtract.outer(frequency, frequency)
    away *= away
    if owner is not None:
        away[owner[:, None] != owner] = np.inf
    np.fill_diagonal(away, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        np.divide(1.0, away, out=away)
        mixed = error * np.sqrt(modal * (away @ (1.0 / modal)))
    rigid = frequency == 0.0
    shape_error = np.where(rigid, 0.0, np.fmin(mixed + 8.0 * EPSILON, 2.0))
    return Modes(frequency, shape, modal, error, shape_error)


# ----------------------------------------------------------------------------
# Singular values of an upper bidiagonal matrix by LAPACK's differential qd algorithm, alone.
#
# `numpy.linalg.svd` ends in the same routine, after a reduction of the full matrix that costs three
# times as much and changes nothing in a bidiagonal one. scipy offers the routine to Cython; its
# capsules can be called as they are. That one module is loaded from its folder, as importing all of
# `scipy.linalg` takes longer than the modes of 500 stations.
# ----------------------------------------------------------------------------

#: from this size on the saving is worth loading it
WORTH_WHILE = 64


@cache
def _dlasq1() -> Callable[..., None]:
    """dlasq1(n, diagonal, above, work, info), all by reference, of scipy's LAPACK."""
    import scipy

    found = PathFinder.find_spec("cython_lapack", [f"{one}/linalg" for one in scipy.__path__])
    assert found is not None and found.loader is not None, "scipy has no module for Cython"
    module: Any = module_from_spec(found)
    found.loader.exec_module(module)
    capsule = module.__pyx_capi__["dlasq1"]
    name = ctypes.pythonapi.PyCapsule_GetName
    name.restype, name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5)
    return signature(pointer(capsule, name(capsule)))


def bidiagonal_singular_values(factor: FloatArray) -> FloatArray:
    """Singular values (n,), descending, of an upper bidiagonal matrix (n, n).

    Raises `NumericalFailure` if the iteration does not end.
    """
    count = len(factor)
    if count < WORTH_WHILE:
        return np.asarray(np.linalg.svd(factor, compute_uv=False), dtype=np.float64)
    diagonal = factor.diagonal().copy()
    above = np.append(factor.diagonal(1), 0.0)
    work = np.empty(4 * count)
    size, info = ctypes.c_int(count), ctypes.c_int(0)
    _dlasq1()(
        ctypes.byref(size),
        diagonal.ctypes.data,
        above.ctypes.data,
        work.ctypes.data,
        ctypes.byref(info),
    )
    if info.value:
        raise NumericalFailure("the singular values of the shaft line's factor did not converge")
    return diagonal


# ----------------------------------------------------------------------------
# Mode shapes of a row of inertias by a twisted factorisation, all modes at once.
#
# At a frequency of its own, the ratio Z of torque to angle runs from both ends of the row. The two
# meet at a station r where Z from the left and Z from the right, its own inertia counted once, add
# up to almost nothing; from there the angles follow outwards as products of k / (k + Z), which
# neither overflow nor cancel (Fernando 1997, Dhillon and Parlett 2004).
# ----------------------------------------------------------------------------


def row_shapes(row: StationRow, frequency: FloatArray) -> FloatArray:
    """Shapes (m, n), largest component of each at angle about 1, at natural frequencies (m,)."""
    count, modes = len(row.inertia), len(frequency)
    if count == 1:
        return np.ones((modes, 1))
    # one piece of memory for all that is needed on the way: the system keeps it for the next call,
    # and handing it out anew takes longer than the arithmetic
    scratch = np.empty((6, count, modes))
    dynamic, other = scratch[:2]
    hanging, ratio = scratch[2:].reshape(2, count, 2, modes)
    ratio = ratio[1:]
    np.multiply(-row.inertia[:, None], frequency**2, out=dynamic)
    dynamic += row.ground[:, None]
    springs = np.stack([row.stiffness, row.stiffness[::-1]], axis=1)
    with np.errstate(all="ignore"):
        _march(dynamic, springs, hanging, ratio, 0.0)
    if not np.isfinite(ratio).all():
        _march(dynamic, springs, hanging, ratio, 2.0**-60)
    np.add(hanging[:, 0], hanging[::-1, 1], out=other)
    other -= dynamic
    np.abs(other, out=other)
    other /= row.inertia[:, None]
    outward = ratio[::-1]
    best = np.argmin(other, axis=0)
    shape = _outwards(outward, best)
    # a start of little energy magnifies roundings: begin again at the station of most
    energy = np.multiply(shape, shape, out=other)
    energy *= row.inertia[:, None]
    better = np.argmax(energy, axis=0)
    every = np.arange(modes)
    moved = np.flatnonzero(energy[best, every] < 0.05 * energy[better, every])
    if moved.size:
        shape[:, moved] = _outwards(outward[:, :, moved], better[moved])
    return shape.T


def _march(
    dynamic: FloatArray, springs: FloatArray, hanging: FloatArray, ratio: FloatArray, nudge: float
) -> None:
    """From the left and from the right, in place: Z with the station's own, `hanging` (n, 2, m),
    and its angle over that of the next station, `ratio` (n - 1, 2, m)."""
    hanging[:, 0], hanging[:, 1] = dynamic, dynamic[::-1]
    ratio[:] = springs[:, :, None]
    pivot, add, multiply, divide = np.empty_like(hanging[0]), np.add, np.multiply, np.divide
    for share, here, there in zip(list(ratio), list(hanging[:-1]), list(hanging[1:]), strict=True):
        add(here, share, pivot)
        if nudge:
            pivot = np.where(pivot == 0.0, share * nudge, pivot)
        divide(share, pivot, share)
        multiply(share, here, pivot)
        add(there, pivot, there)


def _outwards(ratio: FloatArray, start: IntArray) -> FloatArray:
    """Angles (n, m), 1 at the station `start` (m,) of each mode, by products of ratios.

    `ratio` (n - 1, 2, m) is of a station's angle to that of its neighbour towards the start: of
    those left of it from the last to the first, of those right of it from the second to the last.
    """
    count = len(ratio) + 1
    far = np.arange(count - 1)[:, None, None] >= np.stack([count - 1 - start, start])
    # up to the start each product is of ones
    product = np.where(far, ratio, 1.0)
    rows, multiply = list(product), np.multiply
    for there, here in pairwise(rows):
        multiply(here, there, here)
    shape = np.ones((count, len(start)))
    shape[:-1] = product[::-1, 0]
    shape[1:] *= product[:, 1]
    return shape
