"""Samples of the last revolution at equal crank angles, for pictures and comparisons."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.impact.ledger import Piece
from vibecalc.response.impact.roots import evaluate


class Trace(NamedTuple):
    """`angle` (samples,) rad; `gap` m and `force` N (G, B, samples); `seen` (B,) filled so far."""

    angle: FloatArray
    gap: FloatArray
    force: FloatArray
    seen: IntArray
    revolution: int


def open_trace(gaps: int, members: int, samples: int, revolution: int) -> Trace:
    """An empty trace of one revolution (counted from 0)."""
    shape = (gaps, members, samples)
    angle = 2.0 * np.pi * np.arange(samples) / max(samples, 1)
    seen = np.zeros(members, dtype=np.int64)
    return Trace(angle, np.zeros(shape), np.zeros(shape), seen, revolution)


def record(
    trace: Trace, piece: Piece, gap: FloatArray, start: FloatArray, revolution: IntArray
) -> None:
    """Fill in the samples that fall into a piece with gap series (k, G, A) from `start` (A,).

    A sample belongs to the piece that it is the start of, not to the one before.
    """
    samples = len(trace.angle)
    here = np.flatnonzero((revolution == trace.revolution) & (piece.length > 0.0))
    while samples and len(here):
        members = piece.members[here]
        left = trace.seen[members] < samples
        here, members = here[left], members[left]
        following = trace.seen[members]
        at = (trace.angle[following] - start[here]) / piece.length[here]
        inside = at < 1.0
        here, members, following = here[inside], members[inside], following[inside]
        at = np.maximum(at[inside], 0.0)
        for each in range(gap.shape[1]):
            trace.gap[each, members, following] = evaluate(gap[:, each, here], at)[0]
            trace.force[each, members, following] = evaluate(piece.force[:, each, here], at)[0]
        trace.seen[members] += 1
