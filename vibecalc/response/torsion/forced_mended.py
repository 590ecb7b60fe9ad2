"""Frequencies at which elimination along a tree loses digits, solved again in other ways."""

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.elimination import Solution, eliminate
from vibecalc.response.torsion.elimination_plan import plan_of
from vibecalc.response.torsion.forced_dense import dense_solution, mapped
from vibecalc.response.torsion.line import Line

Way: TypeAlias = Callable[[Line, FloatArray, list[ComplexArray | None], ComplexArray], Solution]

#: with a relative error above this a frequency is solved again
DOUBTFUL = 1e-9

#: numbers that are worked on at once
ENTRIES = 1 << 19

#: entries of matrices up to which dense solves come first
FEW = 1 << 10


def mended(
    line: Line,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    bad: IntArray,
    angle: ComplexArray,
    error: FloatArray,
    root: int,
    known: bool,
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """The `bad` ones of all frequencies, where elimination grew: angle, error, largest angle.

    `angle` (n, r, bad) is what elimination towards the root found, `error` its error if it
    is `known`, infinite otherwise. They are solved from other roots, torque by torque, and dense.
    Of all ways the one with the smallest error is kept: near a true resonance none helps.
    """
    n, copies = angle.shape[:2]
    roots = [one for one in (root, 0, n // 2, n - 1) if not known or one != root]
    ways: list[Way] = [partial(_from_root, root=one) for one in dict.fromkeys(roots)]
    largest = np.max(np.abs(angle), axis=0)
    left: IntArray = np.arange(len(bad))
    # a handful of small dense solves takes less time than any elimination
    few = n * n * copies * len(bad) <= FEW
    for way in [_dense, *ways, _superposed] if few else [*ways, _superposed, _dense]:
        size = max(1, ENTRIES // ((4 * n * n if way is _dense else n) * copies))
        for start in range(0, len(left), size):
            part = left[start : start + size]
            rows = bad[part]
            loads = [
                None if one is None else one[:, rows] if one.shape[1] > 1 else one for one in torque
            ]
            chosen = mapped(line, partial(_rows, rows=rows))
            with np.errstate(all="ignore"):
                again = way(
                    chosen,
                    frequency[rows],
                    loads,
                    np.empty((n, copies, len(rows)), dtype=np.complex128),
                )
            better = again.error < error[:, part]
            found, least = angle[..., part], error[:, part]
            found[:, better], least[better] = again.angle[:, better], again.error[better]
            angle[..., part], error[:, part] = found, least
            largest[:, part] = np.max(np.abs(found), axis=0)
        left = left[np.any(~(error[:, left] <= DOUBTFUL * largest[:, left]), axis=0)]
        if len(left) == 0:
            break
    return angle, error, largest


def _rows(values: FloatArray, rows: IntArray) -> FloatArray:
    return values[rows] if values.ndim > 1 else values


def _dense(
    line: Line, frequency: FloatArray, torque: list[ComplexArray | None], angle: ComplexArray
) -> Solution:
    return dense_solution(line, frequency, torque, slice(0, len(frequency)), angle)


def _from_root(
    line: Line,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    angle: ComplexArray,
    root: int,
) -> Solution:
    plan = plan_of(line, root)
    if plan is None:
        return _dense(line, frequency, torque, angle)
    return eliminate(plan, frequency, torque, True, angle)


def _superposed(
    line: Line, frequency: FloatArray, torque: list[ComplexArray | None], angle: ComplexArray
) -> Solution:
    """Each station's torque alone, with that station as the root, and their sum.

    Where the torques act on a resonant sub-line, what they do inside it cancels against what it
    does as a whole; with the torque at the root nothing is carried and nothing cancels.
    """
    error = np.zeros(angle.shape[1:])
    angle[...] = 0.0
    for i, one in enumerate(torque):
        if one is not None:
            alone: list[ComplexArray | None] = [None] * len(torque)
            alone[i] = one
            part = _from_root(line, frequency, alone, np.empty_like(angle), root=i)
            angle += part.angle
            error += part.error + EPSILON * np.max(np.abs(angle), axis=0)
    return Solution(
        angle, error, np.zeros(len(frequency), dtype=bool), np.max(np.abs(angle), axis=0)
    )
