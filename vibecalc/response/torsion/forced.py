"""Steady response of a shaft line to torques at its stations, at all speeds and orders at once."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.elimination import eliminate, room_for
from vibecalc.response.torsion.elimination_plan import plan_of
from vibecalc.response.torsion.forced_dense import dense_solution, mapped
from vibecalc.response.torsion.forced_mended import DOUBTFUL, mended
from vibecalc.response.torsion.line import Line

#: entries (station times frequency) of one block: what it stores stays in the cache
BLOCK = 1 << 19

#: frequencies of one block, at most
LONGEST = 8192

#: places along each axis at which the size of a torque is looked at
LOOKS = 16


class Forced(NamedTuple):
    """Angles (..., n) in rad, complex, 0-to-peak, and their absolute error (...), over stations.

    The error bounds the round-off for the line, frequency and torques as given. It is empty (size
    0) where no estimate was asked for. Stations are the slowest axis in memory.
    """

    angle: ComplexArray
    error: FloatArray


class Masked(NamedTuple):
    """As `Forced`, with `masked` (...) where there is no response; angle 0, error infinite."""

    angle: ComplexArray
    error: FloatArray
    masked: BoolArray


def forced(
    line: Line,
    frequency: ArrayLike,
    torque: ArrayLike,
    *,
    stations: Sequence[int] | None = None,
    estimate: bool = True,
) -> Forced:
    """Steady angles of all stations.

    Parameters
    ----------
    line : Line
        Any network; trees by elimination, loops by dense solves. Leading axes go with frequency.
    frequency : array (...)
        In rad/s, 0 or above.
    torque : complex array (..., n)
        In N m, 0-to-peak, x(t) = Re(X exp(i w t)). Axes in front of those of `frequency` are
        several torques at the same frequencies: factorised once.
    stations : sequence of int, optional
        The stations that the last axis of `torque` stands for; without it all of them.
    estimate : bool
        Without it no error is formed (half the time); frequencies where elimination grew by 1e4
        or more are solved with it all the same, and what is singular is still refused.

    Raises
    ------
    NumericalFailure
        Some frequency is at a resonance without damping to within four digits, or is zero with
        torques on a free line that do not balance. Balanced ones leave a twist; the angles then
        have a mean of zero, weighted with inertia (the limit of low frequency).
    """
    found = forced_masked(line, frequency, torque, stations=stations, estimate=estimate)
    if np.any(found.masked):
        w = np.broadcast_to(np.asarray(frequency, dtype=float), found.masked.shape)
        first = float(w[found.masked][0])
        why = (
            "the torques on a line that is free to turn do not balance"
            if first == 0.0
            else "it is a natural frequency of the line, and nothing there damps it"
        )
        raise NumericalFailure(
            f"forced torsional response: no steady response at {first:.12g} rad/s: {why}"
        )
    return Forced(found.angle, found.error)


def forced_masked(
    line: Line,
    frequency: ArrayLike,
    torque: ArrayLike,
    *,
    stations: Sequence[int] | None = None,
    estimate: bool = True,
    dense: bool = False,
) -> Masked:
    """As `forced` for a range of frequencies: what is singular is masked instead of refused.

    `dense` asks for a full solve with pivoting at each frequency, also where elimination would do.
    """
    w, load = np.asarray(frequency, dtype=float), np.asarray(torque, dtype=np.complex128)
    n = line.inertia.shape[-1]
    leading = np.broadcast_shapes(*(one.shape[:-1] for one in (line.inertia, line.stiffness)))
    extra = max(load.ndim - 1 - max(w.ndim, len(leading)), 0)
    shape = np.broadcast_shapes(w.shape, leading, load.shape[extra:-1])
    several = load.shape[:extra]
    count, copies = math.prod(shape), math.prod(several)
    flat = _flat_line(line, shape)
    flat_w = np.broadcast_to(w, shape).reshape(count)
    loads: list[ComplexArray | None] = [None] * n
    for place_of, i in enumerate(range(n) if stations is None else stations):
        loads[i] = _flat_load(load[..., place_of], several, shape)
    angle = np.empty((n, copies, count), dtype=np.complex128)
    error, largest = np.zeros((copies, count)), np.zeros((copies, count))
    growth = np.zeros(count, dtype=bool)
    root = _most_loaded(loads)
    plan = None if dense else plan_of(flat, root)
    estimated = estimate or plan is None
    size = max(1, (min(LONGEST, BLOCK // n) if plan else BLOCK // (4 * n * n)) // copies)
    # blocks of one length: a short last one would cost as many calls as the others
    size = max(1, -(-count // max(1, -(-count // size))))
    room = room_for(plan, size, estimate) if plan else None
    for start in range(0, count, size):
        part = slice(start, min(start + size, count))
        block = [
            None if one is None else one[:, part] if one.shape[1] > 1 else one for one in loads
        ]
        place = angle[..., part]
        if plan is None:
            solution = dense_solution(flat, flat_w[part], block, part, place)
        else:
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                solution = eliminate(plan.cut(part), flat_w[part], block, estimate, place, room)
        if estimated:
            error[:, part], largest[:, part] = solution.error, solution.largest
        else:
            growth[part] = solution.growth
    again = np.flatnonzero(growth)
    if estimated:
        again = np.flatnonzero(np.any(~(error <= DOUBTFUL * largest), axis=0))
    if plan is not None and len(again):
        known = error[:, again] if estimated else np.full((copies, len(again)), np.inf)
        angle[..., again], error[:, again], largest[:, again] = mended(
            flat, flat_w, loads, again, angle[..., again], known, root, estimated
        )
    masked = np.zeros((copies, count), dtype=bool)
    doubt = ~(error[:, again] < SINGULAR * largest[:, again])
    masked[:, again] = doubt & ~((error[:, again] == 0.0) & (largest[:, again] == 0.0))
    still = np.flatnonzero(flat_w == 0.0)
    if len(still):
        angle[..., still] = _without_turning(flat, angle[..., still], slice(0, count), still)
    if np.any(masked):
        angle[:, masked] = 0.0
        error[masked] = np.inf
    whole = (*several, *shape)
    told = np.reshape(error, whole) if estimate else np.zeros(0)
    by_station = np.moveaxis(angle.reshape(n, *whole), 0, -1)
    return Masked(by_station, told, masked.reshape(whole))


def _without_turning(line: Line, angle: ComplexArray, part: slice, still: IntArray) -> ComplexArray:
    """Angles (n, r, f) at rest, less the mean of each piece that nothing holds."""
    n = line.inertia.shape[-1]
    piece = np.arange(n)
    for _ in range(n):
        for e, (a, b) in enumerate(zip(line.first, line.second, strict=True)):
            if np.any(line.stiffness[..., e]) or np.any(line.damping[..., e]):
                piece[[a, b]] = min(piece[a], piece[b])
    for one in set(piece.tolist()):
        inside = np.flatnonzero(piece == one)
        inertia = line.inertia[..., inside]
        if inertia.ndim > 1:
            inertia = inertia[part][still]
        if np.any(line.ground_stiffness[..., inside]) or not np.all(inertia.sum(axis=-1)):
            continue
        weight = (inertia / inertia.sum(axis=-1, keepdims=True)).T
        weight = weight.reshape(len(inside), 1, -1)
        angle[inside] -= np.sum(weight * angle[inside], axis=0)
    return angle


def _flat_line(line: Line, shape: tuple[int, ...]) -> Line:
    """Values with leading axes as one flat axis; those without stay as they are."""

    def flat(values: FloatArray) -> FloatArray:
        if values.ndim == 1:
            return values
        return np.broadcast_to(values, (*shape, values.shape[-1])).reshape(-1, values.shape[-1])

    return mapped(line, flat)


def _flat_load(
    load: ComplexArray, several: tuple[int, ...], shape: tuple[int, ...]
) -> ComplexArray | None:
    """One station's torque as (r, f) or (r, 1), None where it is zero."""
    if not np.any(_some(load)) and not np.any(load):
        return None
    copies = math.prod(several)
    if load.size == copies and load.shape[: len(several)] == several:
        return load.reshape(copies, 1)
    return np.broadcast_to(load, (*several, *shape)).reshape(copies, -1)


def _most_loaded(loads: list[ComplexArray | None]) -> int:
    """Station with the largest torque: as the root it needs no torque carried down to it."""
    sizes = [0.0 if one is None else _size(one) for one in loads]
    return int(np.argmax(np.array(sizes) * (1.0 + 4.0 * EPSILON)))


def _size(load: ComplexArray) -> float:
    return float(np.max(np.abs(_some(load))))


def _some(load: ComplexArray) -> ComplexArray:
    """A torque at some of its places: which station bears most need not be known exactly."""
    some: ComplexArray = load[tuple(slice(None, None, 1 + size // LOOKS) for size in load.shape)]
    return some
