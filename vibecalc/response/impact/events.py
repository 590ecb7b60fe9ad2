"""When a gap leaves its side within a step: found for every run of a batch at once.

The certificate of `roots.py` tells for each face whether the series crosses it never, once, or
perhaps more often; in the last case the step is halved until it knows. So two crossings inside
one step, or a graze, cannot be passed over.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray
from vibecalc.response.impact.contact import Law
from vibecalc.response.impact.roots import bernstein, sign_changes, single_root

#: halvings after which two crossings are closer together than rounding can tell
DEEPEST = 40


class Crossing(NamedTuple):
    """What happens in a step, for each run (A,).

    `fraction` of the step that is taken, (0, 1], or 0; `gap` the index of the gap that crosses a
    face at its end and `way` -1 (its lower face), +1 (its upper) or 0 (no event); `halve` the
    runs whose step has to be halved first.
    """

    fraction: FloatArray
    gap: IntArray
    way: IntArray
    halve: BoolArray


def first_crossing(series: FloatArray, law: Law, on_face: IntArray, level: IntArray) -> Crossing:
    """First face crossed by the gaps' series (terms, G, A).

    `on_face` (G, A) is -1 or +1 where a gap starts on its lower or upper face (the root at s = 0
    is then divided out), else 0. `level` (A,) counts the halvings so far. A gap that starts on
    the wrong side, or on its face and moving out, crosses at once: fraction 0.
    """
    shape = bernstein(series)
    # z = face + s q(s): q has the power coefficients 1, 2, .. of z
    leaving = bernstein(series[1:])
    leaving = np.concatenate([leaving, leaving[-1:]])
    inside_lower = np.where(on_face == -1, leaving > 0.0, shape > law.lower)
    inside_upper = np.where(on_face == 1, leaving < 0.0, shape < law.upper)
    # at rest on a face the second coefficient decides
    at_rest = (on_face != 0) & (series[1] == 0.0)
    inside_lower[0] = np.where(at_rest, inside_lower[1], inside_lower[0])
    inside_upper[0] = np.where(at_rest, inside_upper[1], inside_upper[0])

    outside = np.where(inside_lower[0], 0, -1) + np.where(inside_upper[0], 0, 1)
    changes = np.stack([sign_changes(inside_lower), sign_changes(inside_upper)])
    at_once = np.any(outside != 0, axis=0)
    unclear = np.any(changes > 1, axis=(0, 1)) & ~at_once
    halve = unclear & (level < DEEPEST)
    runs = series.shape[2]
    fraction = np.where(halve | at_once, 0.0, 1.0)
    gap = np.argmax(outside != 0, axis=0)
    way = np.where(at_once, outside[gap, np.arange(runs)], 0)

    # crossings of a face: one change, or (deepest level) a last value outside
    ends_out = np.stack([~inside_lower[-1], ~inside_upper[-1]])
    crosses = ends_out & ~(halve | at_once)
    face, which, run = np.nonzero(crosses)
    if len(run):
        coefficients = series[:, which, run].copy()
        coefficients[0] -= np.where(face == 0, law.lower[which, run], law.upper[which, run])
        started = on_face[which, run] == np.where(face == 0, -1, 1)
        coefficients[:-1, started] = coefficients[1:, started]
        coefficients[-1, started] = 0.0
        root = single_root(coefficients, np.zeros(len(run)), np.ones(len(run)))
        # of several crossings of one run the first wins: it is assigned last
        order = np.argsort(-root, kind="stable")
        face, which, run = face[order], which[order], run[order]
        fraction[run], gap[run], way[run] = root[order], which, np.where(face == 0, -1, 1)
    return Crossing(fraction, gap, way, halve)
