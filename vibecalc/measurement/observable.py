"""What readings can tell of the motion of a plate, from their places alone."""

from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level_motions import NEEDED
from vibecalc.measurement.quadratic import NO_RANK, quadratic_rank
from vibecalc.measurement.rigid_plate import scaled, span_of
from vibecalc.numerics.typing import FloatArray


class Observable(NamedTuple):
    """Motions that no reading sees, and how many of the levels are independent.

    `unseen` (k, 3) holds real motions (a_0, alpha_x, alpha_y), with angular accelerations times
    the span of the plate, that are zero at every reading; `levels` counts to six, of which five
    leave at most two motions.
    """

    unseen: FloatArray
    levels: int
    span: float


def observable(rows: FloatArray) -> Observable:
    """What rows (r, 3), r >= 1, tell."""
    span = span_of(rows)
    plain = scaled(rows, span)
    unit = plain / np.linalg.norm(plain, axis=1, keepdims=True)
    size, right = np.linalg.svd(unit)[1:]
    seen = int(np.sum(size > NO_RANK * size[0]))
    return Observable(right[seen:], quadratic_rank(plain), span)


def helpful(rows: FloatArray, further: FloatArray) -> list[int]:
    """Places, in `further` (m, 3), of readings whose levels are independent of those at `rows`."""
    span = span_of(np.concatenate([rows, further]))
    plain, more = scaled(rows, span), scaled(further, span)
    rank = quadratic_rank(plain)
    if rank > NEEDED:
        return []
    return [
        place
        for place, row in enumerate(more)
        if np.any(row) and quadratic_rank(np.vstack([plain, row])) > rank
    ]
