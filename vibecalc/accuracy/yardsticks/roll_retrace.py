"""The turn of a running state gone over once more: an eighth-order march from point to point.

The march takes the equations as they are at every point of it, with the kinks where they truly
lie, and knows of the collocation nothing but the start at crank angle zero and where to stop. The
pair of Dormand and Prince of order 8 is taken without its error estimate: from one collocation
point to the next is so short that a step leaves no more than rounding.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.roll_setup import RollSetup, spectrum
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.roll.march_scalar import running
from vibecalc.response.roll.steady import Steady
from vibecalc.response.roll.turn import Turn


class Retraced(NamedTuple):
    """Spectrum (orders,) along the march, rad/s^2, and how far the turn fails to close.

    `gap` is relative to the crank speed, the speeds of crank and shell alike.
    """

    values: ComplexArray
    gap: float


def retrace(setup: RollSetup, found: Steady) -> Retraced:
    """The turn of a machine whose motor has a steady curve, in plain floats in the time domain."""
    rates = running(setup.alone, setup.drive)
    solution, turn = found.solution, found.turn
    edges = solution.edges[0]
    first = solution.left[0, 0]
    start = np.array([0.0, first[0], 0.0, 0.0])
    if setup.mounted:
        start[2:] = first[1:3]
    else:
        moved = _first_shell_speed(setup, float(first[0]))
        start[3] = moved

    def by_angle(angle: float, state: FloatArray) -> FloatArray:
        _, w, theta, s = state.tolist()
        crank, shell = rates(angle, w, theta, s)
        return np.asarray(np.array([1.0, crank, s, shell]) / w)

    nodes = turn.crank_angle[0]
    places = np.unique(np.concatenate([edges, nodes]))
    path = _path(by_angle, places, start)
    own = path[np.searchsorted(places, nodes)]
    shell = [rates(b, *row[1:].tolist())[1] for b, row in zip(nodes.tolist(), own, strict=True)]
    again = Turn(
        turn.crank_angle, turn.weight, own[None, :, 0], own[None, :, 1], own[None, :, 3],
        own[None, :, 2], path[-1:, 0],
    )  # fmt: skip
    off = np.abs(path[-1] - start)[[1, 3]] / start[1]
    return Retraced(spectrum(setup, again, np.array(shell)[None]), float(np.max(off)))


def departure(setup: RollSetup, found: Steady) -> float:
    """Sum of what all steps from one edge to the next depart from the state, over its scale.

    For a motor with fluxes, all panels at once: the sum bounds how far a march along the turn
    would be off, as long as disturbances fade.
    """
    from scipy.integrate import DOP853

    rates, solution = found.problem.rhs, found.solution
    edges = solution.edges[0]
    size = np.asarray(found.problem.scale)
    parts = 8
    x, state = edges[:-1].copy(), solution.left[0].copy()
    step = np.diff(edges) / parts
    for _ in range(parts):
        slopes: list[FloatArray] = []
        for row, share in zip(DOP853.A, DOP853.C, strict=True):
            there = state.copy()
            for factor, slope in zip(row, slopes, strict=False):
                there += (step * factor)[:, None] * slope
            at = (x + share * step)[None, :, None]
            slopes.append(rates(at, there[None, :, None], None)[0][0, :, 0])
        state += step[:, None] * np.einsum("s,spn->pn", DOP853.B, np.array(slopes))
        x += step
    off = np.abs(state - np.roll(solution.left[0], -1, axis=0)) / size
    return float(np.max(np.sum(off, axis=0)))


def _first_shell_speed(setup: RollSetup, speed: float) -> float:
    from vibecalc.response.roll.inertia import inertia

    moved = inertia(setup.machine, np.zeros((1, 1)))
    coupling, shell = float(moved.coupling[0, 0]), float(moved.shell[0, 0])
    return (float(setup.momentum[0]) - coupling * speed) / shell


def _path(rates, places: FloatArray, start: FloatArray) -> FloatArray:  # type: ignore[no-untyped-def]
    """States (k, n) at the ascending places (k,), one step of order 8 between neighbours."""
    from scipy.integrate import DOP853

    rows = [np.asarray(DOP853.A[k, :k]) for k in range(len(DOP853.C))]
    slopes = np.empty((len(DOP853.C), len(start)))
    path, state = [start], start
    for at, step in zip(places[:-1].tolist(), np.diff(places).tolist(), strict=True):
        for k, row in enumerate(rows):
            slopes[k] = rates(at + DOP853.C[k] * step, state + step * (row @ slopes[:k]))
        state = state + step * (DOP853.B @ slopes)
        path.append(state)
    return np.array(path)
