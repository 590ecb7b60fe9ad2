"""Which of the motions that levels leave is the one: by further readings, and how surely."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level import DECIBEL
from vibecalc.measurement.level_motions import LevelMotion
from vibecalc.measurement.level_reach import Reach
from vibecalc.measurement.spread import level_gradient
from vibecalc.numerics.typing import FloatArray

#: a local minimum whose misfit is no more than so many times that of the best is as good
_AS_GOOD = 2.0


class Choice(NamedTuple):
    """`ranking` of the motions, best first, and their `residuals` (c, k) at the choosing readings.

    `decided` says that the best stands out: by more than the choosing readings and what the motions
    predict for them may be off; or, without such readings, that no other motion lies within the
    readings it was found from, nor nearly as near to them.
    """

    ranking: tuple[int, ...]
    residuals: FloatArray
    decided: bool


def choose(
    motions: Sequence[LevelMotion],
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    reach: Reach | None = None,
) -> Choice:
    """Rank motions (best first by their own cost) by the levels of further readings.

    Rows (k, 3), amplitudes (k,) > 0 and half widths (k,) in dB are those of the further readings,
    of which there may be none. `reach` bounds what the motions may be off; without it their slopes
    do. Motions that are one family within the rounding are never decided on.
    """
    choice = _ranked(motions, rows, amplitudes, half_widths, reach)
    return choice._replace(decided=choice.decided and not (reach is not None and reach.folded))


def _ranked(
    motions: Sequence[LevelMotion],
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    reach: Reach | None,
) -> Choice:
    residuals = np.stack([_levels(motion, rows, amplitudes) for motion in motions])
    if not len(rows):
        ranking = tuple(range(len(motions)))
        return Choice(ranking, residuals, _stands_out(motions))
    worst = np.max(np.abs(residuals), axis=1)
    ranking = tuple(int(place) for place in np.argsort(worst, kind="stable"))
    if len(motions) == 1:
        return Choice(ranking, residuals, True)
    first, second = ranking[:2]
    at = int(np.argmax(np.abs(residuals[first] - residuals[second])))
    doubt = half_widths[at] + sum(
        _doubt(motions[place], rows[at], reach) for place in (first, second)
    )
    apart = abs(residuals[second, at]) - abs(residuals[first, at])
    return Choice(ranking, residuals, bool(apart > doubt))


def _doubt(motion: LevelMotion, row: FloatArray, reach: Reach | None) -> float:
    if reach is not None:
        return float(reach.bound(motion, row[None])[0])
    return float(motion.spread.bound(level_gradient(row, motion.motion)))


def _levels(motion: LevelMotion, rows: FloatArray, amplitudes: FloatArray) -> FloatArray:
    size = np.abs(rows @ motion.motion)
    # a node of a motion lies 6000 dB below the reading: it is surely not the one
    return np.asarray(DECIBEL * np.log(np.maximum(size / amplitudes, np.finfo(float).tiny)))


def _stands_out(motions: Sequence[LevelMotion]) -> bool:
    if len(motions) == 1:
        return True
    best, other = motions[0].misfit, motions[1].misfit
    return bool(other > max(1.0, _AS_GOOD * best))
